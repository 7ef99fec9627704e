/**
 * @file
 * The numbers of section 4 of the thesis: Tables 1 to 3, and what its figures say in words.
 * Measured on an NVIDIA GeForce GTX 260+ with CUDA 2.3 in 2010.
 */
#ifndef CLI_BENCH_THESIS_H
#define CLI_BENCH_THESIS_H

#define THESIS_DEVICE "GeForce GTX 260+ (2010)"

#define THESIS_RAYS_MB 188.0 // Table 1: per-ray data at 1024 x 1024
#define THESIS_PIXELS  (1024.0 * 1024.0)
#define THESIS_DECK_MB 528.0 // Table 1: all of DMDeck at 1024 x 1024

/** Depths and shadow rays of Tables 2 and 3; index 0 and 1. */
extern const unsigned thesis_depths[2], thesis_shadow_rays[2];

struct thesis_scene {
    const char *name;                                      // of ours, as its file is called
    const char *thesis;                                    // of the thesis's
    const char *cameras[2];                                // ours for its images; NULL: none
    const char *views[2];                                  // what the thesis calls them
    double triangles, point, directional, area;            // Table 1
    double bvh_mb, geometry_mb, material_mb, footprint_mb; // Table 1
    double mrays[2][2][2];                                 // Table 2: [size][depth][shadow rays]
    double traversal[2][2], lighting[2][2],
        others[2][2];      // Table 3, %: [depth][shadow rays]; 0: not told
    int faster_in_time[2]; // Figure 7, by view: 1 if 4 shadow rays converge faster, -1 if slower,
                           // 0: not told
    int better_by_rays[2]; // Figure 8, by view: 1 if 4 shadow rays have less variance for as many
                           // rays, -1 if more
};

/** The thesis's scene of this name of ours; NULL if there is none. */
const struct thesis_scene *thesis_find(const char *name);

#endif

/**
 * @file
 * Scenes that a test makes, looks at once and throws away.
 */
#ifndef TESTS_SEE_H
#define TESTS_SEE_H

#include "gltf_writer.h"
#include "render_support.h"

#define SPECK 1e-4f // half the side of what look_down() shows, m

/** Adds a camera that sees a speck of the plane y = 0 from above at (x, 0, z). */
void look_down(struct gltf_writer *writer, float x, float z);

/** Adds a point light of 10 cd. */
void add_point_light(struct gltf_writer *writer, float x, float y, float z);

/** Loads the scene of the writer, which is empty then, and renders it once: as render_rgb(). */
struct rgb see_rgb(struct gltf_writer *writer, const struct lk_settings *settings);

/** As render_mean(). */
double see_mean(struct gltf_writer *writer, const struct lk_settings *settings);

/** As estimate_point(). */
struct estimate see_point(struct gltf_writer *writer, const struct lk_settings *settings);

/** The mean of 8 x 8 pixels of a scene that must be grey. */
double see_grey(struct gltf_writer *writer, uint32_t depth);

/** What see_grey() and see_rgb() tell is `exact`, but for rounding of floats and of normals to 32
 * bits. */
void assert_seen(double seen, double exact);

#endif

#include "prep/light_bvh.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "prep/array.h"
#include "prep/light_cluster.h"
#include "prep/vec3.h"

#define WIDTH       ((int)LIGHT_BVH_WIDTH)
#define VISIT_COST  0.1  // of every draw visiting one more wide node, in wide nodes per light
#define ANGLE_SLACK 1e-3 // radians: a light at the very edge of a cone is not lost to rounding

static void set_row(struct light_bvh_node *node, int row, int child, float value)
{
    memcpy((char *)node + (row * WIDTH + child) * (int)sizeof(float), &value, sizeof(value));
}

// The cosine of an angle a little wider.
static float widen(float cosine)
{
    return (float)cos(fmin(acos(fmin(fmax(cosine, -1.0), 1.0)) + ANGLE_SLACK, M_PI));
}

// Writes one child's column.
static void write_child(struct light_bvh_node *node, int child, const struct light_bounds *bounds,
                        uint32_t word)
{
    double radius2 = 0.0;
    for (int k = 0; k < 3; k++) {
        const float c = 0.5f * bounds->lo[k] + 0.5f * bounds->hi[k];
        const double half = fmax((double)bounds->hi[k] - c, (double)c - bounds->lo[k]);
        radius2 += half * half;
        set_row(node, k, child, c);
        set_row(node, 6 + k, child, bounds->axis[k]);
    }
    float bits;
    memcpy(&bits, &word, sizeof(bits));
    set_row(node, 3, child, float_above(sqrt(radius2) * 1.000001));
    set_row(node, 4, child, bounds->two_sided ? -bounds->power : bounds->power);
    set_row(node, 5, child, bounds->range);
    set_row(node, 9, child, widen(bounds->cos_o));
    set_row(node, 10, child, widen(bounds->cos_e));
    set_row(node, 11, child, bits);
}

// How a cluster is best cut into wide nodes, by the number of children that it may take of the wide
// node above it: k of them stand at [k - 1].
struct cut {
    float cost[LIGHT_BVH_WIDTH];   // of all wide nodes from here down
    uint8_t left[LIGHT_BVH_WIDTH]; // children that the left half takes; 0: as with one child less,
                                   // and of one child: the cluster is that child
};

// Finds the cuts of least cost from the leaves up (as I. Wald et al. do for SIMD BVHs: "Getting Rid
// of Packets", 2008). A wide node costs its bytes, and the time of those draws that come to it,
// taken to be its share of all power.
static void find_cuts(struct cut *cuts, const struct light_cluster *clusters, uint32_t light_count)
{
    const double scale = VISIT_COST * light_count / clusters[0].bounds.power;
    for (uint32_t n = 2 * light_count - 1; n-- > 0;) {
        struct cut *cut = &cuts[n];
        *cut = (struct cut){0};
        if (clusters[n].count == 1)
            continue; // stands above its children, so these are done
        const struct cut *left = &cuts[clusters[n].left];
        const struct cut *right = left + 1;
        float best[LIGHT_BVH_WIDTH];
        for (int k = 2; k <= WIDTH; k++) {
            best[k - 1] = INFINITY;
            for (int i = 1; i < k; i++) {
                const float cost = left->cost[i - 1] + right->cost[k - i - 1];
                if (cost < best[k - 1]) {
                    best[k - 1] = cost;
                    cut->left[k - 1] = (uint8_t)i;
                }
            }
        }
        cut->cost[0] = best[WIDTH - 1] + 1.0f + (float)(scale * clusters[n].bounds.power);
        for (int k = 2; k <= WIDTH; k++) {
            cut->cost[k - 1] = best[k - 1];
            if (k < WIDTH && !(best[k - 1] < cut->cost[k - 2])) {
                cut->cost[k - 1] = cut->cost[k - 2];
                cut->left[k - 1] = 0;
            }
        }
    }
}

// Adds the children into which a cluster is cut if it may take k.
static void add_children(uint32_t *children, int *count, const struct light_cluster *clusters,
                         const struct cut *cuts, uint32_t index, int k)
{
    while (k > 1 && cuts[index].left[k - 1] == 0)
        k--;
    if (k == 1) {
        children[(*count)++] = index;
        return;
    }
    const int left = cuts[index].left[k - 1];
    add_children(children, count, clusters, cuts, clusters[index].left, left);
    add_children(children, count, clusters, cuts, clusters[index].left + 1, k - left);
}

// Collapses the clusters, breadth first. source[n] is the cluster of wide node n.
static void collapse(struct light_bvh *out, const struct light_cluster *clusters,
                     const struct cut *cuts, uint32_t *source)
{
    static const struct light_bounds none = {.axis = {0.0, 0.0, 1.0}};
    source[0] = 0;
    out->parents[0] = LIGHT_BVH_ROOT;
    out->node_count = 1;
    for (uint32_t n = 0; n < out->node_count; n++) {
        uint32_t children[LIGHT_BVH_WIDTH];
        int count = 0;
        add_children(children, &count, clusters, cuts, source[n], WIDTH);
        for (int i = 0; i < WIDTH; i++) {
            if (i >= count) {
                write_child(&out->nodes[n], i, &none, LIGHT_BVH_EMPTY);
                continue;
            }
            const struct light_cluster *child = &clusters[children[i]];
            uint32_t word = LIGHT_BVH_LEAF | child->left;
            if (child->count == 1) {
                out->leaves[child->left] = n << 3 | (uint32_t)i;
            } else {
                word = out->node_count++;
                source[word] = children[i];
                out->parents[word] = n << 3 | (uint32_t)i;
            }
            write_child(&out->nodes[n], i, &child->bounds, word);
        }
    }
}

enum status light_bvh_build(struct light_bvh *out, const struct light *lights,
                            const struct light_shape *shapes, const float *power,
                            uint32_t light_count)
{
    if (light_count == 0) {
        *out = (struct light_bvh){0};
        return STATUS_OK;
    }
    struct light_bvh bvh = {.light_count = light_count};
    struct light_cluster *clusters = NULL;
    struct cut *cuts = NULL;
    uint32_t *source = NULL;
    enum status status = light_clusters_build(&clusters, lights, shapes, power, light_count);
    if (status != STATUS_OK)
        return status;

    // Every wide node but the root has two lights or more of its own or a wide node below, so there
    // are fewer wide nodes than lights; shrunk to what is used at the end.
    cuts = array_alloc(2 * (size_t)light_count - 1, sizeof(*cuts));
    source = array_alloc(light_count, sizeof(*source));
    bvh.nodes = array_alloc(light_count, sizeof(*bvh.nodes));
    bvh.parents = array_alloc(light_count, sizeof(*bvh.parents));
    bvh.leaves = array_alloc(light_count, sizeof(*bvh.leaves));
    if (cuts == NULL || source == NULL || bvh.nodes == NULL || bvh.parents == NULL ||
        bvh.leaves == NULL) {
        status = status_fail(STATUS_NO_MEMORY, "no memory for a BVH over %u lights", light_count);
        goto cleanup;
    }
    find_cuts(cuts, clusters, light_count);
    collapse(&bvh, clusters, cuts, source);
    struct light_bvh_node *shrunk = realloc(bvh.nodes, bvh.node_count * sizeof(*bvh.nodes));
    bvh.nodes = shrunk != NULL ? shrunk : bvh.nodes;
    *out = bvh;
    bvh = (struct light_bvh){0}; // the caller owns it now

cleanup:
    light_bvh_free(&bvh);
    free(source);
    free(cuts);
    free(clusters);
    return status;
}

void light_bvh_free(struct light_bvh *bvh)
{
    free(bvh->nodes);
    free(bvh->parents);
    free(bvh->leaves);
    *bvh = (struct light_bvh){0};
}

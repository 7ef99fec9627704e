/**
 * @file
 * Every struct of include/shared/ with its members, in order, for host and device.
 */
#ifndef TESTS_DEVICE_LAYOUT_LIST_H
#define TESTS_DEVICE_LAYOUT_LIST_H

#include "shared/bvh.h"
#include "shared/bvh_compressed.h"
#include "shared/bvh_quad.h"
#include "shared/bvh_wide.h"
#include "shared/camera.h"
#include "shared/environment.h"
#include "shared/film.h"
#include "shared/geometry.h"
#include "shared/light.h"
#include "shared/material.h"
#include "shared/oct.h"
#include "shared/path.h"
#include "shared/ray.h"
#include "shared/rng.h"
#include "shared/settings.h"
#include "shared/zorder.h"

// clang-format off
// S(struct), then M(struct, member) for each of its members
#define LAYOUT_LIST(S, M)                                                                          \
    S(bvh_node)                                                                                    \
    M(bvh_node, row0) M(bvh_node, row1) M(bvh_node, row2) M(bvh_node, row3)                        \
    S(woop)                                                                                        \
    M(woop, row_w) M(woop, row_u) M(woop, row_v)                                                   \
    S(quad_node)                                                                                   \
    M(quad_node, grid) M(quad_node, planes) M(quad_node, words)                                    \
    S(compressed_node)                                                                             \
    M(compressed_node, head) M(compressed_node, links) M(compressed_node, planes)                  \
    S(wide_node)                                                                                   \
    M(wide_node, rows)                                                                             \
    S(woop_block)                                                                                  \
    M(woop_block, rows)                                                                            \
    S(camera)                                                                                      \
    M(camera, org) M(camera, corner) M(camera, right) M(camera, down) M(camera, forward)           \
    M(camera, width) M(camera, height) M(camera, orthographic) M(camera, pad0)                     \
    S(environment_map)                                                                             \
    M(environment_map, width) M(environment_map, height) M(environment_map, turn)                  \
    M(environment_map, pad0)                                                                       \
    S(environment_alias)                                                                           \
    M(environment_alias, keep) M(environment_alias, other)                                         \
    S(film_pixel)                                                                                  \
    M(film_pixel, sum) M(film_pixel, carry)                                                        \
    S(vertex)                                                                                      \
    M(vertex, pos_normal) M(vertex, uv)                                                            \
    S(triangle)                                                                                    \
    M(triangle, v0) M(triangle, v1) M(triangle, v2) M(triangle, material)                          \
    S(light)                                                                                       \
    M(light, org_range) M(light, color_kind)                                                       \
    S(light_shape)                                                                                 \
    M(light_shape, edge_u) M(light_shape, edge_v)                                                  \
    S(directional_light)                                                                           \
    M(directional_light, dir) M(directional_light, color)                                          \
    S(light_node)                                                                                  \
    M(light_node, lo_left) M(light_node, hi_child)                                                 \
    S(light_bvh_node)                                                                              \
    M(light_bvh_node, rows)                                                                        \
    S(texture_slot)                                                                                \
    M(texture_slot, uv_matrix) M(texture_slot, uv_offset) M(texture_slot, texel_first)             \
    M(texture_slot, size) M(texture_slot, flags)                                                   \
    M(texture_slot, pad0) M(texture_slot, pad1) M(texture_slot, pad2)                              \
    S(material)                                                                                    \
    M(material, base) M(material, emission) M(material, specular)                                  \
    M(material, diffuse_transmission) M(material, sheen)                                           \
    M(material, metallic) M(material, roughness) M(material, glossiness) M(material, flags)        \
    M(material, normal_scale) M(material, transmission)                                            \
    M(material, coat) M(material, coat_roughness) M(material, coat_normal_scale)                   \
    M(material, pad0) M(material, pad1) M(material, pad2)                                          \
    M(material, textures)                                                                          \
    S(batch)                                                                                       \
    M(batch, first) M(batch, first_sample) M(batch, count) M(batch, pixel_count)                   \
    M(batch, sample_shift) M(batch, first_pixel) M(batch, pad0) M(batch, pad1)                            \
    S(path)                                                                                        \
    M(path, throughput_bits) M(path, radiance_normal)                                              \
    S(shade)                                                                                       \
    M(shade, diffuse_f0) M(shade, specular_f90)                                                    \
    S(counters)                                                                                    \
    M(counters, active) M(counters, trace_head) M(counters, direct_head)                           \
    M(counters, directional_head) M(counters, shadow_rays)                                         \
    M(counters, directional_rays) M(counters, rays) M(counters, pad0)                                           \
    S(ray)                                                                                         \
    M(ray, org) M(ray, dir)                                                              \
    S(hit)                                                                                         \
    M(hit, t) M(hit, u) M(hit, v) M(hit, triangle)                                                 \
    S(settings)                                                                                    \
    M(settings, seed) M(settings, depth) M(settings, shadow_rays) M(settings, quantity)            \
    M(settings, light_count) M(settings, directional_count) M(settings, material_count)            \
    M(settings, emitter_count)                                                                     \
    M(settings, point_shift) M(settings, triangle_count) M(settings, roulette_depth) M(settings, pad0)
// clang-format on

#endif

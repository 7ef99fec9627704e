#include "core/choices.h"

#include <stddef.h>

const char *const choices_quantity[] = {"radiance", "irradiance", "direct", NULL};
const char *const choices_brdf[] = {"gltf", "phong", NULL};
const char *const choices_light_sampler[] = {"auto", "tree", "uniform", "all", "importance", NULL};
const char *const choices_sampler[] = {"sobol", "random", NULL};
const char *const choices_trace[] = {"auto", "simple", "persistent", "postponing", "warps", NULL};
const char *const choices_bvh[] = {"auto", "binary", "wide", "quad", "compressed", NULL};
const char *const choices_rays[] = {"camera", "first_bounce", "later_bounces", "shadow", NULL};
const char *const choices_reason[] = {"forced", "rule", "probe", "cache", NULL};
const char *const choices_bvh_build[] = {"sbvh", "thesis", NULL};
const char *const choices_textures[] = {"auto", "bound", "pool", NULL};
const char *const choices_nodes[] = {"buffer", "texture", NULL};
const char *const choices_tonemap[] = {"auto", "none", "reinhard", "aces", NULL};
const char *const choices_log_level[] = {"error", "warning", "info", "debug", NULL};

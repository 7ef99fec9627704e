/**
 * @file
 * The words for the choices among the settings, as the command line reads them and reports write
 * them: one table for both. Each list stands in the order of the public enum of the same name and
 * ends with NULL.
 */
#ifndef CORE_CHOICES_H
#define CORE_CHOICES_H

extern const char *const choices_quantity[];
extern const char *const choices_brdf[];
extern const char *const choices_light_sampler[];
extern const char *const choices_sampler[];
extern const char *const choices_trace[];
extern const char *const choices_bvh[];
extern const char *const choices_bvh_build[];
extern const char *const choices_rays[];
extern const char *const choices_reason[];
extern const char *const choices_textures[];
extern const char *const choices_nodes[];
extern const char *const choices_tonemap[];
extern const char *const choices_log_level[];

#endif

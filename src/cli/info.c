#include "cli/commands.h"
#include "core/json.h"

// One row of the tables, and one number of the JSON.
struct number {
    const char *key, *title;
    uint64_t value;
};

static void write_numbers(struct json *json, const char *key, const struct number *numbers,
                          size_t count)
{
    json_object(json, key);
    for (size_t i = 0; i < count; i++)
        json_uint(json, numbers[i].key, numbers[i].value);
    json_object_end(json);
}

static void print_counts(const struct number *numbers, size_t count)
{
    for (size_t i = 0; i < count; i++)
        printf("  %-28s %14llu\n", numbers[i].title, (unsigned long long)numbers[i].value);
}

static void print_bytes(const struct number *numbers, size_t count)
{
    for (size_t i = 0; i < count; i++)
        printf("  %-28s %14.3f\n", numbers[i].title, (double)numbers[i].value * 1e-6);
}

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

static enum status print_info(const struct lk_scene_info *info, const struct lk_scene *scene,
                              bool as_json)
{
    const struct number counts[] = {
        {"triangles", "triangles", info->triangles},
        {"triangles_split", "references in the BVH", info->triangles_split},
        {"instances", "instances", info->instances},
        {"materials", "materials", info->materials},
        {"textures", "textures", info->textures},
    };
    const struct number lights[] = {
        {"point", "point", info->lights.point},
        {"spot", "spot", info->lights.spot},
        {"rect", "rectangle", info->lights.rect},
        {"disc", "disc", info->lights.disc},
        {"directional", "directional", info->lights.directional},
        {"emissive_triangles", "emissive triangles", info->lights.emissive_triangles},
        {"drawn", "drawn from", info->lights.drawn},
        {"bytes_each", "bytes of each, all told",
         info->lights.drawn > 0 ? info->memory.lights / info->lights.drawn : 0},
    };
    const struct number memory[] = {
        {"bvh", "BVH", info->memory.bvh},
        {"geometry", "geometry", info->memory.geometry},
        {"materials", "materials and textures", info->memory.materials},
        {"lights", "lights", info->memory.lights},
        {"rays", "rays", info->memory.rays},
        {"samples", "samples", info->memory.samples},
        {"film", "film", info->memory.film},
        {"total_device", "total on the device", info->memory.total_device},
        {"peak_host", "host, so far", info->memory.peak_host},
    };
    const char *camera = NULL;

    if (as_json) {
        struct json json = {0};
        json_object(&json, NULL);
        json_string(&json, "file", info->file);
        write_numbers(&json, "scene", counts, COUNT(counts));
        write_numbers(&json, "lights", lights, COUNT(lights));
        json_array(&json, "cameras");
        for (size_t i = 0; (camera = lk_scene_camera(scene, i)) != NULL; i++)
            json_string(&json, NULL, camera);
        json_array_end(&json);
        write_numbers(&json, "memory_bytes", memory, COUNT(memory));
        json_uint(&json, "width", info->width);
        json_uint(&json, "height", info->height);
        json_object_end(&json);
        return json_print(&json);
    }

    printf("%s\n", info->file);
    print_counts(counts, COUNT(counts));
    printf("Lights\n");
    print_counts(lights, COUNT(lights));
    printf("Cameras\n");
    for (size_t i = 0; (camera = lk_scene_camera(scene, i)) != NULL; i++)
        printf("  %zu  %s\n", i, camera);
    printf("Memory for %u x %u pixels, MB\n", info->width, info->height);
    print_bytes(memory, COUNT(memory));
    return STATUS_OK;
}

enum status command_info(const struct options *options)
{
    struct lk_scene *scene = NULL;
    struct lk_scene_info info;
    lk_log_set(options->log_level, NULL, NULL);

    enum status status = (enum status)lk_scene_load(&scene, options->operands[0]);
    if (status == STATUS_OK)
        status = (enum status)lk_scene_info(&info, scene, &options->settings);
    if (status == STATUS_OK && options->strict && lk_warning_count() > 0)
        status = status_fail(STATUS_FORMAT, "%s: %u warnings, and --strict makes them errors",
                             options->operands[0], lk_warning_count());
    if (status == STATUS_OK)
        status = print_info(&info, scene, options->json);
    lk_scene_free(scene);
    return status;
}

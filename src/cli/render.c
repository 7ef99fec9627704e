#include "cli/commands.h"

#include <stdio.h>
#include <string.h>

#include "cli/progress.h"
#include "core/file.h"

// Fails before hours are spent on what could not be written.
static enum status check_outputs(const struct options *options)
{
    if (options->output == NULL)
        return status_fail(STATUS_USAGE, "say where the picture goes: -o FILE.exr");
    enum status status = (enum status)lk_image_can_write(options->output);
    if (status == STATUS_OK && options->stats != NULL)
        status = file_check_writable(options->stats);
    return status;
}

static enum status check_warnings(const struct options *options)
{
    const unsigned count = lk_warning_count();
    if (!options->strict || count == 0)
        return STATUS_OK;
    return status_fail(STATUS_FORMAT, "%s: %u warning%s, and --strict makes them errors",
                       options->operands[0], count, count == 1 ? "" : "s");
}

static void print_profile(const struct lk_render_info *info)
{
    double total_s = 0.0;
    for (uint32_t i = 0; i < info->kernel_count; i++)
        total_s += info->kernels[i].time_s;

    printf("%-20s %10s %12s %8s %12s\n", "kernel", "calls", "time, s", "share", "achieved");
    for (uint32_t i = 0; i < info->kernel_count; i++) {
        const struct lk_kernel_time *kernel = &info->kernels[i];
        printf("%-20s %10llu %12.4f %6.1f %%", kernel->name, (unsigned long long)kernel->calls,
               kernel->time_s, total_s > 0.0 ? 100.0 * kernel->time_s / total_s : 0.0);
        if (kernel->rays > 0 && kernel->time_s > 0.0)
            printf(" %12.2f Mrays/s", (double)kernel->rays / kernel->time_s * 1e-6);
        if (kernel->bytes > 0 && kernel->time_s > 0.0)
            printf(" %12.2f GB/s", (double)kernel->bytes / kernel->time_s * 1e-9);
        printf("\n");
    }
    printf("%-20s %10s %12.4f %6.1f %%\n", "all kernels", "", total_s, 100.0);
}

// "a GPU", "a GPU (96 %) and a CPU (4 %)"
static void format_devices(char *text, size_t size, const struct lk_render_info *info)
{
    text[0] = '\0';
    for (uint32_t i = 0; i < info->device_count; i++) {
        const struct lk_device_share *share = &info->devices[i];
        const size_t used = strlen(text);
        const char *between = i == 0 ? "" : i + 1 < info->device_count ? ", " : " and ";
        if (info->device_count == 1)
            snprintf(text, size, "%s", share->info.name);
        else
            snprintf(text + used, size - used, "%s%s (%.1f %%)", between, share->info.name,
                     info->paths > 0 ? 100.0 * (double)share->paths / (double)info->paths : 0.0);
    }
}

// One line: what was made, how fast, and on what.
static void print_summary(const struct options *options, const struct lk_render_info *info)
{
    const double seconds = info->time_s.render;
    const double rays = (double)(info->rays_camera + info->rays_indirect + info->rays_shadow);
    char devices[2560];
    format_devices(devices, sizeof(devices), info);
    fprintf(stderr, "lightkiln: %s: %u x %u, %.4g spp, %.2f s, %.2f Mrays/s, %s%s\n",
            options->output, info->settings.width, info->settings.height, info->spp, seconds,
            seconds > 0.0 ? rays / seconds * 1e-6 : 0.0, devices,
            progress_is_interrupted() ? " (interrupted)" : "");
}

// Writes and prints what a finished, or interrupted, render gives.
static enum status deliver(const struct options *options, const struct lk_image *image)
{
    enum status status = (enum status)lk_image_write(image, options->output, &options->display);
    if (status != STATUS_OK)
        return status;
    if (options->stats != NULL) {
        status = (enum status)lk_report_write(image, options->stats);
        if (status != STATUS_OK)
            return status;
    }
    if (options->settings.profile)
        print_profile(lk_image_info(image));
    if (!options->quiet)
        print_summary(options, lk_image_info(image));
    return STATUS_OK;
}

enum status command_render(const struct options *options)
{
    struct lk_scene *scene = NULL;
    struct lk_image *image = NULL;
    struct progress progress;
    progress_init(&progress, options->quiet, options->strict);
    lk_log_set(options->log_level, progress_log, &progress);
    progress_catch_interrupts();

    enum status status = check_outputs(options);
    if (status != STATUS_OK)
        goto cleanup;
    status = (enum status)lk_scene_load(&scene, options->operands[0]);
    if (status == STATUS_OK)
        status = check_warnings(options);
    if (status != STATUS_OK)
        goto cleanup;

    const struct lk_progress_hook hook = {progress_report, &progress};
    status = (enum status)lk_render(&image, scene, &options->settings, &hook);
    progress_end(&progress);
    if (status != STATUS_OK && status != STATUS_CANCELLED)
        goto cleanup;

    // What an interrupted render has finished is delivered, too; then the status is still told.
    enum status delivered = check_warnings(options);
    if (delivered == STATUS_OK && image != NULL)
        delivered = deliver(options, image);
    else if (delivered == STATUS_OK && !options->quiet)
        fprintf(stderr, "lightkiln: interrupted before anything was finished\n");
    if (delivered != STATUS_OK)
        status = delivered;

cleanup:
    lk_log_set(options->log_level, NULL, NULL);
    lk_image_free(image);
    lk_scene_free(scene);
    return status;
}

#include "cli/commands.h"
#include "core/json.h"

static void write_device(struct json *json, const struct lk_device_info *device)
{
    json_object(json, NULL);
    json_uint(json, "platform_index", device->platform_index);
    json_uint(json, "device_index", device->device_index);
    json_string(json, "platform", device->platform);
    json_string(json, "name", device->name);
    json_string(json, "driver", device->driver);
    json_string(json, "version", device->version);
    json_string(json, "type", device->type);
    json_uint(json, "compute_units", device->compute_units);
    json_uint(json, "global_memory_bytes", device->global_memory);
    json_uint(json, "max_allocation_bytes", device->max_allocation);
    json_uint(json, "local_memory_bytes", device->local_memory);
    json_bool(json, "usable", device->usable);
    json_string(json, "reason", device->usable ? NULL : device->reason);
    json_object_end(json);
}

static void print_device(const struct lk_device_info *device)
{
    printf("%u:%u  %-11s %s\n", device->platform_index, device->device_index, device->type,
           device->name);
    printf("     %s, driver %s, %s\n", device->platform, device->driver, device->version);
    printf("     %u compute units, %.1f GB, largest allocation %.1f GB, local memory %.0f kB\n",
           device->compute_units, (double)device->global_memory * 1e-9,
           (double)device->max_allocation * 1e-9, (double)device->local_memory * 1e-3);
    if (!device->usable)
        printf("     cannot be used: %s\n", device->reason);
}

enum status command_devices(const struct options *options)
{
    struct lk_device_info device;
    struct json json = {0};
    lk_log_set(options->log_level, NULL, NULL);

    // Without any device this is the failure; later it only ends the list.
    enum status status = (enum status)lk_device_info(&device, 0);
    if (status != STATUS_OK)
        return status;
    if (options->json)
        json_array(&json, NULL);
    for (size_t i = 0; status == STATUS_OK; i++) {
        status = (enum status)lk_device_info(&device, i);
        if (status == STATUS_OK && options->json)
            write_device(&json, &device);
        else if (status == STATUS_OK)
            print_device(&device);
    }
    if (status == STATUS_NO_DEVICE)
        status = STATUS_OK;
    if (options->json && status == STATUS_OK) {
        json_array_end(&json);
        status = json_print(&json);
    }
    json_free(&json);
    return status;
}

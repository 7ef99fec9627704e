#include "cli/commands.h"
#include "core/json.h"

static void write_three(struct json *json, const char *key, const double *values)
{
    json_array(json, key);
    for (int i = 0; i < 3; i++)
        json_double(json, NULL, values[i]);
    json_array_end(json);
}

static enum status print_json(const struct lk_comparison *c)
{
    struct json json = {0};
    json_object(&json, NULL);
    json_double(&json, "variance", c->variance);
    json_double(&json, "rmse", c->rmse);
    json_double(&json, "relative_mse", c->relative_mse);
    json_double(&json, "noise", c->noise);
    json_double(&json, "psnr_db", c->psnr_db); // null for equal images
    json_double(&json, "maximum", c->maximum);
    json_uint(&json, "maximum_x", c->maximum_x);
    json_uint(&json, "maximum_y", c->maximum_y);
    write_three(&json, "mean", c->mean);
    write_three(&json, "reference_mean", c->reference_mean);
    json_uint(&json, "not_finite", c->not_finite);
    json_object_end(&json);
    return json_print(&json);
}

static void print_table(const struct lk_comparison *c)
{
    printf("variance        %.6g\n", c->variance);
    printf("RMSE            %.6g\n", c->rmse);
    printf("relative MSE    %.6g\n", c->relative_mse);
    printf("noise           %.6g\n", c->noise);
    printf("PSNR            %.2f dB\n", c->psnr_db);
    printf("maximum         %.6g at %u, %u\n", c->maximum, c->maximum_x, c->maximum_y);
    printf("mean            %.6g %.6g %.6g\n", c->mean[0], c->mean[1], c->mean[2]);
    printf("reference mean  %.6g %.6g %.6g\n", c->reference_mean[0], c->reference_mean[1],
           c->reference_mean[2]);
    printf("not finite      %llu\n", (unsigned long long)c->not_finite);
}

enum status command_compare(const struct options *options)
{
    struct lk_image *image = NULL;
    struct lk_image *reference = NULL;
    struct lk_image *difference = NULL;
    struct lk_comparison comparison;
    lk_log_set(options->log_level, NULL, NULL);

    enum status status = STATUS_OK;
    if (options->diff != NULL)
        status = (enum status)lk_image_can_write(options->diff);
    if (status == STATUS_OK)
        status = (enum status)lk_image_read(&image, options->operands[0]);
    if (status == STATUS_OK)
        status = (enum status)lk_image_read(&reference, options->operands[1]);
    if (status == STATUS_OK)
        status = (enum status)lk_compare(&comparison, options->diff != NULL ? &difference : NULL,
                                         image, reference);
    if (status == STATUS_OK && difference != NULL)
        status = (enum status)lk_image_write(difference, options->diff, NULL);
    if (status == STATUS_OK && options->json)
        status = print_json(&comparison);
    else if (status == STATUS_OK)
        print_table(&comparison);

    lk_image_free(difference);
    lk_image_free(reference);
    lk_image_free(image);
    return status;
}

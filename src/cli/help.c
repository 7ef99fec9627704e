#include <stdio.h>
#include <string.h>

#include "cli/commands.h"

#define LEFT_WIDTH 38 // columns of the options' names

// Appends to a text of `size` bytes; what does not fit is cut.
static void append(char *text, size_t size, const char *more)
{
    const size_t used = strlen(text);
    snprintf(text + used, size - used, "%s", more);
}

// "-o, --output FILE", "--nodes buffer|texture"
static void format_name(char *text, size_t size, const struct option *option)
{
    text[0] = '\0';
    if (option->letter != '\0') {
        const char letter[] = {'-', option->letter, ',', ' ', '\0'};
        append(text, size, letter);
    }
    append(text, size, "--");
    append(text, size, option->name);
    if (option->argument != NULL) {
        append(text, size, " ");
        append(text, size, option->argument);
    }
    for (size_t i = 0; option->choices != NULL && option->choices[i] != NULL; i++) {
        append(text, size, i == 0 ? " " : "|");
        append(text, size, option->choices[i]);
    }
}

// The default, as the field holds it; "" where there is none to show.
static void format_default(char *text, size_t size, const struct option *option)
{
    struct options defaults;
    options_init(&defaults);
    const void *field = (const char *)&defaults + option->offset;
    text[0] = '\0';
    if (option->none != NULL) {
        append(text, size, option->none);
        return;
    }
    switch (option->type) {
    case OPTION_UINT:
        snprintf(text, size, "%u", *(const uint32_t *)field);
        break;
    case OPTION_FLOAT:
        snprintf(text, size, "%g", (double)*(const float *)field);
        break;
    case OPTION_DOUBLE:
        snprintf(text, size, "%g", *(const double *)field);
        break;
    case OPTION_CHOICE:
        append(text, size, option->choices[*(const int *)field]);
        break;
    case OPTION_FLAG:
    case OPTION_TEXT:
    case OPTION_FLOATS2:
    case OPTION_FLOATS3:
    case OPTION_MEGABYTES:
        break;
    }
}

static void print_options(FILE *file, enum command command)
{
    for (const struct option *o = option_table; o->help != NULL; o++) {
        if ((o->commands & command) == 0)
            continue;
        if (o->name == NULL) {
            fprintf(file, "\n%s:\n", o->help);
            continue;
        }
        char left[128];
        char right[64];
        format_name(left, sizeof(left), o);
        format_default(right, sizeof(right), o);
        fprintf(file, "  %-*s", LEFT_WIDTH, left);
        if (strlen(left) >= LEFT_WIDTH)
            fprintf(file, "\n  %-*s", LEFT_WIDTH, "");
        fprintf(file, "%s", o->help);
        if (right[0] != '\0')
            fprintf(file, "%s[%s]", o->help[0] != '\0' ? " " : "", right);
        fprintf(file, "\n");
    }
}

void help_print_command(FILE *file, enum command command)
{
    fprintf(file, "Usage: lightkiln %s %s\n", command_name(command), command_operands(command));
    switch (command) {
    case COMMAND_RENDER:
        fprintf(file,
                "\nRenders a glTF 2.0 scene (.gltf, .glb; \"-\" reads a GLB from standard input).\n"
                "The word render may be left out when the scene comes first. Ctrl-C stops and\n"
                "writes what is finished; once more stops at once.\n");
        break;
    case COMMAND_COMPARE:
        fprintf(file,
                "\nPrints how far an image is from a reference: variance (mean over pixels of\n"
                "the squared differences of R, G and B, summed), RMSE, relative MSE, noise as\n"
                "--noise of render has it, PSNR and the largest difference. Values are linear;\n"
                "8-bit files are decoded.\n");
        break;
    case COMMAND_INFO:
        fprintf(file, "\nPrints what a scene holds and the memory a render of it will take on the\n"
                      "device, without rendering.\n");
        break;
    case COMMAND_DEVICES:
        fprintf(file, "\nPrints the OpenCL devices. The first column is what --device takes.\n");
        break;
    case COMMAND_BENCH:
        fprintf(
            file,
            "\nreport (the default): section 4 of the thesis, on the scenes named or on those of\n"
            "scripts/make_scenes: memory, rays a second, kernels, convergence, pictures, with\n"
            "the thesis's numbers beside. Writes bench.json, CSV files, report.md and images;\n"
            "scripts/plot draws the plots. --time is that of one curve [20], --reference a\n"
            "folder that holds the references of an earlier run.\n\n"
            "lights SCENE: renders the scene with every light sampler for the same --time [10]\n"
            "and prints the variance of each against the reference, times uniform's.\n\n"
            "trace SCENE: traces camera rays, four bounces and shadow rays by every layout of the\n"
            "BVH and every kernel that the device has, taking turns, and prints the median of\n"
            "--runs runs, least and most, in million rays a second. All triangles are solid. A\n"
            "sample of the hits is checked against all triangles in double precision. --views N\n"
            "shares the pixels out among N square views of 90 degrees, from places half way\n"
            "along paths of the camera's and along the heading that sees farthest. The last line\n"
            "tells how hard the rays are: nodes of the binary BVH that one visits, and triangles\n"
            "that it tests.\n\n"
            "path SCENE: renders the scene at depth 1 and 5, or --depth, as the thesis does and\n"
            "as is the default, taking turns, and prints the median of --runs runs of --time\n"
            "[1] seconds, least and most, in million paths a second, and each kernel's share.\n"
            "Rays alone is the part of that time in which bench trace's rays of the same kinds\n"
            "would be traced, as many as the paths have, by the same kernels and nothing else.\n"
            "--light-sampler is that of the default way; the thesis's is tree.\n\n"
            "memory [SCENE...]: bytes on the device and rays a second against the size of the\n"
            "ray queue, measured for --time [3] seconds each.\n\n"
            "scale: a cave of 10,000 to 10,000,000 triangles, and with 1 to 1,000,000 lights,\n"
            "rendered for --time [3] seconds each.\n");
        break;
    case COMMAND_ALL:
        break;
    }
    print_options(file, command);
    if (command == COMMAND_RENDER)
        fprintf(file, "\nExamples:\n"
                      "  lightkiln render level.glb -o level.exr\n"
                      "  lightkiln level.glb -o view.png --camera hall --time 60 --exposure 1\n"
                      "  lightkiln render level.glb -o light.exr --quantity irradiance --spp 256\n"
                      "  lightkiln render level.glb -o direct.exr --depth 1 --device cpu\n"
                      "  lightkiln render level.glb -o level.exr --stats level.json --quiet\n");
}

void help_print(FILE *file)
{
    fprintf(file, "lightkiln %s: glTF in, light out, on any OpenCL device\n\n", lk_version());
    fprintf(
        file,
        "  lightkiln render SCENE -o FILE        renders a scene into an image\n"
        "  lightkiln info SCENE                  tells what is in it and what it takes\n"
        "  lightkiln compare IMAGE REFERENCE     tells how far two images are apart\n"
        "  lightkiln devices                     lists the OpenCL devices\n"
        "  lightkiln bench [EXPERIMENT]          measures; the thesis's experiments by default\n"
        "  lightkiln COMMAND --help              tells more\n\n"
        "Exit codes: 0 done, 1 failed, 2 usage, 3 bad or unsupported input, 4 no usable\n"
        "device, 5 out of memory, 6 cannot write, 130 interrupted (with what was finished\n"
        "written). Results go to stdout, all else to stderr.\n\n");
    help_print_command(file, COMMAND_RENDER);
}

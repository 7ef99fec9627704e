#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <fcntl.h>
#include <strings.h>
#include <unistd.h>

extern "C" {
#include "core/file.h"
#include "scene/image_io.h"
}

using OIIO::ImageInput;
using OIIO::ImageOutput;
using OIIO::ImageSpec;
using OIIO::TypeDesc;

// Larger images are taken for mistakes or attacks: 16384 x 16384 texels are 1 GiB decoded.
static const uint64_t MAX_TEXELS = (uint64_t)1 << 28;
static const int MAX_SIDE = 65535;

// A malloc'ed array that the caller releases with free().
template <typename T> using c_array = std::unique_ptr<T[], void (*)(void *)>;

template <typename T> static c_array<T> make_c_array(size_t count)
{
    T *elements = static_cast<T *>(malloc(count * sizeof(T)));
    if (elements == nullptr)
        throw std::bad_alloc();
    return c_array<T>(elements, free);
}

// The reader's name for the format that the first bytes show, or NULL.
static const char *format_of(const uint8_t *bytes, size_t size)
{
    if (size >= 8 && memcmp(bytes, "\x89PNG\r\n\x1a\n", 8) == 0)
        return "png";
    if (size >= 3 && memcmp(bytes, "\xff\xd8\xff", 3) == 0)
        return "jpeg";
    if (size >= 12 && memcmp(bytes, "RIFF", 4) == 0 && memcmp(bytes + 8, "WEBP", 4) == 0)
        return "webp";
    return nullptr;
}

// Has a PNG all its chunks? libpng reports a missing rest on stderr and leaves by longjmp.
static bool is_complete_png(const uint8_t *bytes, size_t size)
{
    size_t at = 8;
    while (size - at >= 12) {
        const size_t length = (size_t)bytes[at] << 24 | (size_t)bytes[at + 1] << 16 |
                              (size_t)bytes[at + 2] << 8 | bytes[at + 3];
        if (length > size - at - 12)
            return false;
        if (memcmp(bytes + at + 4, "IEND", 4) == 0)
            return true;
        at += length + 12;
    }
    return false;
}

// Does the last scan of a JPEG have an end? libjpeg fills a missing rest with grey. Neither marker
// occurs within a scan.
static bool is_complete_jpeg(const uint8_t *bytes, size_t size)
{
    for (size_t at = size - 1; at-- > 0;) {
        if (bytes[at] == 0xff && bytes[at + 1] == 0xd9)
            return true;
        if (bytes[at] == 0xff && bytes[at + 1] == 0xda)
            return false;
    }
    return false;
}

static bool is_complete(const char *format, const uint8_t *bytes, size_t size)
{
    if (strcmp(format, "png") == 0)
        return is_complete_png(bytes, size);
    return strcmp(format, "jpeg") != 0 || is_complete_jpeg(bytes, size);
}

// Spreads 1 to 3 channels to RGBA. The pixels may be the last part of what is written.
static void expand_to_rgba(uint8_t *rgba, const uint8_t *pixels, size_t count, int channels)
{
    for (size_t i = 0; i < count; i++) {
        const uint8_t *const from = pixels + i * static_cast<size_t>(channels);
        uint8_t *const to = rgba + i * 4;
        const bool is_gray = channels < 3;
        to[0] = from[0];
        to[1] = is_gray ? from[0] : from[1];
        to[2] = is_gray ? from[0] : from[2];
        to[3] = channels == 2 ? from[1] : 255;
    }
}

// Divides colours by alpha, for a reader that multiplies though it is asked not to.
static void divide_by_alpha(uint8_t *rgba, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        uint8_t *const texel = rgba + i * 4;
        const unsigned alpha = texel[3];
        for (int c = 0; c < 3 && alpha != 0; c++) {
            const unsigned value = (texel[c] * 255u + alpha / 2) / alpha;
            texel[c] = static_cast<uint8_t>(value < 255 ? value : 255);
        }
    }
}

static enum status check_size(const ImageSpec &spec, const char *name)
{
    if (spec.width < 1 || spec.height < 1 || spec.width > MAX_SIDE || spec.height > MAX_SIDE ||
        (uint64_t)spec.width * (uint64_t)spec.height > MAX_TEXELS)
        return status_fail(STATUS_FORMAT, "%s: %d x %d texels are too many; scale it down", name,
                           spec.width, spec.height);
    if (spec.nchannels < 1)
        return status_fail(STATUS_FORMAT, "%s: it has no channels", name);
    return STATUS_OK;
}

static enum status decode(uint8_t **rgba, uint32_t *width, uint32_t *height, const uint8_t *bytes,
                          size_t size, const char *name)
{
    const char *format = format_of(bytes, size);
    if (format == nullptr)
        return status_fail(STATUS_FORMAT, "%s: it is no PNG, JPEG or WebP image; convert it to one",
                           name);
    if (!is_complete(format, bytes, size))
        return status_fail(STATUS_FORMAT, "%s: the image is cut short", name);
    OIIO::Filesystem::IOMemReader reader(const_cast<uint8_t *>(bytes), size);
    ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    auto input = ImageInput::create(format);
    if (!input)
        return status_fail(STATUS_UNSUPPORTED, "%s: %s", name, OIIO::geterror().c_str());
    ImageSpec spec;
    if (!input->set_ioproxy(&reader) || !input->open(name, spec, config))
        return status_fail(STATUS_FORMAT, "%s: %s", name, input->geterror().c_str());

    const enum status status = check_size(spec, name);
    if (status != STATUS_OK)
        return status;
    const size_t count = static_cast<size_t>(spec.width) * static_cast<size_t>(spec.height);
    const int channels = spec.nchannels > 4 ? 4 : spec.nchannels;
    auto out = make_c_array<uint8_t>(count * 4);
    uint8_t *const target = out.get() + count * static_cast<size_t>(4 - channels);
    if (!input->read_image(0, 0, 0, channels, TypeDesc::UINT8, target))
        return status_fail(STATUS_FORMAT, "%s: %s", name, input->geterror().c_str());
    if (channels != 4)
        expand_to_rgba(out.get(), target, count, channels);
    // OpenImageIO 2.4 multiplies WebP by alpha whatever the configuration says, and does not mark
    // it.
    const bool is_multiplied = strcmp(format, "webp") == 0 && channels == 4 &&
                               spec.get_int_attribute("oiio:UnassociatedAlpha") == 0;
    if (is_multiplied)
        divide_by_alpha(out.get(), count);
    *width = static_cast<uint32_t>(spec.width);
    *height = static_cast<uint32_t>(spec.height);
    *rgba = out.release();
    return STATUS_OK;
}

enum status image_decode(uint8_t **rgba, uint32_t *width, uint32_t *height, const void *bytes,
                         size_t size, const char *name)
{
    try {
        return decode(rgba, width, height, static_cast<const uint8_t *>(bytes), size, name);
    } catch (const std::bad_alloc &) {
        return status_fail(STATUS_NO_MEMORY, "%s: it does not fit", name);
    } catch (const std::exception &error) {
        return status_fail(STATUS_FORMAT, "%s: %s", name, error.what());
    }
}

static float srgb_to_linear(float value)
{
    return value <= 0.04045f ? value / 12.92f : powf((value + 0.055f) / 1.055f, 2.4f);
}

// Index of a channel, or -1.
static int find_channel(const ImageSpec &spec, const char *name)
{
    for (int i = 0; i < spec.nchannels; i++) {
        if (strcasecmp(spec.channelnames[static_cast<size_t>(i)].c_str(), name) == 0)
            return i;
    }
    return -1;
}

static enum status read_rgb(float **rgb, uint32_t *width, uint32_t *height, const char *path)
{
    if (access(path, R_OK) != 0)
        return status_fail(STATUS_IO, "%s: %s", path, strerror(errno));
    auto input = ImageInput::open(path);
    if (!input)
        return status_fail(STATUS_FORMAT, "%s: %s", path, OIIO::geterror().c_str());
    const ImageSpec &spec = input->spec();
    const enum status status = check_size(spec, path);
    if (status != STATUS_OK)
        return status;

    // Three colours, or one grey channel three times.
    int channels[3] = {find_channel(spec, "R"), find_channel(spec, "G"), find_channel(spec, "B")};
    if (channels[0] < 0 || channels[1] < 0 || channels[2] < 0) {
        const int gray = find_channel(spec, "Y");
        if (gray < 0 && spec.nchannels != 1)
            return status_fail(STATUS_FORMAT, "%s: it has no channels R, G and B", path);
        channels[0] = channels[1] = channels[2] = gray < 0 ? 0 : gray;
    }
    const size_t count = static_cast<size_t>(spec.width) * static_cast<size_t>(spec.height);
    const size_t stride = static_cast<size_t>(spec.nchannels);
    std::vector<float> pixels(count * stride);
    if (!input->read_image(0, 0, 0, spec.nchannels, TypeDesc::FLOAT, pixels.data()))
        return status_fail(STATUS_FORMAT, "%s: %s", path, input->geterror().c_str());

    const bool is_srgb = spec.format == TypeDesc::UINT8;
    auto out = make_c_array<float>(count * 3);
    for (size_t i = 0; i < count; i++) {
        for (size_t c = 0; c < 3; c++) {
            const float value = pixels[i * stride + static_cast<size_t>(channels[c])];
            out[i * 3 + c] = is_srgb ? srgb_to_linear(value) : value;
        }
    }
    *width = static_cast<uint32_t>(spec.width);
    *height = static_cast<uint32_t>(spec.height);
    *rgb = out.release();
    return STATUS_OK;
}

enum status image_read_rgb(float **rgb, uint32_t *width, uint32_t *height, const char *path)
{
    try {
        return read_rgb(rgb, width, height, path);
    } catch (const std::bad_alloc &) {
        return status_fail(STATUS_NO_MEMORY, "%s: it does not fit", path);
    } catch (const std::exception &error) {
        return status_fail(STATUS_FORMAT, "%s: %s", path, error.what());
    }
}

// One format that can be written.
struct output_format {
    const char *extension;
    const char *writer; // OpenImageIO's name
    bool is_float;
};

static const output_format OUTPUT_FORMATS[] = {{"exr", "openexr", true}, {"hdr", "hdr", true},
                                               {"tif", "tiff", true},    {"tiff", "tiff", true},
                                               {"png", "png", false},    {"jpg", "jpeg", false},
                                               {"jpeg", "jpeg", false}};

static const output_format *find_output_format(const char *path)
{
    const char *slash = strrchr(path, '/');
    const char *dot = strrchr(slash != nullptr ? slash : path, '.');
    for (const output_format &format : OUTPUT_FORMATS) {
        if (dot != nullptr && strcasecmp(dot + 1, format.extension) == 0)
            return &format;
    }
    return nullptr;
}

static ImageSpec make_spec(const output_format &format, uint32_t width, uint32_t height,
                           const struct image_attribute *attributes, size_t attribute_count)
{
    ImageSpec spec(static_cast<int>(width), static_cast<int>(height), 3,
                   format.is_float ? TypeDesc::FLOAT : TypeDesc::UINT8);
    spec.attribute("compression", strcmp(format.writer, "jpeg") == 0 ? "jpeg:95" : "zip");
    spec.attribute("oiio:ColorSpace", format.is_float ? "Linear" : "sRGB");
    spec.attribute("DateTime", ""); // else the writers put in the time of day
    for (size_t i = 0; i < attribute_count; i++)
        spec.attribute(attributes[i].name, attributes[i].value);
    return spec;
}

// 8 bits a channel; NaN becomes 0.
static std::vector<uint8_t> quantize(const float *rgb, size_t count)
{
    std::vector<uint8_t> bytes(count);
    for (size_t i = 0; i < count; i++) {
        const float value = rgb[i] > 0.0f ? (rgb[i] < 1.0f ? rgb[i] : 1.0f) : 0.0f;
        bytes[i] = static_cast<uint8_t>(value * 255.0f + 0.5f);
    }
    return bytes;
}

// Encodes an image in memory.
static enum status encode(std::vector<unsigned char> *out, const char *path, const float *rgb,
                          const ImageSpec &spec, const output_format &format)
{
    OIIO::Filesystem::IOVecOutput memory(*out);
    auto output = ImageOutput::create(format.writer);
    if (!output)
        return status_fail(STATUS_WRITE, "%s: %s", path, OIIO::geterror().c_str());
    if (!output->set_ioproxy(&memory) || !output->open(path, spec))
        return status_fail(STATUS_WRITE, "%s: %s", path, output->geterror().c_str());
    bool is_written;
    if (format.is_float) {
        is_written = output->write_image(TypeDesc::FLOAT, rgb);
    } else {
        const std::vector<uint8_t> bytes =
            quantize(rgb, static_cast<size_t>(spec.width) * static_cast<size_t>(spec.height) * 3);
        is_written = output->write_image(TypeDesc::UINT8, bytes.data());
    }
    if (!is_written || !output->close())
        return status_fail(STATUS_WRITE, "%s: %s", path, output->geterror().c_str());
    return STATUS_OK;
}

enum status image_write_rgb(const char *path, const float *rgb, uint32_t width, uint32_t height,
                            const struct image_attribute *attributes, size_t attribute_count)
{
    const output_format *format = find_output_format(path);
    if (format == nullptr)
        return status_fail(STATUS_USAGE,
                           "%s: images are written as .exr .hdr .png .jpg .jpeg .tif .tiff", path);
    try {
        std::vector<unsigned char> bytes;
        const ImageSpec spec = make_spec(*format, width, height, attributes, attribute_count);
        const enum status status = encode(&bytes, path, rgb, spec, *format);
        return status == STATUS_OK ? file_write(path, bytes.data(), bytes.size()) : status;
    } catch (const std::bad_alloc &) {
        return status_fail(STATUS_NO_MEMORY, "%s: it does not fit", path);
    } catch (const std::exception &error) {
        return status_fail(STATUS_WRITE, "%s: %s", path, error.what());
    }
}

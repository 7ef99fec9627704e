#include "scene/gltf_image.hpp"

#include <cstdlib>

#include "scene/gltf_buffer.hpp"

extern "C" {
#include "scene/image_io.h"
}

// texture_slot.texel_first counts the texels of all images in 31 bits.
static const uint64_t MAX_TEXEL_TOTAL = ((uint64_t)1 << 31) - 1;

static uint32_t wrap_mode(int mode, const std::string &owner)
{
    switch (mode) {
    case TINYGLTF_TEXTURE_WRAP_REPEAT:
        return 0;
    case TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE:
        return 1;
    case TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT:
        return 2;
    default:
        fail_import(STATUS_FORMAT, "%s: wrap mode %d does not exist", owner.c_str(), mode);
    }
}

// The image that a texture shows: the WebP one where there is one.
static int image_of(const tinygltf::Texture &texture, const std::string &owner)
{
    const tinygltf::Value *webp = find_extension(texture.extensions, "EXT_texture_webp");
    const int webp_source = webp != nullptr ? index_member(*webp, "source", owner) : -1;
    if (webp_source >= 0)
        return webp_source;
    if (texture.source < 0)
        fail_import(STATUS_UNSUPPORTED, "%s has no PNG, JPEG or WebP image; export it with one",
                    owner.c_str());
    return texture.source;
}

static int32_t use_image(import_context &context, texture_collector &collector, int index,
                         const std::string &owner)
{
    if (index < 0 || static_cast<size_t>(index) >= context.images.size())
        fail_import(STATUS_FORMAT, "%s: there is no image %d", owner.c_str(), index);
    const auto known = collector.images.find(index);
    if (known != collector.images.end())
        return known->second;
    const int32_t added = static_cast<int32_t>(collector.image_sources.size());
    collector.image_sources.push_back(index);
    collector.image_owners.push_back(owner);
    collector.images[index] = added;
    return added;
}

int32_t use_texture(import_context &context, texture_collector &collector, int index,
                    const std::string &owner)
{
    if (index < 0 || static_cast<size_t>(index) >= context.model.textures.size())
        fail_import(STATUS_FORMAT, "%s: there is no texture %d", owner.c_str(), index);
    const auto known = collector.textures.find(index);
    if (known != collector.textures.end())
        return known->second;

    const tinygltf::Texture &source = context.model.textures[static_cast<size_t>(index)];
    const std::string name =
        owner + ", " + label("texture", static_cast<size_t>(index), source.name);
    scene_texture texture = {};
    texture.image = use_image(context, collector, image_of(source, name), owner);
    if (source.sampler >= 0) {
        if (static_cast<size_t>(source.sampler) >= context.model.samplers.size())
            fail_import(STATUS_FORMAT, "%s: there is no sampler %d", name.c_str(), source.sampler);
        const tinygltf::Sampler &sampler =
            context.model.samplers[static_cast<size_t>(source.sampler)];
        texture.wrap_s = wrap_mode(sampler.wrapS, name);
        texture.wrap_t = wrap_mode(sampler.wrapT, name);
        texture.nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
    }
    const int32_t added = static_cast<int32_t>(context.textures.size());
    context.textures.push_back(texture);
    collector.textures[index] = added;
    return added;
}

// One image on its way through the parallel loop.
struct image_job {
    byte_span bytes;         // of a buffer view; else fetched from the uri
    std::string name;        // for messages
    enum status status;      // of this image
    std::string message;     // if it failed
    uint8_t *rgba = nullptr; // to be released with free()
    uint32_t width = 0;      // texels
    uint32_t height = 0;     // texels
};

// Fetches and decodes one image; failures are kept in the job, as nothing may leave the loop.
static void run_job(const import_context &context, const data_source &source, image_job &job)
{
    std::vector<uint8_t> fetched;
    try {
        if (source.buffer_view < 0) {
            fetched = fetch_uri(context, source.uri, job.name);
            job.bytes = {fetched.data(), fetched.size()};
        }
        job.status = image_decode(&job.rgba, &job.width, &job.height, job.bytes.data,
                                  job.bytes.size, job.name.c_str());
        if (job.status != STATUS_OK)
            job.message = status_message();
    } catch (const import_failure &failure) {
        job.status = failure.code;
        job.message = failure.message;
    } catch (...) {
        job.status = STATUS_NO_MEMORY;
    }
}

// What messages call an image: its name or file.
static std::string image_name(const data_source &source, int index)
{
    const bool has_file = !source.uri.empty() && !is_data_uri(source.uri);
    return label("image", static_cast<size_t>(index), has_file ? source.uri : source.name);
}

// Names a job and finds the bytes of a buffer view.
static void prepare_job(import_context &context, const data_source &source, int index,
                        image_job &job)
{
    job.name = image_name(source, index);
    if (source.buffer_view >= 0)
        job.bytes = view_bytes(context, source.buffer_view, job.name);
    else if (source.uri.empty())
        fail_import(STATUS_FORMAT, "%s has neither a uri nor a bufferView", job.name.c_str());
}

decoded_image decode_image(import_context &context, int index, const std::string &owner)
{
    if (index < 0 || static_cast<size_t>(index) >= context.images.size())
        fail_import(STATUS_FORMAT, "%s: there is no image %d", owner.c_str(), index);
    const data_source &source = context.images[static_cast<size_t>(index)];
    image_job job;
    prepare_job(context, source, index, job);
    run_job(context, source, job);
    decoded_image out;
    out.rgba.reset(job.rgba);
    out.width = job.width;
    out.height = job.height;
    if (job.status != STATUS_OK)
        fail_import(job.status, "%s: %s", owner.c_str(), job.message.c_str());
    return out;
}

// Moves decoded images into the scene, or leaves with the first failure.
static void keep_images(import_context &context, const texture_collector &collector,
                        std::vector<image_job> &jobs)
{
    uint64_t texel_total = 0;
    for (size_t i = 0; i < jobs.size(); i++) {
        image_job &job = jobs[i];
        if (job.status == STATUS_NO_MEMORY)
            fail_import(STATUS_NO_MEMORY, "%s does not fit", job.name.c_str());
        if (job.status != STATUS_OK)
            fail_import(job.status, "%s: %s", collector.image_owners[i].c_str(),
                        job.message.c_str());
        const size_t size = static_cast<size_t>(job.width) * job.height * 4;
        texel_total += size / 4;
        if (texel_total > MAX_TEXEL_TOTAL)
            fail_import(STATUS_LIMIT, "textures have more than 2^31 texels; scale them down");
        scene_image &image = context.scene->images[i];
        image.name = arena_text(context, job.name);
        image.width = job.width;
        image.height = job.height;
        if (!arena_adopt(&context.scene->arena, job.rgba, size))
            fail_import(STATUS_NO_MEMORY, "%s does not fit", job.name.c_str());
        image.rgba = job.rgba;
        job.rgba = nullptr; // the scene owns it now
    }
}

void load_images(import_context &context, const texture_collector &collector)
{
    // Buffer views are resolved first, as fetching a buffer changes the context.
    std::vector<image_job> jobs(collector.image_sources.size());
    for (size_t i = 0; i < jobs.size(); i++) {
        const int index = collector.image_sources[i];
        const data_source &source = context.images[static_cast<size_t>(index)];
        prepare_job(context, source, index, jobs[i]);
    }

    context.scene->images = arena_array<scene_image>(context, jobs.size());
    context.scene->image_count = static_cast<uint32_t>(jobs.size());
    const long job_count = static_cast<long>(jobs.size());
#pragma omp parallel for schedule(dynamic)
    for (long i = 0; i < job_count; i++) {
        const size_t index = static_cast<size_t>(collector.image_sources[static_cast<size_t>(i)]);
        run_job(context, context.images[index], jobs[static_cast<size_t>(i)]);
    }
    try {
        keep_images(context, collector, jobs);
    } catch (...) {
        for (image_job &job : jobs)
            free(job.rgba);
        throw;
    }
}

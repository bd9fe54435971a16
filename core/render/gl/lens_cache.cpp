#include "core/render/gl/lens_cache.h"

#include <cmath>

#include "core/render/gl/view_target.h"

namespace camrig::render::gl {
namespace {

GlTexture upload(const GlFunctions& gl, ImageSize size, GLenum storage, GLenum format, GLenum type, const void* data) {
    GlTexture texture = make_texture_2d(gl);
    gl.TextureStorage2D(texture.name(), 1, storage, size.width, size.height);
    gl.TextureSubImage2D(texture.name(), 0, 0, 0, size.width, size.height, format, type, data);
    return texture;
}

}  // namespace

void LensOnDevice::to_optical_axis(std::span<float> depth) const {
    if (plan.depth_factor.empty()) return;
    CHECK(depth.size() == plan.depth_factor.size());
    for (std::size_t i = 0; i < depth.size(); ++i) {
        // Nothing stays infinitely far, whichever way its face looks.
        if (std::isfinite(depth[i])) depth[i] *= plan.depth_factor[i];
    }
}

Result<std::shared_ptr<const LensOnDevice>> LensCache::lens_of(CameraId camera, const world::CameraSpec& spec,
                                                               world::Antialias antialias) {
    const bool is_forced = spec.lens_sampling.method != world::LensMethod::automatic;
    if (spec.lens.model == camera::LensModel::pinhole && !is_forced) {
        of_camera_.erase(camera);
        return nullptr;
    }
    const Key key{.size = spec.size,
                  .intrinsics = spec.intrinsics,
                  .lens = spec.lens,
                  .sampling = spec.lens_sampling,
                  .supersampling = supersampling_of(antialias),
                  .multisampling = multisampling_of(antialias)};
    std::shared_ptr<const Entry>& own = of_camera_[camera];
    if (own == nullptr || own->key != key) {
        std::shared_ptr<const Entry> found;
        for (const auto& [unused, entry] : of_camera_) {
            if (entry != nullptr && entry->key == key) found = entry;
        }
        own = found != nullptr ? found : std::make_shared<const Entry>(Entry{key, make(key)});
    }
    if (!own->lens) return std::unexpected(own->lens.error());
    return std::shared_ptr<const LensOnDevice>(own, &*own->lens);
}

Result<LensOnDevice> LensCache::make(const Key& key) const {
    auto camera = camera::CameraModel::create(key.size, key.intrinsics, key.lens);
    if (!camera) return std::unexpected(camera.error());
    const int samples = key.supersampling * key.supersampling * key.multisampling;
    auto plan = make_lens_plan(*camera, key.sampling,
                               {.max_side = max_side_ / key.supersampling, .max_texels = max_target_samples / samples});
    if (!plan) return std::unexpected(plan.error());

    LensOnDevice lens{.plan = std::move(*plan), .map = {}, .footprint = {}};
    lens.map = upload(gl_, key.size, GL_RG32I, GL_RG_INTEGER, GL_INT, lens.plan.map.data());
    if (key.supersampling > 1) {
        lens.footprint = upload(gl_, key.size, GL_RGBA32F, GL_RGBA, GL_FLOAT, lens.plan.footprint.data());
    }
    lens.plan.map = {};
    lens.plan.footprint = {};
    return lens;
}

}  // namespace camrig::render::gl

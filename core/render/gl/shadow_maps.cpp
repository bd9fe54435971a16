#include "core/render/gl/shadow_maps.h"

#include <spdlog/spdlog.h>

#include "core/render/scene/shadow_casters.h"

namespace camrig::render::gl {
namespace {

GlTexture depth_layers(const GlFunctions& gl, int side, std::size_t count) {
    GlTexture texture = make_texture(gl, GL_TEXTURE_2D_ARRAY);
    gl.TextureStorage3D(texture.name(), 1, GL_DEPTH_COMPONENT32F, side, side, static_cast<GLsizei>(count));
    return texture;
}

Result<std::vector<GlFramebuffer>> targets_of(const GlFunctions& gl, const GlTexture& layers, std::size_t count) {
    std::vector<GlFramebuffer> targets;
    for (std::size_t i = 0; i < count; ++i) {
        targets.push_back(make_framebuffer(gl));
        const GLuint name = targets.back().name();
        gl.NamedFramebufferTextureLayer(name, GL_DEPTH_ATTACHMENT, layers.name(), 0, static_cast<GLint>(i));
        gl.NamedFramebufferDrawBuffers(name, 0, nullptr);
        if (gl.CheckNamedFramebufferStatus(name, GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
            return error(ErrorKind::resource_exhausted,
                         "no memory on the device for shadow maps: there are no shadows");
    }
    return targets;
}

}  // namespace

Result<void> ShadowMaps::plan(const scene::PlacedScene& scene) {
    const std::vector<WorldBox> boxes = shadow_receivers(scene);
    const auto size = [this] { return std::pair(views_.size(), views_.empty() ? 0 : views_.front().side); };
    const auto before = size();
    views_ = plan_shadows(scene.lights(), scene.environment().exposure, boxes, !scene.has_baked_light());
    if (!boxes.empty()) receivers_ = joined(boxes);
    if (size() == before) return {};
    still_targets_.clear();
    now_targets_.clear();
    still_ = {};
    now_ = {};
    if (views_.empty()) return {};
    still_ = depth_layers(gl_, views_.front().side, views_.size());
    now_ = depth_layers(gl_, views_.front().side, views_.size());
    auto still = targets_of(gl_, still_, views_.size());
    auto now = targets_of(gl_, now_, views_.size());
    if (!still || !now) {
        views_.clear();
        return std::unexpected((still ? now : still).error());
    }
    still_targets_ = std::move(*still);
    now_targets_ = std::move(*now);
    return {};
}

void ShadowMaps::copy_from_still(std::size_t layer, const PixelRect& rect) {
    gl_.CopyImageSubData(still_.name(), GL_TEXTURE_2D_ARRAY, 0, rect.x0, rect.y0, static_cast<GLint>(layer),
                         now_.name(), GL_TEXTURE_2D_ARRAY, 0, rect.x0, rect.y0, static_cast<GLint>(layer), rect.width(),
                         rect.height(), 1);
}

void ShadowMaps::update(GpuScene& gpu, DrawPass& pass, bool has_detail_levels) {
    const scene::PlacedScene& scene = gpu.placed();
    bool is_new = false;
    if (scene.statics_number() != statics_number_) {
        const std::vector<ShadowView> before = views_;
        statics_number_ = scene.statics_number();
        if (auto planned = plan(scene); !planned) spdlog::warn("{}", planned.error().message);
        // A light that only flickers changes no shadow.
        is_new = scene.objects_number() != objects_number_ || before != views_;
        objects_number_ = scene.objects_number();
    }
    find_moving_casters(scene, casters_);
    if (views_.empty()) return;

    constexpr std::size_t max_rects = 16;
    dirty_.resize(views_.size());
    pass.begin_shadows(views_.front().side);
    for (std::size_t i = 0; i < views_.size(); ++i) {
        std::vector<PixelRect> stale = std::move(dirty_[i]);
        if (is_new) {
            pass.draw_shadows(still_targets_[i].name(), true, views_[i], gpu, true, 0.0);
            stale = {{0, 0, views_[i].side, views_[i].side}};
        }
        dirty_[i].clear();
        for (const WorldBox& caster : casters_) {
            if (const auto rect = shadow_texels(views_[i], caster)) dirty_[i].push_back(*rect);
        }
        dirty_[i] = disjoint_cover(std::move(dirty_[i]), max_rects);
        for (const PixelRect& rect : stale) copy_from_still(i, rect);
        if (!dirty_[i].empty())
            pass.draw_shadows(now_targets_[i].name(), false, views_[i], gpu, false,
                              has_detail_levels ? 0.5 * views_[i].texel_m : 0.0);
    }
    pass.end_shadows();
}

std::vector<PixelRect> ShadowMaps::changed_pixels(const ViewTransform& view) const {
    std::vector<PixelRect> rects;
    for (const ShadowView& shadow : views_) {
        for (const WorldBox& caster : casters_) {
            if (const auto rect = shadow_pixels(view, shadow, caster, receivers_)) rects.push_back(*rect);
        }
    }
    return rects;
}

}  // namespace camrig::render::gl

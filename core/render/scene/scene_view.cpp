#include "core/render/scene/scene_view.h"

#include <cmath>

namespace camrig::render::scene {

SceneView make_scene_view(const PlacedScene& scene, const ViewTransform& transform, double far_m,
                          world::Quality quality, double max_detail_error_px, std::shared_ptr<const LensView> lens) {
    SceneView view{.scene = &scene,
                   .transform = transform,
                   .frustum = {},
                   .far_m = far_m,
                   .quality = quality,
                   .max_detail_error_px = max_detail_error_px,
                   .lens = std::move(lens),
                   .has_contact_occlusion = quality == world::Quality::beautiful};
    if (view.lens == nullptr) {
        view.frustum = make_frustum(transform, far_m);
    } else if (!view.lens->is_wide()) {
        view.frustum = view.lens->frustum(transform.near_m, far_m);
    }
    return view;
}

float exposure_gain_of(const world::CameraSpec& spec) {
    return static_cast<float>(std::exp2(spec.exposure_ev));
}

FogInView SceneView::fog() const {
    const world::Environment& environment = scene->environment();
    if (!has_fog || !(environment.fog.visibility_m > 0.0)) return {};
    return {environment.fog.color.value_or(environment.background) * exposure(),
            static_cast<float>(world::extinction_per_m(environment.fog))};
}

glm::vec3 SceneView::background() const {
    const FogInView in = fog();
    return in.per_m > 0.0f ? in.color : scene->environment().background * exposure();
}

std::optional<SeenSurface> SceneView::see(const PlacedSurface& surface, bool is_static) const {
    const bool has_patches = has_contact_shadows && !has_contact_occlusion && quality != world::Quality::fast;
    if (surface.is_contact_shadow && !has_patches) return std::nullopt;
    const world::Box& bounds = surface.bounds;
    const glm::dmat4 optical_from_local = transform.optical_from(surface.world_from_local);
    if (!may_see(optical_from_local, bounds)) return std::nullopt;
    SeenSurface seen{.placed = &surface, .is_static = is_static, .optical_from_local = optical_from_local};
    if (max_detail_error_px > 0.0 && !surface.primitive->coarser.empty()) {
        const double px_per_m = lens != nullptr ? lens->error_px(transform, optical_from_local, bounds, 1.0)
                                                : detail_error_px(transform, optical_from_local, bounds, 1.0);
        seen.level = coarsest_level(surface, [&](double error_m) { return error_m * px_per_m <= max_detail_error_px; });
    }
    const glm::dvec3 middle(optical_from_local *
                            glm::dvec4(0.5 * (glm::dvec3(bounds.min) + glm::dvec3(bounds.max)), 1.0));
    seen.distance_m = lens != nullptr && lens->is_wide() ? glm::length(middle) : middle.z;
    return seen;
}

void SceneView::see_all(bool of_statics, std::vector<SeenSurface>* opaque, std::vector<SeenSurface>* blended) const {
    const PlacedSurfaces& group = scene->group_of(of_statics);
    const auto add = [&](const PlacedSurface& surface) {
        auto* const list = surface.primitive->is_blended ? blended : opaque;
        if (list == nullptr) return;
        if (const auto seen = see(surface, of_statics)) list->push_back(*seen);
    };
    if (opaque == nullptr) {
        for (const std::size_t i : group.blended()) add(group.all()[i]);
    } else {
        for (const PlacedSurface& surface : group.all()) add(surface);
    }
}

bool SceneView::may_see(const glm::dmat4& optical_from_local, const world::Box& bounds) const {
    if (lens != nullptr && lens->is_wide()) return lens->may_see(optical_from_local, bounds, far_m);
    return may_be_visible(frustum, optical_from_local, bounds.min, bounds.max);
}

std::optional<PixelRect> SceneView::pixels_of(const glm::dmat4& optical_from_local, const world::Box& bounds) const {
    if (lens != nullptr) return lens->pixels_of(optical_from_local, bounds, transform.near_m);
    return screen_bounds(transform, optical_from_local, bounds.min, bounds.max);
}

bool SceneView::touches(const SeenSurface& seen, std::span<const PixelRect> rects) const {
    const auto pixels = pixels_of(seen);
    return pixels && std::ranges::any_of(rects, [&](const PixelRect& rect) { return rect.intersects(*pixels); });
}

void SeenMovers::see(const SceneView& view) {
    opaque.clear();
    blended.clear();
    rects.clear();
    for (const PlacedSurface& surface : view.scene->movers().all()) {
        const auto seen = view.see(surface, false);
        if (!seen) continue;
        const auto pixels = view.pixels_of(*seen);
        if (!pixels) continue;
        rects.push_back(*pixels);
        (surface.primitive->is_blended ? blended : opaque).push_back(*seen);
    }
}

}  // namespace camrig::render::scene

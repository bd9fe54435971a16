#include "core/render/scene/seen_statics.h"

#include <span>
#include <utility>

#include <glm/gtc/matrix_transform.hpp>

namespace camrig::render::scene {
namespace {

/// Light with a range is none at all beyond it. A rounding more.
constexpr double range_margin = 1.01;

bool may_see_ball(const SceneView& view, const glm::dvec3& centre, double radius) {
    const glm::dmat4 optical_from_ball = view.transform.optical_from(glm::translate(glm::dmat4(1.0), centre));
    const glm::vec3 corner(static_cast<float>(radius));
    return view.may_see(optical_from_ball, {-corner, corner});
}

/// Of the light sets of all static surfaces that a view may show, those that may shine on what it shows of them.
/// quality: of the camera; a view of it that shows no colour has another.
std::vector<world::Light> lights_of_statics(const SceneView& view, world::Quality quality) {
    const std::span<const world::Light> all = view.scene->lights();
    std::vector<SeenSurface> surfaces;
    view.see_all(true, &surfaces, &surfaces);
    std::vector<bool> shines(all.size()), is_in_full_set(all.size());
    for (const SeenSurface& surface : surfaces) {
        const LightSet& set = view.scene->light_sets()[surface.placed->light_set];
        const int count = set.directional + set.local;
        for (int i = 0; i < count; ++i) {
            const std::size_t light = set.lights[static_cast<std::size_t>(i)];
            shines[light] = true;
            // It may have taken another one's place.
            if (count == max_lights_per_draw) is_in_full_set[light] = true;
        }
    }
    std::vector<world::Light> lights;
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (!shines[i]) continue;
        // Vertices shaded beside the picture show in it.
        const bool may_be_aside = all[i].type != world::LightType::directional && all[i].range > 0.0f &&
                                  quality == world::Quality::simple && !is_in_full_set[i];
        if (!may_be_aside || may_see_ball(view, all[i].position, range_margin * double{all[i].range}))
            lights.push_back(all[i]);
    }
    return lights;
}

}  // namespace

std::uint64_t SeenStatics::number_of(const View& view, const SceneView& scene) {
    const PlacedScene& placed = *scene.scene;
    Seen& seen = seen_[view.camera];
    const bool is_same_view = seen.number != 0 && seen.spec_revision == view.spec_revision && seen.pose == view.pose &&
                              seen.quality == view.quality;
    if (is_same_view && seen.statics == placed.statics_number() && seen.proxies == placed.proxies_number()) {
        if (!seen.lights) seen.lights = lights_of_statics(scene, view.quality);
        return seen.number;
    }
    std::optional<std::vector<world::Light>> lights;
    if (is_same_view && view.quality != world::Quality::beautiful) lights = lights_of_statics(scene, view.quality);
    const bool is_same = lights && lights == seen.lights && seen.objects == placed.objects_number() &&
                         seen.environment == placed.environment();
    seen = {.number = is_same ? seen.number : ++last_,
            .spec_revision = view.spec_revision,
            .pose = view.pose,
            .quality = view.quality,
            .statics = placed.statics_number(),
            .objects = placed.objects_number(),
            .proxies = placed.proxies_number(),
            .environment = placed.environment(),
            .lights = std::move(lights)};
    return seen.number;
}

}  // namespace camrig::render::scene

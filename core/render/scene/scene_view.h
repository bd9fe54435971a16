#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <vector>

#include "core/render/pixel_rect.h"
#include "core/render/scene/detail_levels.h"
#include "core/render/scene/lens_view.h"
#include "core/render/scene/placed_scene.h"
#include "core/render/view_transform.h"
#include "core/world/camera_spec.h"

/// What a picture sees of a placed scene: its list of draws.
namespace camrig::render::scene {

/// A draw that may touch the picture.
struct SeenSurface {
    const PlacedSurface* placed = nullptr;
    bool is_static = false;  ///< of PlacedScene::statics, else of its movers
    int level = 0;           ///< of detail; 0: the full mesh, else one more than into PreparedPrimitive::coarser
    glm::dmat4 optical_from_local{1.0};
    /// Of the middle of its bounds along the optical axis (from the eye of a wide lens), for the order of what is
    /// blended.
    double distance_m = 0.0;
    std::size_t order = 0;  ///< among those at one distance
};

/// How much more light a camera shows than the scene's exposure has it.
float exposure_gain_of(const world::CameraSpec& spec);

/// Of the light of something at a distance exp(-per_m * distance) is left; the rest is the fog's.
struct FogInView {
    glm::vec3 color{0.0f};  ///< times the exposure
    float per_m = 0.0f;     ///< 0: no fog
};

/// One picture of a scene.
struct SceneView {
    const PlacedScene* scene = nullptr;
    ViewTransform transform;
    Frustum frustum;  ///< not of a wide lens
    double far_m = 0.0;
    world::Quality quality = world::Quality::simple;
    double max_detail_error_px = 0.0;           ///< 0: every mesh in full
    std::shared_ptr<const LensView> lens = {};  ///< null: none is looked through
    glm::vec3 light_gain{1.0f};                 ///< factor on all light that falls on something
    bool has_contact_shadows = true;            ///< but at quality fast
    /// Bodies darken light from all around (BodiesInView); then there are no patches of ContactShadows.
    bool has_contact_occlusion = false;
    float exposure_gain = 1.0f;   ///< of the camera, beside the exposure of the scene
    bool has_fog = true;          ///< if the scene has
    bool has_tone_curve = false;  ///< lit surfaces are shown by it (quality beautiful)
    double lamps_hz = 0.0;        ///< lamps that flicker so are at their peak (light_in_view)

    float exposure() const { return scene->environment().exposure * exposure_gain; }
    FogInView fog() const;
    /// What is where nothing is: the background, or fog without end.
    glm::vec3 background() const;
    /// The draw of a surface, if any of it may be seen.
    std::optional<SeenSurface> see(const PlacedSurface& surface, bool is_static) const;
    /// Appends what may be seen of what stands still, or of what moves, in the order of the scene; null: not wanted.
    void see_all(bool of_statics, std::vector<SeenSurface>* opaque, std::vector<SeenSurface>* blended) const;
    /// False only if the box certainly touches no pixel.
    bool may_see(const glm::dmat4& optical_from_local, const world::Box& bounds) const;
    /// Every pixel that the box, or the draw, may touch.
    std::optional<PixelRect> pixels_of(const glm::dmat4& optical_from_local, const world::Box& bounds) const;
    std::optional<PixelRect> pixels_of(const SeenSurface& seen) const {
        return pixels_of(seen.optical_from_local, seen.placed->bounds);
    }
    bool touches(const SeenSurface& seen, std::span<const PixelRect> rects) const;
};
SceneView make_scene_view(const PlacedScene& scene, const ViewTransform& transform, double far_m,
                          world::Quality quality, double max_detail_error_px,
                          std::shared_ptr<const LensView> lens = {});

/// What one picture sees of what moves.
struct SeenMovers {
    std::vector<SeenSurface> opaque, blended;
    std::vector<PixelRect> rects;  ///< which pixels each of them may touch

    void see(const SceneView& view);
};

/// For what is blended. By hand, because stable_sort() allocates.
template <typename Draw>
void sort_far_to_near(std::vector<Draw>& draws) {
    for (std::size_t i = 0; i < draws.size(); ++i) draws[i].order = i;
    std::ranges::sort(draws, [](const Draw& a, const Draw& b) {
        return a.distance_m != b.distance_m ? a.distance_m > b.distance_m : a.order < b.order;
    });
}

/// The coarsest level of detail of a surface whose error in metres `is_fine`.
template <typename IsFine>
int coarsest_level(const PlacedSurface& surface, const IsFine& is_fine) {
    const PreparedPrimitive& primitive = *surface.primitive;
    if (primitive.coarser.empty()) return 0;
    const double scale = detail_error_scale(primitive.source->bounds, surface.bounds, surface.world_from_local);
    const auto too_coarse = std::ranges::find_if_not(
        primitive.coarser, [&](const MeshLevel& level) { return is_fine(level.error * scale); });
    return static_cast<int>(too_coarse - primitive.coarser.begin());
}

}  // namespace camrig::render::scene

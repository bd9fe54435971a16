#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "core/render/pixel_rect.h"
#include "core/render/view_transform.h"
#include "core/world/snapshot.h"

namespace camrig::render {

/// Of the lights of a scene, at most so many have shadow maps: directional ones first, then the others, the brighter
/// first.
inline constexpr int max_shadowed_lights = 4;
/// Of all of them together: a point light has one for each side of a cube around it that sees anything.
inline constexpr int max_shadow_maps = 8;
/// Texels along a side of a shadow map; of the finer ones, where there are few maps and their texels would be coarser
/// than `fine_shadow_texel_m`: who stands in a street must have a shadow.
inline constexpr int shadow_map_side = 2048, fine_shadow_map_side = 4096;
inline constexpr double fine_shadow_texel_m = 0.03;
inline constexpr std::size_t max_fine_shadow_maps = 2;
/// The most that the map of a directional light covers; beyond, surfaces are lit.
inline constexpr double max_shadow_extent_m = 200.0;
/// Near plane of the shadow maps of spot and point lights.
inline constexpr double nearest_local_caster_m = 0.05;
/// Texels that a filtered look-up may read from the one it falls into.
inline constexpr int shadow_filter_texels = 3;
/// A surface is looked up so many of a texel's longer side over itself, along the light, which moves no shadow aside.
inline constexpr float shadow_bias_texels = 0.5f;
/// What turns away from the light farther than this cosine is taken for what does not.
inline constexpr float least_shadow_cosine = 0.1f;

struct WorldBox {
    glm::dvec3 min{0.0};
    glm::dvec3 max{0.0};
};
/// Of a box placed in the world.
WorldBox world_box(const glm::dmat4& world_from_local, const world::Box& local);
WorldBox joined(std::span<const WorldBox> boxes);  ///< of at least one

/// Where a shadow map of one light looks. Depends on the light and on what stands still, never on a camera: all
/// cameras share the map, and no shadow swims when one turns.
///
/// Map frame: x right, y down, z along the light, its origin at `origin`. Points are given relative to that origin in
/// double before they become floats, so shadows are the same at every distance from the world's origin.
struct ShadowView {
    std::size_t light = 0;       ///< into the scene's lights
    int side = shadow_map_side;  ///< texels; the same of all maps
    bool is_local = false;       ///< of a spot or point light: rays part from `origin`
    glm::dvec3 origin{0.0};
    glm::dmat3 map_from_world{1.0};
    /// clip = clip_from_map * (x, y, z, 1); OpenGL's unit cube with depth 0 to 1, w = z for a local light and 1
    /// otherwise.
    glm::dmat4 clip_from_map{1.0};
    /// Side of a texel: constant + per metre from the light.
    double texel_m = 0.0;
    double texel_per_m = 0.0;
    Frustum frustum;

    /// Rotation in the upper left, exact difference to the origin in the translation.
    glm::dmat4 map_from(const glm::dmat4& world_from_local) const;
    friend bool operator==(const ShadowView& a, const ShadowView& b);
};

/// Chooses the lights and places their maps around `receivers`, the boxes of what stands still and is lit; maps of one
/// light come after each other, and what one of them has in shadow is so. Empty where there is nothing to fall on or no
/// light for it. with_local: not where baked light has that of lamps.
std::vector<ShadowView> plan_shadows(std::span<const world::Light> lights, float exposure,
                                     std::span<const WorldBox> receivers, bool with_local = true);

/// How deep planes of a view are beside a point of theirs, from the rows that make place and depth in a map of a point
/// in the optical frame: the dot products of these and (n, -dot(n, p)), of the plane through p with normal n, are some
/// a, b and c, and a step to the right or down in the map is one of -a / c or -b / c in depth. Lines and planes stay so
/// in a map.
std::array<glm::vec4, 3> plane_rows(const std::array<glm::dvec4, 4>& rows);

/// All texels that something inside the box may be in, and those whose look-ups may read them.
std::optional<PixelRect> shadow_texels(const ShadowView& shadow, const WorldBox& caster);

/// Every pixel of a view in which the shadow of something inside the box may fall on anything inside `receivers`.
std::optional<PixelRect> shadow_pixels(const ViewTransform& view, const ShadowView& shadow, const WorldBox& caster,
                                       const WorldBox& receivers);

}  // namespace camrig::render

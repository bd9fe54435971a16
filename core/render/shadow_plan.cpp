#include "core/render/shadow_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/portable_math.h"
#include "core/render/scene/light_selection.h"

namespace camrig::render {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
/// A single map of a wider spot would have texels that are too coarse at the rim: it has sides of a cube.
constexpr float widest_single_cone_rad = 1.3f;
/// Around everything, so that nothing lies on the border of a map.
constexpr double margin = 1.02;

glm::dvec3 corner(const WorldBox& box, int i) {
    return {(i & 1 ? box.max : box.min).x, (i & 2 ? box.max : box.min).y, (i & 4 ? box.max : box.min).z};
}

/// Rows: any two directions across the light, and the light's own.
glm::dmat3 map_rotation(const glm::dvec3& towards) {
    const glm::dvec3 z = glm::normalize(towards);
    const glm::dvec3 aside = std::abs(z.z) < 0.9 ? glm::dvec3(0.0, 0.0, 1.0) : glm::dvec3(1.0, 0.0, 0.0);
    const glm::dvec3 x = glm::normalize(glm::cross(aside, z));
    return glm::transpose(glm::dmat3(x, glm::cross(z, x), z));
}

glm::dvec4 plane(const glm::dvec3& inwards, double offset) {
    const double length = glm::length(inwards);
    return {inwards / length, offset / length};
}

/// The middle one of each coordinate: a few things far away do not move it.
glm::dvec3 median_centre(std::span<const WorldBox> boxes) {
    glm::dvec3 result;
    std::vector<double> values;
    for (int axis = 0; axis < 3; ++axis) {
        values.clear();
        for (const WorldBox& box : boxes) values.push_back(0.5 * (box.min[axis] + box.max[axis]));
        const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
        std::ranges::nth_element(values, middle);
        result[axis] = *middle;
    }
    return result;
}

ShadowView directional_view(const world::Light& light, std::span<const WorldBox> receivers) {
    const WorldBox all = joined(receivers);
    ShadowView view;
    view.map_from_world = map_rotation(light.direction);
    view.origin = 0.5 * (all.min + all.max);
    if (glm::length(all.max - all.min) > max_shadow_extent_m) {
        const glm::dvec3 half(0.5 * max_shadow_extent_m);
        view.origin = glm::clamp(median_centre(receivers), glm::min(all.min + half, view.origin),
                                 glm::max(all.max - half, view.origin));
    }
    glm::dvec3 low(infinity), high(-infinity);
    for (int i = 0; i < 8; ++i) {
        const glm::dvec3 p = view.map_from_world * (corner(all, i) - view.origin);
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    const double extent = 0.5 * max_shadow_extent_m;
    low = glm::max(low, glm::dvec3(-extent, -extent, -infinity));
    high = glm::min(high, glm::dvec3(extent, extent, infinity));
    const glm::dvec3 middle = 0.5 * (low + high);
    const glm::dvec3 half = glm::max(0.5 * margin * (high - low), glm::dvec3(1e-3));
    view.origin += glm::transpose(view.map_from_world) * middle;

    view.clip_from_map = glm::dmat4(1.0);
    for (int i = 0; i < 2; ++i) view.clip_from_map[i][i] = 1.0 / half[i];
    view.clip_from_map[2][2] = 0.5 / half.z;
    view.clip_from_map[3][2] = 0.5;
    view.texel_m = 2.0 * std::max(half.x, half.y) / shadow_map_side;
    view.frustum.planes = {glm::dvec4(1, 0, 0, half.x), glm::dvec4(-1, 0, 0, half.x), glm::dvec4(0, 1, 0, half.y),
                           glm::dvec4(0, -1, 0, half.y), glm::dvec4(0, 0, -1, half.z)};
    view.frustum.count = 5;  // whatever is before the near plane casts too (GL_DEPTH_CLAMP)
    return view;
}

/// A map of a local light that sees as far aside of `towards` as the tangent says, up to `far`.
ShadowView pyramid(const glm::dvec3& light, const glm::dvec3& towards, double tangent, double far) {
    ShadowView view;
    view.is_local = true;
    view.map_from_world = map_rotation(towards);
    view.origin = light;
    const double near = nearest_local_caster_m;
    tangent *= margin;
    view.clip_from_map = glm::dmat4(0.0);
    view.clip_from_map[0][0] = view.clip_from_map[1][1] = 1.0 / tangent;
    view.clip_from_map[2] = {0.0, 0.0, far / (far - near), 1.0};
    view.clip_from_map[3][2] = -near * far / (far - near);
    view.texel_per_m = 2.0 * tangent / shadow_map_side;
    view.frustum.planes = {plane({1, 0, tangent}, 0),  plane({-1, 0, tangent}, 0), plane({0, 1, tangent}, 0),
                           plane({0, -1, tangent}, 0), plane({0, 0, 1}, -near),    plane({0, 0, -1}, far)};
    view.frustum.count = 6;
    return view;
}

bool sees_any(const ShadowView& view, std::span<const WorldBox> boxes) {
    return std::ranges::any_of(boxes, [&](const WorldBox& box) {
        glm::dmat4 world_from_box(1.0);
        world_from_box[3] = glm::dvec4(0.5 * (box.min + box.max), 1.0);
        const glm::vec3 half(0.5 * (box.max - box.min));
        return may_be_visible(view.frustum, view.map_from(world_from_box), -half, half);
    });
}

/// One map of a spot, or those sides of a cube, a little larger than they are, so that filters at their borders find
/// what they need, that see light and something for it to fall on.
std::vector<ShadowView> local_views(const world::Light& light, float exposure, std::span<const WorldBox> receivers) {
    const WorldBox all = joined(receivers);
    double far = 0.0;
    for (int i = 0; i < 8; ++i) far = std::max(far, glm::distance(corner(all, i), light.position));
    far = std::min({far, scene::reach_m(light, exposure), max_shadow_extent_m});
    if (!(far > 2.0 * nearest_local_caster_m)) return {};
    const bool is_spot = light.type == world::LightType::spot;
    if (is_spot && light.outer_cone_rad <= widest_single_cone_rad)
        return {pyramid(light.position, light.direction, portable::tan(double{light.outer_cone_rad}), far)};
    std::vector<ShadowView> views;
    const glm::dmat3 axes = is_spot ? glm::transpose(map_rotation(light.direction)) : glm::dmat3(1.0);
    for (int side = 0; side < 6; ++side) {
        const glm::dvec3 towards = (side % 2 == 0 ? 1.0 : -1.0) * axes[2 - side / 2];
        // The last axis is a spot's own, which opens to a quarter turn at most: nothing of its light goes behind it.
        if (is_spot && side == 1) continue;
        const ShadowView view = pyramid(light.position, towards, 1.0, far);
        if (sees_any(view, receivers)) views.push_back(view);
    }
    return views;
}

/// Bounds on a plane of the convex hull of points (x, y, depth > 0 ahead), cut off at `near`: of the points that are
/// beyond it and of where the lines between all pairs meet it. False if nothing is beyond.
template <typename Project>
bool hull_bounds(std::span<const glm::dvec3> points, double near, const Project& project, glm::dvec2& low,
                 glm::dvec2& high) {
    low = glm::dvec2(infinity);
    high = glm::dvec2(-infinity);
    const auto add = [&](const glm::dvec3& p) {
        const glm::dvec2 place = project(p);
        low = glm::min(low, place);
        high = glm::max(high, place);
    };
    for (const glm::dvec3& a : points) {
        if (!(a.z > near)) continue;
        add(a);
        for (const glm::dvec3& b : points) {
            if (b.z > near) continue;
            const double t = (a.z - near) / (a.z - b.z);
            const glm::dvec3 cut = a + t * (b - a);
            add({cut.x, cut.y, near});
        }
    }
    return low.x <= high.x;
}

std::optional<PixelRect> rect_around(const glm::dvec2& low, const glm::dvec2& high, const glm::dvec2& slack,
                                     ImageSize size) {
    const auto inside = [](double value, int side) { return static_cast<int>(std::clamp(value, 0.0, double(side))); };
    const PixelRect rect{
        inside(std::floor(low.x - slack.x), size.width), inside(std::floor(low.y - slack.y), size.height),
        inside(std::ceil(high.x + slack.x) + 1.0, size.width), inside(std::ceil(high.y + slack.y) + 1.0, size.height)};
    if (rect.width() <= 0 || rect.height() <= 0) return std::nullopt;
    return rect;
}

/// How far light that touches `caster` goes on until it has left `receivers`: metres along the light or, for a
/// local one, the factor by which the distance from it grows.
double longest_way(const ShadowView& shadow, const WorldBox& caster, const WorldBox& receivers) {
    if (shadow.is_local) {
        double last = 0.0;
        for (int i = 0; i < 8; ++i) last = std::max(last, glm::distance(corner(receivers, i), shadow.origin));
        return last / std::max(glm::distance(glm::clamp(shadow.origin, caster.min, caster.max), shadow.origin), 1e-6);
    }
    const glm::dvec3 along = glm::transpose(shadow.map_from_world)[2];
    double way = infinity;
    for (int axis = 0; axis < 3; ++axis) {
        const double room =
            along[axis] > 0.0 ? receivers.max[axis] - caster.min[axis] : caster.max[axis] - receivers.min[axis];
        if (std::abs(along[axis]) > 1e-9) way = std::min(way, room / std::abs(along[axis]));
    }
    return way;
}

}  // namespace

WorldBox world_box(const glm::dmat4& world_from_local, const world::Box& local) {
    const glm::dvec3 centre(world_from_local * glm::dvec4(0.5 * (glm::dvec3(local.min) + glm::dvec3(local.max)), 1.0));
    const glm::dvec3 half = 0.5 * (glm::dvec3(local.max) - glm::dvec3(local.min));
    const glm::dvec3 extent = glm::abs(glm::dvec3(world_from_local[0])) * half.x +
                              glm::abs(glm::dvec3(world_from_local[1])) * half.y +
                              glm::abs(glm::dvec3(world_from_local[2])) * half.z;
    return {centre - extent, centre + extent};
}

WorldBox joined(std::span<const WorldBox> boxes) {
    WorldBox all = boxes.front();
    for (const WorldBox& box : boxes) all = {glm::min(all.min, box.min), glm::max(all.max, box.max)};
    return all;
}

glm::dmat4 ShadowView::map_from(const glm::dmat4& world_from_local) const {
    glm::dmat4 result(map_from_world * glm::dmat3(world_from_local));
    result[3] = glm::dvec4(map_from_world * (glm::dvec3(world_from_local[3]) - origin), 1.0);
    return result;
}

bool operator==(const ShadowView& a, const ShadowView& b) {
    return a.light == b.light && a.side == b.side && a.is_local == b.is_local && a.origin == b.origin &&
           a.map_from_world == b.map_from_world && a.clip_from_map == b.clip_from_map;
}

std::vector<ShadowView> plan_shadows(std::span<const world::Light> lights, float exposure,
                                     std::span<const WorldBox> receivers, bool with_local) {
    std::vector<ShadowView> views;
    if (receivers.empty()) return views;
    std::vector<std::size_t> order;
    const auto brightness = [&](std::size_t i) {
        const glm::vec3& c = lights[i].color;
        return lights[i].intensity * std::max({c.r, c.g, c.b});
    };
    for (std::size_t i = 0; i < lights.size(); ++i) {
        const bool is_asked = with_local || lights[i].type == world::LightType::directional;
        if (is_asked && brightness(i) > 0.0f) order.push_back(i);
    }
    std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) {
        const bool a_first = lights[a].type == world::LightType::directional,
                   b_first = lights[b].type == world::LightType::directional;
        return a_first != b_first ? a_first : brightness(a) > brightness(b);
    });
    int left = max_shadowed_lights;
    for (const std::size_t i : order) {
        if (left == 0) break;
        std::vector<ShadowView> of_light = lights[i].type == world::LightType::directional
                                               ? std::vector{directional_view(lights[i], receivers)}
                                               : local_views(lights[i], exposure, receivers);
        if (of_light.empty() || views.size() + of_light.size() > max_shadow_maps) continue;
        for (ShadowView& view : of_light) view.light = i;
        views.insert(views.end(), of_light.begin(), of_light.end());
        --left;
    }
    const auto is_coarse = [](const ShadowView& view) { return view.texel_m > fine_shadow_texel_m; };
    if (views.size() > max_fine_shadow_maps || std::ranges::none_of(views, is_coarse)) return views;
    for (ShadowView& view : views) {
        view.side = fine_shadow_map_side;
        view.texel_m *= double{shadow_map_side} / fine_shadow_map_side;
        view.texel_per_m *= double{shadow_map_side} / fine_shadow_map_side;
    }
    return views;
}

std::array<glm::vec4, 3> plane_rows(const std::array<glm::dvec4, 4>& rows) {
    // Planes go by the inverse of what takes points, transposed.
    const glm::dmat4 inverse = glm::transpose(glm::inverse(glm::dmat4(rows[0], rows[1], rows[2], rows[3])));
    return {glm::vec4(inverse[0]), glm::vec4(inverse[1]), glm::vec4(inverse[2])};
}

std::optional<PixelRect> shadow_texels(const ShadowView& shadow, const WorldBox& caster) {
    std::array<glm::dvec3, 8> points;
    for (int i = 0; i < 8; ++i) {
        const glm::dvec3 p = shadow.map_from_world * (corner(caster, i) - shadow.origin);
        points[static_cast<std::size_t>(i)] = shadow.is_local ? p : glm::dvec3(p.x, p.y, 1.0);
    }
    const auto project = [&](const glm::dvec3& p) {
        const glm::dvec2 clip(shadow.clip_from_map[0][0] * p.x, shadow.clip_from_map[1][1] * p.y);
        return (clip / p.z * 0.5 + 0.5) * static_cast<double>(shadow.side);
    };
    glm::dvec2 low, high;
    if (!hull_bounds(points, shadow.is_local ? nearest_local_caster_m : 0.0, project, low, high)) return std::nullopt;
    return rect_around(low, high, glm::dvec2(shadow_filter_texels), {shadow.side, shadow.side});
}

std::optional<PixelRect> shadow_pixels(const ViewTransform& view, const ShadowView& shadow, const WorldBox& caster,
                                       const WorldBox& receivers) {
    if (!shadow_texels(shadow, caster)) return std::nullopt;
    // The filter blurs.
    double farthest = 0.0;
    for (int i = 0; i < 8; ++i) farthest = std::max(farthest, glm::distance(corner(caster, i), shadow.origin));
    const double blur = shadow_filter_texels * (shadow.texel_m + shadow.texel_per_m * farthest);
    const WorldBox blurred{caster.min - blur, caster.max + blur};
    const double way = longest_way(shadow, blurred, receivers);
    if (!(way > (shadow.is_local ? 1.0 : 0.0))) return std::nullopt;

    const glm::dvec3 along = glm::transpose(shadow.map_from_world)[2];
    std::array<glm::dvec3, 16> points;
    for (int i = 0; i < 8; ++i) {
        const glm::dvec3 p = corner(blurred, i);
        const glm::dvec3 end = shadow.is_local ? shadow.origin + (p - shadow.origin) * way : p + along * way;
        points[static_cast<std::size_t>(i)] = view.optical_from_world * (p - view.eye);
        points[static_cast<std::size_t>(i) + 8] = view.optical_from_world * (end - view.eye);
    }
    const auto project = [&](const glm::dvec3& p) {
        return glm::dvec2(view.intrinsics.fx * p.x / p.z + view.intrinsics.cx,
                          view.intrinsics.fy * p.y / p.z + view.intrinsics.cy);
    };
    glm::dvec2 low, high;
    if (!hull_bounds(points, 0.5 * view.near_m, project, low, high)) return std::nullopt;
    return rect_around(low, high, glm::dvec2(2.0), view.size);
}

}  // namespace camrig::render

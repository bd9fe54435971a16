#pragma once

#include <array>

#include "core/render/software/one_triangle.h"
#include "core/render/software/sampling.h"
#include "core/render/software/triangle_of_each.h"

/// What a triangle's vertices carry, at the pixels of a group: perspective-correct, with the steps to the next pixels.
namespace camrig::render::software {

/// What shading needs to know of the points of a surface that a group of pixels shows. What the draw does not have is
/// not set.
struct SurfacePoints {
    Lanes z;                     ///< metres along the optical axis; through a lens, how many rays it is there
    Lanes3 normal;               ///< local, towards the seen side
    std::array<Lanes, 4> color;  ///< of the vertices
    std::array<TexturePoints, texture_slot_count> textures;
    /// Of normal maps, local, of any length: which way u grows; the other coordinate by the sign of cross(normal,
    /// tangent), or by which way v grows.
    Lanes3 tangent, v_grows;
    Lanes tangent_side;
    Lanes3 light;    ///< quality fast
    Lanes3 ambient;  ///< quality fast
};

/// Where the pixels of a group lie on their triangles, and how that changes to the right and down.
struct PointOnTriangle {
    Lanes z;
    Lanes second, third;  ///< shares of the second and third vertex in space
    Lanes second_dx, third_dx, second_dy, third_dy;
};

/// place_at() through a lens: the shares of a ray, and of those beside and below it.
template <bool stays_inside, typename V>
CAMRIG_LANES PointOnTriangle place_on_ray(const RayEdges<V>& triangle, const PointRays& rays) {
    const auto [ray, dx, dy] = rays;
    Lanes first = triangle.along(0, ray), second = triangle.along(1, ray), third = triangle.along(2, ray);
    if constexpr (stays_inside) {
        constexpr float least = 1e-30f;
        first = max(first, lanes(least));
        second = max(second, Lanes{});
        third = max(third, Lanes{});
    }
    const Lanes inverse = 1.0f / (first + second + third);
    PointOnTriangle place;
    place.z = triangle.length * inverse;
    place.second = second * inverse;
    place.third = third * inverse;
    const Lanes second_dx = triangle.along(1, dx), third_dx = triangle.along(2, dx);
    const Lanes second_dy = triangle.along(1, dy), third_dy = triangle.along(2, dy);
    const Lanes sum_dx = triangle.along(0, dx) + second_dx + third_dx;
    const Lanes sum_dy = triangle.along(0, dy) + second_dy + third_dy;
    place.second_dx = (second_dx - place.second * sum_dx) * inverse;
    place.third_dx = (third_dx - place.third * sum_dx) * inverse;
    place.second_dy = (second_dy - place.second * sum_dy) * inverse;
    place.third_dy = (third_dy - place.third * sum_dy) * inverse;
    return place;
}

template <typename Triangles>
CAMRIG_LANES PointOnTriangle place_at(const Triangles& triangles, int x, int y) {
    if (triangles.rays() != nullptr)
        return place_on_ray<Triangles::stays_inside>(triangles.ray_edges(), triangles.point_rays(x, y));
    using V = Triangles::Value;
    const ScreenShares<V> screen = triangles.shares(x, y);
    const V a = triangles.inverse_z(0), b = triangles.inverse_z(1), c = triangles.inverse_z(2);
    const Lanes second = screen.second * b, third = screen.third * c;
    PointOnTriangle place;
    place.z = 1.0f / ((1.0f - screen.second - screen.third) * a + second + third);
    place.second = second * place.z;
    place.third = third * place.z;
    const V w_dx = screen.second_dx * (b - a) + screen.third_dx * (c - a);
    const V w_dy = screen.second_dy * (b - a) + screen.third_dy * (c - a);
    place.second_dx = (screen.second_dx * b - place.second * w_dx) * place.z;
    place.third_dx = (screen.third_dx * c - place.third * w_dx) * place.z;
    place.second_dy = (screen.second_dy * b - place.second * w_dy) * place.z;
    place.third_dy = (screen.third_dy * c - place.third * w_dy) * place.z;
    return place;
}

/// How a normal map lies on each triangle, from its texture coordinates.
template <typename Triangles>
CAMRIG_LANES void find_tangents(const ViewDraw& draw, const Triangles& triangles, SurfacePoints& points) {
    using V = Triangles::Value;
    const CornerAttribute position{&draw.positions->x, 3, offsetof(VertexValues, local)};
    const CornerAttribute coordinates{&draw.textures[normal_slot]->coordinates.front().x, 2,
                                      offsetof(VertexValues, coordinates) + normal_slot * sizeof(glm::vec2)};
    const std::array<V, 3> a = triangles.template values<3>(0, position);
    const std::array<V, 3> b = triangles.template values<3>(1, position);
    const std::array<V, 3> c = triangles.template values<3>(2, position);
    const std::array<V, 2> at_a = triangles.template values<2>(0, coordinates);
    const std::array<V, 2> at_b = triangles.template values<2>(1, coordinates);
    const std::array<V, 2> at_c = triangles.template values<2>(2, coordinates);
    const V b_u = at_b[0] - at_a[0], b_v = at_b[1] - at_a[1], c_u = at_c[0] - at_a[0], c_v = at_c[1] - at_a[1];
    const V turn = b_u * c_v - c_u * b_v;
    std::array<Lanes, 3> u, v;
    for (std::size_t i = 0; i < 3; ++i) {
        const V to_b = b[i] - a[i], to_c = c[i] - a[i];
        u[i] = Lanes{} + (c_v * to_b - b_v * to_c);
        v[i] = Lanes{} + (b_u * to_c - c_u * to_b);
    }
    const Lanes turned = Lanes{} + turn;
    const auto straight = [&](Lanes value) __attribute__((always_inline)) {
        return turned > 0.0f ? value : turned < 0.0f ? -value : Lanes{};
    };
    points.tangent = {straight(u[0]), straight(u[1]), straight(u[2])};
    points.v_grows = {straight(v[0]), straight(v[1]), straight(v[2])};
}

/// What is to be known of points: everything, or what base_alpha() needs.
enum class PointValues { all, of_alpha };

/// x is the first pixel of the group.
template <PointValues wanted = PointValues::all, typename Triangles>
CAMRIG_LANES SurfacePoints points_of(const ViewGeometry& geometry, const ViewDraw& draw, const Triangles& triangles,
                                     int x, int y) {
    using V = Triangles::Value;
    const PointOnTriangle place = place_at(triangles, x, y);
    const auto between = [&](V a, V b, V c) __attribute__((always_inline)) {
        return a + place.second * (b - a) + place.third * (c - a);
    };
    const auto interpolated = [&]<std::size_t size>(const CornerAttribute& attribute) __attribute__((always_inline)) {
        const std::array<V, size> a = triangles.template values<size>(0, attribute);
        const std::array<V, size> b = triangles.template values<size>(1, attribute);
        const std::array<V, size> c = triangles.template values<size>(2, attribute);
        std::array<Lanes, size> made;
        for (std::size_t i = 0; i < size; ++i) made[i] = between(a[i], b[i], c[i]);
        return made;
    };
    const auto vector = [&](const CornerAttribute& attribute) __attribute__((always_inline)) {
        const std::array<Lanes, 3> v = interpolated.template operator()<3>(attribute);
        return Lanes3{v[0], v[1], v[2]};
    };
    const auto where_front = [&](const Lanes3& front, const Lanes3& back) __attribute__((always_inline)) {
        return Lanes3{triangles.where_front(front.x, back.x), triangles.where_front(front.y, back.y),
                      triangles.where_front(front.z, back.z)};
    };

    SurfacePoints points;
    points.z = place.z;
    if (draw.colors != nullptr)
        points.color = interpolated.template operator()<4>({&draw.colors->x, 4, offsetof(VertexValues, color)});
    constexpr bool is_all = wanted == PointValues::all;
    if (is_all && draw.vertex_lights >= 0) {
        const VertexLight& made = geometry.vertex_lights()[static_cast<std::size_t>(draw.vertex_lights)];
        constexpr auto stride = static_cast<std::int32_t>(sizeof(VertexLight) / sizeof(float));
        points.light = where_front(vector({&made.light.x, stride, offsetof(VertexValues, light)}),
                                   vector({&made.light_behind.x, stride, offsetof(VertexValues, light_behind)}));
        const Lanes3 ambient = vector({&made.ambient.x, stride, offsetof(VertexValues, ambient)});
        const glm::vec3 both = geometry.light().sky + geometry.light().ground;
        points.ambient = where_front(ambient, {both.x - ambient.x, both.y - ambient.y, both.z - ambient.z});
    } else if (is_all && draw.primitive->is_lit) {
        const Lanes3 normal = vector({&draw.normals->x, 3, offsetof(VertexValues, normal)});
        points.normal = where_front(normal, {-normal.x, -normal.y, -normal.z});
    }
    // The back has the whole of the front's mapped normal turned round.
    if (is_all && draw.tangents != nullptr) {
        const auto tangent =
            interpolated.template operator()<4>({&draw.tangents->x, 4, offsetof(VertexValues, tangent)});
        points.tangent = where_front({tangent[0], tangent[1], tangent[2]}, {-tangent[0], -tangent[1], -tangent[2]});
        points.tangent_side = triangles.where_front(tangent[3], -tangent[3]);
    } else if (is_all && draw.textures[normal_slot] != nullptr) {
        find_tangents(draw, triangles, points);
        const Lanes3 u = points.tangent, v = points.v_grows;
        points.tangent = where_front(u, {-u.x, -u.y, -u.z});
        points.v_grows = where_front(v, {-v.x, -v.y, -v.z});
    }
    for (std::size_t slot = 0; slot < texture_slot_count; ++slot) {
        if (draw.textures[slot] == nullptr || (!is_all && slot != base_color_slot)) continue;
        const SampledTexture& texture = *draw.textures[slot];
        const CornerAttribute attribute{&texture.coordinates.front().x, 2,
                                        offsetof(VertexValues, coordinates) + slot * sizeof(glm::vec2)};
        const std::array<V, 2> a = triangles.template values<2>(0, attribute);
        const std::array<V, 2> b = triangles.template values<2>(1, attribute);
        const std::array<V, 2> c = triangles.template values<2>(2, attribute);
        auto& at = points.textures[slot];
        at.u = between(a[0], b[0], c[0]);
        at.v = between(a[1], b[1], c[1]);
        if (slot == light_slot) {
            at.u = at.u + draw.light_map_at.x;
            at.v = at.v + draw.light_map_at.y;
        }
        const SoftwareImage& image = *texture.image;
        const auto width = static_cast<float>(image.levels.front().width);
        const auto height = static_cast<float>(image.levels.front().height);
        const V second_u = (b[0] - a[0]) * width, second_v = (b[1] - a[1]) * height;
        const V third_u = (c[0] - a[0]) * width, third_v = (c[1] - a[1]) * height;
        const Lanes u_dx = place.second_dx * second_u + place.third_dx * third_u;
        const Lanes v_dx = place.second_dx * second_v + place.third_dx * third_v;
        const Lanes u_dy = place.second_dy * second_u + place.third_dy * third_u;
        const Lanes v_dy = place.second_dy * second_v + place.third_dy * third_v;
        const Lanes across2 = u_dx * u_dx + v_dx * v_dx, down2 = u_dy * u_dy + v_dy * v_dy;
        at.longer2 = max(across2, down2);
        at.has_footprints = geometry.has_outlines();
        at.blends_levels = geometry.is_beautiful() && texture.sampler.mipmaps &&
                           texture.sampler.between_mipmaps == world::Filter::linear;
        if (!at.has_footprints) continue;
        const IntLanes is_across = across2 > down2;
        at.shorter2 = is_across ? down2 : across2;
        at.u_step = (is_across ? u_dx : u_dy) * (1.0f / width);
        at.v_step = (is_across ? v_dx : v_dy) * (1.0f / height);
    }
    return points;
}

}  // namespace camrig::render::software

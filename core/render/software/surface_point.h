#pragma once

#include <array>
#include <cstddef>

#include "core/render/software/coverage.h"
#include "core/render/software/sampling.h"

/// What a triangle's vertices carry, at the pixels of a group: perspective-correct, with the steps to the next pixels.
/// A group shows one triangle or one of the same draw in each pixel; both take the same operations in the same order,
/// so a pixel has the same bits whatever is beside it.
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

/// Which draw each triangle is of; numbers from 1, where 0 gives any.
template <typename Isa>
CAMRIG_LANES IntLanes draws_of(const ScreenTriangle* triangles, IntLanes number) {
    static_assert(sizeof(ScreenTriangle) == 32);
    constexpr std::int32_t bits_of_draw = max_draws;
    const IntLanes index = number > 0 ? number - 1 : IntLanes{};
    return gathered<Isa>(reinterpret_cast<const std::int32_t*>(triangles) + 3, index * 8) & bits_of_draw;
}

/// A corner of a triangle of a draw.
struct Corner {
    std::uint32_t vertex;         ///< of the mesh
    const VertexValues* clipped;  ///< what clipping made; null: of the mesh
};

CAMRIG_LANES Corner corner_of(const ViewGeometry& geometry, const ViewDraw& draw, std::uint32_t vertex) {
    const std::uint32_t own = vertex - draw.first_vertex;
    if (own < draw.vertex_count) return {own, nullptr};
    return {own, &geometry.clipped()[draw.first_clipped + own - draw.vertex_count]};
}

/// Where the values of the vertices of a draw are.
struct CornerAttribute {
    const float* of_mesh;    ///< of the first vertex
    std::int32_t stride;     ///< to the next one's, in floats
    std::size_t of_clipped;  ///< in VertexValues, in bytes
};

CAMRIG_LANES const float* values_at(const Corner& corner, const CornerAttribute& attribute) {
    if (corner.clipped != nullptr)
        return reinterpret_cast<const float*>(reinterpret_cast<const std::byte*>(corner.clipped) +
                                              attribute.of_clipped);
    return attribute.of_mesh + static_cast<std::ptrdiff_t>(corner.vertex) * attribute.stride;
}

/// What of a RayTriangle the place of a point follows from. V is float or Lanes.
template <typename V>
struct RayEdges {
    struct {
        V x, y, z;
    } edges[3];
    V length;

    CAMRIG_LANES Lanes along(std::size_t i, const Lanes3& ray) const {
        return ray.x * edges[i].x + ray.y * edges[i].y + ray.z * edges[i].z;
    }
};

/// Rays of a group of points, and how they change to the next pixel on the right and below.
struct PointRays {
    Lanes3 at, dx, dy;
};
CAMRIG_LANES PointRays point_rays_at(const LensRays& rays, int x, int y) {
    const Lanes3 at = rays_at(rays, x, y);
    return {at, rays_at(rays, x + 1, y) - at, rays_at(rays, x, y + 1) - at};
}

/// The shares of the second and third vertex in the plane of the screen, and their steps. V is float or Lanes.
template <typename V>
struct ScreenShares {
    Lanes second, third;
    V second_dx, third_dx, second_dy, third_dy;
};

/// One triangle for all pixels of a group.
class OneTriangle {
public:
    using Value = float;
    static constexpr bool stays_inside = false;  ///< a point beside a triangle takes what its border has

    CAMRIG_LANES OneTriangle(const ViewGeometry& geometry, const ViewDraw& draw, const ScreenTriangle& triangle,
                             const Setup& setup)
        : rays_(geometry.rays()), setup_(setup), is_front_(triangle.is_front) {
        for (std::size_t i = 0; i < 3; ++i) corners_[i] = corner_of(geometry, draw, triangle.vertices[i]);
    }

    CAMRIG_LANES const LensRays* rays() const { return rays_; }
    CAMRIG_LANES PointRays point_rays(int x, int y) const { return point_rays_at(*rays_, x, y); }
    CAMRIG_LANES RayEdges<float> ray_edges() const {
        RayEdges<float> made;
        for (std::size_t i = 0; i < 3; ++i) {
            const glm::vec3& edge = setup_.ray->edges[i];
            made.edges[i] = {edge.x, edge.y, edge.z};
        }
        made.length = setup_.ray->length;
        return made;
    }
    /// x is the first pixel of the group.
    CAMRIG_LANES ScreenShares<float> shares(int x, int y) const {
        const Setup& s = setup_;
        const std::int64_t px = std::int64_t{x} * subpixels, py = std::int64_t{y} * subpixels;
        const double scale = s.inverse_area * subpixels;
        ScreenShares<float> made;
        made.second_dx = static_cast<float>(-s.dy[1] * scale);
        made.third_dx = static_cast<float>(-s.dy[2] * scale);
        made.second_dy = static_cast<float>(s.dx[1] * scale);
        made.third_dy = static_cast<float>(s.dx[2] * scale);
        made.second = static_cast<float>(static_cast<double>(edge(s, 1, px, py)) * s.inverse_area) +
                      lane_numbers() * made.second_dx;
        made.third = static_cast<float>(static_cast<double>(edge(s, 2, px, py)) * s.inverse_area) +
                     lane_numbers() * made.third_dx;
        return made;
    }
    CAMRIG_LANES float inverse_z(std::size_t corner) const { return setup_.at[corner]->inverse_z; }
    CAMRIG_LANES Lanes where_front(Lanes front, Lanes back) const { return is_front_ ? front : back; }

    template <std::size_t size>
    CAMRIG_LANES std::array<float, size> values(std::size_t corner, const CornerAttribute& attribute) const {
        const float* const from = values_at(corners_[corner], attribute);
        std::array<float, size> made;
        for (std::size_t i = 0; i < size; ++i) made[i] = from[i];
        return made;
    }

private:
    const LensRays* rays_;
    const Setup& setup_;
    std::array<Corner, 3> corners_;
    bool is_front_;
};

/// A triangle for each pixel of a group, all of one draw.
template <typename Isa>
class TriangleOfEach {
public:
    using Value = Lanes;
    static constexpr bool stays_inside = false;

    /// numbers: of triangles, from 1; none is 0.
    CAMRIG_LANES TriangleOfEach(const ViewGeometry& geometry, const ViewDraw& draw, IntLanes numbers)
        : geometry_(geometry), draw_(draw) {
        static_assert(sizeof(ScreenTriangle) == 32 && sizeof(ScreenVertex) == 16);
        const ScreenTriangle* const triangles = geometry.triangles().data();
        const IntLanes index = index_ = numbers - 1;
        const bool is_on_screen = rays() == nullptr;
        if (is_on_screen) inverse_area_ = gathered<Isa>(&triangles->inverse_area, index * 4);
        Quads corners;
        Isa::quads(reinterpret_cast<const std::int32_t*>(triangles), index * 8, corners);
        front_ = corners[3] < 0;  // is_front is the highest bit
        for (std::size_t i = 0; i < 3; ++i) {
            if (is_on_screen) {
                Quads at;
                Isa::quads(reinterpret_cast<const std::int32_t*>(geometry.vertices().data()), corners[i] * 4, at);
                x_[i] = at[0];
                y_[i] = at[1];
                inverse_z_[i] = reinterpret_cast<Lanes>(at[3]);
            }
            vertex_[i] = corners[i] - static_cast<std::int32_t>(draw.first_vertex);
            const unsigned clipped = Isa::bits(vertex_[i] >= static_cast<std::int32_t>(draw.vertex_count));
            has_clipped_[i] = clipped != 0;
            all_clipped_[i] = clipped == 0xFF;
        }
    }

    CAMRIG_LANES const LensRays* rays() const { return geometry_.rays(); }
    CAMRIG_LANES PointRays point_rays(int x, int y) const { return point_rays_at(*rays(), x, y); }
    CAMRIG_LANES RayEdges<Lanes> ray_edges() const {
        static_assert(sizeof(RayTriangle) == 16 * sizeof(float));
        const RayTriangle* const triangles = geometry_.ray_triangles().data();
        const auto of = [&](const float& first)
                            __attribute__((always_inline)) { return gathered<Isa>(&first, index_ * 16); };
        RayEdges<Lanes> made;
        for (std::size_t i = 0; i < 3; ++i) {
            const glm::vec3& edge = triangles->edges[i];
            made.edges[i] = {of(edge.x), of(edge.y), of(edge.z)};
        }
        made.length = of(triangles->length);
        return made;
    }
    /// As OneTriangle::shares; coordinates are below 2^24, so these doubles are whole numbers too.
    CAMRIG_LANES ScreenShares<Lanes> shares(int x, int y) const {
        const Edge second = edge_from(2, 0), third = edge_from(0, 1);
        ScreenShares<Lanes> made = shares_of(second, third);
        made.second = narrowed(second.at(x, y) * inverse_area_) + lane_numbers() * made.second_dx;
        made.third = narrowed(third.at(x, y) * inverse_area_) + lane_numbers() * made.third_dx;
        return made;
    }
    CAMRIG_LANES Lanes inverse_z(std::size_t corner) const { return inverse_z_[corner]; }
    CAMRIG_LANES Lanes where_front(Lanes front, Lanes back) const { return front_ ? front : back; }

    template <std::size_t size>
    CAMRIG_LANES std::array<Lanes, size> values(std::size_t corner, const CornerAttribute& attribute) const {
        std::array<Lanes, size> made;
        const IntLanes vertex = vertex_[corner];
        if (has_clipped_[corner]) {
            // Two places, of which each lane takes one.
            const auto count = static_cast<std::int32_t>(draw_.vertex_count);
            const IntLanes is_clipped = vertex >= count;
            const IntLanes of_mesh = is_clipped ? IntLanes{} : vertex,
                           of_clipped = is_clipped ? vertex - count : IntLanes{};
            constexpr auto stride = static_cast<std::int32_t>(sizeof(VertexValues) / sizeof(float));
            const auto* const first = reinterpret_cast<const float*>(
                reinterpret_cast<const std::byte*>(geometry_.clipped().data() + draw_.first_clipped) +
                attribute.of_clipped);
            const bool is_all_clipped = all_clipped_[corner];
            for (std::size_t i = 0; i < size; ++i) {
                const Lanes clipped = gathered<Isa>(first + i, of_clipped * stride);
                if (is_all_clipped) {
                    made[i] = clipped;
                } else {
                    made[i] = is_clipped ? clipped : gathered<Isa>(attribute.of_mesh + i, of_mesh * attribute.stride);
                }
            }
        } else {
            for (std::size_t i = 0; i < size; ++i)
                made[i] = gathered<Isa>(attribute.of_mesh + i, vertex * attribute.stride);
        }
        return made;
    }

protected:
    struct Edge {
        Doubles dx, dy, from_x, from_y;

        CAMRIG_LANES Doubles at(int x, int y) const {
            return dx * (static_cast<double>(y * subpixels) - from_y) -
                   dy * (static_cast<double>(x * subpixels) - from_x);
        }
        CAMRIG_LANES Doubles at(const Doubles& x, const Doubles& y) const {
            return dx * (y - from_y) - dy * (x - from_x);
        }
    };
    CAMRIG_LANES Edge edge_from(std::size_t from, std::size_t to) const {
        return {widened(x_[to] - x_[from]), widened(y_[to] - y_[from]), widened(x_[from]), widened(y_[from])};
    }
    CAMRIG_LANES ScreenShares<Lanes> shares_of(const Edge& second, const Edge& third) const {
        const Doubles scale = inverse_area_ * static_cast<double>(subpixels);
        ScreenShares<Lanes> made;
        made.second_dx = narrowed(-second.dy * scale);
        made.third_dx = narrowed(-third.dy * scale);
        made.second_dy = narrowed(second.dx * scale);
        made.third_dy = narrowed(third.dx * scale);
        return made;
    }

    const ViewGeometry& geometry_;
    const ViewDraw& draw_;
    Doubles inverse_area_{};
    IntLanes index_, front_;
    std::array<IntLanes, 3> vertex_, x_{}, y_{};  ///< vertex: of the draw
    std::array<Lanes, 3> inverse_z_{};
    std::array<bool, 3> has_clipped_, all_clipped_;
};

/// Triangles of one draw at places of their own, in subpixels; share: how far it is to the next pixel there.
template <typename Isa>
class TriangleAtPlaces : public TriangleOfEach<Isa> {
public:
    /// A sliver's values go anywhere within a pixel.
    static constexpr bool stays_inside = true;

    CAMRIG_LANES TriangleAtPlaces(const ViewGeometry& geometry, const ViewDraw& draw, IntLanes numbers,
                                  const Doubles& x, const Doubles& y, Lanes share)
        : TriangleOfEach<Isa>(geometry, draw, numbers), x_at_(x), y_at_(y), share_(share) {}

    CAMRIG_LANES ScreenShares<Lanes> shares(int, int) const {
        const auto second = this->edge_from(2, 0), third = this->edge_from(0, 1);
        ScreenShares<Lanes> made = this->shares_of(second, third);
        made.second = clamp01(narrowed(second.at(x_at_, y_at_) * this->inverse_area_));
        made.third = min(clamp01(narrowed(third.at(x_at_, y_at_) * this->inverse_area_)), 1.0f - made.second);
        for (Lanes* step : {&made.second_dx, &made.third_dx, &made.second_dy, &made.third_dy}) *step = *step * share_;
        return made;
    }

    /// Between the rays of pixels.
    CAMRIG_LANES PointRays point_rays(int, int) const {
        const Doubles x = x_at_ * (1.0 / subpixels), y = y_at_ * (1.0 / subpixels);
        const IntLanes column = rounded(x), row = rounded(y);
        const Lanes right = narrowed(x - widened(column)), down = narrowed(y - widened(row));
        const LensRays::Coordinates of = this->rays()->rays();
        const auto along = [&](const Rows<const float>& plane, Lanes& at, Lanes& dx, Lanes& dy)
                               __attribute__((always_inline)) {
                                   const auto stride = static_cast<std::int32_t>(plane.stride);
                                   const IntLanes first = row * stride + column;
                                   const Lanes centre = gathered<Isa>(plane.data, first);
                                   dx = gathered<Isa>(plane.data, first + 1) - centre;
                                   dy = gathered<Isa>(plane.data, first + stride) - centre;
                                   at = centre + dx * right + dy * down;
                                   dx = dx * share_;
                                   dy = dy * share_;
                               };
        PointRays made;
        along(of.x, made.at.x, made.dx.x, made.dy.x);
        along(of.y, made.at.y, made.dx.y, made.dy.y);
        along(of.z, made.at.z, made.dx.z, made.dy.z);
        return made;
    }

private:
    Doubles x_at_, y_at_;
    Lanes share_;
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

/// x is the first pixel of the group.
template <typename Triangles>
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
    if (draw.vertex_lights >= 0) {
        const VertexLight& made = geometry.vertex_lights()[static_cast<std::size_t>(draw.vertex_lights)];
        constexpr auto stride = static_cast<std::int32_t>(sizeof(VertexLight) / sizeof(float));
        points.light = where_front(vector({&made.light.x, stride, offsetof(VertexValues, light)}),
                                   vector({&made.light_behind.x, stride, offsetof(VertexValues, light_behind)}));
        const Lanes3 ambient = vector({&made.ambient.x, stride, offsetof(VertexValues, ambient)});
        const glm::vec3 both = geometry.light().sky + geometry.light().ground;
        points.ambient = where_front(ambient, {both.x - ambient.x, both.y - ambient.y, both.z - ambient.z});
    } else if (draw.primitive->is_lit) {
        const Lanes3 normal = vector({&draw.normals->x, 3, offsetof(VertexValues, normal)});
        points.normal = where_front(normal, {-normal.x, -normal.y, -normal.z});
    }
    if (draw.tangents != nullptr) {
        const auto tangent =
            interpolated.template operator()<4>({&draw.tangents->x, 4, offsetof(VertexValues, tangent)});
        points.tangent = {tangent[0], tangent[1], tangent[2]};
        points.tangent_side = tangent[3];
    } else if (draw.textures[normal_slot] != nullptr) {
        find_tangents(draw, triangles, points);
    }
    for (std::size_t slot = 0; slot < texture_slot_count; ++slot) {
        if (draw.textures[slot] == nullptr) continue;
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

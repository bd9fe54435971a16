#include "core/render/software/rasterizer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "core/render/software/lanes.h"

namespace camrig {
namespace {

/// The edges of a triangle; each lies opposite of the vertex it weighs.
struct Setup {
    std::array<const ScreenVertex*, 3> at{};
    std::array<std::int32_t, 3> dx{}, dy{};
    double inverse_area = 0.0;
};

CAMRIG_LANES std::int64_t edge(const Setup& s, std::size_t i, std::int64_t x, std::int64_t y) {
    const ScreenVertex& from = *s.at[(i + 1) % 3];
    return s.dx[i] * (y - from.y) - s.dy[i] * (x - from.x);
}

CAMRIG_LANES Setup set_up(const ScreenVertex* vertices, const ScreenTriangle& triangle) {
    Setup s;
    for (std::size_t i = 0; i < 3; ++i) s.at[i] = vertices + triangle.vertices[i];
    for (std::size_t i = 0; i < 3; ++i) {
        const ScreenVertex &from = *s.at[(i + 1) % 3], &to = *s.at[(i + 2) % 3];
        s.dx[i] = to.x - from.x;
        s.dy[i] = to.y - from.y;
    }
    s.inverse_area = triangle.inverse_area;
    return s;
}

/// Depth is linear on the screen: at the first pixel of a group from its edges, in double, then along the row.
struct DepthPlane {
    double base, second, third;
    float dx;
};

CAMRIG_LANES DepthPlane depth_plane(const Setup& s) {
    const double base = s.at[0]->depth;
    const double second = (s.at[1]->depth - base) * s.inverse_area, third = (s.at[2]->depth - base) * s.inverse_area;
    return {base, second, third,
            static_cast<float>(-subpixels *
                               (static_cast<double>(s.dy[1]) * second + static_cast<double>(s.dy[2]) * third))};
}

CAMRIG_LANES Lanes depth_at(const DepthPlane& plane, std::int64_t second_edge, std::int64_t third_edge) {
    const double base =
        plane.base + static_cast<double>(second_edge) * plane.second + static_cast<double>(third_edge) * plane.third;
    return static_cast<float>(base) + lane_numbers() * plane.dx;
}

/// Calls visit(x, y, mask, depth) for all groups of pixels of a row that a triangle covers; x is a multiple of
/// lane_count.
template <typename Visit>
CAMRIG_LANES void rasterize(const Setup& s, const PixelRect& rect, const Visit& visit) {
    constexpr int bits = 8;
    const auto [least_x, most_x] = std::minmax({s.at[0]->x, s.at[1]->x, s.at[2]->x});
    const auto [least_y, most_y] = std::minmax({s.at[0]->y, s.at[1]->y, s.at[2]->y});
    const int x0 = std::max(rect.x0, (least_x + subpixels - 1) >> bits), x1 = std::min(rect.x1, (most_x >> bits) + 1);
    const int y0 = std::max(rect.y0, (least_y + subpixels - 1) >> bits), y1 = std::min(rect.y1, (most_y >> bits) + 1);
    if (x0 >= x1 || y0 >= y1) return;
    const DepthPlane depth = depth_plane(s);
    const int first = x0 & -lane_count;
    std::array<std::int64_t, 3> row{};   // at the first pixel of a row, of the groups
    std::array<std::int32_t, 3> bias{};  // a middle on an edge that is neither top nor left is outside
    for (std::size_t i = 0; i < 3; ++i) {
        const bool is_top_left = s.dy[i] < 0 || (s.dy[i] == 0 && s.dx[i] > 0);
        bias[i] = is_top_left ? 0 : -1;
        row[i] = edge(s, i, std::int64_t{first} * subpixels, std::int64_t{y0} * subpixels);
    }
    const IntLanes from = int_lane_numbers();
    constexpr int small = 1 << 14;  // its edges fit into 32 bits
    if (most_x - least_x < small && most_y - least_y < small) {
        std::array<IntLanes, 3> across{};
        for (std::size_t i = 0; i < 3; ++i) across[i] = from * (-s.dy[i] * subpixels);
        for (int y = y0; y < y1; ++y) {
            std::array<std::int32_t, 3> at{static_cast<std::int32_t>(row[0]), static_cast<std::int32_t>(row[1]),
                                           static_cast<std::int32_t>(row[2])};
            for (int x = first; x < x1; x += lane_count) {
                const IntLanes outside = (across[0] + (at[0] + bias[0])) | (across[1] + (at[1] + bias[1])) |
                                         (across[2] + (at[2] + bias[2])) | (from + (x - x0)) | ((x1 - 1 - x) - from);
                const IntLanes mask = outside >= 0;
                if (any(mask)) visit(x, y, mask, depth_at(depth, at[1], at[2]));
                for (std::size_t i = 0; i < 3; ++i) at[i] -= s.dy[i] * subpixels * lane_count;
            }
            for (std::size_t i = 0; i < 3; ++i) row[i] += std::int64_t{s.dx[i]} * subpixels;
        }
        return;
    }
    for (int y = y0; y < y1; ++y) {
        // The pixels of the row that are inside of all three edges.
        int begin = x0, end = x1;
        for (std::size_t i = 0; i < 3; ++i) {
            const std::int64_t value = row[i] + bias[i], step = -std::int64_t{s.dy[i]} * subpixels;
            if (step == 0) {
                if (value < 0) end = begin;
            } else if (step > 0) {
                if (value < 0)
                    begin = std::max<std::int64_t>(
                        begin, first + std::min<std::int64_t>((-value + step - 1) / step, x1 - first));
            } else {
                end = value < 0 ? begin : static_cast<int>(std::min<std::int64_t>(end, first + value / -step + 1));
            }
        }
        for (int x = begin & -lane_count; x < end; x += lane_count) {
            const IntLanes mask = ((from + (x - begin)) | ((end - 1 - x) - from)) >= 0;
            const std::int64_t steps = std::int64_t{x - first} * subpixels;
            visit(x, y, mask, depth_at(depth, row[1] - s.dy[1] * steps, row[2] - s.dy[2] * steps));
        }
        for (std::size_t i = 0; i < 3; ++i) row[i] += std::int64_t{s.dx[i]} * subpixels;
    }
}

using LaneValues = std::array<float, lane_count>;

/// Where pixels lie on their triangle, and how that changes to the right and down. F is float for one pixel, Lanes for
/// a group of them that show the same triangle: the same operations in the same order, so the same bits.
template <typename F>
struct Place {
    F z;
    F second, third;  ///< shares of the second and third vertex in space
    F second_dx, third_dx, second_dy, third_dy;
};

/// x is the first pixel of a group, `lane` says which of the group's pixels.
template <typename F>
CAMRIG_LANES Place<F> place_at(const Setup& s, int x, int y, F lane) {
    const std::int64_t px = std::int64_t{x} * subpixels, py = std::int64_t{y} * subpixels;
    const double scale = s.inverse_area * subpixels;
    // Shares in the plane of the screen.
    const auto second_dx = static_cast<float>(-s.dy[1] * scale), third_dx = static_cast<float>(-s.dy[2] * scale);
    const auto second_dy = static_cast<float>(s.dx[1] * scale), third_dy = static_cast<float>(s.dx[2] * scale);
    const F on_screen2 =
        static_cast<float>(static_cast<double>(edge(s, 1, px, py)) * s.inverse_area) + lane * second_dx;
    const F on_screen3 = static_cast<float>(static_cast<double>(edge(s, 2, px, py)) * s.inverse_area) + lane * third_dx;
    const float a = s.at[0]->inverse_z, b = s.at[1]->inverse_z, c = s.at[2]->inverse_z;
    const F second = on_screen2 * b, third = on_screen3 * c;
    Place<F> place;
    place.z = 1.0f / ((1.0f - on_screen2 - on_screen3) * a + second + third);
    place.second = second * place.z;
    place.third = third * place.z;
    const float w_dx = second_dx * (b - a) + third_dx * (c - a);
    const float w_dy = second_dy * (b - a) + third_dy * (c - a);
    place.second_dx = (second_dx * b - place.second * w_dx) * place.z;
    place.third_dx = (third_dx * c - place.third * w_dx) * place.z;
    place.second_dy = (second_dy * b - place.second * w_dy) * place.z;
    place.third_dy = (third_dy * c - place.third * w_dy) * place.z;
    return place;
}

template <typename F>
CAMRIG_LANES F between(const Place<F>& place, float a, float b, float c) {
    return a + place.second * (b - a) + place.third * (c - a);
}

/// What shading needs to know of a point on a surface. What the draw does not have is not set.
template <typename F>
struct Point {
    F z;
    std::array<F, 3> normal;  ///< local, towards the seen side
    std::array<F, 4> color;   ///< of the vertices
    /// Coordinates, and the square of the longer of their steps to the next pixel and row, in texels of the full size.
    struct {
        F u, v, step2;
    } textures[texture_slot_count];
    std::array<F, 3> light;    ///< quality fast
    std::array<F, 3> ambient;  ///< quality fast
};
static_assert(sizeof(Point<float>) % sizeof(float) == 0 && sizeof(Point<Lanes>) == lane_count * sizeof(Point<float>));

/// So many values at the beginning of a point are all that the draw has.
CAMRIG_LANES std::size_t point_values(const ViewDraw& draw) {
    if (draw.vertex_lights >= 0) return sizeof(Point<float>) / sizeof(float);
    std::size_t slots = texture_slot_count;
    while (slots > 0 && draw.textures[slots - 1] == nullptr) --slots;
    return offsetof(Point<float>, textures) / sizeof(float) + 3 * slots;
}

/// Of one vertex of a draw: from the arrays of the mesh, or what clipping made.
struct Corner {
    std::uint32_t vertex;         ///< of the mesh
    const VertexValues* clipped;  ///< null: of the mesh
};

template <typename F>
CAMRIG_LANES void interpolate(const ViewGeometry& geometry, const ViewDraw& draw, const ScreenTriangle& triangle,
                              const Place<F>& place, Point<F>& point) {
    std::array<Corner, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t vertex = triangle.vertices[i] - draw.first_vertex;
        const bool is_of_mesh = vertex < draw.vertex_count;
        corners[i] = {vertex,
                      is_of_mesh ? nullptr : &geometry.clipped()[draw.first_clipped + vertex - draw.vertex_count]};
    }
    const auto carry = [&]<std::size_t size>(std::array<F, size>& to, const auto& of_mesh,
                                             const auto& of_clipped) __attribute__((always_inline)) {
        std::array<const float*, 3> from;
        for (std::size_t i = 0; i < 3; ++i)
            from[i] = corners[i].clipped == nullptr ? of_mesh(corners[i].vertex) : of_clipped(*corners[i].clipped);
        for (std::size_t k = 0; k < size; ++k) to[k] = between(place, from[0][k], from[1][k], from[2][k]);
    };
    point.z = place.z;
    const bool is_front = triangle.is_front;
    if (draw.colors != nullptr) {
        carry(
            point.color, [&](std::uint32_t v) { return &draw.colors[v].x; },
            [](const VertexValues& v) { return &v.color.x; });
    }
    if (draw.vertex_lights >= 0) {
        const VertexLight* const made = geometry.vertex_lights().data() + draw.vertex_lights;
        carry(
            point.light, [&](std::uint32_t v) { return is_front ? &made[v].light.x : &made[v].light_behind.x; },
            [&](const VertexValues& v) { return is_front ? &v.light.x : &v.light_behind.x; });
        carry(
            point.ambient, [&](std::uint32_t v) { return &made[v].ambient.x; },
            [](const VertexValues& v) { return &v.ambient.x; });
        const glm::vec3 both = geometry.light().sky + geometry.light().ground;
        if (!is_front) {
            for (std::size_t k = 0; k < 3; ++k)
                point.ambient[k] = both[static_cast<glm::length_t>(k)] - point.ambient[k];
        }
    } else if (draw.primitive->is_lit) {
        carry(
            point.normal, [&](std::uint32_t v) { return &draw.normals[v].x; },
            [](const VertexValues& v) { return &v.normal.x; });
        if (!is_front) {
            for (F& value : point.normal) value = -value;
        }
    }
    for (std::size_t slot = 0; slot < texture_slot_count; ++slot) {
        if (draw.textures[slot] == nullptr) continue;
        const SampledTexture& texture = *draw.textures[slot];
        std::array<glm::vec2, 3> uv;
        for (std::size_t i = 0; i < 3; ++i) {
            uv[i] = corners[i].clipped == nullptr ? texture.coordinates[corners[i].vertex]
                                                  : corners[i].clipped->coordinates[slot];
        }
        auto& at = point.textures[slot];
        at.u = between(place, uv[0].x, uv[1].x, uv[2].x);
        at.v = between(place, uv[0].y, uv[1].y, uv[2].y);
        const TextureLevel& full = texture.image->levels.front();
        const glm::vec2 size(static_cast<float>(full.width), static_cast<float>(full.height));
        const glm::vec2 second = (uv[1] - uv[0]) * size, third = (uv[2] - uv[0]) * size;
        const F u_dx = place.second_dx * second.x + place.third_dx * third.x;
        const F v_dx = place.second_dx * second.y + place.third_dx * third.y;
        const F u_dy = place.second_dy * second.x + place.third_dy * third.x;
        const F v_dy = place.second_dy * second.y + place.third_dy * third.y;
        const F to_right = u_dx * u_dx + v_dx * v_dx, down = u_dy * u_dy + v_dy * v_dy;
        at.step2 = to_right > down ? to_right : down;
    }
}

/// The points of a group of pixels that show triangles of one draw.
CAMRIG_LANES Point<Lanes> points_of(const ViewGeometry& geometry, const ViewDraw& draw, IntLanes numbers, int x, int y,
                                    IntLanes mask) {
    const ScreenVertex* const vertices = geometry.vertices().data();
    const ScreenTriangle* const triangles = geometry.triangles().data();
    Point<Lanes> points;
    std::array<Point<float>, 1> single;
    auto* const to = reinterpret_cast<float*>(&points);
    const std::size_t count = point_values(draw);
    for (int k = 0; k < lane_count; ++k) {
        if (mask[k] == 0) continue;
        const ScreenTriangle& triangle = triangles[numbers[k] - 1];
        const Setup s = set_up(vertices, triangle);
        interpolate(geometry, draw, triangle, place_at(s, x, y, static_cast<float>(k)), single[0]);
        const auto* const from = reinterpret_cast<const float*>(single.data());
        for (std::size_t i = 0; i < count; ++i) to[i * lane_count + static_cast<std::size_t>(k)] = from[i];
    }
    return points;
}

CAMRIG_LANES Point<Lanes> points_of(const ViewGeometry& geometry, const ViewDraw& draw, const ScreenTriangle& triangle,
                                    const Setup& s, int x, int y) {
    Point<Lanes> points;
    interpolate(geometry, draw, triangle, place_at(s, x, y, lane_numbers()), points);
    return points;
}

struct Rgba {
    Lanes3 rgb;
    Lanes a;
};

using Texel4 = float __attribute__((vector_size(16)));

CAMRIG_LANES Texel4 loaded(const Texel& texel) {
    // 16 bits to 32 by zeros between them: the compiler converts such short vectors one by one.
    using Halves = std::uint16_t __attribute__((vector_size(16)));
    using Words = std::int32_t __attribute__((vector_size(16)));
    using Pair = std::int64_t __attribute__((vector_size(16)));
    const auto halves = reinterpret_cast<Halves>(Pair{std::bit_cast<std::int64_t>(texel), 0});
    return __builtin_convertvector(
        reinterpret_cast<Words>(__builtin_shufflevector(halves, Halves{}, 0, 8, 1, 8, 2, 8, 3, 8)), Texel4);
}

/// The two texels beside a coordinate, with the share of the second.
struct TexelPair {
    IntLanes first, second;
    Lanes share;
};

CAMRIG_LANES TexelPair texels_beside(Lanes coordinate, Lanes size, Wrap wrap, bool is_linear) {
    Lanes at = coordinate;
    if (wrap == Wrap::repeat) {
        at = at - floor(at);
    } else if (wrap == Wrap::mirrored_repeat) {
        at = at - 2.0f * floor(at * 0.5f);
        at = at > 1.0f ? 2.0f - at : at;
    } else {
        at = clamp01(at);
    }
    const Lanes last = size - 1.0f;
    at = at * size - (is_linear ? 0.5f : 0.0f);
    const Lanes low = floor(at);
    Lanes first = low, second = low + 1.0f;
    if (wrap == Wrap::repeat) {
        first = first < 0.0f ? last : first;
        first = first > last ? first - size : first;
        second = second > last ? second - size : second;
    }
    // With any wrap: coordinates of no number, or beyond what floor() holds, read some texel, but one of the image.
    first = min(max(first, Lanes{}), last);
    second = min(max(second, Lanes{}), last);
    return {truncated(first), truncated(second), is_linear ? at - low : Lanes{}};
}

CAMRIG_LANES Rgba sample(const ViewDraw& draw, TextureSlot slot, const Point<Lanes>& points, IntLanes mask) {
    const SampledTexture& texture = *draw.textures[slot];
    const std::vector<TextureLevel>& levels = texture.image->levels;
    const Lanes u = points.textures[slot].u, v = points.textures[slot].v, step2 = points.textures[slot].step2;
    // OpenGL 4.5, 8.14: level of detail from the longer of the two steps.
    // The exponent of the square is the level, doubled: half a level up is the next.
    const IntLanes exponent = (reinterpret_cast<IntLanes>(step2) >> 23) - 127;
    const int most = texture.sampler.mipmaps ? static_cast<int>(levels.size()) - 1 : 0;
    const IntLanes nearest = (exponent + 1) >> 1;
    IntLanes level = nearest < 0 ? IntLanes{} : nearest;
    level = level > most ? IntLanes{} + most : level;
    const bool same_filter = texture.sampler.magnify == texture.sampler.minify;
    // 8.14.3: from sharp to filtered at the full size; linear magnification beside a nearest mip level goes on for half
    // a level.
    const bool goes_on = texture.sampler.mipmaps && texture.sampler.minify == Filter::nearest;
    const IntLanes is_magnified = exponent < (goes_on ? 1 : 0);

    std::array<const TextureLevel*, lane_count> of_lane{};
    LaneValues lane_widths{}, lane_heights{};
    for (std::size_t k = 0; k < lane_count; ++k) {
        const TextureLevel& chosen = levels[static_cast<std::size_t>(level[static_cast<int>(k)])];
        of_lane[k] = &chosen;
        lane_widths[k] = static_cast<float>(chosen.width);
        lane_heights[k] = static_cast<float>(chosen.height);
    }
    const Lanes widths = std::bit_cast<Lanes>(lane_widths), heights = std::bit_cast<Lanes>(lane_heights);
    const auto pairs = [&](bool is_linear, TexelPair& columns, TexelPair& rows) __attribute__((always_inline)) {
        columns = texels_beside(u, widths, texture.sampler.wrap_s, is_linear);
        rows = texels_beside(v, heights, texture.sampler.wrap_t, is_linear);
    };
    TexelPair columns, rows;
    pairs(texture.sampler.minify == Filter::linear, columns, rows);
    if (!same_filter) {
        TexelPair large_columns, large_rows;
        pairs(texture.sampler.magnify == Filter::linear, large_columns, large_rows);
        const auto choose = [&](TexelPair& to, const TexelPair& large) {
            to.first = is_magnified ? large.first : to.first;
            to.second = is_magnified ? large.second : to.second;
            to.share = is_magnified ? large.share : to.share;
        };
        choose(columns, large_columns);
        choose(rows, large_rows);
    }
    LaneValues red{}, green{}, blue{}, alpha{};
    for (int i = 0; i < lane_count; ++i) {
        if (mask[i] == 0) continue;
        const auto k = static_cast<std::size_t>(i);
        const TextureLevel& from = *of_lane[k];
        const Texel* const top = from.texels.data() + static_cast<std::ptrdiff_t>(rows.first[i]) * from.width;
        const Texel* const bottom = from.texels.data() + static_cast<std::ptrdiff_t>(rows.second[i]) * from.width;
        const float across = columns.share[i], down = rows.share[i];
        const Texel4 a = loaded(top[columns.first[i]]), b = loaded(top[columns.second[i]]);
        const Texel4 c = loaded(bottom[columns.first[i]]), d = loaded(bottom[columns.second[i]]);
        const Texel4 upper = a + (b - a) * across, lower = c + (d - c) * across;
        const Texel4 value = (upper + (lower - upper) * down) * (1.0f / 65535.0f);
        red[k] = value[0];
        green[k] = value[1];
        blue[k] = value[2];
        alpha[k] = value[3];
    }
    return {{std::bit_cast<Lanes>(red), std::bit_cast<Lanes>(green), std::bit_cast<Lanes>(blue)},
            std::bit_cast<Lanes>(alpha)};
}

CAMRIG_LANES Rgba base_color(const ViewDraw& draw, const Point<Lanes>& points, IntLanes mask) {
    const glm::vec4& factor = draw.primitive->material->base_color;
    Rgba base{{lanes(factor.r), lanes(factor.g), lanes(factor.b)}, lanes(factor.a)};
    if (draw.colors != nullptr) {
        base.rgb = base.rgb * Lanes3{points.color[0], points.color[1], points.color[2]};
        base.a = base.a * points.color[3];
    }
    if (draw.textures[base_color_slot] != nullptr) {
        const Rgba texture = sample(draw, base_color_slot, points, mask);
        base.rgb = base.rgb * texture.rgb;
        base.a = base.a * texture.a;
    }
    return base;
}

CAMRIG_LANES Lanes3 splat(const glm::vec3& v) {
    return {lanes(v.x), lanes(v.y), lanes(v.z)};
}

CAMRIG_LANES Lanes3 hemisphere(const ViewLight& light, const Lanes3& n) {
    return splat(light.ground) + splat(light.sky - light.ground) * (0.5f + 0.5f * dot(n, splat(light.up)));
}

/// Everything that reaches a Lambert surface but the ambient part (as lighting.glsl).
CAMRIG_LANES Lanes3 lambert(const SurfaceLights& lights, const Lanes3& n, const Lanes3& position) {
    Lanes3 sum{};
    for (const SurfaceLight& light : lights.directional)
        sum = sum + splat(light.color) * max(dot(n, splat(light.towards)), Lanes{});
    for (const SurfaceLight& light : lights.local) {
        const Lanes3 towards = splat(light.position) - position;
        const Lanes distance2 = max(dot(towards, towards), lanes(1e-8f));
        const Lanes3 direction = towards * (1.0f / sqrt(distance2));
        const Lanes ratio2 = distance2 * light.inverse_range2;
        const Lanes window = clamp01(1.0f - ratio2 * ratio2);
        const Lanes cone = clamp01(-dot(direction, splat(light.direction)) * light.spot_scale + light.spot_offset);
        sum = sum + splat(light.color) * (window * cone * cone / distance2 * max(dot(n, direction), Lanes{}));
    }
    return sum;
}

CAMRIG_LANES Lanes3 surface_light(const ViewGeometry& geometry, const ViewDraw& draw, const Point<Lanes>& points, int x,
                                  int y, Lanes occlusion) {
    const ViewLight& light = geometry.light();
    if (draw.vertex_lights >= 0) {
        return Lanes3{points.light[0], points.light[1], points.light[2]} +
               Lanes3{points.ambient[0], points.ambient[1], points.ambient[2]} * (occlusion - 1.0f);
    }
    const glm::mat3& m = draw.optical_from_normal;
    Lanes3 n = splat(m[0]) * points.normal[0] + splat(m[1]) * points.normal[1] + splat(m[2]) * points.normal[2];
    n = n * (1.0f / sqrt(max(dot(n, n), lanes(1e-30f))));
    const Intrinsics& k = geometry.scope().transform.intrinsics;
    const auto inverse_fx = static_cast<float>(1.0 / k.fx), inverse_fy = static_cast<float>(1.0 / k.fy);
    const Lanes ray_x = (lane_numbers() + static_cast<float>(x - k.cx)) * inverse_fx;
    const float ray_y = static_cast<float>(y - k.cy) * inverse_fy;
    const Lanes3 position{ray_x * points.z, ray_y * points.z, points.z};
    return hemisphere(light, n) * occlusion + lambert(*draw.lights, n, position);
}

/// x^(1/2.4) fitted by two square roots, as srgb.glsl: at most 0.03 of a code of 255 from IEC 61966-2-1.
CAMRIG_LANES Lanes srgb(Lanes c) {
    c = clamp01(c);
    const Lanes root = sqrt(c);
    const Lanes high =
        0.91269030f * root + 0.25450221f * sqrt(root) + c * (0.03564411f * root - 0.13222371f) - 0.07051239f;
    return c <= 0.0031308f ? 12.92f * c : high;
}

CAMRIG_LANES IntLanes code(Lanes value) {
    return truncated(value * 255.0f + 0.5f);
}

/// Linear light of a group of pixels.
CAMRIG_LANES Rgba shade(const ViewGeometry& geometry, const ViewDraw& draw, const Point<Lanes>& points, int x, int y,
                        IntLanes mask) {
    const Material& material = *draw.primitive->material;
    const Rgba color = base_color(draw, points, mask);
    const float exposure = geometry.light().exposure;
    if (!draw.primitive->is_lit) return {color.rgb * lanes(exposure), color.a};
    Lanes occlusion = lanes(1.0f);
    if (draw.textures[occlusion_slot] != nullptr) {
        const Lanes red = sample(draw, occlusion_slot, points, mask).rgb.x;
        occlusion = 1.0f + material.occlusion_strength * (red - 1.0f);
    }
    Lanes3 emissive = splat(material.emissive * exposure);
    if (draw.textures[emissive_slot] != nullptr) emissive = emissive * sample(draw, emissive_slot, points, mask).rgb;
    return {color.rgb * surface_light(geometry, draw, points, x, y, occlusion) + emissive, color.a};
}

CAMRIG_LANES IntLanes pixels_of(const Lanes3& srgb_color) {
    return code(srgb_color.x) | (code(srgb_color.y) << 8) | (code(srgb_color.z) << 16) | (IntLanes{} + (255 << 24));
}

CAMRIG_LANES void store(std::uint32_t* row, int x, IntLanes mask, IntLanes values) {
    auto* const at = reinterpret_cast<IntLanes*>(row + x);
    *at = mask ? values : *at;
}

/// find_visible for a triangle of few pixels, as most of people's are: false if it has more. The same arithmetic.
CAMRIG_LANES bool find_small(const Setup& s, const PixelRect& rect, const Canvas& canvas,
                             const TriangleNumbers& numbers, std::uint32_t number) {
    constexpr int bits = 8, side = 4;
    const ScreenVertex &a = *s.at[0], &b = *s.at[1], &c = *s.at[2];
    const std::int32_t least_x = std::min(a.x, std::min(b.x, c.x)), most_x = std::max(a.x, std::max(b.x, c.x));
    const std::int32_t least_y = std::min(a.y, std::min(b.y, c.y)), most_y = std::max(a.y, std::max(b.y, c.y));
    if (most_x - least_x >= side * subpixels || most_y - least_y >= side * subpixels) return false;
    const int x0 = std::max(rect.x0, (least_x + subpixels - 1) >> bits), x1 = std::min(rect.x1, (most_x >> bits) + 1);
    const int y0 = std::max(rect.y0, (least_y + subpixels - 1) >> bits), y1 = std::min(rect.y1, (most_y >> bits) + 1);
    if (x0 >= x1 || y0 >= y1) return true;
    const int first = x0 & -lane_count;
    if (first != ((x1 - 1) & -lane_count)) return false;
    const DepthPlane depth = depth_plane(s);
    std::array<std::int32_t, 3> row{}, bias{};  // at the first pixel of the group
    for (std::size_t i = 0; i < 3; ++i) {
        bias[i] = s.dy[i] < 0 || (s.dy[i] == 0 && s.dx[i] > 0) ? 0 : -1;
        row[i] = static_cast<std::int32_t>(edge(s, i, std::int64_t{first} * subpixels, std::int64_t{y0} * subpixels));
    }
    for (int y = y0; y < y1; ++y) {
        const float base = static_cast<float>(depth.base + static_cast<double>(row[1]) * depth.second +
                                              static_cast<double>(row[2]) * depth.third);
        float* const kept = canvas.depth.row(y);
        for (int x = x0; x < x1; ++x) {
            const std::int32_t steps = (x - first) * subpixels;
            const std::int32_t outside = (row[0] + bias[0] - s.dy[0] * steps) | (row[1] + bias[1] - s.dy[1] * steps) |
                                         (row[2] + bias[2] - s.dy[2] * steps);
            if (outside < 0) continue;
            const float z = base + static_cast<float>(x - first) * depth.dx;
            if (!(z > kept[x])) continue;
            kept[x] = z;
            numbers.row(y)[x] = number;
        }
        for (std::size_t i = 0; i < 3; ++i) row[i] += s.dx[i] * subpixels;
    }
    return true;
}

CAMRIG_LANES void find_visible_body(const ViewGeometry& geometry, std::uint32_t first, std::uint32_t count,
                                    const PixelRect& rect, const Canvas& canvas, const TriangleNumbers& numbers) {
    const ScreenVertex* const vertices = geometry.vertices().data();
    for (std::uint32_t i = first; i < first + count; ++i) {
        const ScreenTriangle& triangle = geometry.triangles()[i];
        const ViewDraw& draw = geometry.draws()[triangle.draw];
        const Material& material = *draw.primitive->material;
        const bool is_masked = material.alpha_mode == AlphaMode::mask;
        const Setup s = set_up(vertices, triangle);
        if (!is_masked && find_small(s, rect, canvas, numbers, i + 1)) continue;
        rasterize(s, rect, [&](int x, int y, IntLanes mask, Lanes depth) __attribute__((always_inline)) {
            auto* const kept = reinterpret_cast<Lanes*>(canvas.depth.row(y) + x);
            mask &= depth > *kept;
            if (!any(mask)) return;
            if (is_masked) {
                const Lanes alpha = base_color(draw, points_of(geometry, draw, triangle, s, x, y), mask).a;
                mask &= alpha >= material.alpha_cutoff;
            }
            *kept = mask ? depth : *kept;
            store(numbers.row(y), x, mask, IntLanes{} + static_cast<std::int32_t>(i + 1));
        });
    }
}

CAMRIG_LANES void shade_visible_body(const ViewGeometry& geometry, const PixelRect& rect, const Canvas& canvas,
                                     const TriangleNumbers& numbers) {
    const ScreenVertex* const vertices = geometry.vertices().data();
    const ScreenTriangle* const triangles = geometry.triangles().data();
    for (int y = rect.y0; y < rect.y1; ++y) {
        for (int x = rect.x0 & -lane_count; x < rect.x1; x += lane_count) {
            auto* const at = reinterpret_cast<IntLanes*>(numbers.row(y) + x);
            IntLanes left = *at;
            if (!any(left)) continue;
            *at = IntLanes{};
            IntLanes pixels{};
            const IntLanes drawn = left != 0;
            for (int i = 0; i < lane_count; ++i) {
                const std::int32_t number = left[i];
                if (number == 0) continue;
                // All pixels of one draw at once; most often they are all that are left.
                const std::uint32_t draw_number = triangles[number - 1].draw;
                const ViewDraw& draw = geometry.draws()[draw_number];
                IntLanes mask = left == number;
                const bool is_one_triangle = !any(left & ~mask);
                Point<Lanes> points;
                if (is_one_triangle) {
                    const ScreenTriangle& triangle = triangles[number - 1];
                    points = points_of(geometry, draw, triangle, set_up(vertices, triangle), x, y);
                } else {
                    for (int k = i + 1; k < lane_count; ++k) {
                        if (left[k] != 0 && triangles[left[k] - 1].draw == draw_number) mask[k] = -1;
                    }
                    points = points_of(geometry, draw, left, x, y, mask);
                }
                left = mask ? IntLanes{} : left;
                const Rgba color = shade(geometry, draw, points, x, y, mask);
                const IntLanes made = pixels_of({srgb(color.rgb.x), srgb(color.rgb.y), srgb(color.rgb.z)});
                pixels = mask ? made : pixels;
            }
            store(canvas.color.row(y), x, drawn, pixels);
        }
    }
}

/// Linear light of the 256 codes.
const std::array<float, 256>& linear_of_code() {
    static const std::array<float, 256> table = [] {
        std::array<float, 256> made{};
        for (std::size_t i = 0; i < made.size(); ++i) {
            const double value = static_cast<double>(i) / 255.0;
            made[i] = static_cast<float>(value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4));
        }
        return made;
    }();
    return table;
}

CAMRIG_LANES void blend_body(const ViewGeometry& geometry, std::uint32_t first, std::uint32_t count,
                             const PixelRect& rect, const Canvas& canvas, const std::array<float, 256>& linear) {
    const ScreenVertex* const vertices = geometry.vertices().data();
    for (std::uint32_t i = first; i < first + count; ++i) {
        const ScreenTriangle& triangle = geometry.triangles()[i];
        const ViewDraw& draw = geometry.draws()[triangle.draw];
        const Setup s = set_up(vertices, triangle);
        rasterize(s, rect, [&](int x, int y, IntLanes mask, Lanes depth) __attribute__((always_inline)) {
            mask &= depth > *reinterpret_cast<const Lanes*>(canvas.depth.row(y) + x);
            if (!any(mask)) return;
            const Rgba color = shade(geometry, draw, points_of(geometry, draw, triangle, s, x, y), x, y, mask);
            const std::uint32_t* const row = canvas.color.row(y);
            LaneValues red{}, green{}, blue{};
            for (std::size_t k = 0; k < lane_count; ++k) {
                const std::uint32_t pixel = row[static_cast<std::size_t>(x) + k];
                red[k] = linear[pixel & 0xFF];
                green[k] = linear[pixel >> 8 & 0xFF];
                blue[k] = linear[pixel >> 16 & 0xFF];
            }
            const Lanes3 behind{std::bit_cast<Lanes>(red), std::bit_cast<Lanes>(green), std::bit_cast<Lanes>(blue)};
            const Lanes alpha = clamp01(color.a);
            const auto mixed = [&](Lanes over, Lanes under) __attribute__((always_inline)) {
                return srgb(clamp01(over) * alpha + under * (1.0f - alpha));
            };
            store(
                canvas.color.row(y), x, mask,
                pixels_of({mixed(color.rgb.x, behind.x), mixed(color.rgb.y, behind.y), mixed(color.rgb.z, behind.z)}));
        });
    }
}

#if defined(__x86_64__)
#define CAMRIG_WIDE [[gnu::target("avx2")]]
#else
#define CAMRIG_WIDE
#endif

CAMRIG_WIDE void find_visible_wide(const ViewGeometry& geometry, std::uint32_t first, std::uint32_t count,
                                   const PixelRect& rect, const Canvas& canvas, const TriangleNumbers& numbers) {
    find_visible_body(geometry, first, count, rect, canvas, numbers);
}
CAMRIG_WIDE void shade_visible_wide(const ViewGeometry& geometry, const PixelRect& rect, const Canvas& canvas,
                                    const TriangleNumbers& numbers) {
    shade_visible_body(geometry, rect, canvas, numbers);
}
CAMRIG_WIDE void blend_wide(const ViewGeometry& geometry, std::uint32_t first, std::uint32_t count,
                            const PixelRect& rect, const Canvas& canvas) {
    blend_body(geometry, first, count, rect, canvas, linear_of_code());
}

}  // namespace

bool has_wide_lanes() {
#if defined(__x86_64__)
    static const bool has = __builtin_cpu_supports("avx2");
    return has;
#else
    return false;
#endif
}

void find_visible(const ViewGeometry& geometry, std::uint32_t first_triangle, std::uint32_t count,
                  const PixelRect& rect, const Canvas& canvas, const TriangleNumbers& numbers) {
    if (geometry.scope().wide_lanes) return find_visible_wide(geometry, first_triangle, count, rect, canvas, numbers);
    find_visible_body(geometry, first_triangle, count, rect, canvas, numbers);
}

void shade_visible(const ViewGeometry& geometry, const PixelRect& rect, const Canvas& canvas,
                   const TriangleNumbers& numbers) {
    if (geometry.scope().wide_lanes) return shade_visible_wide(geometry, rect, canvas, numbers);
    shade_visible_body(geometry, rect, canvas, numbers);
}

void blend(const ViewGeometry& geometry, std::uint32_t first_triangle, std::uint32_t count, const PixelRect& rect,
           const Canvas& canvas) {
    if (geometry.scope().wide_lanes) return blend_wide(geometry, first_triangle, count, rect, canvas);
    blend_body(geometry, first_triangle, count, rect, canvas, linear_of_code());
}

std::uint8_t srgb_code(float linear) {
    return static_cast<std::uint8_t>(code(srgb(lanes(linear)))[0]);
}

}  // namespace camrig

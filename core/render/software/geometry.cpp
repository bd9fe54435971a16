#include "core/render/software/geometry.h"

#include <algorithm>
#include <cmath>

namespace camrig {
namespace {

SurfaceLight surface_light(const Light& light, const ViewTransform& view, float exposure) {
    SurfaceLight made;
    made.color = light.color * light.intensity * exposure;
    made.towards = glm::vec3(view.optical_from_world * -light.direction);
    if (light.type == LightType::directional) return made;
    made.position = glm::vec3(view.optical_from_world * (light.position - view.eye));
    made.direction = glm::vec3(view.optical_from_world * light.direction);
    made.inverse_range2 = light.range > 0.0f ? 1.0f / (light.range * light.range) : 0.0f;
    if (light.type == LightType::spot) {
        const float inner = std::cos(light.inner_cone_rad), outer = std::cos(light.outer_cone_rad);
        made.spot_scale = 1.0f / std::max(0.001f, inner - outer);
        made.spot_offset = -outer * made.spot_scale;
    }
    return made;
}

glm::vec3 hemisphere(const ViewLight& light, const glm::vec3& n) {
    return light.ground + (light.sky - light.ground) * (0.5f + 0.5f * glm::dot(n, light.up));
}

glm::vec3 lambert(const SurfaceLights& lights, const glm::vec3& n, const glm::vec3& position) {
    glm::vec3 sum(0.0f);
    for (const SurfaceLight& light : lights.directional)
        sum += light.color * std::max(glm::dot(n, light.towards), 0.0f);
    for (const SurfaceLight& light : lights.local) {
        const glm::vec3 towards = light.position - position;
        const float distance2 = std::max(glm::dot(towards, towards), 1e-8f);
        const glm::vec3 direction = towards / std::sqrt(distance2);
        const float ratio2 = distance2 * light.inverse_range2;
        const float window = std::clamp(1.0f - ratio2 * ratio2, 0.0f, 1.0f);
        const float cone =
            std::clamp(-glm::dot(direction, light.direction) * light.spot_scale + light.spot_offset, 0.0f, 1.0f);
        sum += light.color * (window * cone * cone / distance2 * std::max(glm::dot(n, direction), 0.0f));
    }
    return sum;
}

/// A corner of a clipped polygon: where it is, and how much of each corner of the triangle it is made of.
struct ClippedCorner {
    glm::dvec3 position;
    glm::dvec3 shares;
};

}  // namespace

void ViewGeometry::begin_view(const ViewScope& scope) {
    scope_ = scope;
    const Environment& environment = *scope.environment;
    light_.up = glm::vec3(scope.transform.optical_from_world * glm::dvec3(0.0, 0.0, 1.0));
    light_.sky = environment.ambient_sky * environment.exposure;
    light_.ground = environment.ambient_ground * environment.exposure;
    light_.exposure = environment.exposure;
    lights_used_ = 0;
    draws_.clear();
    vertices_.clear();
    triangles_.clear();
    clipped_.clear();
    vertex_lights_.clear();
}

const SurfaceLights* ViewGeometry::lights_of(const LightSet& set) {
    for (std::size_t i = 0; i < lights_used_; ++i) {
        if (lights_[i].set == set) return &lights_[i];
    }
    if (lights_used_ == lights_.size()) lights_.emplace_back();
    SurfaceLights& lights = lights_[lights_used_++];
    lights.set = set;
    lights.directional.clear();
    lights.local.clear();
    for (int i = 0; i < set.directional + set.local; ++i) {
        auto& list = i < set.directional ? lights.directional : lights.local;
        list.push_back(surface_light(scope_.lights[set.lights[static_cast<std::size_t>(i)]], scope_.transform,
                                     scope_.environment->exposure));
    }
    return &lights;
}

std::optional<ViewDraw> ViewScope::draw_of(const SoftwareItem& item) const {
    const glm::dmat4 optical_from_local = transform.optical_from(item.world_from_local);
    if (!may_be_visible(frustum, optical_from_local, item.bounds.min, item.bounds.max)) return std::nullopt;
    const SoftwarePrimitive& primitive = *item.primitive;
    ViewDraw draw;
    draw.item = &item;
    draw.primitive = &primitive;
    draw.optical_from_local = optical_from_local;
    draw.level = &primitive.levels.front();
    if (max_detail_error_px > 0.0 && primitive.levels.size() > 1) {
        const double px_per_unit = detail_error_px(transform, optical_from_local, item.bounds, 1.0) *
                                   detail_error_scale(primitive.source->bounds, item.bounds, item.world_from_local);
        for (const SoftwareLevel& level : primitive.levels) {
            // Not so for the full mesh where it reaches behind the image plane: its error is 0 there too.
            if (level.error > 0.0f && !(level.error * px_per_unit <= max_detail_error_px)) break;
            draw.level = &level;
        }
    }
    const glm::dvec3 middle = 0.5 * (glm::dvec3(item.bounds.min) + glm::dvec3(item.bounds.max));
    draw.distance_m = (optical_from_local * glm::dvec4(middle, 1.0)).z;
    return draw;
}

const ViewDraw& ViewGeometry::add(ViewDraw draw, const SoftwareItems& items) {
    const SoftwareItem& item = *draw.item;
    const Primitive& source = *draw.primitive->source;
    draw.positions = source.positions.data();
    draw.normals = source.normals.empty() ? nullptr : source.normals.data();
    if (item.deformation >= 0) {
        const DeformedVertices& made = items.deformed(item);
        draw.positions = made.positions.data();
        if (draw.normals != nullptr) draw.normals = made.normals.data();
    }
    draw.colors = source.colors.empty() ? nullptr : source.colors.data();
    const std::array<const SampledTexture*, texture_slot_count> textures{
        &draw.primitive->base_color, &draw.primitive->emissive, &draw.primitive->occlusion};
    for (std::size_t i = 0; i < textures.size(); ++i)
        draw.textures[i] = textures[i]->image != nullptr ? textures[i] : nullptr;
    draw.optical_from_normal = glm::mat3(normals_from(draw.optical_from_local, item.is_mirrored));
    draw.first_vertex = static_cast<std::uint32_t>(vertices_.size());
    draw.vertex_count = static_cast<std::uint32_t>(source.positions.size());
    draw.first_clipped = static_cast<std::uint32_t>(clipped_.size());
    draw.first_triangle = static_cast<std::uint32_t>(triangles_.size());
    if (draw.primitive->is_lit) {
        draw.lights = lights_of(item.lights);
        if (scope_.quality == Quality::fast) light_vertices(draw);
    }
    add_triangles(draw);
    draw.triangle_count = static_cast<std::uint32_t>(triangles_.size()) - draw.first_triangle;
    return draws_.emplace_back(draw);
}

ScreenVertex ViewGeometry::on_screen(const glm::dvec3& p) const {
    const ViewTransform& t = scope_.transform;
    const double inverse = 1.0 / p.z;
    const double u = t.intrinsics.fx * p.x * inverse + t.intrinsics.cx;
    const double v = t.intrinsics.fy * p.y * inverse + t.intrinsics.cy;
    return {.x = static_cast<std::int32_t>(std::lrint(u * subpixels)),
            .y = static_cast<std::int32_t>(std::lrint(v * subpixels)),
            .depth = static_cast<float>(t.depth_scale + t.depth_shift * inverse),
            .inverse_z = static_cast<float>(inverse)};
}

void ViewGeometry::light_vertices(ViewDraw& draw) {
    draw.vertex_lights = static_cast<std::ptrdiff_t>(vertex_lights_.size());
    vertex_lights_.resize(vertex_lights_.size() + draw.vertex_count);
    VertexLight* const to = vertex_lights_.data() + draw.vertex_lights;
    const bool has_back = draw.primitive->material->double_sided;
    for (const std::uint32_t i : draw.level->vertices) {
        const glm::vec3 p(draw.optical_from_local * glm::dvec4(draw.positions[i], 1.0));
        const glm::vec3 n = glm::normalize(draw.optical_from_normal * draw.normals[i]);
        to[i].ambient = hemisphere(light_, n);
        to[i].light = to[i].ambient + lambert(*draw.lights, n, p);
        if (has_back) to[i].light_behind = hemisphere(light_, -n) + lambert(*draw.lights, -n, p);
    }
}

void ViewGeometry::add_triangles(const ViewDraw& draw) {
    vertices_.resize(vertices_.size() + draw.vertex_count);
    outside_.resize(draw.vertex_count);
    project(scope_.transform, draw.optical_from_local, draw.positions, draw.level->vertices, scope_.wide_lanes,
            vertices_.data() + draw.first_vertex, outside_.data());
    for (auto* const list : {&to_clip_, &made_by_clipping_}) {
        for (auto& corners : *list) corners.clear();
    }
    const TriangleRule rule{.draw = static_cast<std::uint32_t>(draws_.size()),
                            .first_vertex = draw.first_vertex,
                            .is_mirrored = draw.item->is_mirrored,
                            .is_double_sided = draw.primitive->material->double_sided};
    const auto add = [&](const TriangleCorners& corners) {
        assemble(corners, vertices_.data() + draw.first_vertex, outside_.data(), rule, scope_.wide_lanes, triangles_,
                 to_clip_);
    };
    add(draw.level->triangles);
    for (std::size_t i = 0; i < to_clip_[0].size(); ++i) clip(draw, {to_clip_[0][i], to_clip_[1][i], to_clip_[2][i]});
    if (!made_by_clipping_[0].empty()) add(made_by_clipping_);
}

VertexValues ViewGeometry::values_of(const ViewDraw& draw, std::uint32_t vertex) const {
    VertexValues values;
    if (draw.normals != nullptr) values.normal = draw.normals[vertex];
    if (draw.colors != nullptr) values.color = draw.colors[vertex];
    for (std::size_t i = 0; i < draw.textures.size(); ++i) {
        if (draw.textures[i] != nullptr) values.coordinates[i] = draw.textures[i]->coordinates[vertex];
    }
    if (draw.vertex_lights >= 0) {
        const VertexLight& light = vertex_lights_[static_cast<std::size_t>(draw.vertex_lights) + vertex];
        values.light = light.light;
        values.light_behind = light.light_behind;
        values.ambient = light.ambient;
    }
    return values;
}

void ViewGeometry::clip(const ViewDraw& draw, const std::array<std::uint32_t, 3>& corners) {
    // Sutherland and Hodgman, Reentrant Polygon Clipping, 1974. Each plane adds one corner at most.
    constexpr std::size_t plane_count = 5, max_corners = 3 + plane_count;
    const ViewTransform& t = scope_.transform;
    const double guard_x = guard_px - std::abs(t.intrinsics.cx), guard_y = guard_px - std::abs(t.intrinsics.cy);
    const std::array<glm::dvec4, plane_count> planes{
        glm::dvec4(0.0, 0.0, 1.0, -t.near_m), glm::dvec4(t.intrinsics.fx, 0.0, guard_x, 0.0),
        glm::dvec4(-t.intrinsics.fx, 0.0, guard_x, 0.0), glm::dvec4(0.0, t.intrinsics.fy, guard_y, 0.0),
        glm::dvec4(0.0, -t.intrinsics.fy, guard_y, 0.0)};
    std::array<ClippedCorner, max_corners> polygon{}, inside{};
    std::size_t count = 3;
    for (std::size_t i = 0; i < 3; ++i) {
        polygon[i].position = glm::dvec3(draw.optical_from_local * glm::dvec4(draw.positions[corners[i]], 1.0));
        polygon[i].shares[static_cast<glm::length_t>(i)] = 1.0;
    }
    for (const glm::dvec4& plane : planes) {
        const auto height = [&](const ClippedCorner& corner) {
            return glm::dot(glm::dvec3(plane), corner.position) + plane.w;
        };
        std::size_t kept = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const ClippedCorner &from = polygon[i], &to = polygon[(i + 1) % count];
            const double a = height(from), b = height(to);
            if (a >= 0.0) inside[kept++] = from;
            if ((a >= 0.0) == (b >= 0.0)) continue;
            // Always from the inner to the outer end: the neighbour over this edge finds the same point.
            const ClippedCorner &in = a >= 0.0 ? from : to, &out = a >= 0.0 ? to : from;
            const double in_height = std::max(a, b), share = in_height / (in_height - std::min(a, b));
            inside[kept++] = {in.position + (out.position - in.position) * share,
                              in.shares + (out.shares - in.shares) * share};
        }
        polygon = inside;
        count = kept;
        if (count < 3) return;
    }
    const std::array<VertexValues, 3> values{values_of(draw, corners[0]), values_of(draw, corners[1]),
                                             values_of(draw, corners[2])};
    const auto first = static_cast<std::uint32_t>(vertices_.size());
    for (std::size_t i = 0; i < count; ++i) {
        // A point on the near plane may lie a rounding before it.
        glm::dvec3 position = polygon[i].position;
        if (!(position.z >= t.near_m)) position *= t.near_m / position.z;
        vertices_.push_back(on_screen(position));
        VertexValues& made = clipped_.emplace_back();
        made.color = glm::vec4(0.0f);
        for (std::size_t k = 0; k < 3; ++k) {
            const auto share = static_cast<float>(polygon[i].shares[static_cast<glm::length_t>(k)]);
            made.normal += values[k].normal * share;
            made.color += values[k].color * share;
            for (std::size_t s = 0; s < made.coordinates.size(); ++s)
                made.coordinates[s] += values[k].coordinates[s] * share;
            made.light += values[k].light * share;
            made.light_behind += values[k].light_behind * share;
            made.ambient += values[k].ambient * share;
        }
    }
    // All of it lies on the screen.
    outside_.resize(outside_.size() + count, 0);
    for (std::uint32_t i = 2; i < count; ++i) {
        const std::array<std::uint32_t, 3> fan{first, first + i - 1, first + i};
        for (std::size_t c = 0; c < fan.size(); ++c) made_by_clipping_[c].push_back(fan[c] - draw.first_vertex);
    }
}

}  // namespace camrig

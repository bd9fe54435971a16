#include "core/render/software/geometry.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/render/scene/light_sum.h"
#include "core/render/software/lambert.h"

namespace camrig::render::software {
namespace {

/// A corner of a clipped polygon: where it is, and how much of each corner of the triangle it is made of.
struct ClippedCorner {
    glm::dvec3 position;
    glm::dvec3 shares;
};

}  // namespace

void ViewGeometry::begin_view(const scene::SceneView& view, std::shared_ptr<const LensRays> rays, bool wide_lanes,
                              bool has_outlines, std::span<const ShadowInView> shadows,
                              std::shared_ptr<const BakedPicture> baked) {
    view_ = view;
    wide_lanes_ = wide_lanes;
    has_outlines_ = has_outlines;
    has_both_sides_ = false;
    shadows_.assign(shadows.begin(), shadows.end());
    bodies_ = nullptr;
    baked_ = is_beautiful() ? std::move(baked) : nullptr;
    reflections_ = {};
    if (baked_ != nullptr) {
        const glm::vec3 gain = view.light_gain * view.exposure_gain;
        light_of_map_ = baked_->scale * gain;
        if (!baked_->light->reflection_probes.places.empty())
            reflections_ = scene::reflections_in_view(baked_->reflections, *baked_->sights, view.transform, gain);
    }
    light_ = scene::ambient_in_view(view.scene->environment(), view.exposure(), view.transform);
    fog_ = view.fog();
    light_.sky *= view.light_gain;
    light_.ground *= view.light_gain;
    const auto light_sets = static_cast<std::size_t>(view.scene->light_sets().size());
    lights_.resize(std::max(lights_.size(), light_sets));
    lights_made_.assign(light_sets, false);
    draws_.clear();
    vertices_.clear();
    triangles_.clear();
    clipped_.clear();
    vertex_lights_.clear();
    rays_ = std::move(rays);
    ray_triangles_.clear();
    if (rays_ != nullptr) lens_ = LensNumbers(*view.lens, view.transform);
}

const SurfaceLights* ViewGeometry::lights_of(int light_set) {
    const auto number = static_cast<std::size_t>(light_set);
    SurfaceLights& lights = lights_[number];
    if (lights_made_[number]) return &lights;
    lights_made_[number] = true;
    lights.directional.clear();
    lights.local.clear();
    lights.directional_shadows.clear();
    lights.local_shadows.clear();
    const scene::LightSet& set = view_.scene->light_sets()[light_set];
    for (int i = 0; i < set.directional + set.local; ++i) {
        const std::size_t index = set.lights[static_cast<std::size_t>(i)];
        const world::Light& light = view_.scene->lights()[index];
        const bool is_directional = i < set.directional;
        (is_directional ? lights.directional : lights.local)
            .push_back(scene::light_in_view(light, view_.transform, light_.exposure, view_.lamps_hz));
        (is_directional ? lights.directional : lights.local).back().color *= view_.light_gain;
        const auto first = std::ranges::find(shadows_, index, &ShadowInView::light);
        const auto last = std::find_if(first, shadows_.end(), [&](const auto& map) { return map.light != index; });
        (is_directional ? lights.directional_shadows : lights.local_shadows).emplace_back(first, last);
    }
    return &lights;
}

const ViewDraw& ViewGeometry::add(const scene::SeenSurface& seen, const SoftwarePrimitive& primitive,
                                  const glm::vec3* positions_ahead) {
    const scene::PlacedSurface& placed = *seen.placed;
    const world::Primitive& source = *placed.primitive->source;
    ViewDraw draw;
    static_cast<scene::SeenSurface&>(draw) = seen;
    draw.primitive = placed.primitive;
    draw.mesh =
        seen.level == 0 ? &primitive.full : &placed.primitive->coarser[static_cast<std::size_t>(seen.level - 1)];
    draw.positions = source.positions.data();
    draw.normals = source.normals.empty() ? nullptr : source.normals.data();
    if (placed.deformation >= 0) {
        const scene::DeformedVertices& made = view_.scene->group_of(seen.is_static).deformed(placed);
        draw.positions = made.positions.data();
        if (draw.normals != nullptr) draw.normals = made.normals.data();
    }
    draw.positions_ahead = positions_ahead;
    draw.colors = source.colors.empty() ? nullptr : source.colors.data();
    draw.base_color = draw.primitive->material->base_color * glm::vec4(placed.tint, 1.0f);
    const auto use = [&](std::size_t slot, const SampledTexture& texture) {
        draw.textures[slot] = texture.image != nullptr ? &texture : nullptr;
    };
    for (std::size_t i = 0; i < primitive.textures.size(); ++i) use(i, primitive.textures[i]);
    if (is_beautiful() && draw.primitive->is_lit) {
        for (const TextureSlot slot : {normal_slot, metallic_roughness_slot})
            use(slot, primitive.of_material->of(*draw.primitive, slot));
        if (baked_ != nullptr) use_baked_light(draw);
        // Tangents are not deformed.
        if (draw.textures[normal_slot] != nullptr && !source.tangents.empty() && placed.deformation < 0)
            draw.tangents = source.tangents.data();
    }
    draw.optical_from_normal = glm::mat3(scene::normals_from(draw.optical_from_local, placed.is_mirrored));
    draw.first_vertex = static_cast<std::uint32_t>(vertices_.size());
    draw.vertex_count = static_cast<std::uint32_t>(source.positions.size());
    draw.first_clipped = static_cast<std::uint32_t>(clipped_.size());
    draw.first_triangle = static_cast<std::uint32_t>(triangles_.size());
    if (draw.primitive->is_lit) {
        draw.lights = lights_of(placed.light_set);
        if (view_.quality == world::Quality::fast) light_vertices(draw);
    }
    add_triangles(draw, primitive);
    draw.triangle_count = static_cast<std::uint32_t>(triangles_.size()) - draw.first_triangle;
    return draws_.emplace_back(draw);
}

void ViewGeometry::use_baked_light(ViewDraw& draw) {
    const scene::PlacedSurface& placed = *draw.placed;
    const auto map =
        placed.light_map_at ? baked_->of_primitives.find(placed.primitive->source) : baked_->of_primitives.end();
    if (map != baked_->of_primitives.end()) {
        draw.textures[light_slot] = &map->second;
        // What hides light is in the map.
        draw.textures[occlusion_slot] = nullptr;
        draw.light_map_at =
            glm::vec2(*placed.light_map_at) / glm::vec2(baked_->light->size.width, baked_->light->size.height);
        return;
    }
    if (const auto probe = scene::probe_at(baked_->light->grid, baked_->probes, placed.middle()))
        draw.surroundings =
            scene::surroundings_in_view(probe->scaled(view_.light_gain * view_.exposure_gain), view_.transform);
}

ScreenVertex ViewGeometry::on_screen(const glm::dvec3& p) const {
    const ViewTransform& t = view_.transform;
    const double inverse = 1.0 / p.z;
    const double u = t.intrinsics.fx * p.x * inverse + t.intrinsics.cx;
    const double v = t.intrinsics.fy * p.y * inverse + t.intrinsics.cy;
    // Clipping has no digits left for corners that are 1e20 m away. What is no number becomes one here.
    const auto snapped = [](double px) {
        return static_cast<std::int32_t>(std::lrint(std::fmin(std::fmax(px, -guard_px), guard_px) * subpixels));
    };
    return {.x = snapped(u),
            .y = snapped(v),
            .depth = static_cast<float>(t.depth_scale + t.depth_shift * inverse),
            .inverse_z = static_cast<float>(inverse)};
}

void ViewGeometry::light_vertices(ViewDraw& draw) {
    draw.vertex_lights = static_cast<std::ptrdiff_t>(vertex_lights_.size());
    vertex_lights_.resize(vertex_lights_.size() + draw.vertex_count);
    VertexLight* const to = vertex_lights_.data() + draw.vertex_lights;
    const bool has_back = draw.primitive->material->double_sided;
    for (const std::uint32_t i : draw.mesh->vertices) {
        const glm::vec3 p(draw.optical_from_local * glm::dvec4(draw.positions[i], 1.0));
        // Of what is flattened to nothing it is none.
        const glm::vec3 normal = draw.optical_from_normal * draw.normals[i];
        const glm::vec3 n = normal * glm::inversesqrt(std::max(glm::dot(normal, normal), 1e-30f));
        to[i].ambient = hemisphere<OnePoint>(light_, n);
        to[i].light = to[i].ambient + lambert<OnePoint>(*draw.lights, n, p);
        if (has_back) to[i].light_behind = hemisphere<OnePoint>(light_, -n) + lambert<OnePoint>(*draw.lights, -n, p);
    }
}

void ViewGeometry::add_triangles(const ViewDraw& draw, const SoftwarePrimitive& primitive) {
    if (draw.primitive->source->topology != world::Topology::triangles) return add_strokes(draw);
    const MeshNeighbors* const neighbors =
        has_outlines_ ? &primitive.neighbors->of(primitive, *draw.primitive, draw.level) : nullptr;
    TriangleRule rule{.draw = static_cast<std::uint32_t>(draws_.size()),
                      .first_vertex = draw.first_vertex,
                      .turns_clockwise = draw.placed->turns_clockwise,
                      .is_double_sided = has_both_sides_ || draw.primitive->material->double_sided,
                      .keeps_thin = has_outlines_,
                      .neighbors = neighbors};
    if (rays_ != nullptr) return add_ray_triangles(draw, rule);
    vertices_.resize(vertices_.size() + draw.vertex_count);
    outside_.resize(draw.vertex_count);
    project(view_.transform, draw.optical_from_local, draw.positions, draw.mesh->vertices, wide_lanes_,
            vertices_.data() + draw.first_vertex, outside_.data());
    for (auto* const list : {&to_clip_, &made_by_clipping_}) {
        for (auto& corners : *list) corners.clear();
    }
    const auto add = [&](const scene::TriangleCorners& corners) {
        assemble(corners, vertices_.data() + draw.first_vertex, outside_.data(), rule, wide_lanes_, outline_scratch_,
                 triangles_, to_clip_);
    };
    add(draw.mesh->triangles);
    for (std::size_t i = 0; i < to_clip_[0].size(); ++i) clip(draw, {to_clip_[0][i], to_clip_[1][i], to_clip_[2][i]});
    // What was made is no triangle of the mesh.
    rule.neighbors = nullptr;
    if (!made_by_clipping_[0].empty()) add(made_by_clipping_);
}

void ViewGeometry::add_ray_triangles(const ViewDraw& draw, const TriangleRule& rule) {
    lens_vertices_.resize(std::max<std::size_t>(lens_vertices_.size(), draw.vertex_count));
    place_vertices(lens_, transform().size, draw.optical_from_local, draw.positions, draw.mesh->vertices, wide_lanes_,
                   lens_vertices_.data());
    assemble_rays(draw.mesh->triangles, lens_vertices_.data(), rule, lens_, *rays_, wide_lanes_, outline_scratch_,
                  triangles_, ray_triangles_);
}

std::int64_t ViewGeometry::bytes() const {
    const auto of = [](const auto& values) { return static_cast<std::int64_t>(values.capacity() * sizeof values[0]); };
    return of(draws_) + of(vertices_) + of(triangles_) + of(ray_triangles_) + of(clipped_) + of(vertex_lights_) +
           of(outside_) + of(lens_vertices_);
}

VertexValues ViewGeometry::values_of(const ViewDraw& draw, std::uint32_t vertex) const {
    VertexValues values;
    values.position = draw.positions[vertex];
    values.local = draw.positions[vertex];
    if (draw.positions_ahead != nullptr) values.local_ahead = draw.positions_ahead[vertex];
    if (draw.normals != nullptr) values.normal = draw.normals[vertex];
    if (draw.colors != nullptr) values.color = draw.colors[vertex];
    if (draw.tangents != nullptr) values.tangent = draw.tangents[vertex];
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
    // Sutherland and Hodgman, Reentrant Polygon Clipping, 1974. Each plane adds one corner to a convex polygon.
    // Rounding bends those of triangles of 1e20 m, which a plane may then cross more than twice: of n corners with k
    // before the plane k + 2 min(k, n - k) are left, at most 4 of 3, then 6, 9, 13 and 19.
    constexpr std::size_t plane_count = 5, max_corners = 19;
    const ViewTransform& t = view_.transform;
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
        if (kept < 3) return;
        std::copy_n(inside.begin(), kept, polygon.begin());
        count = kept;
    }
    const std::array<VertexValues, 3> values{values_of(draw, corners[0]), values_of(draw, corners[1]),
                                             values_of(draw, corners[2])};
    const auto first = static_cast<std::uint32_t>(vertices_.size());
    for (std::size_t i = 0; i < count; ++i) {
        // A point on the near plane may lie a rounding before it.
        glm::dvec3 position = polygon[i].position;
        if (!(position.z >= t.near_m)) position *= t.near_m / position.z;
        vertices_.push_back(on_screen(position));
        add_between(values, polygon[i].shares).position = position;
    }
    // All of it lies on the screen.
    outside_.resize(outside_.size() + count, 0);
    for (std::uint32_t i = 2; i < count; ++i) {
        const std::array<std::uint32_t, 3> fan{first, first + i - 1, first + i};
        for (std::size_t c = 0; c < fan.size(); ++c) made_by_clipping_[c].push_back(fan[c] - draw.first_vertex);
    }
}

VertexValues& ViewGeometry::add_between(const std::array<VertexValues, 3>& values, const glm::dvec3& shares) {
    VertexValues& made = clipped_.emplace_back();
    made.color = glm::vec4(0.0f);
    for (std::size_t k = 0; k < 3; ++k) {
        const auto share = static_cast<float>(shares[static_cast<glm::length_t>(k)]);
        made.normal += values[k].normal * share;
        made.color += values[k].color * share;
        made.tangent += values[k].tangent * share;
        made.local += values[k].local * share;
        made.local_ahead += values[k].local_ahead * share;
        for (std::size_t s = 0; s < made.coordinates.size(); ++s)
            made.coordinates[s] += values[k].coordinates[s] * share;
        made.light += values[k].light * share;
        made.light_behind += values[k].light_behind * share;
        made.ambient += values[k].ambient * share;
    }
    return made;
}

}  // namespace camrig::render::software

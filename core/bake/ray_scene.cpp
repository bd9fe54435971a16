#include "core/bake/ray_scene.h"

#include <algorithm>
#include <cmath>

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include "core/render/scene/placement.h"
#include "core/render/surface_tables.h"

namespace camrig::bake {
namespace {

using render::scene::PlacedSurface;

/// So many surfaces a ray goes through at most: leaves, panes.
constexpr int max_passed = 24;
/// Metres before the next surface is looked for.
constexpr float step_m = 1e-4f;

/// What both sides of a pane do not mirror, back and forth between them, of light at that cosine: by Fresnel's
/// equations, for light from a hemisphere 1 % less than by Schlick's fit of them.
float through_pane(float cosine) {
    constexpr float index = 1.5f;
    const float outside = std::min(cosine, 1.0f);
    const float inside = std::sqrt(1.0f - (1.0f - outside * outside) / (index * index));
    const float across = (outside - index * inside) / (outside + index * inside);
    const float along = (index * outside - inside) / (index * outside + inside);
    const float mirrored = 0.5f * (across * across + along * along);
    return (1.0f - mirrored) / (1.0f + mirrored);
}

RaySurface surface_of(const render::scene::PlacedScene& scene, const PlacedSurface& placed) {
    const world::Primitive& primitive = *placed.primitive->source;
    RaySurface made;
    made.placed = &placed;
    made.primitive = &primitive;
    made.material = placed.primitive->material;
    made.is_lit = placed.primitive->is_lit;
    const glm::vec3* positions = primitive.positions.data();
    const glm::vec3* normals = primitive.normals.empty() ? nullptr : primitive.normals.data();
    if (placed.deformation >= 0) {
        const render::scene::DeformedVertices& vertices = scene.statics().deformed(placed);
        positions = vertices.positions.data();
        if (normals != nullptr) normals = vertices.normals.data();
    }
    const glm::dmat3 turn = render::scene::normals_from(placed.world_from_local, placed.is_mirrored);
    for (std::size_t i = 0; i < primitive.positions.size(); ++i) {
        made.positions.emplace_back(placed.world_from_local * glm::dvec4(positions[i], 1.0));
        if (normals != nullptr) made.normals.emplace_back(glm::normalize(turn * glm::dvec3(normals[i])));
    }
    return made;
}

glm::uvec3 vertices_of(const world::Primitive& primitive, std::size_t triangle) {
    return {primitive.indices[3 * triangle], primitive.indices[3 * triangle + 1], primitive.indices[3 * triangle + 2]};
}

}  // namespace

struct RayScene::Embree {
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
    ~Embree() {
        if (scene != nullptr) rtcReleaseScene(scene);
        if (device != nullptr) rtcReleaseDevice(device);
    }
};

glm::vec3 RaySurface::position_at(std::size_t triangle, const glm::vec3& shares) const {
    const glm::uvec3 corners = vertices_of(*primitive, triangle);
    return positions[corners.x] * shares.x + positions[corners.y] * shares.y + positions[corners.z] * shares.z;
}

glm::vec3 RaySurface::side_of(std::size_t triangle) const {
    const glm::uvec3 corners = vertices_of(*primitive, triangle);
    const glm::dvec3 a(positions[corners.x]), b(positions[corners.y]), c(positions[corners.z]);
    const glm::dvec3 across = glm::cross(b - a, c - a) * (placed->turns_clockwise ? -1.0 : 1.0);
    const double length = glm::length(across);
    return length > 0.0 ? glm::vec3(across / length) : glm::vec3(0.0f);
}

glm::vec3 RaySurface::normal_at(std::size_t triangle, const glm::vec3& shares) const {
    if (normals.empty()) return side_of(triangle);
    const glm::uvec3 corners = vertices_of(*primitive, triangle);
    const glm::vec3 sum = normals[corners.x] * shares.x + normals[corners.y] * shares.y + normals[corners.z] * shares.z;
    const float length = glm::length(sum);
    return length > 1e-6f ? sum / length : side_of(triangle);
}

RayScene::RayScene(const render::scene::PlacedScene& scene) : embree_(std::make_unique<Embree>()) {
    for (const PlacedSurface& placed : scene.statics().all()) {
        if (placed.is_contact_shadow || placed.primitive->source->topology != world::Topology::triangles) continue;
        if (placed.object->model->sky_radius_m > 0.0) continue;
        surfaces_.push_back(surface_of(scene, placed));
    }
    // One thread builds, so that what lies in one place is found in the same order each time.
    embree_->device = rtcNewDevice("threads=1");
    CHECK(embree_->device != nullptr);
    embree_->scene = rtcNewScene(embree_->device);
    rtcSetSceneFlags(embree_->scene, RTC_SCENE_FLAG_ROBUST);
    for (std::size_t i = 0; i < surfaces_.size(); ++i) {
        const RaySurface& surface = surfaces_[i];
        const RTCGeometry geometry = rtcNewGeometry(embree_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
        // Buffers end with more than the 16 bytes that Embree may read.
        void* const vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                       sizeof(glm::vec3), surface.positions.size());
        std::copy_n(surface.positions.data(), surface.positions.size(), static_cast<glm::vec3*>(vertices));
        const auto& indices = surface.primitive->indices;
        void* const triangles = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                        3 * sizeof(std::uint32_t), indices.size() / 3);
        std::copy_n(indices.data(), indices.size() / 3 * 3, static_cast<std::uint32_t*>(triangles));
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(embree_->scene, geometry, static_cast<unsigned>(i));
        rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(embree_->scene);
}

RayScene::~RayScene() = default;

std::optional<RayHit> RayScene::nearest(const Ray& ray) const {
    RTCRayHit at{};
    at.ray.org_x = ray.from.x;
    at.ray.org_y = ray.from.y;
    at.ray.org_z = ray.from.z;
    at.ray.dir_x = ray.along.x;
    at.ray.dir_y = ray.along.y;
    at.ray.dir_z = ray.along.z;
    at.ray.tfar = ray.length;
    at.ray.mask = 0xFFFFFFFF;
    at.hit.geomID = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
    rtcIntersect1(embree_->scene, &at);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(embree_->scene, &context, &at);
#endif
    if (at.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    const glm::vec3 side = surfaces_[at.hit.geomID].side_of(at.hit.primID);
    return RayHit{at.hit.geomID, at.hit.primID, glm::vec3(1.0f - at.hit.u - at.hit.v, at.hit.u, at.hit.v), at.ray.tfar,
                  glm::dot(side, ray.along) <= 0.0f};
}

std::optional<RayHit> RayScene::first_hit(Ray ray, glm::vec3& through) const {
    through = glm::vec3(1.0f);
    for (int passed = 0; passed < max_passed; ++passed) {
        const auto hit = nearest(ray);
        if (!hit) return std::nullopt;
        const world::Material& material = *surfaces_[hit->surface].material;
        if (material.alpha_mode == world::AlphaMode::opaque) return hit;
        const float alpha = base_color(hit->surface, hit->triangle, hit->shares).a;
        if (material.alpha_mode == world::AlphaMode::mask) {
            if (alpha >= material.alpha_cutoff) return hit;
        } else {
            through *= 1.0f - alpha;
            if (material.transmission > 0.0f) {
                const glm::vec3 side = surfaces_[hit->surface].side_of(hit->triangle);
                through *= material.tint * through_pane(std::abs(glm::dot(side, ray.along)));
            }
        }
        ray.from = ray.from + ray.along * (hit->distance + step_m);
        ray.length -= hit->distance + step_m;
    }
    through = glm::vec3(0.0f);
    return std::nullopt;
}

glm::vec3 RayScene::open_share(Ray ray) const {
    constexpr glm::vec3 none(0.0f);
    glm::vec3 open(1.0f);
    for (int passed = 0; passed < max_passed && ray.length > 0.0f; ++passed) {
        glm::vec3 through;
        const auto hit = first_hit(ray, through);
        open *= through;
        if (!hit || open == none) return open;
        if (surfaces_[hit->surface].is_lit) return none;
        const glm::vec3 at = surfaces_[hit->surface].position_at(hit->triangle, hit->shares);
        const float gone = glm::dot(at - ray.from, ray.along) + step_m;
        ray.from = ray.from + ray.along * gone;
        ray.length -= gone;
    }
    return open;
}

glm::vec4 RayScene::base_color(std::uint32_t surface, std::uint32_t triangle, const glm::vec3& shares) const {
    const RaySurface& of = surfaces_[surface];
    const glm::uvec3 corners = vertices_of(*of.primitive, triangle);
    glm::vec4 color = of.material->base_color *
                      colors_.of(**of.placed->source, of.material->base_color_texture, *of.primitive, corners, shares);
    const auto& colors = of.primitive->colors;
    if (!colors.empty())
        color *= colors[corners.x] * shares.x + colors[corners.y] * shares.y + colors[corners.z] * shares.z;
    return color;
}

glm::vec3 RayScene::glow(std::uint32_t surface, std::uint32_t triangle, const glm::vec3& shares) const {
    const RaySurface& of = surfaces_[surface];
    if (!of.is_lit) return glm::vec3(base_color(surface, triangle, shares));
    if (of.material->emissive == glm::vec3(0.0f)) return glm::vec3(0.0f);
    return of.material->emissive * glm::vec3(colors_.of(**of.placed->source, of.material->emissive_texture,
                                                        *of.primitive, vertices_of(*of.primitive, triangle), shares));
}

}  // namespace camrig::bake

#include "core/world/backdrop/proxy_maker.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/portable_math.h"
#include "core/camera/lens_traits.h"
#include "core/world/backdrop/triangulate.h"
#include "core/world/box_faces.h"
#include "core/world/world_fields.h"

namespace camrig::world {
namespace {

/// Ground farther away is as good as the horizon.
constexpr double max_ground_m = 1e5;
/// Sides of what was outlined in a picture through a lens are bent: they are cut so short, or into so many pieces.
constexpr double piece_px = 16.0, max_pieces = 500.0;

/// World axes (z up) to those of glTF, in which models are.
glm::vec3 gltf_axes(const glm::dvec3& p) {
    return glm::vec3(glm::dvec3(p.x, p.z, -p.y));
}

/// Proxies are seen by what they hide and what falls on them, never by their colour.
Material material_of(ProxyRole role) {
    Material material;
    material.name = std::string(to_string(role));
    material.unlit = role == ProxyRole::holdout;
    material.base_color = {0.5f, 0.5f, 0.5f, 1.0f};
    material.metallic = 0.0f;
    material.double_sided = true;
    return material;
}

}  // namespace

Result<glm::dvec3> ProxyMaker::on_ground(const glm::dvec2& pixel, double z) const {
    const auto d = direction(pixel);
    if (!d) return std::unexpected(refused(": the lens sees nothing at this pixel"));
    const double times = (z - eye().z) / d->z;
    if (!(times > 0.0) || !(times <= max_ground_m))
        return std::unexpected(
            refused(": is over the horizon of the ground: nothing of it shows at this pixel, or only farther than "
                    "100 km away; give a pixel below"));
    return *d * times;
}

bool ProxyMaker::is_ahead(const std::vector<glm::dvec3>& corners) const {
    return spec_.backdrop->is_panorama() || sees_behind(spec_.lens.model) ||
           std::ranges::any_of(corners,
                               [&](const glm::dvec3& p) { return glm::dot(world_from_optical_[2], p) > spec_.near_m; });
}

void ProxyMaker::begin(const glm::dvec3& normal) {
    normal_ = gltf_axes(normal);
    first_ = static_cast<std::uint32_t>(primitive().positions.size());
}

void ProxyMaker::corner(const glm::dvec3& place) {
    primitive().positions.push_back(gltf_axes(place));
    primitive().normals.push_back(normal_);
}

std::vector<glm::dvec2> ProxyMaker::with_short_sides(const std::vector<glm::dvec2>& polygon) const {
    if (spec_.lens.model == camera::LensModel::pinhole) return polygon;
    double around = 0.0;
    for (std::size_t i = 0; i < polygon.size(); ++i)
        around += glm::length(polygon[(i + 1) % polygon.size()] - polygon[i]);
    const double piece = std::max(piece_px, around / max_pieces);
    std::vector<glm::dvec2> made;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const glm::dvec2 side = polygon[(i + 1) % polygon.size()] - polygon[i];
        const int pieces = std::max(1, static_cast<int>(std::ceil(glm::length(side) / piece)));
        for (int k = 0; k < pieces; ++k) made.push_back(polygon[i] + side * (static_cast<double>(k) / pieces));
    }
    return made;
}

Result<std::vector<glm::dvec3>> ProxyMaker::corners_of(const LevelGround& ground) const {
    if (ground.polygon_m.empty() == ground.polygon_px.empty())
        return std::unexpected(refused(": give one of polygon_m and polygon_px"));
    if (!(eye().z > ground.z))
        return std::unexpected(refused(".z: is not below the camera, which is over its horizon"));
    std::vector<glm::dvec3> corners;
    const char* const given = ground.polygon_px.empty() ? ".polygon_m" : ".polygon_px";
    for (const glm::dvec2& p : ground.polygon_m) corners.push_back(glm::dvec3(p, ground.z) - eye());
    for (std::size_t i = 0; i < ground.polygon_px.size(); ++i)
        if (auto hit = on_ground(ground.polygon_px[i], ground.z); !hit) return under(item_path(given, i), hit.error());
    for (const glm::dvec2& pixel : with_short_sides(ground.polygon_px)) {
        const auto hit = on_ground(pixel, ground.z);
        if (!hit) return under(given, hit.error());
        corners.push_back(*hit);
    }
    return corners;
}

Result<void> ProxyMaker::add(const GroundProxy& ground) {
    const auto found = corners_of(ground.where());
    if (!found) return std::unexpected(found.error());
    const std::vector<glm::dvec3>& corners = *found;
    const char* const given = ground.polygon_px.empty() ? ".polygon_m" : ".polygon_px";
    if (!is_ahead(corners)) return std::unexpected(refused(std::string(given) + ": is behind the camera"));
    std::vector<glm::dvec2> flat;
    for (const glm::dvec3& p : corners) flat.emplace_back(p);
    const auto triangles = triangles_of(flat);
    if (!triangles) return at(given, triangles.error());
    role_ = ground.role;
    begin({0.0, 0.0, 1.0});
    for (const glm::dvec3& p : corners) corner(p);
    close(*triangles);
    return {};
}

Result<void> ProxyMaker::add(const BoxProxy& box) {
    const double yaw = glm::radians(box.yaw_deg);
    const glm::dmat3 turned({portable::cos(yaw), portable::sin(yaw), 0.0},
                            {-portable::sin(yaw), portable::cos(yaw), 0.0}, {0.0, 0.0, 1.0});
    const glm::dvec3 middle = box.position + glm::dvec3(0.0, 0.0, 0.5 * box.size.z) - eye();
    std::vector<glm::dvec3> corners;
    for (int i = 0; i < 8; ++i)
        corners.push_back(middle +
                          turned * (0.5 * box.size *
                                    glm::dvec3((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1)));
    if (!is_ahead(corners)) return std::unexpected(refused(": is behind the camera"));
    role_ = box.role;
    for (const BoxFace& face : box_faces()) {
        begin(turned * face.normal);
        for (const glm::dvec3& c : face.corners) corner(middle + turned * (0.5 * box.size * c));
        close(box_face_triangles);
    }
    return {};
}

Result<void> ProxyMaker::add(const CutoutProxy& cutout, std::span<const PixelRect> mask) {
    if (cutout.polygon_px.empty() == mask.empty()) return std::unexpected(refused(": give one of polygon_px and mask"));
    const auto foot = on_ground(cutout.foot_px, cutout.z);
    if (!foot) return under(".foot_px", foot.error());
    const double distance = glm::length(glm::dvec2(*foot));
    if (!(distance > spec_.near_m)) return std::unexpected(refused(".foot_px: is right below the camera"));
    const glm::dvec2 ahead = glm::dvec2(*foot) / distance, aside(-ahead.y, ahead.x);
    const std::string given = mask.empty() ? ".polygon_px" : ".mask";
    const auto upright = [&](const glm::dvec2& pixel) -> Result<glm::dvec3> {
        const auto d = direction(pixel);
        const double along = d ? glm::dot(glm::dvec2(*d), ahead) : 0.0;
        if (along > 1e-3) return *d * (distance / along);
        return std::unexpected(refused(given + ": not all of it can stand upright at its foot as the camera sees it"));
    };
    role_ = cutout.role;
    for (const PixelRect& piece : mask) {
        begin(glm::dvec3(-ahead, 0.0));
        for (const auto& [x, y] :
             {std::pair(piece.x0, piece.y0), {piece.x1, piece.y0}, {piece.x1, piece.y1}, {piece.x0, piece.y1}}) {
            const auto place = upright(glm::dvec2(x, y) - 0.5);
            if (!place) return std::unexpected(place.error());
            corner(*place);
        }
        close(box_face_triangles);
    }
    if (!mask.empty()) return {};
    std::vector<glm::dvec3> corners;
    std::vector<glm::dvec2> flat;
    for (const glm::dvec2& pixel : with_short_sides(cutout.polygon_px)) {
        const auto place = upright(pixel);
        if (!place) return std::unexpected(place.error());
        corners.push_back(*place);
        flat.emplace_back(glm::dot(glm::dvec2(corners.back()), aside), corners.back().z);
    }
    const auto triangles = triangles_of(flat);
    if (!triangles) return at(".polygon_px", triangles.error());
    begin(glm::dvec3(-ahead, 0.0));
    for (const glm::dvec3& p : corners) corner(p);
    close(*triangles);
    return {};
}

Result<void> ProxyMaker::add(const DepthProxy& depth, std::span<const DepthPiece> pieces) {
    std::array<glm::dvec3, 4> corners;
    role_ = depth.role;
    bool is_seen = false;
    for (const DepthPiece& piece : pieces) {
        const auto [x0, y0, x1, y1] = piece.rect;
        std::size_t known = 0;
        for (const auto& [x, y] : {std::pair(x0, y0), {x1, y0}, {x1, y1}, {x0, y1}}) {
            const glm::dvec2 pixel = glm::dvec2(x, y) - 0.5;
            const auto d = direction(pixel);
            const double ahead = !d                                     ? 0.0
                                 : depth.measure == DepthMeasure::range ? 1.0
                                                                        : glm::dot(*d, world_from_optical_[2]);
            // The rim of a lens, and what lies beside its camera.
            if (!(ahead > 1e-3)) break;
            corners[known++] = *d * (depth.unit_m / (piece.inverse_at(pixel.x, pixel.y) * ahead));
        }
        if (known < corners.size()) continue;
        const glm::dvec3 normal = glm::cross(corners[3] - corners[0], corners[1] - corners[0]);
        begin(normal / std::max(glm::length(normal), 1e-300) * (glm::dot(normal, corners[0]) > 0.0 ? -1.0 : 1.0));
        for (const glm::dvec3& place : corners) corner(place);
        close(box_face_triangles);
        is_seen = true;
    }
    if (!is_seen) return std::unexpected(refused(".file: the lens sees nothing where it has depth"));
    return {};
}

ModelRef ProxyMaker::model_of(std::initializer_list<ProxyRole> roles) {
    auto model = std::make_shared<Model>();
    Mesh mesh{.name = "proxies", .primitives = {}, .weights = {}};
    for (const ProxyRole role : roles) {
        Primitive& made = primitives_[static_cast<std::size_t>(role)];
        if (made.indices.empty()) continue;
        made.material = static_cast<int>(model->materials.size());
        made.bounds = {made.positions.front(), made.positions.front()};
        for (const glm::vec3& p : made.positions) {
            made.bounds.min = glm::min(made.bounds.min, p);
            made.bounds.max = glm::max(made.bounds.max, p);
        }
        mesh.primitives.push_back(std::move(made));
        model->materials.push_back(material_of(role));
    }
    if (mesh.primitives.empty()) return nullptr;
    model->name = "proxies";
    model->nodes.push_back({.name = "proxies", .local = {}, .mesh = 0, .weights = {}, .keypoint = {}});
    model->order = {0};
    model->meshes.push_back(std::move(mesh));
    return model;
}

}  // namespace camrig::world

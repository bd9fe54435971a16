#include "core/world/backdrop/backdrop.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/base/portable_math.h"
#include "core/camera/camera_model.h"
#include "core/camera/lens_traits.h"
#include "core/world/backdrop/scale_picture.h"
#include "core/world/backdrop/triangulate.h"
#include "core/world/box_faces.h"
#include "core/world/world_fields.h"

namespace camrig::world {
namespace {

/// Ground farther away is as good as the horizon.
constexpr double max_ground_m = 1e5;
/// Sides of what was outlined in a picture through a lens are bent: they are cut so short, or into so many pieces.
constexpr double piece_px = 16.0, max_pieces = 500.0;

Error refused(std::string message) {
    return {ErrorKind::invalid_argument, std::move(message)};
}

/// The error of a part, whose message goes on where the path of the whole ends: ".z: ..." or ": ...".
std::unexpected<Error> under(std::string_view place, Error inner) {
    inner.message.insert(0, place);
    return std::unexpected(std::move(inner));
}

/// World axes (z up) to those of glTF, in which models are.
glm::vec3 gltf_axes(const glm::dvec3& p) {
    return glm::vec3(glm::dvec3(p.x, p.z, -p.y));
}

/// Proxies are seen by what they hide and what falls on them, never by their colour.
Material material_of_proxies() {
    Material material;
    material.name = "proxy";
    material.base_color = {0.5f, 0.5f, 0.5f, 1.0f};
    material.metallic = 0.0f;
    material.double_sided = true;
    return material;
}

/// Shapes about the eye, in the world's axes.
class ProxyMaker {
public:
    ProxyMaker(const CameraSpec& spec, const camera::CameraModel& camera)
        : spec_(spec), camera_(camera), world_from_optical_(world_from_optical_rotation(spec.pose)) {}

    /// From the eye.
    Result<std::vector<glm::dvec3>> corners_of(const GroundProxy& ground) const;
    Result<void> add(const GroundProxy& ground);
    Result<void> add(const BoxProxy& box);
    Result<void> add(const CutoutProxy& cutout, std::span<const PixelRect> mask);
    /// All of them; null: none.
    ModelRef model();
    std::vector<glm::dvec2> in_camera(std::vector<glm::dvec2> pixels) const {
        for (glm::dvec2& pixel : pixels) pixel = in_camera(pixel);
        return pixels;
    }

private:
    const glm::dvec3& eye() const { return spec_.pose.position; }
    glm::dvec2 in_camera(const glm::dvec2& pixel) const {
        const ImageSize from = spec_.backdrop->files->size(), to = spec_.size;
        return (pixel + 0.5) * glm::dvec2(to.width, to.height) / glm::dvec2(from.width, from.height) - 0.5;
    }
    /// From the eye, of a pixel of the picture.
    std::optional<glm::dvec3> direction(const glm::dvec2& pixel) const {
        const auto ray = camera_.ray(in_camera(pixel));
        return ray ? std::optional(world_from_optical_ * *ray) : std::nullopt;
    }
    /// Where the ground of that height shows in a pixel, from the eye.
    Result<glm::dvec3> on_ground(const glm::dvec2& pixel, double z) const {
        const auto d = direction(pixel);
        if (!d) return std::unexpected(refused(": the lens sees nothing at this pixel"));
        const double times = (z - eye().z) / d->z;
        if (!(times > 0.0) || !(times <= max_ground_m))
            return std::unexpected(
                refused(": is over the horizon of the ground: nothing of it shows at this pixel, or only farther than "
                        "100 km away; give a pixel below"));
        return *d * times;
    }
    std::vector<glm::dvec2> with_short_sides(const std::vector<glm::dvec2>& polygon) const;
    bool is_ahead(const std::vector<glm::dvec3>& corners) const {
        return spec_.backdrop->is_panorama() || sees_behind(spec_.lens.model) ||
               std::ranges::any_of(
                   corners, [&](const glm::dvec3& p) { return glm::dot(world_from_optical_[2], p) > spec_.near_m; });
    }
    void begin(const glm::dvec3& normal) {
        normal_ = gltf_axes(normal);
        first_ = static_cast<std::uint32_t>(primitive_.positions.size());
    }
    void corner(const glm::dvec3& place) {
        primitive_.positions.push_back(gltf_axes(place));
        primitive_.normals.push_back(normal_);
    }
    template <typename Triangles>
    void close(const Triangles& triangles) {
        for (const auto& triangle : triangles)
            for (const std::uint32_t index : triangle) primitive_.indices.push_back(first_ + index);
    }

    const CameraSpec& spec_;
    const camera::CameraModel& camera_;
    glm::dmat3 world_from_optical_;
    Primitive primitive_;
    glm::vec3 normal_{0.0f};
    std::uint32_t first_ = 0;
};

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

Result<std::vector<glm::dvec3>> ProxyMaker::corners_of(const GroundProxy& ground) const {
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
    const auto found = corners_of(ground);
    if (!found) return std::unexpected(found.error());
    const std::vector<glm::dvec3>& corners = *found;
    const char* const given = ground.polygon_px.empty() ? ".polygon_m" : ".polygon_px";
    if (!is_ahead(corners)) return std::unexpected(refused(std::string(given) + ": is behind the camera"));
    std::vector<glm::dvec2> flat;
    for (const glm::dvec3& p : corners) flat.emplace_back(p);
    const auto triangles = triangles_of(flat);
    if (!triangles) return at(given, triangles.error());
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

ModelRef ProxyMaker::model() {
    if (primitive_.indices.empty()) return nullptr;
    primitive_.material = 0;
    primitive_.bounds = {primitive_.positions.front(), primitive_.positions.front()};
    for (const glm::vec3& p : primitive_.positions) {
        primitive_.bounds.min = glm::min(primitive_.bounds.min, p);
        primitive_.bounds.max = glm::max(primitive_.bounds.max, p);
    }
    auto model = std::make_shared<Model>();
    model->name = "proxies";
    model->nodes.push_back({.name = "proxies", .local = {}, .mesh = 0, .weights = {}, .keypoint = {}});
    model->order = {0};
    model->meshes.push_back({.name = "proxies", .primitives = {std::move(primitive_)}, .weights = {}});
    model->materials.push_back(material_of_proxies());
    return model;
}

Result<void> check_shape(ImageSize picture, ImageSize size) {
    if (has_sides_of(picture, size)) return {};
    return std::unexpected(refused("backdrop.file: a picture of " + picture.to_string() + " for a camera of " +
                                   size.to_string() + "; give the camera the size " + picture.to_string() +
                                   ", or another one with the same ratio of its sides"));
}

/// What is said in pixels of a picture is nowhere in one that turns.
Result<void> check_panorama(const BackdropSpec& given) {
    if (given.files->panorama == nullptr) return std::unexpected(refused("backdrop.file: its picture was not read"));
    if (given.intrinsics)
        return std::unexpected(refused("backdrop.intrinsics: a panorama has none; the camera's own count"));
    for (std::size_t i = 0; i < given.proxies.walkable.size(); ++i)
        if (!given.proxies.walkable[i].polygon_px.empty())
            return std::unexpected(refused(item_path("backdrop.proxies.walkable", i) +
                                           ".polygon_px: a panorama has no such pixels; give polygon_m"));
    if (given.proxies.ground && !given.proxies.ground->polygon_px.empty())
        return std::unexpected(
            refused("backdrop.proxies.ground.polygon_px: a panorama has no such pixels; give polygon_m"));
    if (!given.proxies.cutouts.empty())
        return std::unexpected(
            refused("backdrop.proxies.cutouts[0]: a panorama has no such pixels; give boxes or a file"));
    if (!given.ignore.empty())
        return std::unexpected(refused("backdrop.ignore[0].polygon_px: a panorama has no such pixels"));
    return {};
}

Instance proxy_at(const ModelRef& model, const glm::dvec3& position) {
    auto info = std::make_shared<ObjectInfo>();
    info->name = "backdrop";
    info->model = model;
    Instance instance;
    instance.info = std::move(info);
    instance.position = position;
    return instance;
}

}  // namespace

bool has_sides_of(ImageSize picture, ImageSize size) {
    const double wanted = static_cast<double>(picture.height) * size.width / picture.width;
    return std::abs(wanted - size.height) <= 0.5;
}

camera::Intrinsics scaled(const camera::Intrinsics& k, ImageSize from, ImageSize to) {
    const double x = static_cast<double>(to.width) / from.width, y = static_cast<double>(to.height) / from.height;
    return {k.fx * x, k.fy * y, (k.cx + 0.5) * x - 0.5, (k.cy + 0.5) * y - 0.5};
}

Result<std::shared_ptr<const Backdrop>> make_backdrop(const CameraSpec& spec) {
    const BackdropSpec& given = *spec.backdrop;
    if (given.files == nullptr) return std::unexpected(refused("backdrop.file: its picture was not read"));
    if (given.is_panorama()) {
        if (auto good = check_panorama(given); !good) return std::unexpected(good.error());
    } else if (auto good = check_shape(given.files->size(), spec.size); !good) {
        return std::unexpected(good.error());
    }
    if (given.proxies.is_empty() && !given.is_panorama())
        return std::unexpected(
            refused("backdrop.proxies: there are none, so that people would stand before everything; give ground, "
                    "boxes, cutouts or a file, or, where the scene's objects are what the picture shows, scene: "
                    "\"proxies\""));
    const auto camera = camera::CameraModel::create(spec.size, spec.intrinsics, spec.lens);
    if (!camera) return std::unexpected(camera.error());
    ProxyMaker maker(spec, *camera);
    const std::string proxies = "backdrop.proxies.";
    if (given.proxies.ground)
        if (auto added = maker.add(*given.proxies.ground); !added) return under(proxies + "ground", added.error());
    for (std::size_t i = 0; i < given.proxies.boxes.size(); ++i)
        if (auto added = maker.add(given.proxies.boxes[i]); !added)
            return under(item_path(proxies + "boxes", i), added.error());
    for (std::size_t i = 0; i < given.proxies.cutouts.size(); ++i) {
        const auto& masks = given.files->masks;
        const auto mask = i < masks.size() ? std::span(masks[i]) : std::span<const PixelRect>();
        if (auto added = maker.add(given.proxies.cutouts[i], mask); !added)
            return under(item_path(proxies + "cutouts", i), added.error());
    }

    auto made = std::make_shared<Backdrop>();
    made->size = spec.size;
    if (given.is_panorama()) {
        made->panorama = given.files->panorama;
        made->yaw_rad = glm::radians(given.yaw_deg);
    } else if (given.files->film != nullptr) {
        made->film = std::make_shared<FilmPlayer>(given.files->film, given.fps.value_or(given.files->film->index.rate),
                                                  spec.size);
    } else {
        made->files = given.files;
    }
    for (std::size_t i = 0; i < given.proxies.walkable.size(); ++i) {
        const GroundProxy& ground = given.proxies.walkable[i];
        const std::string place = item_path(proxies + "walkable", i);
        const auto corners = maker.corners_of(ground);
        if (!corners) return under(place, corners.error());
        if (corners->size() < 3) return std::unexpected(refused(place + ": a polygon has at least 3 corners"));
        made->walkable.emplace_back();
        for (const glm::dvec3& corner : *corners) made->walkable.back().emplace_back(corner + spec.pose.position);
    }
    if (const ModelRef own = maker.model()) made->proxies.push_back(proxy_at(own, spec.pose.position));
    if (given.files->proxies != nullptr) made->proxies.push_back(proxy_at(given.files->proxies, glm::dvec3(0.0)));
    for (std::size_t i = 0; i < given.ignore.size(); ++i) {
        if (given.ignore[i].polygon_px.size() < 3)
            return std::unexpected(
                refused(item_path("backdrop.ignore", i) + ".polygon_px: a polygon has at least 3 corners"));
        made->ignore.push_back(given.ignore[i]);
        made->ignore.back().polygon_px = maker.in_camera(given.ignore[i].polygon_px);
    }
    return made;
}

std::shared_ptr<const Image> Backdrop::picture(const FilmShot& shot) const {
    if (film != nullptr) return film->picture_of(shot);
    std::call_once(once_, [&] {
        picture_ = files->scaled != nullptr && files->scaled->size == size
                       ? files->scaled
                       : std::make_shared<const Image>(scaled_picture(files->picture, size));
    });
    return picture_;
}

}  // namespace camrig::world

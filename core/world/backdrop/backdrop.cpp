#include "core/world/backdrop/backdrop.h"

#include <algorithm>
#include <cmath>

#include "core/world/backdrop/proxy_maker.h"
#include "core/world/backdrop/scale_picture.h"
#include "core/world/world_fields.h"

namespace camrig::world {
namespace {

Result<void> check_shape(ImageSize picture, ImageSize size) {
    if (has_sides_of(picture, size)) return {};
    return std::unexpected(refused("backdrop.file: a picture of " + picture.to_string() + " for a camera of " +
                                   size.to_string() + "; give the camera the size " + picture.to_string() +
                                   ", or another one with the same ratio of its sides"));
}

/// What a projected picture needs to be laid on its proxies.
Result<void> check_projected(const BackdropSpec& given) {
    if (given.files->projected == nullptr) return std::unexpected(refused("backdrop.file: its picture was not read"));
    const ImageSize size = given.files->size();
    if (std::max(size.width, size.height) > max_image_size.width)
        return std::unexpected(refused("backdrop.file: a projected picture of " + size.to_string() + "; it has " +
                                       max_image_size.to_string() + " pixels at most"));
    if (!given.taken_from)
        return std::unexpected(
            refused("backdrop.taken_from: is missing; a projected picture needs the pose of the camera that took it"));
    if (!given.intrinsics)
        return std::unexpected(
            refused("backdrop.intrinsics: is missing; a projected picture needs those of its own pixels, as camrig "
                    "plate calibrate finds them"));
    if (auto good = check_intrinsics(size, *given.intrinsics); !good) return at("backdrop", good.error());
    if (!given.ignore.empty())
        return std::unexpected(refused(
            "backdrop.ignore[0]: where it shows changes with the camera's pose; a projected picture takes none"));
    return {};
}

/// The camera that took the picture: the view itself but of one that is projected.
CameraSpec taker_of(const CameraSpec& spec) {
    if (!spec.backdrop->is_projected()) return spec;
    CameraSpec taker = spec;
    taker.size = spec.backdrop->files->size();
    taker.intrinsics = *spec.backdrop->intrinsics;
    taker.pose = *spec.backdrop->taken_from;
    taker.lens = spec.backdrop->lens.value_or(spec.lens);
    return taker;
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
    if (given.proxies.depth)
        return std::unexpected(refused("backdrop.proxies.depth: a panorama has no such pixels; give boxes or a file"));
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
    } else if (given.is_projected()) {
        if (auto good = check_projected(given); !good) return std::unexpected(good.error());
    } else if (auto good = check_shape(given.files->size(), spec.size); !good) {
        return std::unexpected(good.error());
    }
    if (given.proxies.is_empty() && !given.is_panorama())
        return std::unexpected(
            refused("backdrop.proxies: there are none, so that people would stand before everything; give ground, "
                    "boxes, cutouts or a file, or, where the scene's objects are what the picture shows, scene: "
                    "\"proxies\""));
    const CameraSpec taker = taker_of(spec);
    const auto camera = camera::CameraModel::create(taker.size, taker.intrinsics, taker.lens);
    if (!camera) return given.is_projected() ? at("backdrop", camera.error()) : std::unexpected(camera.error());
    ProxyMaker maker(taker, *camera);
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
    if (given.proxies.depth)
        if (auto added = maker.add(*given.proxies.depth, given.files->depth); !added)
            return under(proxies + "depth", added.error());

    auto made = std::make_shared<Backdrop>();
    made->size = spec.size;
    if (given.is_panorama()) {
        made->panorama = given.files->panorama;
        made->yaw_rad = glm::radians(given.yaw_deg);
    } else if (given.is_projected()) {
        made->projected = ProjectedPicture{given.files->projected, *camera, taker.pose};
    } else if (given.files->film != nullptr) {
        made->film = std::make_shared<FilmPlayer>(given.files->film, given.fps.value_or(given.files->film->index.rate),
                                                  spec.size);
    } else {
        made->files = given.files;
    }
    for (std::size_t i = 0; i < given.proxies.walkable.size(); ++i) {
        const LevelGround& ground = given.proxies.walkable[i];
        const std::string place = item_path(proxies + "walkable", i);
        const auto corners = maker.corners_of(ground);
        if (!corners) return under(place, corners.error());
        if (corners->size() < 3) return std::unexpected(refused(place + ": a polygon has at least 3 corners"));
        made->walkable.emplace_back();
        for (const glm::dvec3& corner : *corners) made->walkable.back().emplace_back(corner + taker.pose.position);
    }
    made->walkable.insert(made->walkable.end(), given.files->walkable.begin(), given.files->walkable.end());
    const auto put = [&](std::vector<Instance>& to, const ModelRef& own, const ModelRef& of_file) {
        if (own != nullptr) to.push_back(proxy_at(own, taker.pose.position));
        if (of_file != nullptr) to.push_back(proxy_at(of_file, glm::dvec3(0.0)));
    };
    put(made->proxies, maker.hiding(), given.files->proxies);
    put(made->catchers, maker.catching(), given.files->catchers);
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

#pragma once

#include <algorithm>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/render/software/software_drawer.h"
#include "core/world/backdrop/backdrop.h"
#include "core/world/backdrop/panorama.h"
#include "tests/render/support/test_rig.h"

/// Pictures that people walk in, and a yard for them to walk in.
namespace camrig::render {

using world::SceneInBackdrop;

inline constexpr std::uint32_t person_id = 90;

inline std::unique_ptr<software::SoftwareDrawer> drawer(int threads = 1,
                                                        std::int64_t layer_bytes = std::int64_t{64} << 20) {
    return std::make_unique<software::SoftwareDrawer>(software::SoftwareDrawer::Options{
        .pool = std::make_shared<frame::FramePool>(), .static_layer_bytes = layer_bytes, .threads = threads});
}

inline std::vector<frame::FrameRef> drawn(software::SoftwareDrawer& by, const world::SnapshotRef& snapshot,
                                          const View& view) {
    by.begin_instant(snapshot);
    const View* const asked = &view;
    std::vector<frame::FrameRef> frames;
    by.draw({&asked, 1}, 0, frames);
    return frames;
}

inline View all_kinds(View view) {
    for (const frame::FrameKind kind :
         {frame::FrameKind::depth, frame::FrameKind::instance, frame::FrameKind::semantic, frame::FrameKind::normal})
        view.kinds[static_cast<int>(kind)] = true;
    return view;
}

/// The view with this picture behind what moves.
inline View with_plate(View view, world::Image picture, const world::ProxiesSpec& proxies,
                       const std::function<void(world::BackdropSpec&)>& change = {}) {
    auto spec = std::make_shared<world::CameraSpec>(*view.spec);
    spec->pose = view.pose;
    auto files = std::make_shared<world::BackdropFiles>();
    files->picture = std::move(picture);
    spec->backdrop.emplace().proxies = proxies;
    spec->backdrop->files = files;
    if (change) change(*spec->backdrop);
    auto made = make_backdrop(*spec);
    if (!made) throw std::runtime_error(made.error().message);
    spec->backdrop_here = *made;
    view.spec = spec;
    view.spec_revision += 1'000'000;
    return view;
}

/// The view before this panorama, with the ground of its yard.
inline View with_panorama(View view, std::shared_ptr<const world::Panorama> panorama, double yaw_deg) {
    auto spec = std::make_shared<world::CameraSpec>(*view.spec);
    spec->pose = view.pose;
    auto files = std::make_shared<world::BackdropFiles>();
    files->panorama = std::move(panorama);
    world::BackdropSpec& backdrop = spec->backdrop.emplace();
    backdrop.kind = world::BackdropKind::panorama;
    backdrop.yaw_deg = yaw_deg;
    backdrop.proxies.scene = SceneInBackdrop::hidden;
    backdrop.proxies.ground.emplace().polygon_m = {{-30, -30}, {30, -30}, {30, 30}, {-30, 30}};
    backdrop.files = files;
    auto made = make_backdrop(*spec);
    if (!made) throw std::runtime_error(made.error().message);
    spec->backdrop_here = *made;
    view.spec = spec;
    view.spec_revision += 1'000'000;
    return view;
}

inline View with_panorama(View view, world::Image picture, double yaw_deg) {
    return with_panorama(std::move(view), world::PanoramaMaker::create(std::move(picture), 1).value().finish(),
                         yaw_deg);
}

inline world::Image picture_of(const frame::Frame& frame) {
    world::Image image{.size = frame.info().size, .rgba = {}};
    const auto* const bytes = reinterpret_cast<const std::uint8_t*>(frame.bytes().data());
    image.rgba.assign(bytes, bytes + frame.bytes().size());
    return image;
}

inline world::Image noise(ImageSize size) {
    world::Image image{.size = size, .rgba = {}};
    for (std::int64_t i = 0; i < size.pixels(); ++i) {
        for (std::uint64_t c = 0; c < 3; ++c)
            image.rgba.push_back(static_cast<std::uint8_t>(256.0 * random_unit(7, c, static_cast<std::uint64_t>(i))));
        image.rgba.push_back(255);
    }
    return image;
}

inline bool has_bytes_of(const frame::Frame& frame, const world::Image& image) {
    return std::ranges::equal(frame.bytes(), std::as_bytes(std::span(image.rgba)));
}

/// A yard: ground, a wall and pillars, under the sun and a lamp; nothing of it is as bright as white.
inline TestWorld yard() {
    TestWorld world;
    world.environment = {.background = {0.3f, 0.4f, 0.5f},
                         .ambient_sky = glm::vec3(0.25f, 0.28f, 0.32f),
                         .ambient_ground = glm::vec3(0.15f)};
    world.lights = {
        light_of(world::LightType::directional, 0.6f, {}, glm::normalize(glm::dvec3(0.6, 0.5, -0.7))),
        light_of(world::LightType::spot, 5.0f, {4.0, -2.0, 3.0}, glm::normalize(glm::dvec3(0.3, 0.4, -0.8)))};
    std::uint32_t id = 1;
    const auto put = [&](world::Primitive primitive, glm::vec3 color, glm::dvec3 position) {
        world::Material paint = colored(color);
        paint.roughness = 1.0f;
        world.objects.push_back(instance_of(model_of(std::move(primitive), paint), position, id++));
    };
    put(rectangle({10, 0, 0}, {10, 0, 0}, {0, 10, 0}), {0.45f, 0.42f, 0.4f}, {});
    put(box({0.2f, 3.0f, 1.0f}), {0.5f, 0.3f, 0.25f}, {9.0, 1.0, 1.0});
    put(box({0.15f, 0.15f, 1.2f}), {0.3f, 0.4f, 0.3f}, {4.0, 0.9, 1.2});
    put(box({0.15f, 0.15f, 1.2f}), {0.3f, 0.3f, 0.5f}, {6.0, -1.3, 1.2});
    return world;
}

/// Somebody as a box of this height, and a pane of glass, on their way.
inline TestWorld walked(TestWorld world, double where) {
    world::Material glass = colored({0.3f, 0.5f, 0.9f});
    glass.alpha_mode = world::AlphaMode::blend;
    glass.base_color.a = 0.4f;
    world.movers = {
        instance_of(model_of(box({0.2f, 0.25f, 0.875f}), colored({0.6f, 0.2f, 0.1f})), {5.0, where, 0.875}, person_id),
        instance_of(model_of(box({0.1f, 0.3f, 0.5f}), glass), {3.2, -where, 0.5}, person_id + 1)};
    return world;
}

struct Looking {
    const char* name;
    camera::Lens lens;
    double focal_px;
};
inline std::vector<Looking> lenses() {
    const auto lens = [](camera::LensModel model, std::vector<double> k) {
        return camera::make_lens(model, k).value();
    };
    return {{"pinhole", {}, 110.0},
            {"plumb_bob", lens(camera::LensModel::plumb_bob, {-0.25, 0.05, 0.001, -0.001, 0.0}), 110.0},
            {"rational",
             lens(camera::LensModel::rational_polynomial, {0.3, 0.02, 0.0005, -0.0004, 0.001, 0.6, 0.1, 0.01}), 110.0},
            // Its corners see nothing.
            {"equidistant", lens(camera::LensModel::equidistant, {0.02, -0.01, 0.0, 0.0}), 45.0}};
}
inline TestCamera camera_through(const Looking& looking, world::Quality quality) {
    return {.eye = {0.0, 0.3, 1.6},
            .size = {163, 121},
            .focal_px = looking.focal_px,
            .lens = looking.lens,
            .quality = quality};
}
inline constexpr world::Quality qualities[] = {world::Quality::fast, world::Quality::simple, world::Quality::beautiful};

inline world::ProxiesSpec scene_is(SceneInBackdrop role) {
    world::ProxiesSpec proxies;
    proxies.scene = role;
    return proxies;
}

inline int largest_difference(const frame::Frame& a, const frame::Frame& b) {
    int most = 0;
    for (std::size_t i = 0; i < a.bytes().size(); ++i)
        most = std::max(most, std::abs(std::to_integer<int>(a.bytes()[i]) - std::to_integer<int>(b.bytes()[i])));
    return most;
}

/// Linear light of the three channels of a pixel.
inline glm::dvec3 light_at(const world::Image& image, int x, int y) {
    const std::size_t at =
        4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.size.width) + static_cast<std::size_t>(x));
    return {linear_of(image.rgba[at]), linear_of(image.rgba[at + 1]), linear_of(image.rgba[at + 2])};
}

}  // namespace camrig::render

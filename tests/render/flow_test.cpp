#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include <gtest/gtest.h>

#include "core/render/software/software_drawer.h"
#include "core/world/scene.h"
#include "tests/render/support/gallery.h"

// Optical flow against points of surfaces that are followed in double precision: each sampled pixel's ray is met with
// every triangle, and where that point of the triangle is a frame later goes through the exact model of the camera of
// then.
namespace camrig::render::flow_test {
namespace {

constexpr TimeNs now_ns = ns_per_s, frame_ns = 40 * ns_per_ms;
constexpr double tolerance_px = 0.01;
/// What is further away from a point in a fiftieth of a pixel beside it is another part, of a person for instance.
constexpr double beside_m = 0.02;

struct Triangle {
    ObjectId object{};
    std::array<glm::dvec3, 3> now{}, then{};
};

std::vector<glm::dvec3> placed(const world::Instance& instance, int node, const world::Primitive& primitive) {
    world::PosedModel pose;
    const world::Model& model = *instance.info->model;
    world::pose_model(model, instance.clips, pose);
    std::vector<glm::vec3> local = primitive.positions;
    std::vector<glm::vec3> normals(primitive.normals.size());
    const bool is_deformed = world::is_deformed(model, node);
    if (is_deformed) world::deform_vertices(model, pose, node, primitive, local, normals);
    std::vector<glm::dvec3> points;
    for (const glm::vec3& p : local) {
        const glm::dvec3 at =
            is_deformed ? glm::dvec3(p)
                        : glm::dvec3(pose.model_from_node[static_cast<std::size_t>(node)] * glm::dvec4(p, 1.0));
        points.push_back(instance.position + instance.orientation * (instance.scale * at));
    }
    return points;
}

/// What is so is in no picture but colour.
bool is_blended(const world::Model& model, const world::Primitive& primitive) {
    return model.materials[static_cast<std::size_t>(primitive.material)].alpha_mode == world::AlphaMode::blend;
}

/// Of what is there at both times.
std::vector<Triangle> triangles_of(const world::Snapshot& now, const world::Snapshot& then) {
    std::vector<Triangle> all;
    const auto add = [&](const std::vector<world::Instance>& first, const std::vector<world::Instance>& second) {
        for (const world::Instance& a : first) {
            const auto b = std::ranges::find(second, a.info, &world::Instance::info);
            if (b == second.end()) continue;
            const world::Model& model = *a.info->model;
            const world::Look look = world::look_of(model, {});
            for (const int node : model.order) {
                if (model.nodes[static_cast<std::size_t>(node)].mesh < 0) continue;
                const auto mesh = static_cast<std::size_t>(model.nodes[static_cast<std::size_t>(node)].mesh);
                for (const world::Primitive& primitive : model.meshes[mesh].primitives) {
                    if (is_blended(model, primitive)) continue;
                    // What people of this look do not wear.
                    if (!look.empty() && primitive.material >= 0 &&
                        look[static_cast<std::size_t>(primitive.material)].is_hidden)
                        continue;
                    const auto from = placed(a, node, primitive), to = placed(*b, node, primitive);
                    for (std::size_t i = 0; i + 2 < primitive.indices.size(); i += 3) {
                        Triangle& one = all.emplace_back(Triangle{.object = a.info->id});
                        for (std::size_t k = 0; k < 3; ++k) {
                            one.now[k] = from[primitive.indices[i + k]];
                            one.then[k] = to[primitive.indices[i + k]];
                        }
                    }
                }
            }
        }
    };
    add(now.statics->objects, then.statics->objects);
    add(now.movers, then.movers);
    return all;
}

struct Hit {
    ObjectId object{};
    glm::dvec3 then{0.0};
};

/// The front that a ray meets first beyond so many lengths of it (Moeller and Trumbore, 1997).
std::optional<Hit> meet(const std::vector<Triangle>& triangles, const glm::dvec3& eye, const glm::dvec3& ray,
                        double near) {
    double nearest = std::numeric_limits<double>::infinity();
    std::optional<Hit> hit;
    for (const Triangle& one : triangles) {
        const glm::dvec3 a = one.now[1] - one.now[0], b = one.now[2] - one.now[0], p = glm::cross(ray, b);
        const double scale = glm::dot(a, p);
        if (scale <= 0.0) continue;
        const glm::dvec3 from = eye - one.now[0], q = glm::cross(from, a);
        const double u = glm::dot(from, p) / scale, v = glm::dot(ray, q) / scale, t = glm::dot(b, q) / scale;
        if (u < 0.0 || v < 0.0 || u + v > 1.0 || t < near || t >= nearest) continue;
        nearest = t;
        hit = {one.object, one.then[0] + u * (one.then[1] - one.then[0]) + v * (one.then[2] - one.then[0])};
    }
    return hit;
}

struct Shot {
    world::SnapshotRef now, then;
    View view;
    camera::CameraState state_then;
    std::shared_ptr<const world::WorldPast> past;
    std::vector<frame::FrameRef> frames;

    glm::dvec2 at(int x, int y) const {
        const auto* const pixels = reinterpret_cast<const float*>(frames.back()->bytes().data());
        const float* const flow = pixels + 2 * (y * view.spec->size.width + x);
        return {flow[0], flow[1]};
    }
};

struct Motion {
    world::CameraPatch patch{};
    TimeNs begin_ns = 0, duration_ns = 0;
};

/// What is wanted beside flow, by number.
using Kinds = std::vector<frame::FrameKind>;

Shot shoot(const world::SceneRef& scene, const TestCamera& test, const Motion& motion = {}, const Kinds& beside = {},
           int threads = 2, bool wide_lanes = software::has_wide_lanes()) {
    const auto world = world::World::create(scene, 1).value();
    world->advance_to(now_ns);
    Shot shot{.now = world->snapshot(now_ns),
              .then = {},
              .view = test.view(),
              .state_then = {},
              .past = world->past(0),
              .frames = {}};
    auto spec = std::make_shared<world::CameraSpec>(*shot.view.spec);
    spec->pose = shot.view.pose;
    const world::Camera camera =
        world::Camera(*spec).changed(motion.patch, motion.begin_ns, motion.duration_ns).value();
    const camera::CameraState state = camera.at(*shot.now);
    spec->intrinsics = state.intrinsics;
    shot.view.spec = spec;
    shot.view.pose = state.pose;
    shot.view.future =
        std::make_shared<world::CameraFuture>(world->copy(), "c", camera, std::vector<world::CameraMove>{});
    shot.view.frame_ns = frame_ns;
    std::ranges::fill(shot.view.kinds, false);
    shot.view.kinds[index_of(frame::FrameKind::flow)] = true;
    for (const frame::FrameKind kind : beside) shot.view.kinds[index_of(kind)] = true;
    software::SoftwareDrawer drawer({.pool = std::make_shared<frame::FramePool>(),
                                     .static_layer_bytes = std::int64_t{64} << 20,
                                     .threads = threads,
                                     .wide_lanes = wide_lanes});
    drawer.begin_instant(shot.now);
    drawer.draw(std::vector<const View*>{&shot.view}, 0, shot.frames);
    EXPECT_EQ(shot.frames.size(), 1 + beside.size());
    world->advance_to(now_ns + frame_ns);
    shot.then = world->snapshot(now_ns + frame_ns);
    shot.state_then = camera.at(*shot.then);
    return shot;
}

struct Compared {
    int pixels = 0, gone = 0;
    double worst_px = 0.0, longest_px = 0.0;
};

Compared compare(const Shot& shot, std::optional<std::uint32_t> only = {}) {
    const world::CameraSpec& spec = *shot.view.spec;
    const auto now = camera::CameraModel::create(spec.size, spec.intrinsics, spec.lens).value();
    const auto then = camera::CameraModel::create(spec.size, shot.state_then.intrinsics, spec.lens).value();
    const glm::dmat3 world_from_now = camera::world_from_optical_rotation(shot.view.pose);
    const glm::dmat3 then_from_world = glm::transpose(camera::world_from_optical_rotation(shot.state_then.pose));
    const std::vector<Triangle> triangles = triangles_of(*shot.now, *shot.then);
    const auto look = [&](const glm::dvec2& pixel) -> std::optional<Hit> {
        const auto ray = now.ray(pixel);
        if (!ray) return std::nullopt;
        const bool is_wide = spec.lens.model == camera::LensModel::equidistant;
        return meet(triangles, shot.view.pose.position, world_from_now * *ray, spec.near_m / (is_wide ? 1.0 : ray->z));
    };
    Compared result;
    for (int y = 3; y < spec.size.height; y += 9) {
        for (int x = 3; x < spec.size.width; x += 9) {
            const auto hit = look({x, y});
            // Vertices are rounded to 1/256 pixel: at an outline something else may be drawn.
            bool is_outline = false;
            for (const glm::dvec2& beside : {glm::dvec2(0.02, 0), {-0.02, 0}, {0, 0.02}, {0, -0.02}}) {
                const auto other = look(glm::dvec2(x, y) + beside);
                is_outline |=
                    other.has_value() != hit.has_value() ||
                    (hit && (other->object != hit->object || glm::distance(other->then, hit->then) > beside_m));
            }
            if (is_outline) continue;
            const glm::dvec2 flow = shot.at(x, y);
            if (!hit) {
                EXPECT_TRUE(std::isnan(flow.x) && std::isnan(flow.y)) << x << ' ' << y;
                continue;
            }
            if (only && static_cast<std::uint32_t>(hit->object) != *only) continue;
            const auto seen = then.project(then_from_world * (hit->then - shot.state_then.pose.position));
            EXPECT_EQ(seen.has_value(), !std::isnan(flow.x)) << x << ' ' << y;
            if (!seen) ++result.gone;
            if (!seen || std::isnan(flow.x)) continue;
            ++result.pixels;
            const glm::dvec2 expected = *seen - glm::dvec2(x, y);
            result.longest_px = std::max(result.longest_px, glm::length(expected));
            result.worst_px = std::max(result.worst_px, glm::length(flow - expected));
        }
    }
    std::printf("%d pixels, %d that go out of sight, moved by up to %.2f px: wrong by up to %.5f px\n", result.pixels,
                result.gone, result.longest_px, result.worst_px);
    EXPECT_LE(result.worst_px, tolerance_px);
    return result;
}

/// A floor, a wall 8 m ahead and a box before it; a cart that drives across, and a person who walks.
std::shared_ptr<world::Scene> scene_of(bool has_movers) {
    auto scene = std::make_shared<world::Scene>();
    scene->models["floor"].model = model_of(rectangle({0, 0, -1.5f}, {30, 0, 0}, {0, 30, 0}), colored(glm::vec3(0.5f)));
    scene->models["wall"].model =
        model_of(rectangle({8, 0, 0.5f}, {0, -3, 0.5f}, {0.5f, 0, 2}), colored(glm::vec3(0.5f)));
    scene->models["box"].model = model_of(box({0.4f, 0.5f, 0.6f}), colored(glm::vec3(0.5f)));
    const auto put = [&](const char* name, const char* model, glm::dvec3 at) {
        world::ObjectSpec object;
        object.name = name;
        object.model = model;
        object.position = at;
        scene->objects.push_back(object);
    };
    put("floor", "floor", {});
    put("wall", "wall", {});
    put("box", "box", {5, 1.2, -0.4});
    if (!has_movers) return scene;
    const auto hall = world::load_scene("scenes/hall.json").value();
    const auto person =
        std::ranges::find_if(hall->actors, [](const auto& actor) { return actor.object_class == "person"; });
    scene->models["person"] = hall->models.at(person->model);
    scene->routes["across"] = {.points = {{5.5, -4, -0.9}, {5, 4, -0.9}}};
    scene->routes["along"] = {.points = {{4.5, -0.2, -1.5}, {2, 0.4, -1.5}}};
    const auto route = [](const char* name, double speed_m_s, const char* clip) {
        world::RouteBehaviour walk;
        walk.route = name;
        walk.speed_m_s = speed_m_s;
        walk.clip = clip;
        return walk;
    };
    world::ActorSpec cart;
    cart.name = "cart";
    cart.model = "box";
    cart.behaviour = route("across", 3.0, "");
    scene->actors.push_back(cart);
    world::ActorSpec walker;
    walker.name = "walker";
    walker.object_class = "person";
    walker.model = "person";
    walker.behaviour = route("along", 1.2, "walk");
    scene->actors.push_back(walker);
    return scene;
}

constexpr ImageSize size{320, 240};
const TestCamera standing{.eye = {0, 0, 0.2}, .size = size, .focal_px = 260.0};

world::CameraPatch turned(double pan_rad) {
    world::CameraPatch patch;
    patch.pan_rad = pan_rad;
    return patch;
}

TEST(Flow, OfAStandingCameraIsNothingButThatOfWhatMoves) {
    const Shot still = shoot(scene_of(false), standing);
    int shown = 0;
    for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) {
            const glm::dvec2 flow = still.at(x, y);
            if (std::isnan(flow.x)) continue;
            EXPECT_EQ(flow, glm::dvec2(0.0));
            ++shown;
        }
    EXPECT_GT(shown, size.pixels() / 2);
    EXPECT_LT(shown, size.pixels());
    EXPECT_GT(compare(shoot(scene_of(true), standing), 4).longest_px, 4.0);
}

TEST(Flow, FollowsTheSkinOfAPersonWhoWalks) {
    const Compared walker = compare(shoot(scene_of(true), standing), 5);
    EXPECT_GT(walker.pixels, 20);
    EXPECT_GT(walker.longest_px, 1.0);
}

TEST(Flow, FollowsTheSkinOfAPersonWhoReachesBehindTheCamera) {
    // Cut at the near plane: what is between the corners is followed too.
    const TestCamera near{.eye = {3.1, 0.1, -0.75}, .size = size, .focal_px = 120.0, .near_m = 0.08};
    EXPECT_GT(compare(shoot(scene_of(true), near), 5).pixels, 100);
}

TEST(Flow, GoesThroughEveryLensOfACameraThatTurnsAndMoves) {
    const std::array<camera::Lens, 4> lenses{
        camera::Lens{}, camera::Lens{camera::LensModel::plumb_bob, {-0.32, 0.13, 0.001, -0.0007, -0.025}},
        camera::Lens{camera::LensModel::rational_polynomial, {0.3, -0.1, 0.0005, 0.0003, 0.01, 0.6, -0.05, 0.02}},
        camera::Lens{camera::LensModel::equidistant, {-0.01, 0.002, 0, 0}}};
    for (const camera::Lens& lens : lenses) {
        TestCamera camera = standing;
        camera.lens = lens;
        if (lens.model == camera::LensModel::equidistant) camera.focal_px = 90.0;
        Motion motion{.patch = turned(0.6), .begin_ns = 0, .duration_ns = 2 * ns_per_s};
        EXPECT_GT(compare(shoot(scene_of(true), camera, motion)).longest_px, 0.5);
        world::CameraPatch drive;
        drive.pose = camera::pose_from_angles({1.0, 0.5, 0.4}, {.pan = 0.2, .tilt = -0.1, .roll = 0.1}).value();
        EXPECT_GT(compare(shoot(scene_of(true), camera, {drive, 0, 2 * ns_per_s})).pixels, 200);
    }
}

TEST(Flow, GrowsWithAZoom) {
    for (const camera::Lens& lens :
         {camera::Lens{}, camera::Lens{camera::LensModel::plumb_bob, {-0.2, 0.03, 0, 0, 0}}}) {
        TestCamera camera = standing;
        camera.lens = lens;
        world::CameraPatch zoom;
        zoom.zoom = 3.0;
        EXPECT_GT(compare(shoot(scene_of(true), camera, {zoom, 0, 2 * ns_per_s})).longest_px, 2.0);
    }
}

TEST(Flow, IsNoNumberOfWhatGoesOutOfTheLensField) {
    const Shot shot = shoot(scene_of(true), standing, {turned(2.0), now_ns, frame_ns});
    const Compared compared = compare(shot);
    EXPECT_GT(compared.gone, 100);
}

TEST(Flow, IsNoNumberOfWhatIsGoneThen) {
    auto scene = scene_of(true);
    scene->events.push_back(
        {.name = "end", .when = world::AtTime{now_ns + frame_ns / 2}, .actions = {world::RemoveAction{"cart"}}});
    const Kinds beside{frame::FrameKind::instance};
    const Shot gone = shoot(scene, standing, {}, beside);
    const auto* const ids = reinterpret_cast<const std::uint32_t*>(gone.frames.front()->bytes().data());
    int of_cart = 0;
    for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) {
            const std::uint32_t id = ids[y * size.width + x];
            of_cart += id == 4;
            EXPECT_EQ(std::isnan(gone.at(x, y).x), id == 0 || id == 4);
        }
    EXPECT_GT(of_cart, 100);
}

TEST(Flow, IsTheSameBytesHoweverTheWorkIsDoneAndWhateverIsDrawnBesideIt) {
    const Motion motion{.patch = turned(0.4), .begin_ns = 0, .duration_ns = 2 * ns_per_s};
    const Kinds all{frame::FrameKind::color, frame::FrameKind::depth, frame::FrameKind::instance};
    const Shot alone = shoot(scene_of(true), standing, motion), beside = shoot(scene_of(true), standing, motion, all);
    const auto bytes = [](const Shot& shot) {
        const auto of = shot.frames.back()->bytes();
        return std::vector<std::byte>(of.begin(), of.end());
    };
    EXPECT_EQ(bytes(alone), bytes(beside));
    EXPECT_EQ(bytes(alone), bytes(shoot(scene_of(true), standing, motion, {}, 1, false)));
}

/// A camera with a sensor that turns.
View sensing(const Shot& shot) {
    View view = TestCamera{.size = {32, 24}, .focal_px = 26.0}.view(2);
    auto spec = std::make_shared<world::CameraSpec>(*view.spec);
    spec->sensor.emplace().exposure_s = 0.02;
    view.spec = spec;
    world::CameraPatch turn = turned(0.2);
    turn.optics = spec->intrinsics;
    const world::Camera camera = world::Camera(*spec).changed(turn, 0, now_ns).value();
    view.past = std::make_shared<const world::CameraPast>(shot.past, camera);
    view.pose = camera.at(*shot.now).pose;
    return view;
}

// Threads draw both in bands, by the same moment of the drawer.
TEST(Flow, AndPicturesOfASensorAreCountedAsOthersAre) {
    const Shot shot = shoot(scene_of(false), standing);
    const View next = sensing(shot);
    software::SoftwareDrawer drawer({.pool = std::make_shared<frame::FramePool>(), .threads = 2});
    drawer.begin_instant(shot.now);
    std::vector<frame::FrameRef> frames;
    drawer.draw(std::vector<const View*>{&shot.view}, 0, frames);
    EXPECT_EQ(drawer.counters().views, 1u);
    EXPECT_EQ(drawer.counters().draws, 3u) << "floor, wall and box";
    drawer.draw(std::vector<const View*>{&next}, 0, frames);
    EXPECT_EQ(drawer.counters().views, 2u);
    EXPECT_GT(drawer.counters().draws, 3u);
}

TEST(Flow, IsRefusedWithTheReasonByWhoDoesNotDrawIt) {
    const Shot shot = shoot(scene_of(false), standing);
    const auto renderer = create_renderer({.device = "null", .pool = std::make_shared<frame::FramePool>()}).value();
    const auto finished = renderer->draw(shot.now, 0, {&shot.view, 1}).value();
    EXPECT_TRUE(finished.set.frames.empty());
    ASSERT_EQ(finished.failures.size(), 1u);
    EXPECT_EQ(finished.failures[0].error.kind, ErrorKind::unsupported);
    EXPECT_NE(finished.failures[0].error.message.find("rasteriser"), std::string::npos);
}

TEST(Flow, BesideADevicesPicturesIsWhatItIsAlone) {
    const Shot shot = shoot(scene_of(false), standing);
    View view = shot.view;
    view.kinds[index_of(frame::FrameKind::color)] = true;
    const auto renderer = create_renderer({.device = "llvmpipe", .pool = std::make_shared<frame::FramePool>()}).value();
    const auto finished = renderer->draw(shot.now, 0, {&view, 1}).value();
    EXPECT_TRUE(finished.failures.empty());
    ASSERT_EQ(finished.set.frames.size(), 2u) << "each kind once, by one of both";
    EXPECT_EQ(finished.set.frames.front()->info().kind, frame::FrameKind::color);
    EXPECT_EQ(finished.set.frames.back()->info().kind, frame::FrameKind::flow);
    EXPECT_TRUE(std::ranges::equal(finished.set.frames.back()->bytes(), shot.frames.back()->bytes()));
}

}  // namespace
}  // namespace camrig::render::flow_test

// What happens before and around drawing: skinning, culling, and looking through lenses. Run from the repository.
#include <benchmark/benchmark.h>

#include "core/render/lens_plan.h"
#include "core/render/renderer_factory.h"
#include "core/render/view_transform.h"
#include "core/world/posed_model.h"
#include "core/world/world.h"

namespace camrig::bench {
namespace {

const world::SceneRef& hall() {
    static const world::SceneRef scene = [] {
        auto loaded = world::load_scene("scenes/hall.json");
        CHECK(loaded.has_value());
        return *loaded;
    }();
    return scene;
}

world::SnapshotRef people() {
    static const std::unique_ptr<world::World> world = [] {
        auto made = world::World::create(hall(), 1);
        CHECK(made.has_value());
        return std::move(*made);
    }();
    return world->snapshot(0);
}

camera::CameraModel camera_with(const camera::Lens& lens) {
    constexpr ImageSize size{640, 480};
    auto model = camera::CameraModel::create(size, *camera::intrinsics_from_vfov(size, 1.0), lens);
    CHECK(model.has_value());
    return std::move(*model);
}

void pose(benchmark::State& state) {
    const world::SnapshotRef snapshot = people();
    world::PosedModel posed;
    for ([[maybe_unused]] auto turn : state) {
        for (const world::Instance& mover : snapshot->movers) pose_model(*mover.info->model, mover.clips, posed);
        benchmark::DoNotOptimize(posed.model_from_node.data());
    }
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(snapshot->movers.size()));
}

/// Items are vertices.
void skin(benchmark::State& state) {
    const world::SnapshotRef snapshot = people();
    const world::Instance& person = snapshot->movers.front();
    const world::Model& model = *person.info->model;
    world::PosedModel posed;
    pose_model(model, person.clips, posed);
    std::vector<glm::vec3> positions, normals;
    std::int64_t vertices = 0;
    for ([[maybe_unused]] auto turn : state) {
        for (const int node : model.order) {
            const int mesh = model.nodes[static_cast<std::size_t>(node)].mesh;
            if (mesh < 0 || !is_deformed(model, node)) continue;
            for (const world::Primitive& primitive : model.meshes[static_cast<std::size_t>(mesh)].primitives) {
                positions.resize(primitive.positions.size());
                normals.resize(primitive.positions.size());
                deform_vertices(model, posed, node, primitive, positions, normals);
                vertices += static_cast<std::int64_t>(positions.size());
            }
        }
        benchmark::DoNotOptimize(positions.data());
    }
    state.SetItemsProcessed(vertices);
}

/// Items are boxes, half of them in view.
void cull(benchmark::State& state) {
    const render::ViewTransform view =
        render::make_view_transform({}, {640, 480}, *camera::intrinsics_from_vfov({640, 480}, 1.0), 0.05, 0.0);
    const render::Frustum frustum = make_frustum(view, 0.0);
    std::vector<glm::dmat4> places(1000, glm::dmat4(1.0));
    for (std::size_t i = 0; i < places.size(); ++i)
        places[i][3] = glm::dvec4(i % 2 == 0 ? 0.0 : 50.0, 0.0, 5.0 + 0.01 * static_cast<double>(i), 1.0);
    for ([[maybe_unused]] auto turn : state) {
        int visible = 0;
        for (const glm::dmat4& place : places)
            visible += may_be_visible(frustum, place, glm::vec3(-0.5f), glm::vec3(0.5f));
        benchmark::DoNotOptimize(visible);
    }
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(places.size()));
}

const camera::Lens barrel =
    make_lens(camera::LensModel::plumb_bob, std::vector{-0.28, 0.08, 8e-4, -5e-4, -0.005}).value();
const camera::Lens fisheye = make_lens(camera::LensModel::equidistant, std::vector{0.02, -0.01, 0.0, 0.0}).value();

/// The exact map of a lens, made when a camera is: items are pixels.
void lens_plan(benchmark::State& state, const camera::Lens& lens) {
    const camera::CameraModel camera = camera_with(lens);
    for ([[maybe_unused]] auto turn : state) benchmark::DoNotOptimize(render::make_lens_plan(camera, {}, {}));
    state.SetItemsProcessed(state.iterations() * 640 * 480);
}

/// Pictures of the hall's lobby on the CPU rasteriser, read into host memory. A moving camera turns before each, so
/// that nothing of the one before can be kept.
void draw_lobby(benchmark::State& state, world::CameraSpec spec, bool is_moving) {
    auto renderer = render::create_renderer({.device = "cpu", .pool = std::make_shared<frame::FramePool>()});
    CHECK(renderer.has_value());
    spec.name = "lobby";
    spec.size = {640, 480};
    spec.intrinsics = *camera::intrinsics_from_vfov(spec.size, 1.0);
    render::View view;
    view.name = std::make_shared<const std::string>(spec.name);
    view.quality = spec.quality.value_or(world::Quality::simple);
    view.spec = std::make_shared<const world::CameraSpec>(std::move(spec));
    view.pose = hall()->places.at("lobby").pose;
    const world::SnapshotRef snapshot = people();
    int turns = 0;
    const auto draw = [&] {
        if (is_moving) {
            const double angle = 1e-3 * (turns++ % 100 - 50);
            view.pose.orientation =
                hall()->places.at("lobby").pose.orientation * glm::dquat(glm::dvec3(0.0, 0.0, angle));
        }
        auto finished = (*renderer)->draw(snapshot, 0, {&view, 1});
        CHECK(finished.has_value());
        benchmark::DoNotOptimize(finished);
    };
    // The first makes shaders and textures, the second what is kept of the scene.
    for (int i = 0; i < 3; ++i) draw();
    for ([[maybe_unused]] auto turn : state) draw();
    state.SetItemsProcessed(state.iterations() * 640 * 480);
}

/// What looking through it costs beside no lens.
void draw_through(benchmark::State& state, const camera::Lens& lens) {
    world::CameraSpec spec;
    spec.lens = lens;
    draw_lobby(state, spec, false);
}

/// What an accurate picture costs beside one whose pixels show what lies at their middles.
void draw_areas(benchmark::State& state, world::Antialias antialias, world::Quality quality, bool is_moving) {
    world::CameraSpec spec;
    spec.quality = quality;
    spec.antialias = antialias;
    draw_lobby(state, spec, is_moving);
}

BENCHMARK(pose)->Unit(benchmark::kMicrosecond);
BENCHMARK(skin)->Unit(benchmark::kMicrosecond);
BENCHMARK(cull)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(lens_plan, plumb_bob, barrel)->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(lens_plan, equidistant, fisheye)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(draw_through, no_lens, camera::Lens{})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(draw_through, plumb_bob, barrel)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(draw_through, equidistant, fisheye)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();

#define CAMRIG_DRAW_AREAS(name, antialias, quality, is_moving)                                           \
    BENCHMARK_CAPTURE(draw_areas, name, world::Antialias::antialias, world::Quality::quality, is_moving) \
        ->Unit(benchmark::kMillisecond)                                                                  \
        ->UseRealTime()                                                                                  \
        ->MeasureProcessCPUTime()
CAMRIG_DRAW_AREAS(simple_none_standing, none, simple, false);
CAMRIG_DRAW_AREAS(simple_coverage_standing, coverage, simple, false);
CAMRIG_DRAW_AREAS(simple_none_moving, none, simple, true);
CAMRIG_DRAW_AREAS(simple_coverage_moving, coverage, simple, true);
CAMRIG_DRAW_AREAS(beautiful_none_moving, none, beautiful, true);
CAMRIG_DRAW_AREAS(beautiful_coverage_moving, coverage, beautiful, true);

}  // namespace
}  // namespace camrig::bench

// What happens before and around drawing: skinning, culling, and looking through lenses. Run from the repository.
#include <benchmark/benchmark.h>

#include "core/render/lens_plan.h"
#include "core/render/renderer_factory.h"
#include "core/render/view_transform.h"
#include "core/world/posed_model.h"
#include "core/world/world.h"

namespace camrig {
namespace {

const SceneRef& hall() {
    static const SceneRef scene = [] {
        auto loaded = load_scene("scenes/hall.json");
        CHECK(loaded.has_value());
        return *loaded;
    }();
    return scene;
}

SnapshotRef people() {
    static const std::unique_ptr<World> world = [] {
        auto made = World::create(hall(), 1);
        CHECK(made.has_value());
        return std::move(*made);
    }();
    return world->snapshot(0);
}

CameraModel camera_with(const Lens& lens) {
    constexpr ImageSize size{640, 480};
    auto model = CameraModel::create(size, *intrinsics_from_vfov(size, 1.0), lens);
    CHECK(model.has_value());
    return std::move(*model);
}

void pose(benchmark::State& state) {
    const SnapshotRef snapshot = people();
    PosedModel posed;
    for ([[maybe_unused]] auto turn : state) {
        for (const Instance& mover : snapshot->movers) pose_model(*mover.info->model, mover.clips, posed);
        benchmark::DoNotOptimize(posed.model_from_node.data());
    }
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(snapshot->movers.size()));
}

/// Items are vertices.
void skin(benchmark::State& state) {
    const SnapshotRef snapshot = people();
    const Instance& person = snapshot->movers.front();
    const Model& model = *person.info->model;
    PosedModel posed;
    pose_model(model, person.clips, posed);
    std::vector<glm::vec3> positions, normals;
    std::int64_t vertices = 0;
    for ([[maybe_unused]] auto turn : state) {
        for (const int node : model.order) {
            const int mesh = model.nodes[static_cast<std::size_t>(node)].mesh;
            if (mesh < 0 || !is_deformed(model, node)) continue;
            for (const Primitive& primitive : model.meshes[static_cast<std::size_t>(mesh)].primitives) {
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
    const ViewTransform view = make_view_transform({}, {640, 480}, *intrinsics_from_vfov({640, 480}, 1.0), 0.05, 0.0);
    const Frustum frustum = make_frustum(view, 0.0);
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

const Lens barrel = make_lens(LensModel::plumb_bob, std::vector{-0.28, 0.08, 8e-4, -5e-4, -0.005}).value();
const Lens fisheye = make_lens(LensModel::equidistant, std::vector{0.02, -0.01, 0.0, 0.0}).value();

/// The exact map of a lens, made when a camera is: items are pixels.
void lens_plan(benchmark::State& state, const Lens& lens) {
    const CameraModel camera = camera_with(lens);
    for ([[maybe_unused]] auto turn : state) benchmark::DoNotOptimize(make_lens_plan(camera, {}, {}));
    state.SetItemsProcessed(state.iterations() * 640 * 480);
}

/// A standing camera's picture on the CPU rasteriser, read into host memory: what the warp costs beside no lens.
void draw_through(benchmark::State& state, const Lens& lens) {
    auto renderer = create_renderer({.device = "cpu", .pool = std::make_shared<FramePool>()});
    CHECK(renderer.has_value());
    auto spec = std::make_shared<CameraSpec>();
    spec->name = "lobby";
    spec->size = {640, 480};
    spec->intrinsics = *intrinsics_from_vfov(spec->size, 1.0);
    spec->lens = lens;
    View view;
    view.name = std::make_shared<const std::string>("lobby");
    view.spec = std::move(spec);
    view.pose = hall()->places.at("lobby").pose;
    const SnapshotRef snapshot = people();
    const auto draw = [&] {
        auto finished = (*renderer)->draw(snapshot, 0, {&view, 1});
        CHECK(finished.has_value());
        benchmark::DoNotOptimize(finished);
    };
    // The first makes shaders and textures, the second what is kept of the scene.
    for (int i = 0; i < 3; ++i) draw();
    for ([[maybe_unused]] auto turn : state) draw();
    state.SetItemsProcessed(state.iterations() * 640 * 480);
}

BENCHMARK(pose)->Unit(benchmark::kMicrosecond);
BENCHMARK(skin)->Unit(benchmark::kMicrosecond);
BENCHMARK(cull)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(lens_plan, plumb_bob, barrel)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(lens_plan, equidistant, fisheye)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(draw_through, no_lens, Lens{})->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(draw_through, plumb_bob, barrel)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(draw_through, equidistant, fisheye)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();

}  // namespace
}  // namespace camrig

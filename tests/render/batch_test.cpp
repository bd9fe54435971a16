#include <algorithm>

#include <gtest/gtest.h>

#include "tests/render/support/gallery.h"

// Surfaces that differ only in mesh and place are drawn by one call of OpenGL: the bytes of drawing each by its own.
namespace camrig::render {
namespace {

/// A surface somewhere in the world.
struct Placed {
    world::Primitive primitive;
    int material = 0;
    glm::dmat4 world_from_local{1.0};
};

std::vector<world::Material> paints() {
    std::vector<world::Material> paints(6, colored(glm::vec3(0.8f)));
    paints[1] = colored({0.2f, 0.7f, 0.4f});
    paints[2].double_sided = true;
    paints[3].alpha_mode = world::AlphaMode::mask;
    paints[3].base_color_texture = {.texture = 0, .scale = {2.0f, 2.0f}};
    paints[4].base_color_texture.texture = 0;
    paints[4].emissive = {0.3f, 0.1f, 0.2f};
    paints[4].occlusion_texture = {.texture = 0, .scale = {0.5f, 0.7f}};
    paints[5] = colored({0.9f, 0.2f, 0.1f}, true);
    return paints;
}

/// The same surface with indices that need 32 bits.
world::Primitive widened(world::Primitive primitive) {
    constexpr std::size_t unused = 66000;
    const auto widen = [](auto& values) {
        if (!values.empty()) values.insert(values.begin(), unused, values.front());
    };
    widen(primitive.positions);
    widen(primitive.normals);
    widen(primitive.texcoords[0]);
    widen(primitive.colors);
    for (std::uint32_t& index : primitive.indices) index += unused;
    return primitive;
}

world::Primitive without_colors(world::Primitive primitive) {
    primitive.colors.clear();
    return primitive;
}

glm::dmat4 at(double x, double y, double z) {
    return {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {x, y, z, 1}};
}

/// Neighbours that agree in all but their vertex layouts.
std::vector<Placed> pair() {
    return {{box(glm::vec3(0.2f)), 1, at(4.5, 2.4, 0.0)}, {ball(0.2f, 6), 1, at(4.5, 2.4, 0.5)}};
}

/// A wall of things of all materials and vertex layouts in turn, so that no two neighbours agree; behind it more small
/// boxes of one material than one call may draw.
std::vector<Placed> wall() {
    constexpr float size = 0.16f;
    const world::Primitive shapes[] = {box(glm::vec3(size)), ball(size, 6), without_colors(ball(size, 8)),
                                       rectangle({0, 0, 0}, {0.1f, size, 0}, {0, 0, size})};
    const world::Primitive wide_box = widened(shapes[0]);
    const world::Primitive wide_ball = widened(shapes[1]);
    std::vector<Placed> placed;
    for (int i = 0; i < 72; ++i) {
        Placed next{.primitive = i % 12 == 4   ? wide_box
                                 : i % 12 == 7 ? wide_ball
                                               : shapes[i % 4],
                    .material = i / 2 % 6};
        next.world_from_local = at(3.5 + 0.1 * (i % 3), 0.4 * (i % 9) - 1.6, 0.4 * (i / 9) - 1.4);
        next.world_from_local[2] *= i % 5 == 3 ? -1.0 : 1.0;  // mirrored
        placed.push_back(next);
    }
    for (int i = 0; i < 150; ++i)
        placed.push_back({box({0.05f, 0.06f, 0.07f}), 0, at(5.0, 0.25 * (i % 15) - 1.7, 0.4 * (i / 15) - 1.6)});
    return placed;
}

/// The model of some surfaces, a node each.
std::shared_ptr<world::Model> model_with(std::span<const Placed> surfaces) {
    auto model = model_of(surfaces.front().primitive, {});
    const world::Node turned = model->nodes[0];
    const world::Mesh like = model->meshes[0];
    model->materials = paints();
    model->images.push_back(patterned({32, 32}));
    model->textures.push_back({.image = 0, .sampler = {}});
    model->nodes.clear();
    model->meshes.clear();
    model->order.clear();
    for (const Placed& surface : surfaces) {
        const auto number = static_cast<int>(model->nodes.size());
        world::Node node = turned;
        node.matrix = turned.matrix * surface.world_from_local;
        node.mesh = number;
        model->order.push_back(number);
        model->nodes.push_back(node);
        world::Mesh mesh = model_of(surface.primitive, {})->meshes[0];
        mesh.primitives[0].material = surface.material;
        model->meshes.push_back(std::move(mesh));
    }
    return model;
}

enum class Models : std::uint8_t { one, one_each };

world::SnapshotRef world_of(Models models) {
    TestWorld world;
    world.environment.ambient_sky = glm::vec3(0.2f);
    world.environment.ambient_ground = glm::vec3(0.1f);
    world.lights = {
        light_of(world::LightType::directional, 0.5f, {}, glm::normalize(glm::dvec3(1.0, 0.4, -0.7))),
        light_of(world::LightType::point, 1.5f, {3.0, 1.0, 0.5}),
        light_of(world::LightType::spot, 9.0f, {2.0, -1.5, 1.5}, glm::normalize(glm::dvec3(0.6, 0.2, -0.5)))};
    world.lights[1].range = 1.2f;  // so that not all have the same lights
    std::uint32_t id = 1;
    for (const std::vector<Placed>& surfaces : {wall(), pair()}) {
        const std::size_t step = models == Models::one ? surfaces.size() : 1;
        for (std::size_t i = 0; i < surfaces.size(); i += step)
            world.objects.push_back(instance_of(model_with(std::span(surfaces).subspan(i, step)), {}, id++));
    }
    // Objects of one model, neighbours too.
    world::ModelRef crate;
    for (const double y : {-2.3, -2.0, -1.7}) {
        if (crate == nullptr || models == Models::one_each) crate = model_with(std::vector{pair().front()});
        world.objects.push_back(instance_of(crate, {-0.5, y - 0.5, 1.0}, id++));
    }
    const std::vector<Placed> some = wall();
    world.movers.push_back(instance_of(model_with(std::span(some).first(9)), {-1.0, 0, 0}, 1000));
    return world.snapshot();
}

struct Pictures {
    std::vector<frame::FrameRef> frames;
    RenderCounters counters;
};

Pictures film(const world::SnapshotRef& first, world::Quality quality, const RendererOptions& options) {
    auto renderer = create_renderer(options);
    if (!renderer) {
        ADD_FAILURE() << renderer.error().message;
        return {};
    }
    std::vector<View> views{
        TestCamera{.size = {200, 150}, .focal_px = 130.0, .quality = quality}.view(1),
        TestCamera{.eye = {0.5, 0.7, 0.3}, .size = {121, 91}, .focal_px = 70.0, .quality = quality}.view(2)};
    for (View& view : views) std::fill_n(view.kinds, frame::scene_kind_count, true);
    Pictures seen;
    for (int n = 0; n < 4; ++n) {
        auto snapshot = std::make_shared<world::Snapshot>(*first);
        snapshot->movers[0].position.y = 0.2 * n;
        auto finished = (*renderer)->draw(snapshot, 0, views);
        if (!finished || !finished->failures.empty()) {
            ADD_FAILURE() << "a picture is missing";
            return seen;
        }
        std::ranges::move(finished->set.frames, std::back_inserter(seen.frames));
    }
    seen.counters = (*renderer)->counters();
    return seen;
}

RendererOptions options_with(bool batch_draws, std::int64_t static_layer_bytes = 0) {
    return {.device = "llvmpipe",
            .pool = std::make_shared<frame::FramePool>(),
            .static_layer_bytes = static_layer_bytes,
            .batch_draws = batch_draws};
}

constexpr world::Quality qualities[] = {world::Quality::fast, world::Quality::simple, world::Quality::beautiful};

void expect_same(const Pictures& a, const Pictures& b, const std::string& what, bool with_ids = true) {
    ASSERT_EQ(a.frames.size(), b.frames.size());
    ASSERT_FALSE(a.frames.empty());
    for (std::size_t i = 0; i < a.frames.size(); ++i) {
        const frame::FrameKind kind = a.frames[i]->info().kind;
        if (!with_ids && (kind == frame::FrameKind::instance || kind == frame::FrameKind::semantic)) continue;
        EXPECT_TRUE(std::ranges::equal(a.frames[i]->bytes(), b.frames[i]->bytes())) << what << ", picture " << i;
    }
}

TEST(BatchedDraws, ChangeNoByteInAnyQualityWithAndWithoutLayers) {
    const world::SnapshotRef snapshot = world_of(Models::one);
    for (const world::Quality quality : qualities) {
        for (const std::int64_t layer_bytes : {0, 1 << 24}) {
            const Pictures apart = film(snapshot, quality, options_with(false, layer_bytes));
            const Pictures batched = film(snapshot, quality, options_with(true, layer_bytes));
            expect_same(apart, batched, std::string(to_string(quality)) + (layer_bytes > 0 ? ", layers" : ""));
            EXPECT_EQ(apart.counters.draw_calls, apart.counters.draws);
            EXPECT_EQ(batched.counters.draws, apart.counters.draws);
            EXPECT_LT(2 * batched.counters.draw_calls, apart.counters.draw_calls);
        }
    }
}

TEST(BatchedDraws, ShowWhatSurfacesInModelsOfTheirOwnShow) {
    const Pictures in_one = film(world_of(Models::one), world::Quality::simple, options_with(true));
    const Pictures in_many = film(world_of(Models::one_each), world::Quality::simple, options_with(true));
    expect_same(in_one, in_many, "all but ids", false);
    EXPECT_EQ(in_one.counters.draws, in_many.counters.draws);
}

/// The hall's lobby in its baked light, and once more where it has moved, so that all surfaces take the light of
/// probes.
std::vector<frame::FrameRef> in_baked_light(bool batch_draws, std::uint64_t& draw_calls) {
    auto renderer = create_renderer(options_with(batch_draws)).value();
    Film film("hall", true);
    View view = film.view("lobby", {200, 150}, 1);
    view.quality = world::Quality::beautiful;
    auto spec = std::make_shared<world::CameraSpec>(*view.spec);
    spec->antialias = world::Antialias::none;
    view.spec = spec;
    const world::SnapshotRef stands = film.at(4 * ns_per_s);
    std::vector<frame::FrameRef> frames;
    for (const world::SnapshotRef& snapshot : {stands, with_moved_objects(stands, {0.05, 0.0, 0.0})})
        frames.push_back(renderer->draw(snapshot, 0, {&view, 1}).value().set.frames.at(0));
    draw_calls = renderer->counters().draw_calls;
    return frames;
}

TEST(BatchedDraws, ChangeNoByteInBakedLight) {
    std::uint64_t apart_calls = 0, batched_calls = 0;
    const auto apart = in_baked_light(false, apart_calls), batched = in_baked_light(true, batched_calls);
    for (std::size_t i = 0; i < apart.size(); ++i)
        EXPECT_TRUE(std::ranges::equal(apart[i]->bytes(), batched[i]->bytes())) << i;
    EXPECT_LT(batched_calls, apart_calls);
}

}  // namespace
}  // namespace camrig::render

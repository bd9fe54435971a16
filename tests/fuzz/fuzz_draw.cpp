#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <utility>

#include <fuzzer/FuzzedDataProvider.h>

#include "core/render/software/software_drawer.h"
#include "tests/render/support/gallery.h"

// Random small scenes through camrig's rasteriser: any numbers as vertices and texture coordinates, every sort of
// surface, points and lines, any camera, lens, quality and antialiasing that it draws. What must hold: no crash, and
// the same bytes whether the drawer keeps static layers or not, draws kinds of pictures together or alone, with one
// thread or two, with wide lanes or without.
namespace camrig::render {
namespace {

constexpr int max_objects = 5, max_triangles = 12, max_lights = 3;

void require(bool condition) {
    if (!condition) std::abort();
}

/// Reads a scene from the fuzzer's bytes.
class Draws {
public:
    Draws(const std::uint8_t* data, std::size_t size) : from_(data, size) {}

    TestWorld world() {
        TestWorld result;
        result.environment = {.background = color(), .ambient_sky = color(), .ambient_ground = color()};
        const int objects = below(max_objects) + 1, lights = below(max_lights + 1);
        for (int i = 0; i < objects; ++i) {
            auto& list = from_.ConsumeBool() ? result.movers : result.objects;
            world::Instance& instance =
                list.emplace_back(instance_of(model(), place(), static_cast<std::uint32_t>(i + 1)));
            instance.scale = from_.ConsumeBool() ? -1.0 : 1.0;
        }
        for (int i = 0; i < lights; ++i) {
            const auto type = static_cast<world::LightType>(below(3));
            result.lights.push_back(light_of(type, within(0.0f, 10.0f), place(), glm::dvec3(0.6, 0.0, -0.8)));
        }
        return result;
    }

    /// To be read before the world: which sorts of surfaces are drawn depends on the lens.
    View view(std::uint32_t number) {
        TestCamera camera{.eye = place() * 0.2};
        camera.quality = static_cast<world::Quality>(below(3));
        camera.antialias = std::array{world::Antialias::none, world::Antialias::coverage,
                                      world::Antialias::automatic}[static_cast<std::size_t>(below(3))];
        camera.lens = lens();
        camera.size = {16 + below(80), 16 + below(60)};
        camera.focal_px = std::exp(within(0.0f, 9.0f));
        camera.near_m = 0.001 + within(0.0f, 1.0f);
        camera.far_m = below(4) == 0 ? 1.5 + within(0.0f, 5.0f) : 0.0;
        View result = camera.view(number);
        const int kinds = 1 + below((1 << frame::scene_kind_count) - 1);
        for (int k = 0; k < frame::scene_kind_count; ++k) result.kinds[k] = (kinds >> k & 1) != 0;
        has_strokes_ = camera.lens.model == camera::LensModel::pinhole && from_.ConsumeBool();
        return result;
    }

    glm::dvec3 place() {
        const double x = within(-1.0f, 8.0f), y = within(-3.0f, 3.0f);
        return {x, y, within(-2.0f, 2.0f)};
    }

private:
    int below(int count) { return from_.ConsumeIntegralInRange(0, count - 1); }
    float within(float least, float most) { return from_.ConsumeFloatingPointInRange(least, most); }
    glm::vec3 color() {
        const float red = within(0.0f, 1.0f), green = within(0.0f, 1.0f);
        return {red, green, within(0.0f, 1.0f)};
    }
    /// Mostly a number that a scene would have, at times any number there is.
    float coordinate() { return below(8) == 0 ? from_.ConsumeFloatingPoint<float>() : within(-3.0f, 3.0f); }

    camera::Lens lens() {
        camera::Lens result;
        if (from_.ConsumeBool()) return result;
        result.model = static_cast<camera::LensModel>(1 + below(3));
        for (int i = 0; i < camera::coefficient_count(result.model); ++i)
            result.coefficients[static_cast<std::size_t>(i)] = below(3) == 0 ? 0.0 : within(-0.5f, 0.5f);
        return result;
    }

    world::Material material() {
        world::Material result = colored(color(), from_.ConsumeBool());
        result.double_sided = from_.ConsumeBool();
        result.alpha_mode = static_cast<world::AlphaMode>(below(3));
        result.base_color.a = within(0.0f, 1.0f);
        result.emissive = color();
        return result;
    }

    world::ModelRef model() {
        world::Primitive surface;
        if (has_strokes_) surface.topology = static_cast<world::Topology>(below(3));
        const int corners = 6 * (below(max_triangles / 2) + 1);  // whole triangles and whole lines
        const bool has_texture = from_.ConsumeBool(), has_colors = from_.ConsumeBool();
        for (int i = 0; i < corners; ++i) {
            const float x = coordinate(), y = coordinate();
            surface.positions.emplace_back(x, y, coordinate());
            surface.normals.emplace_back(-1.0f, 0.0f, 0.0f);
            surface.indices.push_back(static_cast<std::uint32_t>(below(i + 1)));
            if (has_texture) surface.texcoords[0].emplace_back(coordinate(), coordinate());
            if (has_colors) surface.colors.emplace_back(color(), within(0.0f, 1.0f));
        }
        world::Material look = material();
        if (has_texture) look.base_color_texture.texture = 0;
        auto result = model_of(std::move(surface), std::move(look));
        if (has_texture) {
            result->images.push_back(patterned({1 + below(16), 1 + below(16)}));
            world::Sampler sampler{static_cast<world::Wrap>(below(3)), static_cast<world::Wrap>(below(3))};
            sampler.magnify = static_cast<world::Filter>(below(2));
            sampler.mipmaps = from_.ConsumeBool();
            result->textures.push_back({.image = 0, .sampler = sampler});
        }
        return result;
    }

    FuzzedDataProvider from_;
    bool has_strokes_ = false;
};

software::SoftwareDrawer make_drawer(int threads, std::int64_t layer_bytes, bool wide_lanes) {
    software::SoftwareDrawer::Options options;
    options.pool = std::make_shared<frame::FramePool>();
    options.threads = threads;
    options.static_layer_bytes = layer_bytes;
    options.wide_lanes = wide_lanes && software::has_wide_lanes();
    return software::SoftwareDrawer(options);
}

/// Those of the kinds wanted that are drawn here, in their order.
std::vector<frame::FrameRef> drawn(software::SoftwareDrawer& by, const View& view) {
    std::vector<frame::FrameRef> frames;
    by.draw(std::vector<const View*>{&view}, 0, frames);
    return frames;
}

View of_kind(View view, frame::FrameKind kind) {
    for (int k = 0; k < frame::scene_kind_count; ++k) view.kinds[k] = static_cast<frame::FrameKind>(k) == kind;
    return view;
}

/// The pictures of one instant by `kept`, all together, are those that `plain` draws each by itself.
void compare(software::SoftwareDrawer& kept, software::SoftwareDrawer& plain, const View& view) {
    std::vector<frame::FrameRef> expected;
    for (int k = 0; k < frame::scene_kind_count; ++k) {
        const auto kind = static_cast<frame::FrameKind>(k);
        require(kept.can_draw(view, kind) == plain.can_draw(view, kind));
        if (!view.kinds[k] || !plain.can_draw(view, kind)) continue;
        plain.forget(view.camera);
        expected.push_back(drawn(plain, of_kind(view, kind)).at(0));
    }
    const std::vector<frame::FrameRef> frames = drawn(kept, view);
    require(frames.size() == expected.size());
    for (std::size_t i = 0; i < frames.size(); ++i)
        require(std::ranges::equal(frames[i]->bytes(), expected[i]->bytes()));
}

/// What each object would show alone, by the layers of `kept` and by pictures of it alone.
void compare_silhouettes(software::SoftwareDrawer& kept, software::SoftwareDrawer& plain, const View& view) {
    if (!kept.can_draw(view, frame::FrameKind::instance)) return;
    std::vector<ObjectId> objects;
    for (std::uint32_t id = 1; id <= max_objects; ++id) objects.push_back(ObjectId{id});
    const auto silhouettes = kept.silhouettes(view, objects);
    for (std::size_t i = 0; i < objects.size(); ++i) {
        View alone = of_kind(view, frame::FrameKind::instance);
        alone.only_objects = {objects[i]};
        plain.forget(view.camera);
        const frame::FrameRef picture = drawn(plain, alone).at(0);
        std::vector<std::uint32_t> shown(picture->bytes().size() / sizeof(std::uint32_t));
        std::memcpy(shown.data(), picture->bytes().data(), picture->bytes().size());
        for (const frame::PixelRun& run : silhouettes[i])
            for (int x = run.x0; x < run.x1; ++x)
                require(std::exchange(shown.at(static_cast<std::size_t>(view.spec->size.width * run.y + x)), 0u) != 0);
        require(std::ranges::all_of(shown, [](std::uint32_t id) { return id == 0; }));
    }
}

void run(const std::uint8_t* data, std::size_t size) {
    static software::SoftwareDrawer with_layers = make_drawer(2, std::int64_t{1} << 20, true),
                                    plain = make_drawer(1, 0, false);
    Draws from(data, size);
    View view = from.view(1);
    const world::SnapshotRef first = from.world().snapshot();
    for (int instant = 0; instant < 3; ++instant) {
        auto snapshot = std::make_shared<world::Snapshot>(*first);
        for (world::Instance& mover : snapshot->movers) mover.position += from.place() * 0.1;
        with_layers.begin_instant(snapshot);
        plain.begin_instant(snapshot);
        view.sequence = instant;
        compare(with_layers, plain, view);
        if (instant == 1) compare_silhouettes(with_layers, plain, view);
    }
    with_layers.forget(view.camera);
    plain.forget(view.camera);
}

}  // namespace
}  // namespace camrig::render

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    camrig::render::run(data, size);
    return 0;
}

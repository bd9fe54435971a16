#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>

#include <fuzzer/FuzzedDataProvider.h>

#include "core/render/software/software_drawer.h"
#include "tests/render/support/gallery.h"

// Random small scenes through camrig's rasteriser: any numbers as vertices and texture coordinates, every sort of
// surface, any camera. What must hold: no crash, and the same bytes whether the drawer keeps static layers or not, with
// one thread or two, with wide lanes or without.
namespace camrig {
namespace {

constexpr int max_objects = 5, max_triangles = 12, max_lights = 3;

void require(bool condition) {
    if (!condition) std::abort();
}

/// Reads a scene from the fuzzer's bytes.
class Draws {
public:
    Draws(const std::uint8_t* data, std::size_t size) : from_(data, size) {}

    render::TestWorld world() {
        render::TestWorld result;
        result.environment = {.background = color(), .ambient_sky = color(), .ambient_ground = color()};
        const int objects = below(max_objects) + 1, lights = below(max_lights + 1);
        for (int i = 0; i < objects; ++i) {
            auto& list = from_.ConsumeBool() ? result.movers : result.objects;
            world::Instance& instance =
                list.emplace_back(render::instance_of(model(), place(), static_cast<std::uint32_t>(i + 1)));
            instance.scale = from_.ConsumeBool() ? -1.0 : 1.0;
        }
        for (int i = 0; i < lights; ++i) {
            const auto type = static_cast<world::LightType>(below(3));
            result.lights.push_back(render::light_of(type, within(0.0f, 10.0f), place(), glm::dvec3(0.6, 0.0, -0.8)));
        }
        return result;
    }

    render::View view(std::uint32_t number) {
        render::TestCamera camera{.eye = place() * 0.2};
        camera.size = {16 + below(80), 16 + below(60)};
        camera.focal_px = std::exp(within(0.0f, 9.0f));
        camera.near_m = 0.001 + within(0.0f, 1.0f);
        camera.quality = from_.ConsumeBool() ? world::Quality::fast : world::Quality::simple;
        return camera.view(number);
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

    world::Material material() {
        world::Material result = render::colored(color(), from_.ConsumeBool());
        result.double_sided = from_.ConsumeBool();
        result.alpha_mode = static_cast<world::AlphaMode>(below(3));
        result.base_color.a = within(0.0f, 1.0f);
        result.emissive = color();
        return result;
    }

    world::ModelRef model() {
        world::Primitive surface;
        const int corners = 3 * (below(max_triangles) + 1);
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
        auto result = render::model_of(std::move(surface), std::move(look));
        if (has_texture) {
            result->images.push_back(render::patterned({1 + below(16), 1 + below(16)}));
            world::Sampler sampler{static_cast<world::Wrap>(below(3)), static_cast<world::Wrap>(below(3))};
            sampler.magnify = static_cast<world::Filter>(below(2));
            sampler.mipmaps = from_.ConsumeBool();
            result->textures.push_back({.image = 0, .sampler = sampler});
        }
        return result;
    }

    FuzzedDataProvider from_;
};

render::software::SoftwareDrawer make_drawer(int threads, std::int64_t layer_bytes, bool wide_lanes) {
    render::software::SoftwareDrawer::Options options;
    options.pool = std::make_shared<frame::FramePool>();
    options.threads = threads;
    options.static_layer_bytes = layer_bytes;
    options.wide_lanes = wide_lanes && render::software::has_wide_lanes();
    return render::software::SoftwareDrawer(options);
}

std::vector<frame::FrameRef> drawn(render::software::SoftwareDrawer& by, const world::SnapshotRef& snapshot,
                                   const render::View& view) {
    by.begin_instant(snapshot);
    require(by.can_draw(view));
    std::vector<frame::FrameRef> frames;
    by.draw(std::vector<const render::View*>{&view}, 0, frames);
    return frames;
}

void run(const std::uint8_t* data, std::size_t size) {
    static render::software::SoftwareDrawer with_layers = make_drawer(2, std::int64_t{1} << 20, true),
                                            plain = make_drawer(1, 0, false);
    Draws from(data, size);
    const render::TestWorld world = from.world();
    const world::SnapshotRef first = world.snapshot();
    const render::View view = from.view(1);
    for (int instant = 0; instant < 3; ++instant) {
        auto snapshot = std::make_shared<world::Snapshot>(*first);
        for (world::Instance& mover : snapshot->movers) mover.position += from.place() * 0.1;
        const frame::FrameRef kept = drawn(with_layers, snapshot, view).at(0),
                              full = drawn(plain, snapshot, view).at(0);
        require(std::ranges::equal(kept->bytes(), full->bytes()));
    }
    with_layers.forget(view.camera);
    plain.forget(view.camera);
}

}  // namespace
}  // namespace camrig

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    camrig::run(data, size);
    return 0;
}

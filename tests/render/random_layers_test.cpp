#include <cstdlib>
#include <random>

#include <gtest/gtest.h>

#include "core/render/software/software_drawer.h"
#include "core/world/camera_past.h"
#include "tests/render/support/gallery.h"
#include "tests/render/support/test_rig.h"

// Random worlds, cameras and wishes: whatever a drawer keeps from picture to picture never shows. Each frame has the
// bytes of one by a drawer that knows nothing; kept memory stays below its bound and is given back.
// CAMRIG_RANDOM_LAYERS: how many worlds (40).
namespace camrig::render::random_layers_test {
namespace {

constexpr TimeNs step_ns = 20 * ns_per_ms;

class Random {
public:
    explicit Random(std::uint64_t seed) : bits_(seed) {}

    double real(double from, double to) { return from + (to - from) * static_cast<double>(bits_() >> 11) * 0x1p-53; }
    int integer(int from, int to) {
        return from + static_cast<int>(bits_() % static_cast<std::uint64_t>(to - from + 1));
    }
    bool chance(double share) { return real(0.0, 1.0) < share; }
    template <typename T>
    T one_of(std::initializer_list<T> list) {
        return list.begin()[integer(0, static_cast<int>(list.size()) - 1)];
    }

private:
    std::mt19937_64 bits_;
};

world::Material glass() {
    world::Material made = colored({0.3f, 0.5f, 0.9f});
    made.alpha_mode = world::AlphaMode::blend;
    made.base_color.a = 0.4f;
    return made;
}

/// Boxes, balls and thin things on a floor, under the sun and lamps; movers among them.
TestWorld room(Random& random) {
    TestWorld world;
    if (random.chance(0.3)) world = gallery();
    world.movers.clear();
    if (random.chance(0.8))
        world.lights.push_back(
            light_of(world::LightType::directional, 0.8f, {}, glm::normalize(glm::dvec3(1.0, 0.4, -0.7))));
    if (random.chance(0.6)) world.lights.push_back(light_of(world::LightType::point, 2.0f, {3.0, 0.5, 1.5}));
    if (random.chance(0.6))
        world.lights.push_back(
            light_of(world::LightType::spot, 9.0f, {3.0, -1.5, 2.5}, glm::normalize(glm::dvec3(0.6, 0.4, -0.8))));
    std::uint32_t id = 201;
    const auto add = [&](std::vector<world::Instance>& to, world::Primitive shape, const world::Material& paint,
                         const glm::dvec3& at) {
        to.push_back(instance_of(model_of(std::move(shape), paint), at, id++));
    };
    add(world.objects, rectangle({6, 0, -1}, {6, 0, 0}, {0, 6, 0}), colored(glm::vec3(0.7f)), {});
    for (int i = random.integer(2, 8); i > 0; --i) {
        const glm::dvec3 at(random.real(3.0, 7.0), random.real(-2.0, 2.0), random.real(-0.9, 0.3));
        const world::Material paint =
            random.chance(0.2) ? glass() : colored({0.6f, 0.7f, 0.1f * static_cast<float>(i)});
        const auto side = static_cast<float>(random.real(0.1, 0.5));
        const float thin = random.chance(0.4) ? 0.004f : side;
        add(world.objects, random.chance(0.3) ? ball(side, 12) : box({side, thin, 0.7f}), paint, at);
    }
    for (int i = random.integer(0, 4); i > 0; --i) {
        const auto side = static_cast<float>(random.real(0.05, 0.5));
        add(world.movers, random.chance(0.3) ? ball(side, 8) : box({side, 0.5f * side, 1.5f * side}),
            random.chance(0.3) ? glass() : colored({0.9f, 0.2f, 0.1f}, random.chance(0.3)),
            {random.real(1.5, 7.0), random.real(-2.5, 2.5), random.real(-0.9, 1.5)});
    }
    return world;
}

/// What became of a world, step by step: movers go and stand, lamps change and begin to flicker.
class Film {
public:
    Film(const TestWorld& world, Random& random, int count) {
        const world::SnapshotRef first = world.snapshot(0);
        auto statics = first->statics;
        const double light_changes = random.one_of({0.0, 0.0, 0.02, 0.2});
        std::vector<world::ActorState> states;
        std::vector<glm::dvec3> speeds(first->movers.size(), glm::dvec3(0.0));
        for (const world::Instance& mover : first->movers)
            states.push_back({.position = mover.position, .orientation = mover.orientation, .clips = {}});
        for (int n = 0; n < count; ++n) {
            if (n > 0 && random.chance(light_changes)) statics = changed(*statics, random);
            world::StepRecord step{.world_ns = n * step_ns, .arrived = {}, .statics = statics, .movers = {}};
            for (std::size_t i = 0; i < states.size(); ++i) {
                if (random.chance(0.15))
                    speeds[i] = random.chance(0.5)
                                    ? glm::dvec3(0.0)
                                    : glm::dvec3(random.real(-1, 1), random.real(-3, 3), random.real(-1, 1));
                states[i].position += speeds[i] * 0.02;
                if (glm::distance(states[i].position, glm::dvec3(4.0, 0.0, 0.0)) > 4.0) speeds[i] = -speeds[i];
                if (n > 0) step.arrived.push_back(states[i]);
                step.movers.push_back({.info = first->movers[i].info, .state = states[i], .held = {}});
            }
            steps_.push_back(std::move(step));
        }
    }

    std::shared_ptr<const world::WorldPast> past(int n) const {
        constexpr int kept = 14;
        world::StepHistory history;
        for (int k = std::max(0, n - kept); k < n; ++k) history.push(steps_[static_cast<std::size_t>(k)]);
        return std::make_shared<const world::WorldPast>(std::move(history), steps_[static_cast<std::size_t>(n)]);
    }

private:
    static std::shared_ptr<const world::StaticSet> changed(const world::StaticSet& statics, Random& random) {
        auto made = std::make_shared<world::StaticSet>(statics);
        for (world::Light& light : made->lights) light.intensity *= static_cast<float>(random.real(0.5, 1.5));
        if (!made->lights.empty() && random.chance(0.2))
            made->lights[0].flicker_depth = made->lights[0].flicker_depth > 0.0f ? 0.0f : 0.6f;
        return made;
    }

    std::vector<world::StepRecord> steps_;
};

std::unique_ptr<software::SoftwareDrawer> drawer(int threads, std::int64_t layer_bytes, const SharedCaches& caches) {
    return std::make_unique<software::SoftwareDrawer>(
        software::SoftwareDrawer::Options{.pool = std::make_shared<frame::FramePool>(),
                                          .caches = caches,
                                          .static_layer_bytes = layer_bytes,
                                          .threads = threads});
}

std::optional<sensor::SensorSpec> some_sensor(Random& random) {
    if (random.chance(0.25)) return std::nullopt;
    sensor::SensorSpec spec =
        sensor::sensor_preset(random.one_of({sensor::SensorPreset::imx219, sensor::SensorPreset::imx249}));
    spec.exposure_s = random.one_of({1e-6, 1e-3, 0.01, 0.02, 0.05});
    spec.readout_s = random.one_of({0.0, 0.01, 0.02});
    spec.blur = random.chance(0.7);
    if (random.chance(0.1)) {
        spec.focus_m = 3.0;
        spec.f_number = 8.0;
    }
    return spec;
}

world::Quality some_quality(Random& random) {
    return random.one_of({world::Quality::fast, world::Quality::simple, world::Quality::beautiful});
}
world::Antialias some_antialias(Random& random) {
    return random.one_of({world::Antialias::none, world::Antialias::coverage});
}

class RandomCamera {
public:
    RandomCamera(std::uint32_t number, Random& random)
        : view_(TestCamera{.eye = {0.0, random.real(-0.5, 0.5), 0.2},
                           .size = {random.integer(20, 100), random.integer(20, 70)},
                           .focal_px = random.real(25.0, 60.0)}
                    .view(number)),
          spec_(*view_.spec) {
        const camera::Lens barrel =
            make_lens(camera::LensModel::plumb_bob, std::vector{-0.25, 0.05, 0.001, -0.001, 0.0}).value();
        const camera::Lens fisheye =
            make_lens(camera::LensModel::equidistant, std::vector{0.02, -0.01, 0.0, 0.0}).value();
        view_.quality = some_quality(random);
        spec_.pose = view_.pose;
        spec_.lens = random.one_of({camera::Lens{}, camera::Lens{}, barrel, fisheye});
        spec_.antialias = some_antialias(random);
        spec_.sensor = some_sensor(random);
        renew();
    }

    /// As by a command.
    void change(Random& random) {
        switch (random.integer(0, 4)) {
            case 0:
                spec_.sensor = some_sensor(random);
                break;
            case 1:
                spec_.antialias = some_antialias(random);
                break;
            case 2:
                spec_.intrinsics.fx = spec_.intrinsics.fy = random.real(25.0, 90.0);
                break;
            case 3:
                view_.quality = some_quality(random);
                break;
            default:
                spec_.pose.position.y += 0.05;
        }
        renew();
    }

    void ask_for_other_kinds(Random& random) {
        for (std::size_t k = 0; k < frame::scene_kind_count; ++k) view_.kinds[k] = random.chance(k == 0 ? 0.7 : 0.25);
        view_.kinds[index_of(frame::FrameKind::sensor)] = random.chance(0.4);
    }

    const View& at(int n, const std::shared_ptr<const world::WorldPast>& past, const world::SnapshotRef& instant) {
        view_.sequence = n;
        view_.pose = camera_->at(*instant).pose;
        view_.past = spec_.sensor ? std::make_shared<const world::CameraPast>(past, *camera_) : nullptr;
        return view_;
    }

private:
    void renew() {
        view_.spec = std::make_shared<world::CameraSpec>(spec_);
        ++view_.spec_revision;
        camera_.emplace(spec_);
    }

    View view_;
    world::CameraSpec spec_;
    std::optional<world::Camera> camera_;
};

std::string description_of(const View& view) {
    const auto& sensor = view.spec->sensor;
    return std::string(to_string(view.quality)) + " " + std::string(to_string(view.spec->antialias)) + " " +
           std::string(to_string(view.spec->lens.model)) +
           (sensor
                ? " exposure " + std::to_string(*sensor->exposure_s) + " readout " + std::to_string(sensor->readout_s)
                : " without a sensor");
}

void expect_same(software::SoftwareDrawer& by, const world::SnapshotRef& instant, const std::vector<View>& views,
                 const SharedCaches& caches) {
    std::vector<const View*> asked;
    for (const View& view : views) asked.push_back(&view);
    std::vector<frame::FrameRef> frames, expected;
    by.begin_instant(instant);
    by.draw(asked, 0, frames);
    const auto fresh = drawer(2, 0, caches);
    fresh->begin_instant(instant);
    fresh->draw(asked, 0, expected);
    ASSERT_EQ(frames.size(), expected.size());
    for (std::size_t i = 0; i < frames.size(); ++i) {
        ASSERT_EQ(frames[i]->info().kind, expected[i]->info().kind);
        const View& view = *std::ranges::find(views, frames[i]->info().camera_id, &View::camera);
        ASSERT_TRUE(std::ranges::equal(frames[i]->bytes(), expected[i]->bytes()))
            << to_string(frames[i]->info().kind) << ", " << description_of(view);
    }
}

void draw_a_film(std::uint64_t seed) {
    Random random(seed);
    const TestWorld world = room(random);
    const int count = random.integer(6, 40);
    const Film film(world, random, count);
    // From less than a layer to more than enough.
    const auto budget =
        static_cast<std::int64_t>(random.chance(0.3) ? 64e6 : std::exp(random.real(std::log(2e4), std::log(3e6))));
    const SharedCaches caches = make_shared_caches();
    const std::array lanes{drawer(random.integer(1, 3), budget, caches), drawer(random.integer(1, 3), budget, caches)};
    const double changes = random.one_of({0.0, 0.03, 0.2}), other_kinds = random.one_of({0.05, 0.5});
    std::vector<RandomCamera> cameras;
    std::vector<std::size_t> lane_of;
    for (int i = random.integer(1, 3); i > 0; --i) {
        cameras.emplace_back(static_cast<std::uint32_t>(i), random);
        cameras.back().ask_for_other_kinds(random);
        lane_of.push_back(0);
    }
    for (int n = 0; n < count && !testing::Test::HasFatalFailure(); ++n) {
        const auto past = film.past(n);
        const world::SnapshotRef instant = past->at(n * step_ns);
        std::array<std::vector<View>, 2> due;
        for (std::size_t c = 0; c < cameras.size(); ++c) {
            if (random.chance(changes)) cameras[c].change(random);
            if (random.chance(other_kinds)) cameras[c].ask_for_other_kinds(random);
            const View& view = cameras[c].at(n, past, instant);
            if (random.chance(0.03)) {
                lanes[lane_of[c]]->hand_over(view.camera);
                lane_of[c] = 1 - lane_of[c];
            }
            if (random.chance(0.01)) lanes[lane_of[c]]->forget(view.camera);
            if (random.chance(0.95)) due[lane_of[c]].push_back(view);
        }
        for (std::size_t lane = 0; lane < lanes.size(); ++lane) {
            SCOPED_TRACE("seed " + std::to_string(seed) + ", picture " + std::to_string(n));
            expect_same(*lanes[lane], instant, due[lane], caches);
            // Drawn again, and other kinds with it, as on demand.
            for (View& view : due[lane]) view.kinds[0] = !view.kinds[0];
            if (random.chance(0.1)) expect_same(*lanes[lane], instant, due[lane], caches);
            ASSERT_LE(lanes[lane]->counters().layer_bytes, budget);
        }
    }
    for (const auto& lane : lanes) {
        for (std::uint32_t camera = 1; camera <= cameras.size(); ++camera) lane->forget(CameraId{camera});
        EXPECT_EQ(lane->counters().layer_bytes, 0);
    }
}

TEST(RandomLayers, NeverShow) {
    const char* const asked = std::getenv("CAMRIG_RANDOM_LAYERS");
    const std::uint64_t worlds = asked != nullptr ? std::strtoull(asked, nullptr, 10) : 40;
    for (std::uint64_t seed = 1; seed <= worlds && !HasFatalFailure(); ++seed) draw_a_film(seed);
}

}  // namespace
}  // namespace camrig::render::random_layers_test

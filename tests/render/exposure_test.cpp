#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <cstring>
#include <numbers>

#include <gtest/gtest.h>

#include "core/render/moments.h"
#include "core/render/software/software_drawer.h"
#include "core/world/camera_past.h"
#include "tests/render/support/gallery.h"
#include "tests/render/support/test_rig.h"

// Pictures that take time: blur, rolling shutter and flicker against closed forms, from delivered numbers.
namespace camrig::render::exposure_test {
namespace {

constexpr ImageSize size{320, 240};
constexpr double focal_px = 300.0;
constexpr TimeNs now_ns = 200 * ns_per_ms;

sensor::SensorSpec quiet(double exposure_s, double readout_s) {
    sensor::SensorSpec spec;
    spec.filter = sensor::ColorFilter::mono;
    spec.full_well_e = 1e6;
    spec.white_balance_k = 6500.0;
    spec.exposure_s = exposure_s;
    spec.readout_s = readout_s;
    // White is half of the range whatever the exposure.
    spec.gain_db = 0.0;
    return spec;
}

struct Scenery {
    TestWorld begin;                     ///< at world time 0
    std::vector<world::Instance> end;    ///< the movers at now_ns; empty: as in the beginning
    camera::Pose pose{}, pose_at_end{};  ///< of the camera, the same times
};

/// The two steps of a world that goes straight from one to the other.
std::shared_ptr<const world::CameraPast> past_of(const Scenery& scenery, const world::CameraSpec& spec) {
    const world::SnapshotRef first = scenery.begin.snapshot(0);
    world::StepRecord begin{.world_ns = 0, .arrived = {}, .statics = first->statics, .movers = {}};
    for (const world::Instance& mover : first->movers)
        begin.movers.push_back({.info = mover.info,
                                .state = {.position = mover.position, .orientation = mover.orientation, .clips = {}},
                                .held = {}});
    world::StepRecord end = begin;
    end.world_ns = now_ns;
    for (std::size_t i = 0; i < begin.movers.size(); ++i) {
        if (!scenery.end.empty()) {
            end.movers[i].state.position = scenery.end[i].position;
            end.movers[i].state.orientation = scenery.end[i].orientation;
        }
        end.arrived.push_back(end.movers[i].state);
    }
    world::StepHistory history;
    history.push(std::move(begin));
    world::CameraSpec standing = spec;
    standing.pose = scenery.pose;
    world::CameraPatch turn;
    turn.pose = scenery.pose_at_end;
    turn.optics = spec.intrinsics;
    const world::Camera camera = world::Camera(standing).changed(turn, 0, now_ns).value();
    return std::make_shared<const world::CameraPast>(
        std::make_shared<const world::WorldPast>(std::move(history), std::move(end)), camera);
}

struct Taken {
    std::vector<std::uint16_t> numbers;
    frame::FrameRef color, ids, depth;
    double cpu_ns = 0.0;

    double at(int x, int y) const { return numbers[static_cast<std::size_t>(y * size.width + x)]; }
    std::uint32_t id(int x, int y) const {
        return reinterpret_cast<const std::uint32_t*>(ids->bytes().data())[y * size.width + x];
    }
};

std::unique_ptr<software::SoftwareDrawer> drawer(int threads, std::int64_t layer_bytes = std::int64_t{64} << 20) {
    software::SoftwareDrawer::Options options;
    options.pool = std::make_shared<frame::FramePool>();
    options.static_layer_bytes = layer_bytes;
    options.threads = threads;
    return std::make_unique<software::SoftwareDrawer>(options);
}

struct Wishes {
    int threads = 1;
    world::Antialias antialias = world::Antialias::none;
    camera::Lens lens{};
    bool has_past = true;
    bool has_ids = true;
    world::Quality quality = world::Quality::simple;
};

struct Setup {
    View view;
    world::SnapshotRef instant;
};

Setup set_up(const Scenery& scenery, const sensor::SensorSpec& spec, const Wishes& wishes) {
    View view = TestCamera{.size = size,
                           .focal_px = focal_px,
                           .lens = wishes.lens,
                           .antialias = wishes.antialias,
                           .quality = wishes.quality}
                    .view();
    auto with_sensor = std::make_shared<world::CameraSpec>(*view.spec);
    with_sensor->sensor = spec;
    view.spec = with_sensor;
    view.kinds[index_of(frame::FrameKind::sensor)] = true;
    view.kinds[index_of(frame::FrameKind::instance)] = wishes.has_ids;
    view.kinds[index_of(frame::FrameKind::depth)] = wishes.has_ids;
    const auto past = past_of(scenery, *with_sensor);
    const auto instant = past->at(now_ns);
    view.pose = instant.state.pose;
    if (wishes.has_past) view.past = past;
    return {view, instant.snapshot};
}

Taken taken(const Scenery& scenery, const sensor::SensorSpec& spec, const Wishes& wishes = {}) {
    const auto [view, instant] = set_up(scenery, spec, wishes);
    const auto by = drawer(wishes.threads);
    by->begin_instant(instant);
    std::vector<frame::FrameRef> frames;
    by->draw(std::vector<const View*>{&view}, 0, frames);
    Taken made;
    made.cpu_ns = static_cast<double>(by->cost_ns().front());
    for (const frame::FrameRef& frame : frames) {
        if (frame->info().kind == frame::FrameKind::color) made.color = frame;
        if (frame->info().kind == frame::FrameKind::instance) made.ids = frame;
        if (frame->info().kind == frame::FrameKind::depth) made.depth = frame;
        if (frame->info().kind != frame::FrameKind::sensor) continue;
        made.numbers.resize(frame->bytes().size() / 2);
        std::memcpy(made.numbers.data(), frame->bytes().data(), frame->bytes().size());
    }
    return made;
}

camera::Pose turned(double pan_rad) {
    return camera::pose_from_angles(glm::dvec3(0.0), {.pan = pan_rad}).value();
}

/// A white wall 4 m ahead that fills the right half of a picture at time 0; its edge is at world y = 0.
world::Instance half_wall(std::uint32_t id = 1, double y = 0.0) {
    return instance_of(model_of(rectangle({4.0f, -40.0f, 0.0f}, {0.0f, -40.0f, 0.0f}, {0.0f, 0.0f, 40.0f}),
                                colored(glm::vec3(0.2f), true)),
                       glm::dvec3(0.0, y, 0.0), id);
}

/// A bar, upright, a few pixels wide.
world::Instance bar(std::uint32_t id = 1, double y = 0.0) {
    return instance_of(model_of(rectangle({4.0f, 0.0f, 0.0f}, {0.0f, -0.1f, 0.0f}, {0.0f, 0.0f, 40.0f}),
                                colored(glm::vec3(1.0f), true)),
                       glm::dvec3(0.0, y, 0.0), id);
}

/// Where the light of a row is, in columns.
double middle_of_row(const Taken& picture, int y) {
    double sum = 0.0, moment = 0.0;
    for (int x = 0; x < size.width; ++x) {
        sum += picture.at(x, y);
        moment += picture.at(x, y) * x;
    }
    return moment / sum;
}

/// Columns a row, and the largest distance of a row from the line.
std::pair<double, double> slope_of(const std::vector<double>& places) {
    const auto n = static_cast<double>(places.size());
    double x = 0, y = 0, xx = 0, xy = 0, worst = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
        const auto row = static_cast<double>(i);
        x += row, y += places[i], xx += row * row, xy += row * places[i];
    }
    const double slope = (n * xy - x * y) / (n * xx - x * x), offset = (y - slope * x) / n;
    for (std::size_t i = 0; i < places.size(); ++i)
        worst = std::max(worst, std::abs(places[i] - offset - slope * static_cast<double>(i)));
    return {slope, worst};
}

TEST(Exposures, OfAnEdgeThatMovesAreARampOfSpeedTimesExposure) {
    // 0.2 s for 1.6 m at 4 m: 600 px/s.
    for (const double exposure_s : {0.01, 0.02, 0.04}) {
        const double expected_px = 600.0 * exposure_s;
        Scenery moving{.begin = {}, .end = {half_wall(1, 0.8)}};
        moving.begin.movers = {half_wall(1, -0.8)};
        sensor::SensorSpec spec = quiet(exposure_s, 0.0);
        const Taken picture = taken(moving, spec);
        // The integral of the part between dark and light is half of the ramp's length, whatever its steps are.
        const double light = picture.at(size.width - 1, 120), dark = picture.at(0, 120);
        ASSERT_GT(light, 1000);
        int first = size.width, last = 0;
        double worst = 0.0;
        const double end_x = (size.width - 1) / 2.0 - 0.8 / 4.0 * focal_px;
        for (int x = 0; x < size.width; ++x) {
            const double share = (picture.at(x, 120) - dark) / (light - dark);
            if (share > 0.05) first = std::min(first, x);
            if (share < 0.95) last = std::max(last, x);
            worst = std::max(worst, std::abs(share - std::clamp((x - end_x) / expected_px, 0.0, 1.0)));
        }
        EXPECT_NEAR(last - first + 1, 0.9 * expected_px, 1.5) << exposure_s;
        EXPECT_LT(worst, 0.5 / std::min(expected_px, 32.0) * 2.0 + 0.05) << exposure_s;
    }
}

TEST(Exposures, OfACameraThatPansAreBlurredAsMuch) {
    // 60 deg/s, 20 ms: 1.2 deg.
    const double rate = std::numbers::pi / 3.0;
    Scenery panning{.begin = {}, .end = {}, .pose = turned(-rate * 0.2 + 0.02), .pose_at_end = turned(0.02)};
    panning.begin.objects = {half_wall()};
    const Taken picture = taken(panning, quiet(0.02, 0.0));
    std::vector<double> columns(size.width);
    for (int x = 0; x < size.width; ++x)
        for (int y = 0; y < size.height; ++y) columns[static_cast<std::size_t>(x)] += picture.at(x, y);
    // What is between dark and light makes a triangle with the ramp's length for its base.
    double light = 0.0, blurred = 0.0;
    for (int x = size.width - 100; x < size.width; ++x) light += columns[static_cast<std::size_t>(x)] / 100.0;
    for (int x = 100; x < size.width - 100; ++x)
        blurred += std::min(columns[static_cast<std::size_t>(x)], light - columns[static_cast<std::size_t>(x)]) / light;
    EXPECT_NEAR(4.0 * blurred, rate * 0.02 * focal_px, 0.4);
}

TEST(Exposures, OfRowsOneAfterTheOtherLeanByPanTimesRowTime) {
    for (const double deg_s : {60.0, 300.0}) {
        for (const auto antialias : {world::Antialias::none, world::Antialias::coverage}) {
            const double rate = deg_s * std::numbers::pi / 180.0, readout_s = 6.0 / deg_s;
            // The bar is ahead when the row in the middle counts.
            const double at_middle = rate * 0.5 * readout_s;
            Scenery panning{
                .begin = {}, .end = {}, .pose = turned(at_middle - rate * 0.2), .pose_at_end = turned(at_middle)};
            panning.begin.objects = {bar()};
            const Taken picture = taken(panning, quiet(1e-4, readout_s), {.antialias = antialias});
            std::vector<double> rows;
            for (int y = 0; y < size.height; ++y) rows.push_back(middle_of_row(picture, y));
            const auto [slope, worst] = slope_of(rows);
            const double expected = rate * focal_px * readout_s / size.height;
            // The tangent of the angle: a little more than the angle beside the middle.
            const double half = rate * readout_s / 2.0;
            const double stretched = expected * (1.0 + 0.2 * half * half * 3.0);
            EXPECT_NEAR(slope / stretched, 1.0, 0.01) << deg_s;
            EXPECT_LT(worst, 1.0) << deg_s;
            // Ids are where the picture shows them.
            int wrong = 0;
            for (int y = 0; y < size.height; ++y) {
                const int x = static_cast<int>(std::lround(rows[static_cast<std::size_t>(y)]));
                wrong += picture.id(x, y) != 1;
                wrong += picture.id(x - 12, y) != 0;
                wrong += picture.id(x + 12, y) != 0;
            }
            EXPECT_EQ(wrong, 0);
        }
    }
}

TEST(Exposures, OfAMoverBeforeAStandingCameraLeanToo) {
    // 24 m/s at 4 m: 1800 px/s, 20 ms: 36 px from the first row to the last.
    Scenery moving{.begin = {}, .end = {bar(1, -0.24)}};
    moving.begin.movers = {bar(1, 4.56)};
    moving.begin.objects = {
        instance_of(model_of(rectangle({8.0f, 0.0f, 0.0f}, {0.0f, -40.0f, 0.0f}, {0.0f, 0.0f, 40.0f}),
                             colored(glm::vec3(0.0f), true)),
                    glm::dvec3(0.0), 2)};
    const Taken picture = taken(moving, quiet(1e-3, 0.02));
    std::vector<double> rows;
    for (int y = 0; y < size.height; ++y) rows.push_back(middle_of_row(picture, y));
    const auto [slope, worst] = slope_of(rows);
    EXPECT_NEAR(slope / (1800.0 * 0.02 / size.height), 1.0, 0.01);
    EXPECT_LT(worst, 1.0);
}

TEST(Exposures, OfSeveralCamerasOfOneInstantAreAllOfThatInstant) {
    Scenery moving{.begin = {}, .end = {half_wall(1, 0.8)}};
    moving.begin.movers = {half_wall(1, -0.8)};
    auto [view, instant] = set_up(moving, quiet(0.004, 0.03), {});
    std::array<View, 3> views{view, view, view};
    for (std::size_t i = 0; i < views.size(); ++i) views[i].camera = CameraId{static_cast<std::uint32_t>(i + 1)};
    const auto by = drawer(2);
    by->begin_instant(instant);
    std::vector<frame::FrameRef> frames;
    by->draw(std::vector<const View*>{&views[0], &views[1], &views[2]}, 0, frames);
    ASSERT_EQ(frames.size(), 12u);
    for (const frame::FrameRef& frame : frames) EXPECT_EQ(frame->info().world_ns, now_ns);
}

TEST(Exposures, OfWhatStandsAreWhatTheyWereToTheByte) {
    Scenery standing{.begin = gallery(), .end = {}};
    for (const auto antialias : {world::Antialias::none, world::Antialias::coverage}) {
        const sensor::SensorSpec spec = sensor::sensor_preset(sensor::SensorPreset::imx219);
        const Taken with = taken(standing, spec, {.antialias = antialias});
        const Taken without = taken(standing, spec, {.antialias = antialias, .has_past = false});
        EXPECT_TRUE(std::ranges::equal(with.color->bytes(), without.color->bytes()));
        EXPECT_TRUE(std::ranges::equal(with.ids->bytes(), without.ids->bytes()));
    }
}

TEST(Exposures, AreTheSameWithAnyThreadsAndPartsAsInFull) {
    Scenery moving{.begin = gallery(), .end = {bar(90, -0.3)}};
    moving.begin.movers = {bar(90, 0.3)};
    for (const auto antialias : {world::Antialias::none, world::Antialias::coverage}) {
        const sensor::SensorSpec spec = sensor::sensor_preset(sensor::SensorPreset::imx219);
        const Taken one = taken(moving, spec, {.threads = 1, .antialias = antialias});
        const Taken three = taken(moving, spec, {.threads = 3, .antialias = antialias});
        EXPECT_TRUE(std::ranges::equal(one.color->bytes(), three.color->bytes()));
        EXPECT_TRUE(std::ranges::equal(one.numbers, three.numbers));
        EXPECT_TRUE(std::ranges::equal(one.ids->bytes(), three.ids->bytes()));
        // A camera that stands draws what stands once; one that is said to move by nothing to speak of draws all.
        Scenery drifting = moving;
        drifting.pose_at_end.position.x = 1e-12;
        sensor::SensorSpec exact = quiet(0.02, 0.02);
        const Taken parts = taken(moving, exact, {.antialias = antialias}),
                    full = taken(drifting, exact, {.antialias = antialias});
        int unlike = 0;
        for (std::size_t i = 0; i < parts.numbers.size(); ++i)
            unlike += std::abs(parts.numbers[i] - full.numbers[i]) > 1;
        EXPECT_EQ(unlike, 0);
    }
}

TEST(Exposures, LeaveNothingBehindInPicturesThatComeNext) {
    // Two things move far apart. Between them are statics, and what may move but stands reaches from one to the other.
    const auto beam = instance_of(model_of(rectangle({3.8f, 0.0f, 0.0f}, {0.0f, -1.5f, 0.0f}, {0.0f, 0.0f, 0.1f}),
                                           colored({0.2f, 0.3f, 0.8f}, true)),
                                  glm::dvec3(0.0), 92);
    Scenery moving{.begin = gallery(), .end = {bar(90, -0.6), bar(91, 1.1), beam}};
    moving.begin.movers = {bar(90, -1.1), bar(91, 0.6), beam};
    TestWorld wall;
    wall.objects = {half_wall()};
    const world::SnapshotRef next = wall.snapshot(now_ns);
    const auto picture_of = [](software::SoftwareDrawer& by, const world::SnapshotRef& instant, const View& view) {
        by.begin_instant(instant);
        std::vector<frame::FrameRef> frames;
        by.draw(std::vector<const View*>{&view}, 0, frames);
        return frames.at(0);
    };
    for (const auto antialias : {world::Antialias::none, world::Antialias::coverage}) {
        const View second = TestCamera{.size = size, .focal_px = focal_px, .antialias = antialias}.view(2);
        const auto expected = picture_of(*drawer(2), next, second);
        for (const std::int64_t layer_bytes : {std::int64_t{0}, std::int64_t{64} << 20}) {
            const auto [view, instant] = set_up(moving, quiet(0.02, 0.02), {.antialias = antialias, .has_ids = false});
            const auto by = drawer(2, layer_bytes);
            // The second picture makes a layer, the third is drawn over it.
            for (int n = 0; n < 3; ++n) picture_of(*by, instant, view);
            EXPECT_TRUE(std::ranges::equal(picture_of(*by, next, second)->bytes(), expected->bytes()))
                << to_string(antialias) << " " << layer_bytes;
        }
    }
}

/// Pictures of four instants, of colour and numbers, and what was kept meanwhile.
std::pair<std::vector<std::byte>, RenderCounters> four_pictures(const Scenery& scenery, const sensor::SensorSpec& spec,
                                                                const Wishes& wishes, std::int64_t layer_bytes) {
    View view = set_up(scenery, spec, wishes).view;
    const auto by = drawer(wishes.threads, layer_bytes);
    std::vector<std::byte> made;
    for (TimeNs at_ns = now_ns - 60 * ns_per_ms; at_ns <= now_ns; at_ns += 20 * ns_per_ms) {
        by->begin_instant(view.past->at(at_ns).snapshot);
        ++view.sequence;
        std::vector<frame::FrameRef> frames;
        by->draw(std::vector<const View*>{&view}, 0, frames);
        for (const frame::FrameRef& frame : frames)
            made.insert(made.end(), frame->bytes().begin(), frame->bytes().end());
    }
    return {made, by->counters()};
}

TEST(Exposures, OverALayerThatIsKeptAreThoseWithoutOne) {
    // A bar that moves, one of glass, and one that only may: over a scene with glass, before it and behind.
    world::Material glass = colored({0.3f, 0.9f, 0.5f});
    glass.alpha_mode = world::AlphaMode::blend;
    glass.base_color.a = 0.5f;
    const auto pane = [&](double y) {
        return instance_of(model_of(rectangle({3.5f, 0.0f, 0.0f}, {0.0f, -0.3f, 0.0f}, {0.0f, 0.0f, 0.4f}), glass),
                           glm::dvec3(0.0, y, 0.0), 91);
    };
    // The first crosses tiles of the picture while it is taken.
    Scenery scenery{.begin = gallery(), .end = {bar(90, -1.6), pane(0.5), bar(92, 0.8)}};
    scenery.begin.movers = {bar(90, 1.6), pane(-0.2), bar(92, 0.8)};
    const camera::Lens barrel =
        make_lens(camera::LensModel::plumb_bob, std::vector{-0.25, 0.05, 0.001, -0.001, 0.0}).value();
    sensor::SensorSpec still = sensor::sensor_preset(sensor::SensorPreset::imx219);
    still.exposure_s = 1e-6;
    still.readout_s = 0.0;
    sensor::SensorSpec rolling = still;
    rolling.exposure_s = 0.01;
    rolling.readout_s = 0.02;
    for (const sensor::SensorSpec& spec : {still, rolling}) {
        for (const auto quality : {world::Quality::simple, world::Quality::beautiful}) {
            for (const auto antialias : {world::Antialias::none, world::Antialias::coverage}) {
                for (const camera::Lens& lens : {camera::Lens{}, barrel}) {
                    const Wishes wishes{.threads = 2, .antialias = antialias, .lens = lens, .quality = quality};
                    const std::string what = std::to_string(*spec.exposure_s) + " " + std::string(to_string(quality)) +
                                             " " + std::string(to_string(antialias)) + " " +
                                             std::string(to_string(lens.model));
                    const auto [with, kept] = four_pictures(scenery, spec, wishes, std::int64_t{64} << 20);
                    const auto [without, none] = four_pictures(scenery, spec, wishes, 0);
                    EXPECT_TRUE(with == without) << what;
                    EXPECT_EQ(none.layers_drawn, 0u);
                    EXPECT_EQ(kept.layers_drawn, 1u);
                    // Gathered light is kept where there is room; any other part that lacks room in the end is given
                    // up in the middle of a picture, with all that was kept.
                    const std::int64_t ungathered = kept.layer_bytes - sensor::SiteLight::bytes_for(spec, size);
                    for (const std::int64_t room : {kept.layer_bytes - 1, ungathered - 1}) {
                        const auto [refused, left] = four_pictures(scenery, spec, wishes, room);
                        EXPECT_TRUE(refused == without) << what << ", refused";
                        EXPECT_EQ(left.layer_bytes, room < ungathered ? 0 : ungathered) << what;
                    }
                }
            }
        }
    }
}

TEST(Exposures, UnderALampOnTheMainsSwingAsTheClosedFormSays) {
    // Modulation left by an exposure: |sinc(hz T)|, docs/decisions/0163.
    const double expected[][2] = {{0.001, .984}, {0.002, .935}, {0.005, .637}, {0.00833, .191}, {0.010, 0.0},
                                  {0.012, .156}, {0.015, .212}, {0.020, 0.0},  {0.0333, .082}};
    TestWorld room;
    room.objects = {instance_of(
        model_of(rectangle({4.0f, 0.0f, 0.0f}, {0.0f, -40.0f, 0.0f}, {0.0f, 0.0f, 40.0f}), colored(glm::vec3(1.0f))))};
    room.environment.ambient_sky = room.environment.ambient_ground = glm::vec3(0.0f);
    room.lights = {light_of(world::LightType::directional, 0.5f, {}, {1.0, 0.0, 0.0})};
    room.lights[0].flicker_depth = 0.6f;
    for (const auto& [exposure_s, modulation] : expected) {
        sensor::SensorSpec spec = quiet(exposure_s, 0.04);
        spec.lux = 100.0 / exposure_s * 0.01;
        spec.pixel_pitch_m = 1e-5;
        const Taken picture = taken({.begin = room, .end = {}}, spec);
        double least = 1e9, most = 0.0;
        for (int y = 0; y < size.height; ++y) {
            double sum = 0.0;  // the noise of electrons averages out
            for (int x = 0; x < size.width; ++x) sum += picture.at(x, y);
            least = std::min(least, sum);
            most = std::max(most, sum);
        }
        EXPECT_NEAR((most - least) / (most + least) / 0.6, modulation, 0.02) << exposure_s;
    }
}

TEST(Exposures, ShowAStrobeInTheRowsThatCountThen) {
    // A wall 80 m wide that flies by: it is at the middle column from 185 to 190 ms.
    constexpr double exposure_s = 0.001, from_s = 0.185, to_s = 0.190;
    const double speed = 80.0 / (to_s - from_s);
    Scenery strobe{.begin = {}, .end = {half_wall(1, 80.0 - speed * (0.2 - from_s))}};
    strobe.begin.movers = {half_wall(1, 80.0 + speed * from_s)};
    const sensor::SensorSpec spec = quiet(exposure_s, 0.02);
    const Taken picture = taken(strobe, spec);
    const sensor::RowTimes times = spec.row_times(exposure_s, size.height, now_ns);
    int lit = 0, expected = 0;
    for (int row = 0; row < size.height; ++row) {
        const double begin_s = 1e-9 * static_cast<double>(times.begin_ns + row * times.row_ns);
        expected += begin_s + exposure_s > from_s && begin_s < to_s;
        lit += picture.at(160, row) > 10;
    }
    EXPECT_GT(expected, 60);
    EXPECT_NEAR(lit, expected, 1);
}

TEST(Exposures, AreSharesThatMakeAWhole) {
    for (const double readout_s : {0.0, 0.005, 0.02}) {
        for (const double exposure_s : {1e-6, 0.004, 0.03}) {
            const Moments moments(quiet(exposure_s, readout_s).row_times(exposure_s, size.height, now_ns), 100.0);
            EXPECT_LE(moments.count(), Moments::most_of_picture);
            for (int row = 0; row < size.height; ++row) {
                double sum = 0.0;
                for (int cell = 0; cell < moments.count(); ++cell) {
                    const auto [first, end] = moments.rows(cell);
                    const float weight = moments.weight(cell, row);
                    EXPECT_EQ(weight > 0.0f, row >= first && row < end);
                    sum += double{weight};
                }
                EXPECT_NEAR(sum, 1.0, 1e-5);
            }
        }
    }
}

/// A camera with an opening of 15 mm (f/2), whose pixels are a tenth of a millimetre.
sensor::SensorSpec focused(double focus_m) {
    sensor::SensorSpec spec = quiet(0.01, 0.0);
    spec.pixel_pitch_m = 1e-4;
    spec.focus_m = focus_m;
    return spec;
}

/// The circle of confusion at 4 m, in pixels.
double disc_px(double focus_m) {
    const double focal_m = 1.0 / (1.0 / (focal_px * 1e-4) + 1.0 / focus_m);
    return focal_m / 2.0 * focal_px * std::abs(1.0 / focus_m - 1.0 / 4.0);
}

/// Contrast at a frequency (cycles a pixel) of an edge through the middle that leans by `lean_rad`: ISO 12233, slanted
/// edge, with eight bins a pixel.
double contrast(const Taken& picture, double lean_rad, double frequency) {
    constexpr int per_px = 8, reach_px = 24;
    std::vector<double> sum(2 * reach_px * per_px), count(sum.size());
    for (int y = 0; y < size.height; ++y) {
        for (int x = 0; x < size.width; ++x) {
            const double beside =
                (x - (size.width - 1) / 2.0) * std::cos(lean_rad) + (y - (size.height - 1) / 2.0) * std::sin(lean_rad);
            const auto bin = static_cast<long>(std::floor((beside + reach_px) * per_px));
            if (bin < 0 || bin >= static_cast<long>(sum.size())) continue;
            sum[static_cast<std::size_t>(bin)] += picture.at(x, y);
            count[static_cast<std::size_t>(bin)] += 1.0;
        }
    }
    std::complex<double> at_frequency;
    for (std::size_t i = 0; i + 1 < sum.size(); ++i) {
        const double step = sum[i + 1] / count[i + 1] - sum[i] / count[i];
        at_frequency += std::polar(step, -2.0 * std::numbers::pi * frequency * static_cast<double>(i) / per_px);
    }
    const auto sinc = [](double f) { return f == 0.0 ? 1.0 : std::sin(std::numbers::pi * f) / (std::numbers::pi * f); };
    const double whole = sum.back() / count.back() - sum.front() / count.front();
    return std::abs(at_frequency) / std::abs(whole) / (sinc(frequency / per_px) * sinc(frequency / per_px));
}

TEST(Focus, AnEdgeHasTheContrastOfPixelAndDisc) {
    const double roll = 5.0 * std::numbers::pi / 180.0;
    const camera::Pose pose = camera::pose_from_angles(glm::dvec3(0.0), {.roll = roll}).value();
    Scenery standing{.begin = {}, .end = {}, .pose = pose, .pose_at_end = pose};
    standing.begin.objects = {half_wall()};
    const auto sinc = [](double f) { return f == 0.0 ? 1.0 : std::sin(std::numbers::pi * f) / (std::numbers::pi * f); };
    for (const bool has_past : {true, false}) {
        for (const double focus_m : {4.0, 100.0, 1.0, 0.5}) {
            const Taken picture =
                taken(standing, focused(focus_m), {.antialias = world::Antialias::coverage, .has_past = has_past});
            const double lean = contrast(picture, roll, 0.4) > contrast(picture, -roll, 0.4) ? roll : -roll;
            double worst = 0.0;
            for (double f = 0.02; f <= 0.5; f += 0.02) {
                const double z = std::numbers::pi * f * disc_px(focus_m);
                const double disc = z < 1e-6 ? 1.0 : std::abs(2.0 * std::cyl_bessel_j(1.0, z) / z);
                const double pixel = sinc(f * std::cos(roll)) * sinc(f * std::sin(roll));
                worst = std::max(worst, std::abs(contrast(picture, lean, f) - pixel * disc));
            }
            std::printf("focus %g m, disc %.2f px: contrast within %.4f\n", focus_m, disc_px(focus_m), worst);
            EXPECT_LT(worst, 0.02) << focus_m;
        }
    }
}

TEST(Focus, OfRowsThatMoveIsTheSameDiscAndLosesNoLight) {
    // As above, while the camera rises along the edge, row after row: nothing is seen of that but its work.
    Scenery rising{.begin = {}, .end = {}};
    rising.pose.position.z = -0.4;
    rising.begin.objects = {half_wall()};
    for (const bool blurs : {true, false}) {
        sensor::SensorSpec rows = focused(0.5), standing = focused(0.5);
        rows.readout_s = 0.03;
        rows.blur = blurs;
        const Taken moved = taken(rising, rows, {.antialias = world::Antialias::coverage});
        Scenery still = rising;
        still.pose = still.pose_at_end;
        const Taken stood = taken(still, standing, {.antialias = world::Antialias::coverage});
        const double light = stood.at(size.width - 1, 120);
        double worst = 0.0;
        for (int y = 0; y < size.height; ++y)
            for (int x = 0; x < size.width; ++x)
                worst = std::max(worst, std::abs(moved.at(x, y) - stood.at(x, y)) / light);
        EXPECT_LT(worst, 0.03) << blurs;
    }
}

TEST(Focus, ThroughALensTheMiddleIsSharpAtTheFocus) {
    const camera::Lens barrel{camera::LensModel::plumb_bob, {-0.3, 0.1, 0.0, 0.0, 0.0}};
    Scenery standing;
    standing.begin.objects = {half_wall()};
    const auto width_of_edge = [&](double focus_m, const camera::Lens& lens) {
        const Taken picture =
            taken(standing, focused(focus_m), {.antialias = world::Antialias::coverage, .lens = lens});
        int between = 0;
        const double light = picture.at(size.width - 1, 120);
        for (int x = 0; x < size.width; ++x) {
            const double share = picture.at(x, 120) / light;
            between += share > 0.02 && share < 0.98;
        }
        return between;
    };
    EXPECT_LE(width_of_edge(4.0, barrel), 2);
    EXPECT_EQ(width_of_edge(0.5, barrel), width_of_edge(0.5, {}));
    EXPECT_GE(width_of_edge(0.5, barrel), 6);
}

TEST(Focus, IsTheSameByAnyThreadsAndGrainOfTimes) {
    Scenery moving{.begin = {}, .end = {half_wall(1, 0.4)}};
    moving.begin.movers = {half_wall(1, -0.4)};
    const auto once = taken(moving, focused(1.0), {.threads = 1});
    EXPECT_EQ(once.numbers, taken(moving, focused(1.0), {.threads = 3}).numbers);
}

TEST(Focus, LeavesIdsAndDepthSharp) {
    Scenery standing;
    standing.begin.objects = {half_wall()};
    const Taken sharp = taken(standing, quiet(0.01, 0.0)), soft = taken(standing, focused(0.5));
    EXPECT_NE(sharp.numbers, soft.numbers);
    EXPECT_TRUE(std::ranges::equal(sharp.ids->bytes(), soft.ids->bytes()));
    EXPECT_TRUE(std::ranges::equal(sharp.depth->bytes(), soft.depth->bytes()));
}

}  // namespace
}  // namespace camrig::render::exposure_test

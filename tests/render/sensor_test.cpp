#include <algorithm>
#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "core/render/software/software_drawer.h"
#include "tests/render/support/gallery.h"
#include "tests/render/support/test_rig.h"

// Cameras with a sensor: what is measured of delivered frames is what was put in.
namespace camrig::render {
namespace {

constexpr ImageSize size{320, 240};
constexpr double well_e = 10'000.0;
constexpr double full_scale_s = 0.01;  // light 1 fills the wells

sensor::SensorSpec plain_mono() {
    sensor::SensorSpec spec;
    spec.filter = sensor::ColorFilter::mono;
    spec.full_well_e = well_e;
    spec.bits = 12;
    spec.white_balance_k = 6500.0;
    return spec;
}

sensor::SensorSpec noisy_mono() {
    sensor::SensorSpec spec = plain_mono();
    spec.read_noise_e = 6.0;
    return spec;
}

/// A wall of that light before the camera, all over the picture.
TestWorld wall(float light) {
    TestWorld world;
    world.objects.push_back(instance_of(model_of(
        rectangle({4.0f, 0.0f, 0.0f}, {0.0f, -40.0f, 0.0f}, {0.0f, 0.0f, 40.0f}), colored(glm::vec3(light), true))));
    return world;
}

View view_of(const sensor::SensorSpec& spec, std::int64_t sequence = 0,
             world::Antialias antialias = world::Antialias::none) {
    View view = TestCamera{.size = size, .focal_px = 300.0, .antialias = antialias}.view();
    auto with_sensor = std::make_shared<world::CameraSpec>(*view.spec);
    with_sensor->sensor = spec;
    view.spec = with_sensor;
    view.sequence = sequence;
    view.kinds[index_of(frame::FrameKind::sensor)] = true;
    return view;
}

struct Shown {
    frame::FrameRef color, raw;

    std::vector<double> numbers() const {
        std::vector<std::uint16_t> made(raw->bytes().size() / 2);
        std::memcpy(made.data(), raw->bytes().data(), raw->bytes().size());
        return {made.begin(), made.end()};
    }
    const SensorReading& reading() const { return *color->info().sensor; }
};

std::unique_ptr<software::SoftwareDrawer> drawer(int threads = 1) {
    software::SoftwareDrawer::Options options;
    options.pool = std::make_shared<frame::FramePool>();
    options.static_layer_bytes = std::int64_t{64} << 20;
    options.threads = threads;
    return std::make_unique<software::SoftwareDrawer>(options);
}

Shown shown(software::SoftwareDrawer& by, const world::SnapshotRef& snapshot, const View& view) {
    by.begin_instant(snapshot);
    std::vector<frame::FrameRef> frames;
    by.draw(std::vector<const View*>{&view}, 0, frames);
    Shown made;
    for (const frame::FrameRef& frame : frames)
        (frame->info().kind == frame::FrameKind::sensor ? made.raw : made.color) = frame;
    return made;
}

double mean_of(const std::vector<double>& values) {
    double sum = 0.0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
}

/// Of one picture, by the difference of two: what is the same in both does not count.
double variance_of(const std::vector<double>& a, const std::vector<double>& b) {
    const double offset = mean_of(a) - mean_of(b);
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i] - offset) * (a[i] - b[i] - offset);
    return sum / (2.0 * static_cast<double>(a.size() - 1));
}

TEST(DeliveredNumbers, HaveTheGainReadNoiseAndLinearityThatWerePutIn) {
    sensor::SensorSpec spec = noisy_mono();
    const auto by = drawer();
    const auto snapshot = wall(0.5f).snapshot();
    const auto taken = [&](double exposure_s, std::int64_t sequence) {
        spec.exposure_s = exposure_s;
        return shown(*by, snapshot, view_of(spec, sequence)).numbers();
    };
    constexpr int steps = 16;
    std::vector<double> means, variances;
    for (int i = 0; i < steps; ++i) {
        const double exposure_s = i == 0 ? 1e-6 : 2.0 * full_scale_s * 0.9 * i / (steps - 1);
        const auto a = taken(exposure_s, 2 * i), b = taken(exposure_s, 2 * i + 1);
        means.push_back((mean_of(a) + mean_of(b)) / 2.0);
        variances.push_back(variance_of(a, b));
    }
    double w = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
    for (std::size_t i = 0; i < means.size(); ++i) {
        const double weight = 1.0 / (variances[i] * variances[i]);
        w += weight, x += weight * means[i], y += weight * variances[i];
        xx += weight * means[i] * means[i], xy += weight * means[i] * variances[i];
    }
    const double gain = (w * xy - x * y) / (w * xx - x * x);
    EXPECT_NEAR(gain / spec.numbers_per_e(), 1.0, 0.01);
    EXPECT_NEAR(std::sqrt(variances[0] - 1.0 / 12.0) / gain / spec.read_noise_e, 1.0, 0.03);
    const double range = spec.max_number() - spec.black();
    for (std::size_t i = 1; i < means.size(); ++i) {
        const double expected = spec.black() + range * 0.9 * static_cast<double>(i) / (steps - 1);
        EXPECT_NEAR(means[i], expected, 0.002 * range) << i;
    }
}

TEST(DeliveredNumbers, AreOfLightThatIsNotClamped) {
    sensor::SensorSpec spec = plain_mono();
    spec.exposure_s = full_scale_s / 16.0;
    for (const auto antialias : {world::Antialias::none, world::Antialias::coverage}) {
        const auto seen = shown(*drawer(), wall(8.0f).snapshot(), view_of(spec, 0, antialias));
        EXPECT_NEAR(mean_of(seen.numbers()), 0.5 * spec.max_number(), 0.002 * spec.max_number());
    }
}

TEST(DeliveredNumbers, AtTheEdgeOfWhatIsBrightAreItsShareOfTheLight) {
    // A wall that ends in the middle of a column, before nothing.
    TestWorld world;
    world.environment.background = glm::vec3(0.0f);
    const auto end = static_cast<float>(4.0 / 300.0 * 0.5);
    world.objects.push_back(
        instance_of(model_of(rectangle({4.0f, end - 40.0f, 0.0f}, {0.0f, -40.0f, 0.0f}, {0.0f, 0.0f, 40.0f}),
                             colored(glm::vec3(8.0f), true))));
    sensor::SensorSpec spec = plain_mono();
    spec.exposure_s = full_scale_s / 16.0;
    const auto numbers = shown(*drawer(), world.snapshot(), view_of(spec, 0, world::Antialias::coverage)).numbers();
    std::vector<double> shares;
    for (int x = 0; x < size.width; ++x) {
        std::vector<double> column;
        for (int y = 0; y < size.height; ++y) column.push_back(numbers[static_cast<std::size_t>(y * size.width + x)]);
        shares.push_back(mean_of(column) / (0.5 * spec.max_number()));
    }
    // Left of it nothing, right of it all; what is between is of one column, and adds up to where the edge is.
    double sum = 0.0;
    for (const double share : shares) sum += share;
    EXPECT_NEAR(sum, size.width / 2 + 0.5 - 0.0, 0.02);
    EXPECT_NEAR(*std::ranges::max_element(shares), 1.0, 0.01);
}

TEST(DeliveredNumbers, OfWhatIsBlendedAreTheSumOfBothLights) {
    TestWorld world = wall(8.0f);
    world::Material glass = colored(glm::vec3(4.0f), true);
    glass.alpha_mode = world::AlphaMode::blend;
    glass.base_color.a = 0.25f;
    world.objects.push_back(instance_of(
        model_of(rectangle({2.0f, 0.0f, 0.0f}, {0.0f, -40.0f, 0.0f}, {0.0f, 0.0f, 40.0f}), glass), glm::dvec3(0.0), 2));
    sensor::SensorSpec spec = plain_mono();
    spec.exposure_s = full_scale_s / 16.0;
    const auto seen = shown(*drawer(), world.snapshot(), view_of(spec));
    EXPECT_NEAR(mean_of(seen.numbers()), (0.25 * 4.0 + 0.75 * 8.0) / 16.0 * spec.max_number(),
                0.002 * spec.max_number());
}

TEST(DeliveredNumbers, FollowTheLuxOfTheScene) {
    sensor::SensorSpec spec = plain_mono();
    spec.exposure_s = 0.001;
    TestWorld world = wall(0.5f);
    world.environment.lux = 1000.0;
    const double a = mean_of(shown(*drawer(), world.snapshot(), view_of(spec)).numbers());
    world.environment.lux = 2000.0;
    const double b = mean_of(shown(*drawer(), world.snapshot(), view_of(spec)).numbers());
    spec.lux = 1000.0;
    const double own = mean_of(shown(*drawer(), world.snapshot(), view_of(spec)).numbers());
    EXPECT_GT(a, 0.02 * spec.max_number());
    EXPECT_NEAR(b / a, 2.0, 0.01);
    EXPECT_NEAR(own / a, 1.0, 0.01);
}

TEST(TakenPictures, AreTheSameWithAnyThreads) {
    sensor::SensorSpec spec = sensor::sensor_preset(sensor::SensorPreset::imx219);
    const auto snapshot = gallery().snapshot();
    for (const auto antialias : {world::Antialias::none, world::Antialias::coverage}) {
        const View view = view_of(spec, 5, antialias);
        const Shown one = shown(*drawer(1), snapshot, view), three = shown(*drawer(3), snapshot, view);
        EXPECT_EQ(one.raw->info().format, frame::PixelFormat::bayer_rggb16);
        EXPECT_TRUE(std::ranges::equal(one.raw->bytes(), three.raw->bytes()));
        EXPECT_TRUE(std::ranges::equal(one.color->bytes(), three.color->bytes()));
        const Shown next = shown(*drawer(1), snapshot, view_of(spec, 6, antialias));
        EXPECT_FALSE(std::ranges::equal(one.raw->bytes(), next.raw->bytes())) << "noise is new in each picture";
    }
}

TEST(TakenPictures, DrawnAgainAreTheSameAndCountOnce) {
    sensor::SensorSpec spec = sensor::sensor_preset(sensor::SensorPreset::imx219);
    spec.exposure_s.reset();
    spec.white_balance_k.reset();
    const auto snapshot = wall(0.3f).snapshot();
    const auto film = [&](bool twice) {
        const auto by = drawer(), other = drawer();
        const auto state = std::make_shared<sensor::CameraSensor>();
        std::vector<double> exposures;
        for (std::int64_t n = 0; n < 40; ++n) {
            View view = view_of(spec, n);
            view.sensor = state;
            const Shown first = shown(*by, snapshot, view);
            exposures.push_back(first.reading().exposure_s);
            if (!twice) continue;
            const Shown again = shown(*other, snapshot, view);
            EXPECT_EQ(again.reading(), first.reading());
            EXPECT_TRUE(std::ranges::equal(again.color->bytes(), first.color->bytes()));
        }
        return exposures;
    };
    const std::vector<double> once = film(false);
    EXPECT_EQ(once, film(true));
    // Two frames of delay: the third is the first that the statistics of the first change.
    EXPECT_EQ(once[0], once[2]);
    EXPECT_NE(once[0], once[3]);
    EXPECT_NEAR(once[39] / once[38], 1.0, 0.05);
}

TEST(TakenPictures, OfACameraWithoutASensorThereAreNoNumbers) {
    View view = view_of(plain_mono());
    auto spec = std::make_shared<world::CameraSpec>(*view.spec);
    spec->sensor.reset();
    view.spec = spec;
    const Shown seen = shown(*drawer(), wall(0.5f).snapshot(), view);
    EXPECT_EQ(seen.raw, nullptr);
    ASSERT_NE(seen.color, nullptr);
    EXPECT_FALSE(seen.color->info().sensor);
}

}  // namespace
}  // namespace camrig::render

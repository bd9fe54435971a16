// What EMVA 1288 measures of a camera comes out as it was put in.
#include <cmath>

#include <gtest/gtest.h>

#include "tests/unit/sensor/flat_light.h"

namespace camrig::sensor {
namespace {

constexpr ImageSize size{640, 480};
constexpr double well_e = 10'000.0;
constexpr double full_scale_s = 0.01;  // light 1 fills the wells

SensorSpec noisy() {
    SensorSpec spec = plain_mono(well_e, 12);
    spec.read_noise_e = 6.0;
    spec.prnu = 0.01;
    spec.dsnu_e = 2.0;
    return spec;
}

struct Point {
    double exposure_s, mean, variance;
};

std::vector<Point> photon_transfer(const Sensor& sensor) {
    const GivenLight light(size, 1.0f);
    std::vector<Point> points;
    for (int i = 0; i < 16; ++i) {
        // Evenly to 150 % of the well; the first as good as dark.
        const double exposure_s = i == 0 ? 1e-6 : full_scale_s * 0.1 * i;
        const Numbers a = taken(sensor, light.light(), {.frame = 2 * i, .exposure_s = exposure_s});
        const Numbers b = taken(sensor, light.light(), {.frame = 2 * i + 1, .exposure_s = exposure_s});
        points.push_back({exposure_s, (mean_of(a) + mean_of(b)) / 2.0, variance_of(a, b)});
    }
    return points;
}

/// The slope of variance over mean, each point by the weight that its variance's error gives it.
double conversion_gain(const std::vector<Point>& points) {
    double w = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
    for (std::size_t i = 0; i <= 8; ++i) {
        const Point& p = points[i];
        const double weight = 1.0 / (p.variance * p.variance);
        w += weight, x += weight * p.mean, y += weight * p.variance;
        xx += weight * p.mean * p.mean, xy += weight * p.mean * p.variance;
    }
    return (w * xy - x * y) / (w * xx - x * x);
}

TEST(PhotonTransfer, ConversionGainReadNoiseAndFullWellComeOutAsPutIn) {
    const SensorSpec spec = noisy();
    const auto points = photon_transfer(sensor_of(spec, size));
    const double gain = conversion_gain(points);
    EXPECT_NEAR(gain / spec.numbers_per_e(), 1.0, 0.01);
    const double read_e = std::sqrt(points[0].variance - 1.0 / 12.0) / gain;
    EXPECT_NEAR(read_e / spec.read_noise_e, 1.0, 0.03);
    EXPECT_NEAR((points[15].mean - spec.black()) / gain / well_e, 1.0, 0.01);
    EXPECT_LT(points[15].variance, 0.05 * points[8].variance) << "a full well has no shot noise";
}

TEST(PhotonTransfer, GainMultipliesElectronsAndTheirNoise) {
    const SensorSpec spec = noisy();
    const Sensor sensor = sensor_of(spec, size);
    const GivenLight light(size, 0.1f);
    const Shot once{.frame = 1, .exposure_s = full_scale_s, .gain_db = 12.0};
    const Shot again{.frame = 2, .exposure_s = full_scale_s, .gain_db = 12.0};
    const Numbers a = taken(sensor, light.light(), once), b = taken(sensor, light.light(), again);
    const double factor = std::pow(10.0, 12.0 / 20.0), k = spec.numbers_per_e() * factor;
    EXPECT_NEAR((mean_of(a) - spec.black()) / (k * 0.1 * well_e), 1.0, 0.005);
    EXPECT_NEAR(variance_of(a, b) / (k * k * (0.1 * well_e + 36.0) + 1.0 / 12.0), 1.0, 0.01);
}

TEST(PhotonTransfer, NumbersAreLinearInExposureToTwoThousandths) {
    const auto points = photon_transfer(sensor_of(noisy(), size));
    double w = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
    for (std::size_t i = 0; i <= 9; ++i) {
        w += 1.0, x += points[i].exposure_s, y += points[i].mean;
        xx += points[i].exposure_s * points[i].exposure_s, xy += points[i].exposure_s * points[i].mean;
    }
    const double slope = (w * xy - x * y) / (w * xx - x * x), offset = (y - slope * x) / w;
    const double range = points[9].mean - points[0].mean;
    for (std::size_t i = 0; i <= 9; ++i)
        EXPECT_NEAR((points[i].mean - offset - slope * points[i].exposure_s) / range, 0.0, 0.002) << i;
}

TEST(PhotonTransfer, DarkCurrentGrowsWithExposureAndHasShotNoise) {
    SensorSpec spec = plain_mono(2000.0);
    spec.dark_e_per_s = 100.0;
    const Sensor sensor = sensor_of(spec, size);
    const GivenLight dark(size, 0.0f);
    for (const double exposure_s : {0.5, 2.0, 8.0}) {
        const Numbers a = taken(sensor, dark.light(), {.frame = 1, .exposure_s = exposure_s});
        const Numbers b = taken(sensor, dark.light(), {.frame = 2, .exposure_s = exposure_s});
        const double k = spec.numbers_per_e(), expected_e = 100.0 * exposure_s;
        EXPECT_NEAR(mean_of(a) / k, expected_e, 0.005 * expected_e);
        EXPECT_NEAR(variance_of(a, b) / (k * k), expected_e, 0.01 * expected_e);
    }
}

TEST(PhotonTransfer, FixedPatternsAreAsStrongAsTheySay) {
    SensorSpec spec = plain_mono(well_e);
    spec.prnu = 0.01;
    spec.dsnu_e = 20.0;
    const Sensor sensor = sensor_of(spec, size);
    const auto spread_e = [&](float level) {
        const GivenLight light(size, level);
        std::vector<double> sums(sensor.count());
        constexpr int frames = 16;
        for (int f = 0; f < frames; ++f) {
            const Numbers numbers = taken(sensor, light.light(), {.frame = f, .exposure_s = full_scale_s});
            for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += numbers[i] / spec.numbers_per_e() / frames;
        }
        double sum = 0.0, squares = 0.0;
        for (const double value : sums) sum += value, squares += value * value;
        const auto n = static_cast<double>(sums.size());
        const double shot = level * well_e / frames;
        return std::sqrt(squares / n - sum * sum / (n * n) - shot);
    };
    EXPECT_NEAR(spread_e(0.04f), std::hypot(20.0, 0.01 * 0.04 * well_e), 0.3);
    EXPECT_NEAR(spread_e(0.6f), std::hypot(20.0, 0.01 * 0.6 * well_e), 1.0);
}

}  // namespace
}  // namespace camrig::sensor

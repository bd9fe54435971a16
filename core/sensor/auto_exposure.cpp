#include "core/sensor/auto_exposure.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/base/portable_math.h"
#include "core/base/result.h"

namespace camrig::sensor {
namespace {

constexpr double db_per_e_fold = 8.685889638065036;  // 20 / ln(10)
/// Luminance that counts as none.
constexpr double dark = 1e-4;

/// Centre-weighted, the weights of rpi.agc from the middle outwards.
constexpr double zone_weights[FrameStatistics::rows][FrameStatistics::columns] = {
    {0, 1, 2, 1, 0}, {2, 3, 3, 3, 2}, {0, 1, 2, 1, 0}};

double factor_of(double gain_db) {
    return portable::exp(gain_db / db_per_e_fold);
}

/// Weighted mean luminance if light were so much stronger: zones saturate.
double metered(const FrameStatistics& statistics, const WhiteBalance& balance, double gain) {
    double sum = 0.0, weights = 0.0;
    for (std::size_t z = 0; z < statistics.zones.size(); ++z) {
        const auto light = [&](std::size_t c) {
            return std::min(statistics.zones[z][c] * balance.gains[c] * gain, 1.0);
        };
        const double weight = zone_weights[z / FrameStatistics::columns][z % FrameStatistics::columns];
        sum += weight * (0.299 * light(0) + 0.587 * light(1) + 0.114 * light(2));
        weights += weight;
    }
    return sum / weights;
}

}  // namespace

double ExposureSetting::total_s() const {
    return exposure_s * factor_of(gain_db);
}

AutoExposure::AutoExposure(const Options& options, const ExposureSetting& first) : options_(options) {
    CHECK(options.delay_frames >= 0 && options.delay_frames <= 8);
    settings_.assign(static_cast<std::size_t>(options.delay_frames) + 1, first);
    filtered_s_ = first.total_s();
}

void AutoExposure::advance(const FrameStatistics& statistics, const WhiteBalance& balance) {
    approach(target_s(statistics, balance));
    settings_.push_back(split(filtered_s_));
    settings_.pop_front();
    ++frames_;
}

double AutoExposure::longest_ahead_s() const {
    return std::ranges::max(settings_, {}, &ExposureSetting::exposure_s).exposure_s;
}

double AutoExposure::target_s(const FrameStatistics& statistics, const WhiteBalance& balance) {
    measured_ = metered(statistics, balance, 1.0);
    double gain = 1.0;
    // Several times: what saturates on the way no longer grows.
    for (int i = 0; i < 8; ++i) {
        const double step = std::min(options_.target / std::max(metered(statistics, balance, gain), dark), 10.0);
        gain *= step;
        if (step < 1.01) break;
    }
    if (options_.least_highlights > 0.0)
        gain = std::max(gain, options_.least_highlights / std::max(statistics.highlights, dark));
    return setting().total_s() * gain;
}

void AutoExposure::approach(double target_s) {
    target_s = std::clamp(target_s, options_.min_exposure_s, options_.max_exposure_s * factor_of(options_.max_gain_db));
    if (std::abs(target_s - filtered_s_) < options_.stable * filtered_s_) {
        ++stable_frames_;
        return;
    }
    stable_frames_ = 0;
    double speed = frames_ < options_.startup_frames ? 1.0 : options_.speed;
    if (std::abs(filtered_s_ - target_s) < 0.2 * target_s) speed = std::sqrt(speed);
    filtered_s_ += speed * (target_s - filtered_s_);
}

ExposureSetting AutoExposure::split(double total_s) const {
    // Exposure up to the step, then gain up to the step, then the next step.
    struct Step {
        double exposure_s, gain;
    };
    constexpr Step steps[] = {{100e-6, 1.0}, {10e-3, 2.0}, {30e-3, 4.0}, {60e-3, 6.0}, {10.0, 1e3}};
    const double max_gain = factor_of(options_.max_gain_db);
    double exposure_s = options_.min_exposure_s, gain = 1.0;
    for (const Step& step : steps) {
        exposure_s = std::max(std::min({step.exposure_s, options_.max_exposure_s, total_s / gain}), exposure_s);
        gain = std::max(std::min({step.gain, max_gain, total_s / exposure_s}), gain);
    }
    if (options_.flicker_hz > 0.0) {
        const double period_s = 0.5 / options_.flicker_hz;
        // A millionth more: an exposure of three periods is not two for rounding.
        if (exposure_s >= period_s) exposure_s = std::floor(exposure_s / period_s * (1.0 + 1e-6)) * period_s;
        gain = std::clamp(total_s / exposure_s, 1.0, max_gain);
    }
    return {exposure_s, portable::log(gain) * db_per_e_fold};
}

}  // namespace camrig::sensor

#include "core/sensor/auto_white_balance.h"

#include <algorithm>

namespace camrig::sensor {
namespace {

constexpr double darkest = 0.002, brightest = 0.95;
constexpr double neutral_k = 6500.0;

}  // namespace

AutoWhiteBalance::AutoWhiteBalance(const SensorSpec& spec, const Options& options)
    : options_(options), has_colors_(spec.filter != ColorFilter::mono) {
    const auto gains = WhiteBalance::of_kelvin(spec, neutral_k).gains;
    red_ = gains[0] / gains[1];
    blue_ = gains[2] / gains[1];
}

WhiteBalance AutoWhiteBalance::balance() const {
    return has_colors_ ? WhiteBalance::normalised({red_, 1.0, blue_}) : WhiteBalance{};
}

void AutoWhiteBalance::advance(const FrameStatistics& statistics) {
    double red = 0.0, green = 0.0, blue = 0.0;
    for (const auto& zone : statistics.zones) {
        const auto [low, high] = std::ranges::minmax(zone);
        if (low < darkest || high > brightest) continue;
        red += zone[0];
        green += zone[1];
        blue += zone[2];
    }
    const double speed = frames_++ < options_.startup_frames ? 1.0 : options_.speed;
    if (green == 0.0) return;
    const auto approach = [&](double& gain, double color) {
        const double wanted = std::clamp(green / color, 1.0 / options_.max_gain, options_.max_gain);
        gain += speed * (wanted - gain);
    };
    approach(red_, red);
    approach(blue_, blue);
}

}  // namespace camrig::sensor

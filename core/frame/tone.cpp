#include "core/frame/tone.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/base/black_body.h"
#include "core/frame/srgb.h"

namespace camrig::frame {
namespace {

using ToneCurve = std::array<std::uint8_t, 256>;

/// What each channel's light is multiplied by. Green keeps its value when the white balance changes.
std::array<double, 3> factors_of(const ImageControls& controls) {
    const double exposure = controls.auto_exposure ? 1 : std::exp2(controls.exposure_ev);
    const double light = exposure * std::pow(10, controls.gain_db / 20);
    std::array<double, 3> factors{light, light, light};
    if (controls.auto_white_balance) return factors;
    const auto balance = white_balance_of(controls.white_balance_k);
    for (std::size_t i : {0u, 2u}) factors[i] *= balance[i];
    return factors;
}

ToneCurve curve_of(double factor, const ImageControls& controls) {
    ToneCurve curve;
    for (std::size_t i = 0; i < curve.size(); ++i) {
        const double code = static_cast<double>(i) / 255;
        const double lit = factor == 1 ? code : srgb_of_linear(std::min(1.0, linear_of_srgb(code) * factor));
        const double toned = (lit - 0.5) * controls.contrast + 0.5 + controls.brightness;
        curve[i] = static_cast<std::uint8_t>(std::lround(std::clamp(toned, 0.0, 1.0) * 255));
    }
    return curve;
}

std::uint8_t saturated(int code, int luma, int factor_256) {
    return static_cast<std::uint8_t>(std::clamp(luma + (((code - luma) * factor_256 + 128) >> 8), 0, 255));
}

}  // namespace

bool changes_nothing(const ImageControls& controls) {
    const ImageControls none;
    return (controls.auto_exposure || controls.exposure_ev == 0) && controls.gain_db == 0 &&
           (controls.auto_white_balance || controls.white_balance_k == none.white_balance_k) &&
           controls.brightness == 0 && controls.contrast == 1 && controls.saturation == 1;
}

void apply_tone(std::span<std::byte> rgba, const ImageControls& controls) {
    if (changes_nothing(controls)) return;
    const auto factors = factors_of(controls);
    const std::array<ToneCurve, 3> curves{curve_of(factors[0], controls), curve_of(factors[1], controls),
                                          curve_of(factors[2], controls)};
    const int saturation_256 = static_cast<int>(std::lround(controls.saturation * 256));
    auto* const bytes = reinterpret_cast<std::uint8_t*>(rgba.data());
    for (std::size_t i = 0; i + 3 < rgba.size(); i += 4) {
        const int r = curves[0][bytes[i]], g = curves[1][bytes[i + 1]], b = curves[2][bytes[i + 2]];
        const int luma = (19595 * r + 38470 * g + 7471 * b + 32768) >> 16;
        bytes[i] = saturated(r, luma, saturation_256);
        bytes[i + 1] = saturated(g, luma, saturation_256);
        bytes[i + 2] = saturated(b, luma, saturation_256);
    }
}

}  // namespace camrig::frame

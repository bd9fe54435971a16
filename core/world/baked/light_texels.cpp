#include "core/world/baked/light_texels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <glm/glm.hpp>
#include <glm/gtc/packing.hpp>

#include "core/base/portable_math.h"

namespace camrig::world {
namespace {

/// Texels are kept as logarithms: 128 steps a doubling, so that a step is 1/180 of the value.
constexpr int steps_of_doubling = 128, least_doubling = -14, last_code = 128 * 30;

std::uint16_t code_of(float value) {
    if (!(value > 0.0f)) return 0;
    const double at =
        (portable::log(static_cast<double>(value)) / std::numbers::ln2 - least_doubling) * steps_of_doubling + 1.0;
    return static_cast<std::uint16_t>(std::clamp(std::lround(at), 0l, long{last_code}));
}
float value_of(std::uint16_t code) {
    if (code == 0) return 0.0f;
    return static_cast<float>(portable::exp(((code - 1.0) / steps_of_doubling + least_doubling) * std::numbers::ln2));
}

}  // namespace

/// Differences are small where light is smooth: green to the texel on the left, red and blue to their green.
std::vector<std::byte> pack_light_texels(std::span<const std::uint32_t> texels) {
    const std::size_t count = texels.size();
    std::vector<std::byte> bytes(bytes_of_light_texel * count);
    std::array<int, 3> last{};
    for (std::size_t i = 0; i < count; ++i) {
        const glm::vec3 value = glm::unpackF3x9_E1x5(texels[i]);
        const int green = code_of(value.g);
        const std::array<int, 3> now{green, code_of(value.r) - green, code_of(value.b) - green};
        for (std::size_t c = 0; c < 3; ++c) {
            const int step = now[c] - last[c];
            const auto folded = static_cast<std::uint16_t>(step >= 0 ? 2 * step : -2 * step - 1);
            bytes[(2 * c) * count + i] = static_cast<std::byte>(folded & 0xFF);
            bytes[(2 * c + 1) * count + i] = static_cast<std::byte>(folded >> 8);
        }
        last = now;
    }
    return bytes;
}

std::vector<std::uint32_t> unpack_light_texels(std::span<const std::byte> bytes) {
    static const std::vector<float> values = [] {
        std::vector<float> made;
        for (int code = 0; code <= last_code; ++code) made.push_back(value_of(static_cast<std::uint16_t>(code)));
        return made;
    }();
    const std::size_t count = bytes.size() / bytes_of_light_texel;
    std::vector<std::uint32_t> texels(count);
    std::array<int, 3> last{};
    const auto value = [](int code) { return values[static_cast<std::size_t>(std::clamp(code, 0, last_code))]; };
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            const int folded = std::to_integer<int>(bytes[2 * c * count + i]) |
                               std::to_integer<int>(bytes[(2 * c + 1) * count + i]) << 8;
            last[c] += (folded & 1) == 0 ? folded / 2 : -(folded + 1) / 2;
            last[c] = std::clamp(last[c], -2 * last_code, 2 * last_code);
        }
        texels[i] = glm::packF3x9_E1x5(glm::vec3(value(last[0] + last[1]), value(last[0]), value(last[0] + last[2])));
    }
    return texels;
}

}  // namespace camrig::world

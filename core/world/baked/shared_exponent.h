#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include <glm/glm.hpp>

/// Light in 32 bits: three mantissas of 9 bits, red lowest, and one exponent of 5 for all of them (OpenGL's
/// EXT_texture_shared_exponent, RGB9_E5). glm::packF3x9_E1x5 gives the same bits, by powf and log2f and thus in several
/// times the time.
namespace camrig::world {

namespace shared_exponent {
inline constexpr int mantissa_bits = 9, bias = 15, float_bias = 127, float_mantissa_bits = 23;
inline constexpr float most = 65408.0f;  ///< 511/512 of 2^16

/// number: -126 to 127.
constexpr float power_of_two(int number) {
    return std::bit_cast<float>((number + float_bias) << float_mantissa_bits);
}
}  // namespace shared_exponent

/// The nearest that can be told: what is negative is 0, what is over 65408 is that.
inline std::uint32_t packed_light(const glm::vec3& light) {
    using namespace shared_exponent;
    const glm::vec3 kept = glm::clamp(light, 0.0f, most);
    const float largest = std::max({kept.r, kept.g, kept.b});
    const int doublings = (std::bit_cast<std::int32_t>(largest) >> float_mantissa_bits) - float_bias;
    int exponent = std::max(-bias - 1, doublings) + 1;
    const auto mantissa = [&](float value) {
        return static_cast<std::int32_t>(value * power_of_two(mantissa_bits - exponent) + 0.5f);
    };
    if (mantissa(largest) >> mantissa_bits != 0) ++exponent;
    return static_cast<std::uint32_t>(mantissa(kept.r) | mantissa(kept.g) << mantissa_bits |
                                      mantissa(kept.b) << 2 * mantissa_bits) |
           static_cast<std::uint32_t>(exponent + bias) << 3 * mantissa_bits;
}

inline glm::vec3 unpacked_light(std::uint32_t packed) {
    using namespace shared_exponent;
    constexpr std::uint32_t mantissa = (1u << mantissa_bits) - 1;
    const glm::vec3 mantissas(packed & mantissa, packed >> mantissa_bits & mantissa,
                              packed >> 2 * mantissa_bits & mantissa);
    return mantissas * power_of_two(static_cast<int>(packed >> 3 * mantissa_bits) - bias - mantissa_bits);
}

}  // namespace camrig::world

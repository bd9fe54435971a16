#include "core/world/baked/light_bytes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <glm/glm.hpp>

#include "core/base/portable_math.h"
#include "core/world/baked/shared_exponent.h"

namespace camrig::world {
namespace {

/// Light is kept as logarithms: 128 steps a doubling, so that a step is 1/180 of the value.
constexpr int steps_of_doubling = 128, least_doubling = -14, last_code = 128 * 30;

std::uint16_t code_of(float value) {
    if (!(value > 0.0f)) return 0;
    const double at =
        (portable::log(static_cast<double>(value)) / std::numbers::ln2 - least_doubling) * steps_of_doubling + 1.0;
    return static_cast<std::uint16_t>(std::clamp(std::lround(at), 0l, long{last_code}));
}
using Values = std::array<float, last_code + 1>;
const Values& values_of_codes() {
    static const Values values = [] {
        Values made{};
        for (int at = 1; at <= last_code; ++at)
            made[static_cast<std::size_t>(at)] = static_cast<float>(
                portable::exp(((at - 1.0) / steps_of_doubling + least_doubling) * std::numbers::ln2));
        return made;
    }();
    return values;
}

/// The numbers that a color is kept as: green, and red and blue from there.
template <std::size_t Count>
void put_color(const glm::vec3& color, std::array<int, Count>& numbers) {
    numbers[0] = code_of(color.g);
    numbers[1] = code_of(color.r) - numbers[0];
    numbers[2] = code_of(color.b) - numbers[0];
}
template <std::size_t Count>
glm::vec3 color_of(const std::array<int, Count>& numbers, const Values& values) {
    const auto value_of = [&](int code) { return values[static_cast<std::size_t>(std::clamp(code, 0, last_code))]; };
    return {value_of(numbers[0] + numbers[1]), value_of(numbers[0]), value_of(numbers[0] + numbers[2])};
}

template <std::size_t Count>
using Numbers = std::array<int, Count>;

/// So many numbers of each of a row of things, by their steps from one thing to the next: of the first number all low
/// bytes, all high ones, and so on.
template <std::size_t Count, typename NumbersOf>
std::vector<std::byte> pack(std::size_t things, const NumbersOf& numbers_of) {
    std::vector<std::byte> bytes(2 * Count * things);
    Numbers<Count> last{};
    for (std::size_t i = 0; i < things; ++i) {
        const Numbers<Count> now = numbers_of(i);
        for (std::size_t c = 0; c < Count; ++c) {
            const int step = now[c] - last[c];
            const auto folded = static_cast<std::uint16_t>(step >= 0 ? 2 * step : -2 * step - 1);
            bytes[(2 * c) * things + i] = static_cast<std::byte>(folded & 0xFF);
            bytes[(2 * c + 1) * things + i] = static_cast<std::byte>(folded >> 8);
        }
        last = now;
    }
    return bytes;
}

template <std::size_t Count, typename Take>
void unpack(std::span<const std::byte> bytes, const Take& take) {
    const std::size_t things = bytes.size() / (2 * Count);
    Numbers<Count> last{};
    for (std::size_t i = 0; i < things; ++i) {
        for (std::size_t c = 0; c < Count; ++c) {
            const int folded = std::to_integer<int>(bytes[2 * c * things + i]) |
                               std::to_integer<int>(bytes[(2 * c + 1) * things + i]) << 8;
            last[c] += (folded & 1) == 0 ? folded / 2 : -(folded + 1) / 2;
            last[c] = std::clamp(last[c], -2 * last_code, 2 * last_code);
        }
        take(last);
    }
}

/// Of a probe: its mean, and then how light differs by direction.
constexpr std::size_t numbers_of_texel = bytes_of_light_texel / 2, numbers_of_probe = bytes_of_light_probe / 2;
constexpr float steps_of_mean = 256.0f, most_of_mean = 8.0f;

/// Calls visit(number, channel, value) for what a probe has beside its mean.
template <typename Probe, typename Visit>
void each_difference(Probe& probe, const Visit& visit) {
    std::size_t number = 3;
    const auto visit_channels = [&](auto& color) {
        for (glm::length_t c = 0; c < 3; ++c) visit(number++, c, color[c]);
    };
    for (glm::length_t axis = 0; axis < 3; ++axis) visit_channels(probe.along[axis]);
    for (auto& product : probe.products) visit_channels(product);
}

}  // namespace

std::vector<std::byte> pack_light_texels(std::span<const std::uint32_t> texels, int steps) {
    return pack<numbers_of_texel>(texels.size(), [&](std::size_t i) {
        Numbers<numbers_of_texel> numbers;
        put_color(unpacked_light(texels[i]), numbers);
        // Not each channel by itself: what is grey stays so.
        for (int& number : numbers) number = static_cast<int>(std::lround(static_cast<double>(number) / steps));
        return numbers;
    });
}

std::vector<std::uint32_t> unpack_light_texels(std::span<const std::byte> bytes, int steps) {
    const Values& values = values_of_codes();
    std::vector<std::uint32_t> texels;
    texels.reserve(bytes.size() / bytes_of_light_texel);
    const auto take = [&](const auto& numbers) { texels.push_back(packed_light(color_of(numbers, values))); };
    if (steps == fine_light_steps) {
        unpack<numbers_of_texel>(bytes, take);
    } else {
        unpack<numbers_of_texel>(bytes, [&](Numbers<numbers_of_texel> numbers) {
            for (int& number : numbers) number *= steps;
            take(numbers);
        });
    }
    return texels;
}

std::vector<std::byte> pack_light_probes(std::span<const LightProbe> probes) {
    return pack<numbers_of_probe>(probes.size(), [&](std::size_t i) {
        Numbers<numbers_of_probe> numbers{};
        const LightProbe& probe = probes[i];
        put_color(probe.mean, numbers);
        const glm::vec3 kept = color_of(numbers, values_of_codes());
        each_difference(probe, [&](std::size_t number, glm::length_t c, float value) {
            if (!(kept[c] > 0.0f)) return;
            const float share = std::clamp(value / probe.mean[c], -most_of_mean, most_of_mean);
            numbers[number] = static_cast<int>(std::lround(share * steps_of_mean));
        });
        return numbers;
    });
}

std::vector<LightProbe> unpack_light_probes(std::span<const std::byte> bytes) {
    const Values& values = values_of_codes();
    std::vector<LightProbe> probes;
    probes.reserve(bytes.size() / bytes_of_light_probe);
    unpack<numbers_of_probe>(bytes, [&](const auto& numbers) {
        LightProbe& probe = probes.emplace_back();
        probe.mean = color_of(numbers, values);
        each_difference(probe, [&](std::size_t number, glm::length_t c, float& value) {
            const auto steps = static_cast<float>(numbers[number]);
            value = probe.mean[c] * std::clamp(steps / steps_of_mean, -most_of_mean, most_of_mean);
        });
    });
    return probes;
}

std::vector<std::byte> pack_nearness(std::span<const std::uint16_t> nearness) {
    return pack<1>(nearness.size(), [&](std::size_t i) { return Numbers<1>{nearness[i]}; });
}

std::vector<std::uint16_t> unpack_nearness(std::span<const std::byte> bytes) {
    std::vector<std::uint16_t> nearness;
    nearness.reserve(bytes.size() / bytes_of_nearness);
    unpack<1>(bytes, [&](const auto& numbers) {
        nearness.push_back(static_cast<std::uint16_t>(std::clamp(numbers[0], 0, most_nearness)));
    });
    return nearness;
}

}  // namespace camrig::world

#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/world/baked/baked_light.h"

/// Light as it is in files: logarithms, of which 1/180 of a value is a step, from 2^-14 to 2^16. Each number is kept as
/// its difference to the one before, which packs well.
namespace camrig::world {

inline constexpr std::size_t bytes_of_light_texel = 6, bytes_of_light_probe = 54;

/// texels: as packed_light(). steps: of the logarithms that are kept as one; a mirror image, of which a surface sends
/// on some per cent, needs no more than every fourth.
inline constexpr int fine_light_steps = 1, mirror_light_steps = 4;
std::vector<std::byte> pack_light_texels(std::span<const std::uint32_t> texels, int steps = fine_light_steps);
std::vector<std::uint32_t> unpack_light_texels(std::span<const std::byte> bytes, int steps = fine_light_steps);

/// How light differs by direction is kept as a share of its mean, in steps of 1/256, up to 8.
std::vector<std::byte> pack_light_probes(std::span<const LightProbe> probes);
std::vector<LightProbe> unpack_light_probes(std::span<const std::byte> bytes);

/// Whole numbers of most_nearness.
inline constexpr std::size_t bytes_of_nearness = 2;
std::vector<std::byte> pack_nearness(std::span<const std::uint16_t> nearness);
std::vector<std::uint16_t> unpack_nearness(std::span<const std::byte> bytes);

}  // namespace camrig::world

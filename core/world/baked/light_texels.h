#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// Texels of a map of light as they are in files: logarithms, in differences, which pack well. 1/180 of a value is a
/// step; from 2^-14 to 2^16.
namespace camrig::world {

inline constexpr std::size_t bytes_of_light_texel = 6;

/// texels: as glm::packF3x9_E1x5.
std::vector<std::byte> pack_light_texels(std::span<const std::uint32_t> texels);
std::vector<std::uint32_t> unpack_light_texels(std::span<const std::byte> bytes);

}  // namespace camrig::world

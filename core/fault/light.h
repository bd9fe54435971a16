#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/image_size.h"

/// Arithmetic on coded pictures. The same bits on every processor.
namespace camrig::fault {

/// Linear light, 0 to 1, of an sRGB code (IEC 61966-2-1).
double light_of(int code);
/// The sRGB code of linear light, the nearest of a table of 4096; what is beyond 0 to 1 is cut.
int coded(double light);

/// Spreads 64 bits over all (splitmix64; Steele, Lea, Flood, OOPSLA 2014): random numbers of a counter where there are
/// millions of them.
constexpr std::uint64_t mixed(std::uint64_t bits) {
    bits += 0x9E3779B97F4A7C15u;
    bits = (bits ^ (bits >> 30)) * 0xBF58476D1CE4E5B9u;
    bits = (bits ^ (bits >> 27)) * 0x94D049BB133111EBu;
    return bits ^ (bits >> 31);
}

/// The sum of the eight bytes.
constexpr int byte_sum(std::uint64_t bits) {
    bits = (bits & 0x00FF00FF00FF00FFu) + ((bits >> 8) & 0x00FF00FF00FF00FFu);
    return static_cast<int>((bits * 0x0001000100010001u) >> 48);
}

/// Blurs an rgba8 picture in linear light by three means over squares (extended box filters; Gwosdek, Grewenig, Bruhn,
/// Weickert, SSVM 2011) that together have the variance of a disc of that radius, in pixels. Edges are continued by
/// their pixels. Alpha stays.
void blur(std::span<std::byte> rgba, ImageSize size, double radius);

}  // namespace camrig::fault

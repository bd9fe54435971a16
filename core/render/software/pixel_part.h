#pragma once

#include <cstdint>

/// Which part of a pixel something covers, and how deep it lies there (sample_places.h says where the coverage samples
/// are).
namespace camrig::render::software {

/// A bit for each coverage sample, from left to right.
using SampleMask = std::uint64_t;
inline constexpr SampleMask all_samples = ~SampleMask{0};
inline constexpr int sample_count = 64;
/// Samples lie at most so many 1/128 of a pixel's side from its centre, along each side.
inline constexpr int most_offset = sample_count - 1;

/// Depth about a pixel: at its centre, and the steps to the right and down, of 1/128 of its side each.
struct PixelPlane {
    float z = 0.0f, dx = 0.0f, dy = 0.0f;

    /// Depth differs so much from the centre's at most, at any sample.
    float reach() const { return most_offset * ((dx < 0.0f ? -dx : dx) + (dy < 0.0f ? -dy : dy)); }
};

}  // namespace camrig::render::software

#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "core/render/software/lanes.h"
#include "core/render/software/pixel_part.h"

/// The 64 coverage samples of a pixel: one in each of 64 columns and of 64 rows.
namespace camrig::render::software {

/// The row of each sample. Found by exchanging rows at random while that lowers the error of the area of a half plane
/// (simulated annealing): rms 0.0125, at most 0.049 over all angles and offsets; a grid of 8x8 has 0.0111 and 0.060,
/// the best lattice of 64 points 0.0116 and 0.073.
inline constexpr std::array<std::int32_t, sample_count> sample_rows{
    53, 16, 30, 10, 36, 22, 61, 46, 9,  57, 0,  42, 28, 37, 15, 47, 24, 5,  56, 32, 43, 6,
    20, 49, 12, 63, 26, 55, 41, 33, 18, 1,  45, 13, 54, 35, 4,  31, 17, 44, 7,  25, 62, 51,
    58, 8,  40, 19, 34, 23, 11, 27, 60, 39, 52, 2,  14, 48, 29, 59, 21, 38, 3,  50};

/// Of eight samples, from the pixel centre, in 1/128 of its side: whole odd numbers from -63 to 63.
inline constexpr int sample_groups = sample_count / lane_count;
inline constexpr int offset_in_subpixels = 2;  ///< so many subpixels (screen_triangles.h) each
CAMRIG_LANES IntLanes sample_x(int group) {
    return int_lane_numbers() * 2 + (2 * lane_count * group - most_offset);
}
CAMRIG_LANES IntLanes sample_y(int group) {
    return load_lanes(sample_rows.data() + lane_count * group) * 2 - most_offset;
}

/// An edge of a triangle at eight samples, less its value at the centre; both halved. dx, dy: its direction, in
/// subpixels. Within the guard (screen_triangles.h) that fits into 32 bits together with a centre that is no further
/// from the edge than the samples are: |y dx| + |x dy| <= 63 (2^23 + 2^23).
CAMRIG_LANES IntLanes half_edge_at(int group, std::int32_t dx, std::int32_t dy) {
    static_assert(offset_in_subpixels == 2);
    return sample_y(group) * dx - sample_x(group) * dy;
}

/// The samples where an edge is negative; value: at the pixel centre, less than all its samples reach.
template <typename Isa>
CAMRIG_LANES SampleMask places_outside(std::int32_t dx, std::int32_t dy, std::int64_t value) {
    const auto middle = static_cast<std::int32_t>(value >> 1);
    SampleMask made = 0;
    for (int group = 0; group < sample_groups; ++group)
        made |= SampleMask{Isa::bits(half_edge_at(group, dx, dy) + middle)} << (lane_count * group);
    return made;
}

CAMRIG_LANES int count_of(SampleMask mask) {
    return std::popcount(mask);
}

/// Those samples whose column, or whose row, has a bit set.
consteval std::array<SampleMask, 6> places_with_bit(bool of_rows) {
    std::array<SampleMask, 6> made{};
    for (std::size_t bit = 0; bit < made.size(); ++bit) {
        for (std::size_t i = 0; i < sample_count; ++i) {
            const auto number = of_rows ? static_cast<std::size_t>(sample_rows[i]) : i;
            made[bit] |= SampleMask{number >> bit & 1} << i;
        }
    }
    return made;
}

/// The mean of the samples of a mask that is not empty, in subpixels from the pixel centre.
struct SampleMean {
    double x, y;
};
CAMRIG_LANES SampleMean mean_of(SampleMask mask) {
    constexpr std::array<SampleMask, 6> columns = places_with_bit(false), rows = places_with_bit(true);
    int x = 0, y = 0;
    for (std::size_t bit = 0; bit < columns.size(); ++bit) {
        x += count_of(mask & columns[bit]) << bit;
        y += count_of(mask & rows[bit]) << bit;
    }
    const double scale = 2.0 * offset_in_subpixels / count_of(mask), middle = most_offset * offset_in_subpixels;
    return {x * scale - middle, y * scale - middle};
}

/// Where `a` lies in front of `b`. reach: of both together.
template <typename Isa>
CAMRIG_LANES SampleMask in_front(const PixelPlane& a, const PixelPlane& b, float reach) {
    const float z = a.z - b.z;
    if (z > reach) return all_samples;
    if (z < -reach) return 0;
    const float dx = a.dx - b.dx, dy = a.dy - b.dy;
    SampleMask made = 0;
    for (int group = 0; group < sample_groups; ++group) {
        const Lanes at = z + __builtin_convertvector(sample_x(group), Lanes) * dx +
                         __builtin_convertvector(sample_y(group), Lanes) * dy;
        made |= SampleMask{Isa::bits(at > 0.0f)} << (lane_count * group);
    }
    return made;
}

}  // namespace camrig::render::software

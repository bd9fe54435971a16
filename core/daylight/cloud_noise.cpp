#include "core/daylight/cloud_noise.h"

#include <algorithm>
#include <cstdint>

#include "core/base/random.h"

namespace camrig::daylight {
namespace {

constexpr int side = 512;  ///< of the tile, a power of two
constexpr float tile_m = 12e3f;
constexpr std::uint64_t noise_seed = 0x636c6f756473;
/// The tile again, so many times smaller and moved aside.
constexpr float detail_scale = 5.37f, detail_m = 3000.0f, detail_share = 0.16f;

/// Calls add(place, cell_x, cell_y, part_x, part_y) for all of the tile, cut into so many cells a side.
template <typename Add>
void for_each_place(int cells, Add add) {
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const float at_x = static_cast<float>(x * cells) / side, at_y = static_cast<float>(y * cells) / side;
            const int cell_x = x * cells / side, cell_y = y * cells / side;
            add(static_cast<std::size_t>(y * side + x), cell_x, cell_y, at_x - static_cast<float>(cell_x),
                at_y - static_cast<float>(cell_y));
        }
}

std::vector<float> random_numbers(int count, std::uint64_t stream) {
    std::vector<float> numbers(static_cast<std::size_t>(count));
    for (std::size_t i = 0; i < numbers.size(); ++i)
        numbers[i] = static_cast<float>(random_unit(noise_seed, stream, i));
    return numbers;
}

void add_values(std::vector<float>& tile, int cells, float weight) {
    const std::vector<float> corners = random_numbers(cells * cells, static_cast<std::uint64_t>(cells));
    const auto corner = [&](int x, int y) { return corners[static_cast<std::size_t>(y % cells * cells + x % cells)]; };
    const auto eased = [](float t) { return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f); };
    for_each_place(cells, [&](std::size_t place, int x, int y, float part_x, float part_y) {
        const float a = eased(part_x), b = eased(part_y);
        const float low = corner(x, y) + (corner(x + 1, y) - corner(x, y)) * a;
        const float high = corner(x, y + 1) + (corner(x + 1, y + 1) - corner(x, y + 1)) * a;
        tile[place] += weight * (low + (high - low) * b);
    });
}

/// Round heaps: 1 at a random point of each cell, less with the square of the distance to the nearest.
void add_heaps(std::vector<float>& tile, int cells, float weight) {
    const std::vector<float> across = random_numbers(cells * cells, 1000 + static_cast<std::uint64_t>(cells));
    const std::vector<float> down = random_numbers(cells * cells, 2000 + static_cast<std::uint64_t>(cells));
    for_each_place(cells, [&](std::size_t place, int x, int y, float part_x, float part_y) {
        float nearest2 = 1.0f;
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx) {
                const auto cell = static_cast<std::size_t>((y + dy + cells) % cells * cells + (x + dx + cells) % cells);
                const float to_x = static_cast<float>(dx) + across[cell] - part_x;
                const float to_y = static_cast<float>(dy) + down[cell] - part_y;
                nearest2 = std::min(nearest2, to_x * to_x + to_y * to_y);
            }
        tile[place] += weight * (1.0f - nearest2);
    });
}

}  // namespace

CloudNoise::CloudNoise() : tile_(std::size_t{side} * side, 0.0f) {
    add_values(tile_, 6, 0.275f);
    add_values(tile_, 12, 0.15f);
    add_values(tile_, 24, 0.075f);
    add_heaps(tile_, 14, 0.25f);
    add_heaps(tile_, 28, 0.15f);
    add_heaps(tile_, 60, 0.10f);
    const auto [least, most] = std::ranges::minmax_element(tile_);
    const float low = *least, inverse = 1.0f / (*most - *least);
    for (float& value : tile_) value = (value - low) * inverse;
}

float CloudNoise::at(float x, float y) const {
    constexpr float per_m = side / tile_m;
    const float u = x * per_m, v = y * per_m;
    const auto floor_of = [](float value) {
        const int whole = static_cast<int>(value);
        return whole - (value < static_cast<float>(whole) ? 1 : 0);
    };
    const int whole_u = floor_of(u), whole_v = floor_of(v);
    const float part_u = u - static_cast<float>(whole_u), part_v = v - static_cast<float>(whole_v);
    constexpr int mask = side - 1;
    const auto low = static_cast<std::size_t>((whole_v & mask) * side);
    const auto high = static_cast<std::size_t>(((whole_v + 1) & mask) * side);
    const auto left = static_cast<std::size_t>(whole_u & mask), right = static_cast<std::size_t>((whole_u + 1) & mask);
    const float below = tile_[low + left] + (tile_[low + right] - tile_[low + left]) * part_u;
    const float above = tile_[high + left] + (tile_[high + right] - tile_[high + left]) * part_u;
    return below + (above - below) * part_v;
}

float CloudNoise::detailed_at(float x, float y) const {
    return at(x, y) + detail_share * (at(detail_scale * x + detail_m, detail_scale * y) - 0.5f);
}

}  // namespace camrig::daylight

#include "control/onvif/picture_watch.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "core/base/result.h"

namespace camrig::onvif {
namespace {

struct Measured {
    std::vector<double> cells;  ///< mean luma
    double mean = 0.0;
    double edges = 0.0;  ///< share of pixels that differ from their left neighbour by PictureWatch::edge and more
};

/// BT.601 in 1/256.
int luma_of(const std::uint8_t* pixel) {
    return (77 * pixel[0] + 150 * pixel[1] + 29 * pixel[2]) >> 8;
}

Measured measure(std::span<const std::byte> rgba, ImageSize size) {
    const int columns = std::min(PictureWatch::columns, size.width), rows = std::min(PictureWatch::rows, size.height);
    std::vector<std::int64_t> sums(static_cast<std::size_t>(columns * rows)), counts(sums.size());
    std::vector<std::size_t> column_of(static_cast<std::size_t>(size.width));
    for (int x = 0; x < size.width; ++x)
        column_of[static_cast<std::size_t>(x)] = static_cast<std::size_t>(std::int64_t{x} * columns / size.width);
    std::int64_t total = 0, edges = 0;
    const auto* pixel = reinterpret_cast<const std::uint8_t*>(rgba.data());
    for (int y = 0; y < size.height; ++y) {
        const auto row = static_cast<std::size_t>(std::int64_t{y} * rows / size.height * columns);
        int left = luma_of(pixel);
        for (const std::size_t column : column_of) {
            const int luma = luma_of(pixel);
            sums[row + column] += luma;
            ++counts[row + column];
            total += luma;
            edges += std::abs(luma - left) >= PictureWatch::edge;
            left = luma;
            pixel += 4;
        }
    }
    const double pixels = static_cast<double>(size.width) * size.height;
    Measured made{
        .cells = {}, .mean = static_cast<double>(total) / pixels, .edges = static_cast<double>(edges) / pixels};
    for (std::size_t i = 0; i < sums.size(); ++i)
        made.cells.push_back(static_cast<double>(sums[i]) / static_cast<double>(counts[i]));
    return made;
}

}  // namespace

const PictureFacts& PictureWatch::see(std::span<const std::byte> rgba, ImageSize size, TimeNs world_ns) {
    CHECK(size.width > 0 && size.height > 0);
    CHECK(rgba.size() == std::size_t{4} * static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height));
    if (world_ns_ && (world_ns < *world_ns_ || size != size_)) *this = PictureWatch();
    if (world_ns_ == world_ns) return facts_;
    Measured now = measure(rgba, size);
    std::size_t changed = 0;
    for (std::size_t i = 0; i < cells_.size(); ++i) changed += std::abs(now.cells[i] - cells_[i]) > change;
    if (changed >= std::min<std::size_t>(least_cells, now.cells.size())) moved_ns_ = world_ns;
    if (static_cast<double>(changed) >= most_cells * static_cast<double>(now.cells.size())) changed_ns_ = world_ns;
    const auto is_held = [&](const std::optional<TimeNs>& since) { return since && world_ns - *since < hold_ns; };
    facts_.motion = is_held(moved_ns_);
    facts_.scene_change = is_held(changed_ns_);
    facts_.too_dark = now.mean < dark + (facts_.too_dark ? hysteresis : 0.0);
    facts_.too_bright = now.mean > bright - (facts_.too_bright ? hysteresis : 0.0);
    facts_.too_blurry = !facts_.too_dark && now.edges < blurry_share;
    cells_ = std::move(now.cells);
    size_ = size;
    world_ns_ = world_ns;
    return facts_;
}

}  // namespace camrig::onvif

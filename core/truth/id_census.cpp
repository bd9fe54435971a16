#include "core/truth/id_census.h"

#include <algorithm>

#include "core/base/result.h"

namespace camrig::truth {
namespace {

/// A rectangle while it grows; ends are exclusive.
struct Extent {
    std::int64_t pixels = 0;
    int left = 0, top = 0, right = 0, bottom = 0;
};

}  // namespace

std::unordered_map<std::uint32_t, IdCount> count_ids(std::span<const std::uint32_t> ids, ImageSize size) {
    CHECK(std::ssize(ids) == size.pixels());
    std::unordered_map<std::uint32_t, Extent> extents;
    for (int y = 0; y < size.height; ++y) {
        const auto row = ids.subspan(static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width),
                                     static_cast<std::size_t>(size.width));
        // Run by run: an object covers many neighbours.
        for (auto run = row.begin(); run != row.end();) {
            const auto end = std::find_if(run, row.end(), [id = *run](std::uint32_t other) { return other != id; });
            const int left = static_cast<int>(run - row.begin()), right = static_cast<int>(end - row.begin());
            if (*run != 0) {
                const auto [found, is_new] = extents.try_emplace(*run, Extent{0, left, y, right, y + 1});
                Extent& extent = found->second;
                extent.pixels += right - left;
                extent.left = std::min(extent.left, left);
                extent.right = std::max(extent.right, right);
                extent.bottom = y + 1;
            }
            run = end;
        }
    }
    std::unordered_map<std::uint32_t, IdCount> counts;
    for (const auto& [id, e] : extents) counts[id] = {e.pixels, {e.left, e.top, e.right - e.left, e.bottom - e.top}};
    return counts;
}

std::unordered_map<std::uint32_t, std::int64_t> count_soiled(std::span<const std::uint32_t> ids,
                                                             std::span<const std::uint8_t> mask) {
    CHECK(ids.size() == mask.size());
    std::unordered_map<std::uint32_t, std::int64_t> counts;
    for (std::size_t i = 0; i < ids.size(); ++i)
        if (mask[i] > 127 && ids[i] != 0) ++counts[ids[i]];
    return counts;
}

frame::Silhouette silhouette_of(std::span<const std::uint32_t> ids, std::uint32_t id, const PixelBox& box,
                                ImageSize size) {
    CHECK(std::ssize(ids) == size.pixels());
    frame::Silhouette runs;
    for (int y = box.y; y < box.y + box.height; ++y) {
        const std::uint32_t* const row = ids.data() + std::ptrdiff_t{y} * size.width;
        const int end = box.x + box.width;
        for (int x = box.x; x < end;) {
            const int x0 = static_cast<int>(std::find(row + x, row + end, id) - row);
            x = x0;
            while (x < end && row[x] == id) ++x;
            if (x > x0) runs.push_back({y, x0, x});
        }
    }
    return runs;
}

std::uint32_t main_occluder(std::span<const std::uint32_t> ids, const frame::Silhouette& silhouette, std::uint32_t id,
                            ImageSize size) {
    CHECK(std::ssize(ids) == size.pixels());
    std::unordered_map<std::uint32_t, std::int64_t> covered;
    for (const frame::PixelRun& run : silhouette) {
        const std::uint32_t* const row = ids.data() + std::ptrdiff_t{run.y} * size.width;
        for (int x = run.x0; x < run.x1;) {
            const std::uint32_t shown = row[x];
            const int begin = x;
            while (x < run.x1 && row[x] == shown) ++x;
            if (shown != id && shown != 0) covered[shown] += x - begin;
        }
    }
    std::uint32_t most = 0;
    std::int64_t pixels = 0;
    for (const auto& [other, count] : covered) {
        if (count < pixels || (count == pixels && other > most)) continue;
        most = other;
        pixels = count;
    }
    return most;
}

}  // namespace camrig::truth

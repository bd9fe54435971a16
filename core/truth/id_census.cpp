#include "core/truth/id_census.h"

#include <algorithm>

#include "core/base/result.h"

namespace camrig {
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

std::uint32_t main_occluder(std::span<const std::uint32_t> scene, std::span<const std::uint32_t> alone,
                            std::uint32_t id, const PixelBox& box, ImageSize size) {
    CHECK(std::ssize(scene) == size.pixels() && scene.size() == alone.size());
    std::map<std::uint32_t, std::int64_t> covered;
    for (int y = box.y; y < box.y + box.height; ++y) {
        const auto row = static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width);
        for (int x = box.x; x < box.x + box.width; ++x) {
            const std::size_t i = row + static_cast<std::size_t>(x);
            if (alone[i] == id && scene[i] != id && scene[i] != 0) ++covered[scene[i]];
        }
    }
    const auto most = std::ranges::max_element(covered, {}, [](const auto& entry) { return entry.second; });
    return most == covered.end() ? 0 : most->first;
}

}  // namespace camrig

#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <unordered_map>

#include "core/base/image_size.h"
#include "core/truth/truth.h"

namespace camrig {

/// What an instance picture shows of one object.
struct IdCount {
    std::int64_t pixels = 0;
    PixelBox box;
};

/// Counts an instance picture (rows from the top, no padding). 0, which is nothing, is left out.
std::unordered_map<std::uint32_t, IdCount> count_ids(std::span<const std::uint32_t> ids, ImageSize size);

/// The object in `scene` that shows on most of the pixels where `alone` has `id` and `scene` has not; 0 when there are
/// none, or nothing but background shows on them. Of equals, the smaller number. Only pixels inside `box` are looked
/// at.
std::uint32_t main_occluder(std::span<const std::uint32_t> scene, std::span<const std::uint32_t> alone,
                            std::uint32_t id, const PixelBox& box, ImageSize size);

}  // namespace camrig

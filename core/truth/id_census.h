#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>

#include "core/base/image_size.h"
#include "core/frame/frame.h"
#include "core/frame/silhouette.h"
#include "core/truth/truth.h"

namespace camrig::truth {

/// What an instance picture shows of one object.
struct IdCount {
    std::int64_t pixels = 0;
    PixelBox box;
};

/// The pixels of an instance picture.
inline std::span<const std::uint32_t> ids_of(const frame::Frame& frame) {
    return {reinterpret_cast<const std::uint32_t*>(frame.bytes().data()), frame.bytes().size() / sizeof(std::uint32_t)};
}

/// Counts an instance picture (rows from the top, no padding). 0, which is nothing, is left out.
std::unordered_map<std::uint32_t, IdCount> count_ids(std::span<const std::uint32_t> ids, ImageSize size);

/// How many pixels of each are under more than a half of the mask (hidden_mask(), a byte a pixel). 0 is left out.
std::unordered_map<std::uint32_t, std::int64_t> count_soiled(std::span<const std::uint32_t> ids,
                                                             std::span<const std::uint8_t> mask);

/// The runs of `id` in an instance picture, in the rows and columns of the box.
frame::Silhouette silhouette_of(std::span<const std::uint32_t> ids, std::uint32_t id, const PixelBox& box,
                                ImageSize size);

/// The object that shows on most of those pixels of a silhouette where not `id` does; 0 when there are none, or nothing
/// but background shows on them. Of equals, the smaller number.
std::uint32_t main_occluder(std::span<const std::uint32_t> ids, const frame::Silhouette& silhouette, std::uint32_t id,
                            ImageSize size);

}  // namespace camrig::truth

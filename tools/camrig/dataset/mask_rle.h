#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>

#include "core/base/image_size.h"

namespace camrig::cli {

/// The mask of every id in an instance picture (rows from the top, no padding; 0 is nothing and left out) in COCO's
/// compressed run-length encoding: the `counts` of a segmentation {"size": [height, width], "counts": "..."}, as
/// pycocotools reads it. Source: the format of cocoapi's maskApi.h, written from its description.
std::unordered_map<std::uint32_t, std::string> coco_masks(std::span<const std::uint32_t> ids, ImageSize size);

}  // namespace camrig::cli

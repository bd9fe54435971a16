#pragma once

#include <span>
#include <string_view>

#include "core/world/gltf/limits.h"
#include "core/world/model.h"

namespace camrig::world::gltf {

/// Decodes a PNG or JPEG picture (told apart by its first bytes) to 8-bit RGBA. Colour profiles are ignored, as glTF
/// 2.0, 3.8.1 asks. Pictures over 16384 x 16384, and pictures that cannot be as large as they claim given their bytes,
/// are refused before memory is taken. Throws Failure.
Image decode_image(std::span<const std::byte> bytes, std::string_view place, Budget& budget);

/// What decode_image would find, by the first bytes alone; the same pictures are refused. Throws Failure.
ImageSize image_size(std::span<const std::byte> bytes, std::string_view place);

/// A picture of one channel of 16 bits.
struct Gray16 {
    ImageSize size;
    std::vector<std::uint16_t> values;
};

/// Decodes a PNG of 16-bit gray; others are refused. The same bounds. Throws Failure.
Gray16 decode_gray16(std::span<const std::byte> bytes, std::string_view place, Budget& budget);

}  // namespace camrig::world::gltf

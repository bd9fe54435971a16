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

}  // namespace camrig::world::gltf

#pragma once

#include "core/world/model.h"

namespace camrig::world {

/// The picture in another size: each pixel is the mean, in linear light, of what lies under it. Opaque. Of the same
/// size the bytes are the same. The same bytes on every machine.
Image scaled_picture(const Image& picture, ImageSize to);

}  // namespace camrig::world

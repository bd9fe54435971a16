#pragma once

#include <string>

#include "core/base/image_size.h"

namespace camrig::http {

/// The head of a NumPy .npy file, version 1.0, of little-endian float32 [height, width] in C order, or of several
/// numbers a pixel, [height, width, channels]; the pixels follow as they are. Source: numpy.lib.format. Its length is a
/// multiple of 64, so that the pixels may be mapped.
std::string npy_float32_head(ImageSize size, int channels = 1);

}  // namespace camrig::http

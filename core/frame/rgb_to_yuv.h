#pragma once

#include <cstddef>

#include "core/frame/yuv_matrix.h"

namespace camrig::frame {

/// The row kernels of the colour conversion: BT.601 (Kr 0.299, Kb 0.114) on sRGB codes, 16-bit fixed point, rounded to
/// nearest. Integer arithmetic only: the same bytes on every machine and with every instruction set.
///
/// Own code, because libyuv (Debian 12: 2023-01-23) is fast and coarse here: against exact arithmetic its limited
/// range Y is off by up to 0.76 with a bias of 0.07, U and V by up to 1.6 with a bias of -0.5 codes (the rounding is
/// missing). These are within 0.51 and free of bias (YuvConversion tests).
///
/// A row is `width` pixels of R G B A bytes; U and V rows have (width + 1) / 2 codes. No alignment is needed.
void luma_row(YuvRange range, const std::byte* rgba, int width, std::byte* y);

/// The codes of the mean of each 2x2 block of two rows; an odd last column counts twice. Pass a row twice for 4:2:2
/// or for an odd last row.
void chroma_row(YuvRange range, const std::byte* rgba_0, const std::byte* rgba_1, int width, std::byte* u,
                std::byte* v);

}  // namespace camrig::frame

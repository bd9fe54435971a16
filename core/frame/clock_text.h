#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <utility>

#include "core/base/image_size.h"
#include "core/base/time.h"

namespace camrig::frame {

/// The time that cameras burn into their pictures, for people and for programs that read it there. Days and the time of
/// that day, of a time in nanoseconds: " 00002 07:59:59.980", "-00001 23:59:59.980" of 20 ms before time 0. White on
/// black in the lower left corner, 5 x 7 cells a character and a cell between, cells of max(1, width / 320) pixels.
std::string clock_text(TimeNs time_ns);
/// The rows of a picture of that size that the text is in: first, end.
std::pair<int, int> clock_text_rows(ImageSize size);
/// Draws over an rgba8 picture. What does not fit is left out.
void draw_clock_text(std::span<std::byte> rgba, ImageSize size, TimeNs time_ns);

}  // namespace camrig::frame

#pragma once

#include <cstddef>
#include <span>

#include "core/base/image_size.h"
#include "core/fault/fault_plan.h"

/// Layers optics and sensor: what becomes of a picture's pixels. Pure functions.
namespace camrig::fault {

/// Whether pixels change at all.
bool changes_picture(const FrameFaults& faults);
/// Whether every picture becomes the same one, so that none need be drawn.
bool hides_picture(const FrameFaults& faults);
/// So many rows, from below, are those of the frame before.
int torn_rows(const FrameFaults& faults, int height);
/// Changes an rgba8 picture, rows without padding. Alpha stays as it is.
void change_picture(const FrameFaults& faults, ImageSize size, std::span<std::byte> rgba);

}  // namespace camrig::fault

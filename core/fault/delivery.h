#pragma once

#include <string_view>

#include "core/fault/fault_plan.h"

/// Layer driver: whether a frame comes, and whose picture it has. Pure functions.
namespace camrig::fault {

/// The frame does not come.
bool is_dropped(const FrameFaults& faults);

/// The frame has the picture that the camera showed last, which is of world time `shown_ns`.
bool is_repeat(const FrameFaults& faults, TimeNs shown_ns);

/// So many later frames are due before this one comes to readers of that output.
std::int64_t frames_late(const FrameFaults& faults, std::string_view output);

}  // namespace camrig::fault

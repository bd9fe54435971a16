#pragma once

#include "core/fault/fault_plan.h"

/// Layer driver: whether a frame comes, and whose picture it has. Pure functions.
namespace camrig::fault {

/// The frame does not come.
bool is_dropped(const FrameFaults& faults);

/// The frame has the picture that the camera showed last, which is of world time `shown_ns`.
bool is_repeat(const FrameFaults& faults, TimeNs shown_ns);

}  // namespace camrig::fault

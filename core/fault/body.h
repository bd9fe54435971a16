#pragma once

#include "core/camera/pose.h"
#include "core/fault/fault_plan.h"

/// Layer body: where a camera that was knocked looks. A pure function.
namespace camrig::fault {

/// world_from_link as these faults make it at a world time, of what it is believed to be.
camera::Pose moved(const FrameFaults& faults, const camera::Pose& believed);
bool moves_body(const FrameFaults& faults);

}  // namespace camrig::fault

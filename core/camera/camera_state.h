#pragma once

#include <optional>

#include "core/base/clock_reading.h"
#include "core/base/time.h"
#include "core/camera/intrinsics.h"
#include "core/camera/pose.h"
#include "core/camera/ptz_status.h"

namespace camrig::camera {

/// What changes of a camera with time, at one world time.
struct CameraState {
    TimeNs world_ns = 0;                ///< the time; frames that show it are stamped with it
    Pose pose;                          ///< world_from_link
    std::optional<Pose> believed_pose;  ///< where its calibration takes it to be; nullopt: there it is
    Intrinsics intrinsics;
    std::optional<PtzStatus> head;      ///< of a camera that is on one; pose and intrinsics are what it makes of them
    std::optional<ClockReading> clock;  ///< what its own clock says; nullopt: it has none
    friend bool operator==(const CameraState&, const CameraState&) = default;
};

}  // namespace camrig::camera

#pragma once

#include "core/camera/pose.h"
#include "core/camera/ptz_status.h"

namespace camrig::camera {

/// A pan/tilt head that stands as `base` says: it pans about the z of the frame that `base` is given in (the world's or
/// its mount's), and tilts on from the pan, tilt and roll of `base`; roll turns with it. So a level picture stays
/// level, however far `base` looks down.

/// It looks past straight up or down.
bool is_over(const Pose& base, const PtzPosition& head);

/// world_from_link at these angles; exactly `base` at pan and tilt 0. is_turned_over: by half a turn about where it
/// looks, so that past straight up or down what is up stays up (e-flip).
Pose turned_by(const Pose& base, const PtzPosition& head, bool is_turned_over = false);

/// The angles of a head that looks along a direction, in that frame, on the side of straight up and down where it is
/// now. Straight up or down any pan will do; the present one stays.
PtzPosition aimed_along(const Pose& base, const glm::dvec3& direction, const PtzPosition& now);

}  // namespace camrig::camera

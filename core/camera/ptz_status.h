#pragma once

namespace camrig::camera {

/// Angles in degrees, pan positive to the left and in (-180, 180], tilt upwards; zoom as the factor of the focal
/// length.
struct PtzPosition {
    double pan_deg = 0.0;
    double tilt_deg = 0.0;
    double zoom = 1.0;
    friend bool operator==(const PtzPosition&, const PtzPosition&) = default;
};

/// A head at one time.
struct PtzStatus {
    PtzPosition position;       ///< as its encoders have it
    PtzPosition true_position;  ///< where it is, which pictures show
    bool is_turning = false;    ///< from the command on, its latency included, until it stands
    bool is_zooming = false;
    friend bool operator==(const PtzStatus&, const PtzStatus&) = default;
};

}  // namespace camrig::camera

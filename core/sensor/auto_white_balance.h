#pragma once

#include "core/sensor/develop.h"
#include "core/sensor/frame_statistics.h"

namespace camrig::sensor {

/// Automatic white balance by the grey-world assumption, with inertia: a state machine over the statistics of a
/// camera's frames, each exactly once and in order.
///
/// Zones that are saturated or dark say nothing of the light's colour and do not count; where none counts, it stays as
/// it is. Of a new light 95 % are balanced after 59 frames (speed 0.05 as in libcamera's rpi.awb).
class AutoWhiteBalance {
public:
    struct Options {
        double speed = 0.05;
        int startup_frames = 10;  ///< of a new camera, that go all the way at once
        double max_gain = 8.0;    ///< of red and blue, of that of green; and one over it
    };
    explicit AutoWhiteBalance(const SensorSpec& spec, const Options& options);

    /// Of the next frame.
    WhiteBalance balance() const;
    void advance(const FrameStatistics& statistics);

private:
    Options options_;
    bool has_colors_;
    double red_, blue_;  ///< gains, of that of green
    int frames_ = 0;
};

}  // namespace camrig::sensor

#pragma once

#include <deque>

#include "core/sensor/develop.h"
#include "core/sensor/frame_statistics.h"

namespace camrig::sensor {

struct ExposureSetting {
    double exposure_s = 0.001;
    double gain_db = 0.0;
    /// Seconds at gain 0 dB with as many numbers.
    double total_s() const;
    friend bool operator==(const ExposureSetting&, const ExposureSetting&) = default;
};

/// Automatic exposure: a state machine over the statistics of a camera's frames, each exactly once and in order.
/// Nothing else goes in, so that a camera's exposures are a function of its pictures alone.
///
/// Metering, filter and the steps of exposure and gain are those of libcamera's Raspberry Pi algorithm (rpi.agc;
/// speed, stable region and steps as in its imx219.json); the grid of zones is FrameStatistics'.
class AutoExposure {
public:
    struct Options {
        double target = 0.16;           ///< of the mean luminance, centre-weighted
        double least_highlights = 0.5;  ///< of the mean of the brightest 2 %: more counts than the target; 0: off
        double min_exposure_s = 20e-6;
        double max_exposure_s = 0.066666;  ///< a picture's time at most
        double max_gain_db = 20.0;
        double flicker_hz = 0.0;  ///< of the mains: exposures last whole half periods, where they last one; 0: any
        double speed = 0.2;       ///< share of the way to the target in a frame; its root within 20 % of it
        double stable = 0.02;     ///< so near it stays
        int startup_frames = 10;  ///< of a new camera, that go all the way at once
        /// Frames between one and the first that its statistics change, 0 to 8: registers that are written while the
        /// next frame is exposed act so much later.
        int delay_frames = 2;
    };
    explicit AutoExposure(const Options& options, const ExposureSetting& first = {});

    /// Of the next frame.
    const ExposureSetting& setting() const { return settings_.front(); }
    /// Of the longest exposure that is decided, of the next delay_frames + 1 frames.
    double longest_ahead_s() const;
    /// That frame was taken; `balance` is what its white balance was.
    void advance(const FrameStatistics& statistics, const WhiteBalance& balance);

    /// Of the last frame: its metered luminance; and whether exposure has stood still for six frames.
    double measured() const { return measured_; }
    bool is_locked() const { return stable_frames_ >= 6; }

private:
    double target_s(const FrameStatistics& statistics, const WhiteBalance& balance);
    void approach(double target_s);
    ExposureSetting split(double total_s) const;

    Options options_;
    std::deque<ExposureSetting> settings_;  ///< decided: of the next frames
    double filtered_s_ = 0.0;
    double measured_ = 0.0;
    int frames_ = 0;
    int stable_frames_ = 0;
};

}  // namespace camrig::sensor

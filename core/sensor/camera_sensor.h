#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>

#include "core/base/rate.h"
#include "core/base/sensor_reading.h"
#include "core/sensor/auto_exposure.h"
#include "core/sensor/auto_white_balance.h"
#include "core/sensor/sensor.h"

namespace camrig::sensor {

/// What takes a camera's pictures.
struct SensorSetup {
    SensorSpec spec;
    ImageSize size;
    camera::Intrinsics intrinsics;
    Rate rate;
    friend bool operator==(const SensorSetup&, const SensorSetup&) = default;
};

/// One picture: by what and how it is taken.
struct Exposure {
    std::shared_ptr<const Sensor> sensor;
    Shot shot;
    WhiteBalance balance;
    SensorReading reading;
    RowTimes times;
    std::uint64_t life = 0;  ///< of automatic exposure, which a change of the spec begins anew
};

/// A camera's sensor from picture to picture. Automatic exposure and white balance are functions of the statistics of
/// its pictures, each once and in order; so are their settings, whatever thread draws and however often.
///
/// Thread: any.
class CameraSensor {
public:
    /// How picture `sequence` is taken, whose last row ends at end_ns: as it was if it was among the last ones, else as
    /// the next one is. Another spec
    /// (but for its lux) or size begins automatic exposure anew, from where it is. Errors: Sensor::create.
    Result<Exposure> exposure_of(const SensorSetup& setup, std::int64_t sequence, TimeNs end_ns);
    /// Of the longest of the next pictures that a camera of that spec takes, however many of those before are still
    /// being drawn, or will not be.
    double longest_ahead_s(const SensorSpec& spec);
    /// The picture was taken and has these statistics. Only the first time counts, and none before it.
    void taken(const Exposure& exposure, const FrameStatistics& statistics);

private:
    struct Taken {
        std::int64_t sequence = -1;
        ExposureSetting setting;
        WhiteBalance balance;
        double metered = 0.0;
        bool is_settled = true;
    };
    Result<void> set_up(const SensorSetup& setup);
    Taken next(std::int64_t sequence) const;

    std::mutex mutex_;
    std::optional<SensorSetup> setup_;
    std::shared_ptr<const Sensor> sensor_;
    std::optional<AutoExposure> exposure_;
    std::optional<AutoWhiteBalance> balance_;
    ExposureSetting last_setting_;
    double metered_ = 0.0;
    std::uint64_t life_ = 0;
    std::int64_t last_ = -1;
    std::array<Taken, 16> taken_{};  ///< a ring by sequence
};

}  // namespace camrig::sensor

#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "core/base/field_table.h"
#include "core/base/named.h"

namespace camrig::camera {

/// Heads that come with camrig: `ideal` goes where it is told to, `dome` is a good one on a ceiling, `cheap` is slow,
/// late and inexact. Figures: measured and data-sheet values of heads of each kind (docs/ptz.md names them).
enum class PtzPreset : std::uint8_t { ideal, dome, cheap };
std::span<const Named<PtzPreset>> names_of(std::type_identity<PtzPreset>);

/// From low to high, both included.
struct PtzLimits {
    double low = 0.0;
    double high = 0.0;
    friend bool operator==(const PtzLimits&, const PtzLimits&) = default;
};

/// A pan/tilt/zoom head, as its data sheet would tell. Pan is positive to the left, tilt upwards, both 0 where the
/// camera's `pose` looks; zoom is the factor of the camera's focal length, 1 at the wide end.
struct PtzSpec {
    PtzPreset preset = PtzPreset::dome;
    std::optional<PtzLimits> pan_limits_deg;  ///< nullopt: it turns without end
    PtzLimits tilt_limits_deg{-90.0, 20.0};
    double zoom_max = 30.0;
    double speed_deg_s = 100.0;  ///< of pan and of tilt
    double acceleration_deg_s2 = 400.0;
    double zoom_s = 3.6;              ///< from one end of the zoom to the other, by equal factors a second
    double latency_s = 0.15;          ///< from a command to the begin of its motion
    double stop_latency_s = 0.15;     ///< from a stop to the begin of braking
    double quantum_deg = 0.01;        ///< of the angles that the head tells
    double repeatability_deg = 0.05;  ///< it stops at most so far from where it believes to be, each time elsewhere
    double backlash_deg = 0.0;        ///< so much further does it lag behind after coming from the other side
    bool is_proportional = true;      ///< relative and continuous moves are slower by the zoom
    bool flips = true;                ///< past straight up or down the picture is turned over, so that up is up
    std::uint64_t seed = 0;           ///< of where it stops
    friend bool operator==(const PtzSpec&, const PtzSpec&) = default;
};

PtzSpec ptz_preset(PtzPreset preset);

/// A preset that is given sets all figures; what is given beside it counts.
FieldTable<PtzSpec> fields_of(std::type_identity<PtzSpec>);

}  // namespace camrig::camera

#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "core/base/field_table.h"
#include "core/base/named.h"
#include "core/base/rate.h"
#include "core/base/result.h"
#include "core/sensor/row_times.h"

namespace camrig::sensor {

/// Sensors that come with camrig; docs/sensor.md names the source of each figure. `ideal`: no noise, no falloff.
enum class SensorPreset : std::uint8_t { ideal, imx219, imx477, imx290, ov9281, imx249, webcam };
std::span<const Named<SensorPreset>> names_of(std::type_identity<SensorPreset>);

/// What lies before the photosites. `mono`: nothing, they count luminance. `rgb`: each place has three of its own
/// (three chips). The others: 2x2 mosaics of Bayer, named by their first row and their second.
enum class ColorFilter : std::uint8_t { mono, rgb, rggb, grbg, gbrg, bggr };
std::span<const Named<ColorFilter>> names_of(std::type_identity<ColorFilter>);

/// A camera from its lens to its numbers, as a data sheet would tell. Electrons are written e.
struct SensorSpec {
    SensorPreset preset = SensorPreset::ideal;
    ColorFilter filter = ColorFilter::rgb;
    std::optional<double> exposure_s = 0.01;  ///< nullopt: automatic
    double gain_db = 0.0;                     ///< of electrons, before quantisation; with automatic exposure unused
    /// Of the scene, where light 1 is: white in its light. nullopt: white fills the wells in 10 ms.
    std::optional<double> lux;
    double full_well_e = 100'000.0;     ///< the largest number of the converter at gain 0 dB
    double read_noise_e = 0.0;          ///< standard deviation, of each photosite in each picture
    double dark_e_per_s = 0.0;          ///< dark current
    double quantum_efficiency = 0.6;    ///< electrons a photon, under the green filter
    double response_red = 1.0;          ///< electrons of white light under the red filter, of those under green
    double response_blue = 1.0;         ///< the same of blue
    double prnu = 0.0;                  ///< standard deviation of sensitivity between photosites, of 1
    double dsnu_e = 0.0;                ///< standard deviation of the offset between photosites
    double row_noise_e = 0.0;           ///< standard deviation of an offset of each row in each picture
    double hot_pixels_ppm = 0.0;        ///< photosites of a million with a dark current of their own
    double hot_e_per_s = 0.0;           ///< its mean; it is distributed exponentially
    int bits = 16;                      ///< of the converter
    std::optional<double> black_level;  ///< the number of no electrons; nullopt: 1/16 of the range, 0 without noise
    double f_number = 2.0;
    std::optional<double> focus_m;  ///< what is so far along the optical axis is sharp; nullopt: all is
    double pixel_pitch_m = 3.45e-6;
    double vignetting = 0.0;                ///< 1: the natural falloff of a lens, 0: none
    std::optional<double> white_balance_k;  ///< nullopt: automatic
    double flicker_hz = 0.0;                ///< of the mains that automatic exposure evades; 0: none
    double least_highlights = 0.5;          ///< AutoExposure::Options
    double readout_s = 0.0;                 ///< from the first row to one after the last; 0: a global shutter
    bool blur = true;                       ///< what moves while a row counts is smeared; false: as in its middle
    bool dynamic_framerate = false;         ///< exposures may last longer than the camera's period
    std::uint64_t seed = 0;                 ///< of all that is random
    friend bool operator==(const SensorSpec&, const SensorSpec&) = default;

    int max_number() const { return (1 << bits) - 1; }
    double black() const;
    /// Numbers (DN) for an electron at gain 0 dB: full_well_e reaches from black to the largest number.
    double numbers_per_e() const { return (max_number() - black()) / full_well_e; }
    /// Electrons a second that light 1 makes in a photosite under green, in the middle of the picture.
    double electrons_per_s() const;
    /// Of red, green and blue. Of `mono` and `rgb` all 1.
    std::array<double, 3> responses() const;
    int planes() const { return filter == ColorFilter::rgb ? 3 : 1; }
    /// Of automatic exposure, by a camera of that rate: its period, or what lets the rate fall.
    double longest_exposure_s(const Rate& rate) const;
    /// How many periods of its camera a picture takes: as many as its exposure begins, 1 where the rate never falls.
    std::int64_t periods_of(double counted_s, const Rate& rate) const;
    /// Of a picture of so many rows that count so long, and whose last one ends then.
    RowTimes row_times(double counted_s, int rows, TimeNs end_ns) const;
    bool is_bayer() const { return filter != ColorFilter::mono && filter != ColorFilter::rgb; }
};

SensorSpec sensor_preset(SensorPreset preset);

/// Error invalid_argument names the figure that is out of its range.
Result<void> check_sensor(const SensorSpec& spec);

/// A preset that is given sets all figures but the seed; what is given beside it counts. Ranges have units.
FieldTable<SensorSpec> fields_of(std::type_identity<SensorSpec>);

}  // namespace camrig::sensor

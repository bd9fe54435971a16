#include "core/sensor/sensor_spec.h"

#include <algorithm>
#include <cmath>

#include "core/base/field_of.h"

namespace camrig::sensor {
namespace {

using S = SensorSpec;

FieldOf<S> preset() {
    FieldOf<S> entry =
        field_at<&S::preset>({.name = "preset", .doc = "figures of a sensor; what is given beside it counts"});
    entry.read = [field = entry.field](JsonReader& reader, Changes<S>& changes) {
        if (const auto value = read_value<SensorPreset>(reader, field))
            changes.change([preset = *value](S& s) {
                const std::uint64_t seed = s.seed;
                s = sensor_preset(preset);
                s.seed = seed;
            });
    };
    return entry;
}

constexpr double full_scale_s = 0.01;

/// Of automatic exposure where the rate may fall: what webcams have at most (2047 of UVC's 100 us), 5 pictures a
/// second.
constexpr double longest_dynamic_s = 0.2;
/// By so much the exposures of two pictures may overlap: a whole number of half periods of the mains, or of a rate, is
/// none of nanoseconds.
constexpr TimeNs rounding_ns = 1000;

/// Photons that one lux brings on a square micrometre in a second, of the green channel's band: 4090 at 555 nm alone.
constexpr double photons_per_um2_lux_s = 4500.0;
constexpr double lens_transmission = 0.9;

}  // namespace

std::span<const Named<SensorPreset>> names_of(std::type_identity<SensorPreset>) {
    static constexpr Named<SensorPreset> names[] = {{SensorPreset::ideal, "ideal"},   {SensorPreset::imx219, "imx219"},
                                                    {SensorPreset::imx477, "imx477"}, {SensorPreset::imx290, "imx290"},
                                                    {SensorPreset::ov9281, "ov9281"}, {SensorPreset::imx249, "imx249"},
                                                    {SensorPreset::webcam, "webcam"}};
    return names;
}

std::span<const Named<ColorFilter>> names_of(std::type_identity<ColorFilter>) {
    static constexpr Named<ColorFilter> names[] = {{ColorFilter::mono, "mono"}, {ColorFilter::rgb, "rgb"},
                                                   {ColorFilter::rggb, "rggb"}, {ColorFilter::grbg, "grbg"},
                                                   {ColorFilter::gbrg, "gbrg"}, {ColorFilter::bggr, "bggr"}};
    return names;
}

double SensorSpec::black() const {
    if (black_level) return *black_level;
    return read_noise_e + dsnu_e + row_noise_e > 0.0 ? (max_number() + 1) / 16 : 0.0;
}

double SensorSpec::electrons_per_s() const {
    if (!lux) return full_well_e / full_scale_s;
    // Of a white diffuser far away, on the focal plane: E / (4 N^2).
    const double focal_plane_lux = *lux * lens_transmission / (4.0 * f_number * f_number);
    const double area_um2 = pixel_pitch_m * pixel_pitch_m * 1e12;
    return focal_plane_lux * area_um2 * photons_per_um2_lux_s * quantum_efficiency;
}

RowTimes SensorSpec::row_times(double counted_s, int rows, TimeNs end_ns) const {
    RowTimes times{.begin_ns = 0,
                   .exposure_ns = std::llround(counted_s * 1e9),
                   .row_ns = std::llround(readout_s * 1e9 / rows),
                   .rows = rows};
    times.begin_ns = end_ns - times.end_ns();
    return times;
}

double SensorSpec::longest_exposure_s(const Rate& rate) const {
    const double period_s = static_cast<double>(rate.time_of_frame(1)) * 1e-9;
    return dynamic_framerate ? std::max(period_s, longest_dynamic_s) : period_s;
}

std::int64_t SensorSpec::periods_of(double counted_s, const Rate& rate) const {
    if (!dynamic_framerate) return 1;
    const TimeNs period_ns = rate.time_of_frame(1);
    const TimeNs counted_ns = std::llround(counted_s * 1e9) - rounding_ns;
    return std::max<std::int64_t>(1, (counted_ns + period_ns - 1) / period_ns);
}

std::array<double, 3> SensorSpec::responses() const {
    if (!is_bayer()) return {1.0, 1.0, 1.0};
    return {response_red, 1.0, response_blue};
}

Result<void> check_sensor(const SensorSpec& spec) {
    if (auto good = check_fields(fields_of(std::type_identity<SensorSpec>{}), spec); !good) return good;
    if (spec.black() <= (spec.max_number() + 1) / 4) return {};
    return error(ErrorKind::invalid_argument, "black_level: must be at most " +
                                                  std::to_string((spec.max_number() + 1) / 4) +
                                                  ", a quarter of the range of " + std::to_string(spec.bits) + " bits");
}

SensorSpec sensor_preset(SensorPreset preset) {
    SensorSpec s;
    s.preset = preset;
    if (preset == SensorPreset::ideal) return s;
    // What data sheets of small sensors have in common; the rest by sensor.
    s.filter = ColorFilter::rggb;
    s.bits = 10;
    s.dark_e_per_s = 5.0;
    s.prnu = 0.008;
    s.dsnu_e = 0.5;
    s.row_noise_e = 0.2;
    s.hot_pixels_ppm = 20.0;
    s.hot_e_per_s = 200.0;
    s.vignetting = 1.0;
    switch (preset) {
        case SensorPreset::imx219:
            s.full_well_e = 4866.0;
            s.readout_s = 0.0233;
            s.read_noise_e = 2.5;
            s.pixel_pitch_m = 1.12e-6;
            s.response_red = 0.53;
            s.response_blue = 0.73;
            break;
        case SensorPreset::imx477:
            s.full_well_e = 8560.0;
            s.readout_s = 0.0231;
            s.read_noise_e = 2.5;
            s.pixel_pitch_m = 1.55e-6;
            s.bits = 12;
            s.response_red = 0.31;
            s.response_blue = 0.72;
            break;
        case SensorPreset::imx290:
            s.full_well_e = 9193.0;
            s.readout_s = 0.032;
            s.read_noise_e = 2.5;
            s.pixel_pitch_m = 2.9e-6;
            s.quantum_efficiency = 0.7;
            s.bits = 12;
            s.black_level = 240.0;
            s.response_red = 0.6;
            s.response_blue = 0.7;
            break;
        case SensorPreset::ov9281:
            s.filter = ColorFilter::mono;
            s.full_well_e = 10486.0;
            s.read_noise_e = 3.5;
            s.pixel_pitch_m = 3.0e-6;
            break;
        case SensorPreset::imx249:
            s.filter = ColorFilter::mono;
            s.full_well_e = 32359.0;
            s.read_noise_e = 6.7;
            s.pixel_pitch_m = 5.86e-6;
            s.quantum_efficiency = 0.7;
            s.bits = 12;
            s.dark_e_per_s = 2.0;
            s.row_noise_e = 0.0;
            break;
        case SensorPreset::webcam:
            s.full_well_e = 3600.0;
            s.readout_s = 0.03;
            s.read_noise_e = 5.0;
            s.pixel_pitch_m = 1.4e-6;
            s.quantum_efficiency = 0.5;
            s.dark_e_per_s = 40.0;
            s.prnu = 0.015;
            s.dsnu_e = 1.5;
            s.row_noise_e = 1.0;
            s.hot_pixels_ppm = 100.0;
            s.response_red = 0.55;
            s.response_blue = 0.65;
            break;
        case SensorPreset::ideal:
            break;
    }
    return s;
}

FieldTable<SensorSpec> fields_of(std::type_identity<SensorSpec>) {
    static const std::vector<FieldOf<S>> table{
        preset(),
        field_at<&S::filter>(
            {.name = "filter",
             .doc = "of colours: none (mono), three photosites at each place (rgb), or a mosaic of Bayer"}),
        field_at<&S::exposure_s>(
            {.name = "exposure_s", .doc = "how long it counts", .unit = "s", .range = {1e-6, 10}, .word = "auto"}),
        field_at<&S::gain_db>({.name = "gain_db",
                               .doc = "electrons are multiplied by 10^(dB/20) before they become numbers",
                               .unit = "dB",
                               .range = {0, 48}}),
        field_at<&S::lux>({.name = "lux",
                           .doc = "illuminance of the scene where white is drawn as white",
                           .unit = "lx",
                           .range = {1e-4, 1e6},
                           .null = "white fills the wells in 10 ms"}),
        field_at<&S::full_well_e>(
            {.name = "full_well_e", .doc = "what a photosite holds", .unit = "e", .range = {100, 1e6}}),
        field_at<&S::read_noise_e>(
            {.name = "read_noise_e", .doc = "standard deviation", .unit = "e", .range = {0, 1000}}),
        field_at<&S::dark_e_per_s>({.name = "dark_e_per_s", .doc = "dark current", .unit = "e/s", .range = {0, 1e5}}),
        field_at<&S::quantum_efficiency>(
            {.name = "quantum_efficiency", .doc = "electrons a photon; counts where lux is given", .range = {0, 1}}),
        field_at<&S::response_red>({.name = "response_red",
                                    .doc = "of a mosaic: electrons of white light under red, of those under green",
                                    .range = {0.05, 2}}),
        field_at<&S::response_blue>({.name = "response_blue", .doc = "the same of blue", .range = {0.05, 2}}),
        field_at<&S::prnu>(
            {.name = "prnu", .doc = "standard deviation of sensitivity between photosites", .range = {0, 0.2}}),
        field_at<&S::dsnu_e>({.name = "dsnu_e",
                              .doc = "standard deviation of the offset between photosites",
                              .unit = "e",
                              .range = {0, 1000}}),
        field_at<&S::row_noise_e>({.name = "row_noise_e",
                                   .doc = "standard deviation of the offset of a row in a picture",
                                   .unit = "e",
                                   .range = {0, 1000}}),
        field_at<&S::hot_pixels_ppm>(
            {.name = "hot_pixels_ppm", .doc = "hot photosites of a million", .range = {0, 10'000}}),
        field_at<&S::hot_e_per_s>(
            {.name = "hot_e_per_s", .doc = "their mean dark current", .unit = "e/s", .range = {0, 1e6}}),
        field_at<&S::bits>({.name = "bits", .doc = "of the converter", .range = {8, 16}}),
        field_at<&S::black_level>({.name = "black_level",
                                   .doc = "the number of no electrons, at most a quarter of the range",
                                   .range = {0, 16384},
                                   .null = "1/16 of the range; 0 without noise"}),
        field_at<&S::f_number>({.name = "f_number", .doc = "counts where lux or focus_m is given", .range = {0.5, 64}}),
        field_at<&S::focus_m>({.name = "focus_m",
                               .doc = "what is so far along the optical axis is sharp, what is nearer or farther less",
                               .unit = "m",
                               .range = {0.01, 1e6},
                               .null = "all is sharp"}),
        field_at<&S::pixel_pitch_m>({.name = "pixel_pitch_m",
                                     .doc = "of the picture's pixels; counts where lux or focus_m is given",
                                     .unit = "m",
                                     .range = {1e-7, 1e-3}}),
        field_at<&S::vignetting>(
            {.name = "vignetting", .doc = "1 is the natural falloff of a lens, cos^4 of the angle", .range = {0, 4}}),
        field_at<&S::white_balance_k>({.name = "white_balance",
                                       .doc = "the light that is taken for white",
                                       .unit = "K",
                                       .fallback = "auto",
                                       .range = {2000, 12'000},
                                       .word = "auto"}),
        field_at<&S::flicker_hz>({.name = "flicker_hz",
                                  .doc = "of the mains: automatic exposures last whole periods of its lamps; 0: any",
                                  .unit = "Hz",
                                  .range = {0, 400}}),
        field_at<&S::least_highlights>(
            {.name = "least_highlights",
             .doc = "of automatic exposure: mean of the brightest 2 %, where the largest number is 1, "
                    "that counts more than the mean of all; 0: none does",
             .range = {0, 1}}),
        field_at<&S::readout_s>({.name = "readout_s",
                                 .doc = "rows begin one after the other in this time (rolling shutter); 0: all at once",
                                 .unit = "s",
                                 .range = {0, 0.2}}),
        field_at<&S::blur>(
            {.name = "blur", .doc = "what moves while a row counts is smeared; false: sharp, as in the middle of it"}),
        field_at<&S::dynamic_framerate>(
            {.name = "dynamic_framerate",
             .doc =
                 "exposures may last longer than the camera's period, and its rate falls; automatic ones up to 0.2 s"}),
        field_at<&S::seed>({.name = "seed", .doc = "of all that is random", .range = {.low = 0}}),
    };
    return table;
}

}  // namespace camrig::sensor

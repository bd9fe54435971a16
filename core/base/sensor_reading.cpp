#include "core/base/sensor_reading.h"

#include "core/base/field_of.h"

namespace camrig {

FieldTable<SensorReading> fields_of(std::type_identity<SensorReading>) {
    using S = SensorReading;
    static const std::vector<FieldOf<S>> table{
        field_at<&S::exposure_s>({.name = "exposure_s", .doc = "how long it counted", .unit = "s"}),
        field_at<&S::gain_db>({.name = "gain_db", .doc = "of electrons", .unit = "dB"}),
        field_at<&S::electrons_per_number>(
            {.name = "electrons_per_number", .doc = "of raw numbers, at this gain", .unit = "e"}),
        field_at<&S::black_level>({.name = "black_level", .doc = "the raw number of no electrons"}),
        field_at<&S::bits>({.name = "bits", .doc = "of raw numbers"}),
        field_at<&S::red_gain>({.name = "red_gain", .doc = "of white balance, the smallest of the three is 1"}),
        field_at<&S::green_gain>({.name = "green_gain", .doc = "the same of green"}),
        field_at<&S::blue_gain>({.name = "blue_gain", .doc = "the same of blue"}),
        field_at<&S::metered>({.name = "metered",
                               .doc = "luminance that automatic exposure saw in the picture before, 1 is the largest "
                                      "number; 0: none yet, or manual"}),
        field_at<&S::is_settled>(
            {.name = "settled", .doc = "automatic exposure stood still for six pictures, or is manual"}),
        field_at<&S::exposure_start_ns>(
            {.name = "exposure_start_ns", .doc = "world time at which the first row began to count", .unit = "ns"}),
        field_at<&S::exposure_end_ns>(
            {.name = "exposure_end_ns", .doc = "at which the last row ended: the frame's `time_ns`", .unit = "ns"}),
        field_at<&S::row_ns>({.name = "row_ns",
                              .doc = "from the begin of a row to that of the next; 0: all rows at once",
                              .unit = "ns"}),
        field_at<&S::fps>({.name = "fps",
                           .doc = "pictures a second that such exposures leave time for: the camera's rate, or with "
                                  "`dynamic_framerate` a whole part of it",
                           .unit = "1/s"}),
    };
    return table;
}

}  // namespace camrig

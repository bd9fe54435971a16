#pragma once

#include <type_traits>

#include "core/base/field_table.h"
#include "core/base/time.h"

namespace camrig {

/// How a camera's sensor took one picture, and what its numbers mean (docs/sensor.md).
struct SensorReading {
    double exposure_s = 0.0;
    double gain_db = 0.0;
    double electrons_per_number = 0.0;  ///< at this gain
    double black_level = 0.0;           ///< the number of no electrons
    int bits = 16;
    double red_gain = 1.0, green_gain = 1.0, blue_gain = 1.0;  ///< of white balance; the smallest is 1
    double metered = 0.0;    ///< luminance that automatic exposure saw in the picture before; 0: none yet, or manual
    bool is_settled = true;  ///< automatic exposure has stood still for six pictures, or is manual
    TimeNs exposure_start_ns = 0;  ///< world time at which the first row begins to count
    TimeNs exposure_end_ns = 0;    ///< at which the last row ends: the frame's instant
    TimeNs row_ns = 0;             ///< from the begin of a row to that of the next; 0: all at once
    double fps = 0.0;              ///< pictures a second of this exposure: the camera's rate or a whole part of it
    friend bool operator==(const SensorReading&, const SensorReading&) = default;
};
FieldTable<SensorReading> fields_of(std::type_identity<SensorReading>);

}  // namespace camrig

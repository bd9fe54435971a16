#pragma once

#include "core/base/time.h"

namespace camrig::sensor {

/// When the rows of one picture count light, in world time: row r from begin_ns + r * row_ns for exposure_ns.
struct RowTimes {
    TimeNs begin_ns = 0;
    TimeNs exposure_ns = 0;
    TimeNs row_ns = 0;  ///< 0: all rows at once, a global shutter
    int rows = 1;

    /// Of the last row.
    TimeNs end_ns() const { return begin_ns + (rows - 1) * row_ns + exposure_ns; }
    TimeNs middle_ns(int row) const { return begin_ns + row * row_ns + exposure_ns / 2; }
    /// Of the row in the middle of the picture.
    TimeNs middle_ns() const { return middle_ns(rows / 2); }
    /// Each row as if it counted in the middle of its exposure alone.
    RowTimes middles() const { return {.begin_ns = middle_ns(0), .exposure_ns = 0, .row_ns = row_ns, .rows = rows}; }
    friend bool operator==(const RowTimes&, const RowTimes&) = default;
};

}  // namespace camrig::sensor

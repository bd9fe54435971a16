#pragma once

#include <utility>

#include "core/sensor/row_times.h"

namespace camrig::render {

/// Which moments make a picture, and how much of each is in a row: the time from the first row's begin to the last
/// row's end in cells of equal length, each drawn as it is in its middle.
class Moments {
public:
    static constexpr int most_of_row = 32, most_of_picture = 256;

    /// Cells of at most a pixel, as far as the bounds go. moved_px: in the whole time.
    Moments(const sensor::RowTimes& times, double moved_px);

    int count() const { return count_; }
    TimeNs time(int cell) const;
    /// How many cells a row's exposure takes at least: any so many, one after the other, are of one row.
    int cells_of_row() const;
    /// The row's share of its exposure in the cell; over all cells 1.
    float weight(int cell, int row) const;
    /// Rows [first, end) that have some of the cell.
    std::pair<int, int> rows(int cell) const;
    /// The time that the cell and the row's exposure share.
    std::pair<TimeNs, TimeNs> shared(int cell, int row) const;

private:
    TimeNs edge_ns(int cell) const;

    sensor::RowTimes times_;
    int count_ = 1;
};

/// Mean of sin(2 pi hz t) over [begin_ns, end_ns); at begin_ns where both are one.
double mean_sine(double hz, TimeNs begin_ns, TimeNs end_ns);

}  // namespace camrig::render

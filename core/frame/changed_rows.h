#pragma once

#include <algorithm>
#include <bitset>
#include <cstddef>

#include "core/base/image_size.h"

namespace camrig {

/// Which rows of a picture may differ from an earlier one, in bands of 16 rows: the rows that a row of 4:2:0 blocks of
/// a JPEG is made of, so that what did not change need not be converted or encoded again. A value without allocation.
class ChangedRows {
public:
    static constexpr int band_rows = 16;
    /// Bands beyond this (no camera is so tall) count as changed always.
    static constexpr int max_bands = max_image_size.height / band_rows;

    /// Marks every band that has one of the rows first_row <= row < end_row. Rows outside of the picture may be named.
    void add(int first_row, int end_row) {
        first_row = std::max(first_row, 0);
        end_row = std::min(end_row, max_bands * band_rows);
        for (int band = first_row / band_rows; band * band_rows < end_row && first_row < end_row; ++band)
            bands_.set(static_cast<std::size_t>(band));
    }
    void clear() { bands_.reset(); }
    ChangedRows& operator|=(const ChangedRows& other) {
        bands_ |= other.bands_;
        return *this;
    }

    /// Of rows 16 * band to 16 * band + 15.
    bool contains_band(int band) const { return band >= max_bands || bands_.test(static_cast<std::size_t>(band)); }

    friend bool operator==(const ChangedRows&, const ChangedRows&) = default;

private:
    std::bitset<max_bands> bands_;
};

}  // namespace camrig

#pragma once

#include <algorithm>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/base/image_size.h"

namespace camrig::frame {

/// Where a picture may differ from a base, as compositors and remote desktops tell it: every row that is not damaged is
/// the base's, byte for byte in any one pixel format, so it need not be drawn, converted or encoded again.
///
/// What the base is, who carries it says: of a frame (FrameInfo::damage) an earlier frame, by its sequence; of a view
/// that is drawn, a kept picture, by its number. Without a base nothing is known, and all rows are damaged.
///
/// Rows are told in bands of 16: those that a row of 4:2:0 blocks of a JPEG is made of. A value without allocation.
class Damage {
public:
    static constexpr int band_rows = 16;
    /// Bands beyond this (no camera is so tall) are damaged always.
    static constexpr int max_bands = max_image_size.height / band_rows;

    Damage() = default;
    /// None, yet, since this base.
    static Damage since(std::int64_t base) {
        Damage damage;
        damage.base_ = base;
        return damage;
    }
    /// Of a picture since `earlier`, when both have the same base: where either differs from it. Nothing is known when
    /// they have not.
    static Damage between(std::int64_t earlier, const Damage& of_earlier, const Damage& of_picture) {
        if (!of_picture.base_ || of_picture.base_ != of_earlier.base_) return {};
        Damage damage = since(earlier);
        damage.bands_ = of_earlier.bands_ | of_picture.bands_;
        return damage;
    }

    /// Every band that has one of the rows first_row <= row < end_row. Rows outside of the picture may be named.
    void add(int first_row, int end_row) {
        first_row = std::max(first_row, 0);
        end_row = std::min(end_row, max_bands * band_rows);
        for (int band = first_row / band_rows; band * band_rows < end_row && first_row < end_row; ++band)
            bands_.set(static_cast<std::size_t>(band));
    }

    std::optional<std::int64_t> base() const { return base_; }
    /// Whether rows 16 * band to 16 * band + 15 may differ.
    bool contains_band(int band) const {
        return !base_ || band >= max_bands || bands_.test(static_cast<std::size_t>(band));
    }

    friend bool operator==(const Damage&, const Damage&) = default;

private:
    std::optional<std::int64_t> base_;
    std::bitset<max_bands> bands_;
};

}  // namespace camrig::frame

#pragma once

#include <cstdint>

#include "core/sensor/normal_tables.h"

namespace camrig::sensor {

/// Rows are worked on in pieces of so many photosites; buffers of rows are padded to whole ones.
inline constexpr int row_piece = 16;

/// All that a row of one plane of photosites needs. Electrons are of one picture; numbers are what the converter gives.
struct RowExposure {
    int padded_width = 0;  ///< whole pieces
    float electrons = 0;   ///< that light 1 makes in the middle of the picture
    /// Falloff of the lens: 1 / (1 + u^2 + v^2)^2 at u = u0 + x * u_step. With vignetting 1, u and v are tangents of
    /// the field angle and this is its cosine to the fourth.
    float u0 = 0, u_step = 0, v2 = 0;
    float prnu = 0, dark_e = 0;
    float limit_e = 0;  ///< of the mean: so many that the well is full
    float full_well_e = 0;
    float read_noise_e = 0, dsnu_e = 0;
    float row_e = 0;  ///< offset of this row
    float numbers_per_e = 0, black = 0, max_number = 0;
    RowNoise noise, fixed;  ///< of the picture; of the photosites
};

/// The mean number of electrons of each photosite, without hot ones. `light` and `mean_e`: padded_width values; light
/// is not negative and finite.
void expect_electrons(const RowExposure& row, const float* light, float* mean_e, bool wide);

/// What the converter says to electrons of that mean: shot noise, full well, read noise, offsets, gain, rounding.
void count_electrons(const RowExposure& row, const float* mean_e, std::uint16_t* numbers, bool wide);

/// Whether this processor has AVX2. The bytes are the same with it and without.
bool has_wide_rows();

}  // namespace camrig::sensor

#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/image_size.h"
#include "core/base/result.h"

namespace camrig::sensor {

/// Numbers of a converter as somebody's camera gave them, of `mono` or of a mosaic, rows from the top.
struct RawPicture {
    std::string name;  ///< for errors
    ImageSize size;
    std::vector<std::uint16_t> numbers;
};

/// What pictures of evenly lit grey tell of a sensor (EMVA 1288, photon transfer).
struct PhotonTransfer {
    double numbers_per_e = 0.0;
    double read_noise_e = 0.0;
    double full_well_e = 0.0;  ///< electrons of the largest number
    double black_level = 0.0;
    int pairs = 0;  ///< of lit pictures
};

/// The first two pictures are dark, the others pairs of one light and exposure each: of two pictures of one light the
/// difference is noise alone, without fixed patterns, and its variance grows with the light by the conversion gain.
/// Each place of a 2x2 mosaic is a point of its own on that line. `bits`: of the converter, 8 to 16.
///
/// invalid_argument: fewer than two lit pairs, an odd number of pictures, sizes that differ, numbers that need more
/// bits, lit pictures that are saturated, too dark or no pair; each names the picture.
Result<PhotonTransfer> fit_photon_transfer(std::span<const RawPicture> pictures, int bits);

}  // namespace camrig::sensor

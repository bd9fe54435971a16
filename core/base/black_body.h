#pragma once

#include <array>

namespace camrig {

/// What the channels of linear sRGB are multiplied by where the light of a black body of this temperature, 1667 to
/// 25000 K, is taken for white, in a scene whose white light is 6500 K. Green is 1.
///
/// Source: cubic splines of the Planckian locus, Kim et al. 2002, US 7024034 B2.
std::array<double, 3> white_balance_of(double kelvin);

}  // namespace camrig

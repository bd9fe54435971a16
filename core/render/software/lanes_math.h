#pragma once

#include "core/render/software/lanes.h"

/// Powers and logarithms of lanes, of operations that give the same bits everywhere.
namespace camrig::render::software {

/// 2^x for magnitudes below 120, to 3e-7 of it.
CAMRIG_LANES Lanes exp2_of(Lanes x) {
    const Lanes whole = floor(x + 0.5f);
    const Lanes y = (x - whole) * 0.69314718f;
    const Lanes series =
        1.0f +
        y * (1.0f + y * (0.5f + y * (0.16666667f + y * (0.041666668f + y * (0.0083333338f + y * 0.0013888889f)))));
    return series * reinterpret_cast<Lanes>((truncated(whole) + 127) << 23);
}
/// For normal positive numbers.
CAMRIG_LANES Lanes log2_of(Lanes x) {
    // From sqrt(1/2) to sqrt(2) and a power of two; log(m) = 2 artanh((m - 1) / (m + 1)).
    constexpr std::int32_t sqrt_half = 0x3F3504F3;
    const IntLanes bits = reinterpret_cast<IntLanes>(x);
    const IntLanes power = (bits - sqrt_half) >> 23;
    const Lanes m = reinterpret_cast<Lanes>(bits - (power << 23));
    const Lanes s = (m - 1.0f) / (m + 1.0f), s2 = s * s;
    const Lanes log = 2.0f * s * (1.0f + s2 * (0.33333334f + s2 * (0.2f + s2 * 0.14285715f)));
    return __builtin_convertvector(power, Lanes) + log * 1.44269504f;
}

}  // namespace camrig::render::software

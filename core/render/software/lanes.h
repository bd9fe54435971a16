#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "core/render/software/canvas.h"

/// Eight neighbouring pixels at once, as vectors of the compiler: with AVX2 one instruction each, without it two or
/// four. Only what IEEE 754 defines exactly is used and nothing is contracted (-ffp-contract=off): every CPU gives the
/// same bits.
namespace camrig {

using Lanes = float __attribute__((vector_size(32)));
using IntLanes = std::int32_t __attribute__((vector_size(32)));

/// For code that is compiled once for each instruction set, inlined into a function that names it.
#define CAMRIG_LANES [[gnu::always_inline]] inline

CAMRIG_LANES Lanes lanes(float value) {
    return Lanes{} + value;
}
CAMRIG_LANES Lanes lane_numbers() {
    return Lanes{0, 1, 2, 3, 4, 5, 6, 7};
}
CAMRIG_LANES IntLanes int_lane_numbers() {
    return IntLanes{0, 1, 2, 3, 4, 5, 6, 7};
}
CAMRIG_LANES Lanes min(Lanes a, Lanes b) {
    return a < b ? a : b;
}
CAMRIG_LANES Lanes max(Lanes a, Lanes b) {
    return a > b ? a : b;
}
CAMRIG_LANES Lanes clamp01(Lanes value) {
    return min(max(value, Lanes{}), lanes(1.0f));
}
CAMRIG_LANES Lanes sqrt(Lanes value) {
    for (int i = 0; i < lane_count; ++i) value[i] = std::sqrt(value[i]);
    return value;
}
CAMRIG_LANES IntLanes truncated(Lanes value) {
    return __builtin_convertvector(value, IntLanes);
}
/// For magnitudes below 2^31.
CAMRIG_LANES Lanes floor(Lanes value) {
    const Lanes whole = __builtin_convertvector(truncated(value), Lanes);
    return whole > value ? whole - 1.0f : whole;
}
/// Whether any lane of a mask (0 or -1) is set.
CAMRIG_LANES bool any(IntLanes mask) {
    using Words = std::int64_t __attribute__((vector_size(32)));
    const Words words = reinterpret_cast<Words>(mask);
    return (words[0] | words[1] | words[2] | words[3]) != 0;
}

struct Lanes3 {
    Lanes x, y, z;
};
CAMRIG_LANES Lanes3 operator+(const Lanes3& a, const Lanes3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
CAMRIG_LANES Lanes3 operator-(const Lanes3& a, const Lanes3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
CAMRIG_LANES Lanes3 operator*(const Lanes3& a, const Lanes3& b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
}
CAMRIG_LANES Lanes3 operator*(const Lanes3& a, Lanes b) {
    return {a.x * b, a.y * b, a.z * b};
}
CAMRIG_LANES Lanes dot(const Lanes3& a, const Lanes3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

}  // namespace camrig

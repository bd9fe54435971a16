#pragma once

/// Functions of mathematics that give the same bits on every machine.
///
/// The C library chooses a variant of sin, cos, tan, atan, atan2, log, ... for the processor it finds, and variants
/// with fused multiply-add differ from those without in the last bit of some results. A world whose future depends on
/// them would take another course on another machine. These are made of additions, multiplications, divisions and exact
/// functions of doubles only (IEEE 754 prescribes each bit; the build forbids contraction, -ffp-contract=off).
///
/// Errors, held by PortableMath against long double: sin, cos, log and exp below 1 unit in the last place, atan and
/// atan2 below 1.5, tan below 3. Any thread.
namespace camrig::portable {

/// Arguments are reduced exactly up to 2^20 * pi/2; beyond, the error is as if `x` were off by 1e-16 of itself. Not
/// finite: NaN.
double sin(double x);
double cos(double x);
double tan(double x);
/// Signs, zeros and infinities as C's atan2 has them.
double atan2(double y, double x);
double atan(double x);
/// 0: minus infinity. Below: NaN.
double log(double x);
/// 0 and infinity where doubles end.
double exp(double x);

}  // namespace camrig::portable

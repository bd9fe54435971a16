#include "core/base/portable_math.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <utility>

namespace camrig::portable {
namespace {

/// A number as the sum of two doubles; `low` is at most half a unit in the last place of `high`.
struct Sum {
    double high = 0.0;
    double low = 0.0;
};

/// a + b, exactly (Knuth).
Sum exact_sum(double a, double b) {
    const double sum = a + b;
    const double b_part = sum - a;
    return {sum, (a - (sum - b_part)) + (b - b_part)};
}

/// c[0] + c[1] z + c[2] z^2 + ... (Horner)
template <std::size_t count>
double polynomial(const std::array<double, count>& c, double z) {
    double value = c[count - 1];
    for (std::size_t i = count - 1; i > 0; --i) value = value * z + c[i - 1];
    return value;
}

constexpr Sum pi{0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53};
constexpr Sum half_pi{0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54};
/// pi/2 in pieces of 33 bits, so that their products with a whole number up to 2^20 are exact, and the rest (Cody and
/// Waite, Software Manual for the Elementary Functions, 1980).
constexpr std::array half_pi_pieces = {0x1.921fb544p+0, 0x1.0b4611a6p-34, 0x1.3198a2e0p-69, 0x1.b839a252049c1p-104};
constexpr double most_quarters = 1 << 20;

/// An angle as a number of quarter turns and a rest in [-pi/4, pi/4].
struct Quarters {
    unsigned count = 0;  ///< modulo 4
    Sum rest;
};

Quarters reduced(double x) {
    double quarters = std::nearbyint(x / half_pi.high);
    if (std::abs(quarters) > most_quarters) {
        x = std::remainder(x, 2.0 * pi.high);
        quarters = std::nearbyint(x / half_pi.high);
    }
    const Sum first = exact_sum(x - quarters * half_pi_pieces[0], -quarters * half_pi_pieces[1]);
    const Sum second = exact_sum(first.high, -quarters * half_pi_pieces[2]);
    const double left = first.low + second.low - quarters * half_pi_pieces[3];
    const double high = second.high + left;
    return {static_cast<unsigned>(static_cast<int>(quarters)) % 4u, {high, (second.high - high) + left}};
}

/// Taylor's series of sin(x) = x + x^3 * s(x^2); on [-pi/4, pi/4] what is left out is below 1e-19 of the sum.
constexpr std::array sine_terms = {
    -1.0 / 6.0,        1.0 / 120.0,        -1.0 / 5040.0,          1.0 / 362880.0,
    -1.0 / 39916800.0, 1.0 / 6227020800.0, -1.0 / 1307674368000.0, 1.0 / 355687428096000.0};
/// cos(x) = 1 - x^2/2 + x^4 * c(x^2)
constexpr std::array cosine_terms = {1.0 / 24.0,        -1.0 / 720.0,         1.0 / 40320.0,         -1.0 / 3628800.0,
                                     1.0 / 479001600.0, -1.0 / 87178291200.0, 1.0 / 20922789888000.0};

double sine_of_rest(const Sum& x) {
    const double z = x.high * x.high;
    return x.high + (x.high * z * polynomial(sine_terms, z) + x.low * (1.0 - 0.5 * z));
}

double cosine_of_rest(const Sum& x) {
    const double z = x.high * x.high;
    const double half = 0.5 * z;
    const double first = 1.0 - half;
    return first + (((1.0 - first) - half) + (z * z * polynomial(cosine_terms, z) - x.high * x.low));
}

/// atan(k/8)
constexpr std::array<Sum, 9> atan_of_eighths = {{{0.0, 0.0},
                                                 {0x1.fd5ba9aac2f6ep-4, -0x1.cd37686760c17p-59},
                                                 {0x1.f5b75f92c80ddp-3, 0x1.8ab6e3cf7afbdp-57},
                                                 {0x1.6f61941e4def1p-2, -0x1.c63aae6f6e918p-56},
                                                 {0x1.dac670561bb4fp-2, 0x1.a2b7f222f65e2p-56},
                                                 {0x1.1e00babdefeb4p-1, -0x1.928df287a668fp-58},
                                                 {0x1.4978fa3269ee1p-1, 0x1.2419a87f2a458p-56},
                                                 {0x1.700a7c5784634p-1, -0x1.8c34d25aadef6p-56},
                                                 {0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55}}};
/// atan(x) = x + x^3 * a(x^2); on [-1/16, 1/16] what is left out is below 1e-18 of the sum.
constexpr std::array atan_terms = {-1.0 / 3.0, 1.0 / 5.0, -1.0 / 7.0, 1.0 / 9.0, -1.0 / 11.0, 1.0 / 13.0};

/// atan(t) for t in [0, 1]: the next eighth, and by the addition theorem what it is off.
Sum atan_to_1(double t) {
    const double eighths = std::nearbyint(8.0 * t);
    const double c = eighths / 8.0;
    const double u = (t - c) / (1.0 + t * c);
    const double z = u * u;
    const Sum& known = atan_of_eighths[static_cast<std::size_t>(eighths)];
    const Sum sum = exact_sum(known.high, u);
    return {sum.high, sum.low + (known.low + u * z * polynomial(atan_terms, z))};
}

constexpr Sum log_2{0x1.62e42fefa38p-1, 0x1.ef35793c7673p-45};  ///< its products with an exponent are exact
/// log((1 + s) / (1 - s)) = 2 s + s * l(s^2), l without its constant; s up to 0.172
constexpr std::array log_terms = {2.0 / 3.0,  2.0 / 5.0,  2.0 / 7.0,  2.0 / 9.0,  2.0 / 11.0,
                                  2.0 / 13.0, 2.0 / 15.0, 2.0 / 17.0, 2.0 / 19.0, 2.0 / 21.0};

/// exp(r) = 1 + r + r^2 * e(r); on [-ln(2)/2, ln(2)/2] what is left out is below 1e-18.
constexpr std::array exp_terms = {1.0 / 2.0,          1.0 / 6.0,        1.0 / 24.0,        1.0 / 120.0,
                                  1.0 / 720.0,        1.0 / 5040.0,     1.0 / 40320.0,     1.0 / 362880.0,
                                  1.0 / 3628800.0,    1.0 / 39916800.0, 1.0 / 479001600.0, 1.0 / 6227020800.0,
                                  1.0 / 87178291200.0};

}  // namespace

double sin(double x) {
    if (!std::isfinite(x)) return std::numeric_limits<double>::quiet_NaN();
    if (x == 0.0) return x;
    const Quarters angle = reduced(x);
    const double value = angle.count % 2 == 0 ? sine_of_rest(angle.rest) : cosine_of_rest(angle.rest);
    return angle.count < 2 ? value : -value;
}

double cos(double x) {
    if (!std::isfinite(x)) return std::numeric_limits<double>::quiet_NaN();
    const Quarters angle = reduced(x);
    const double value = angle.count % 2 == 0 ? cosine_of_rest(angle.rest) : sine_of_rest(angle.rest);
    return angle.count == 0 || angle.count == 3 ? value : -value;
}

double tan(double x) {
    if (!std::isfinite(x)) return std::numeric_limits<double>::quiet_NaN();
    if (x == 0.0) return x;
    const Quarters angle = reduced(x);
    const double s = sine_of_rest(angle.rest), c = cosine_of_rest(angle.rest);
    return angle.count % 2 == 0 ? s / c : -c / s;
}

double atan2(double y, double x) {
    if (std::isnan(x) || std::isnan(y)) return std::numeric_limits<double>::quiet_NaN();
    double up = std::abs(y), along = std::abs(x);
    if (std::isinf(up) || std::isinf(along)) {
        // Only which of them is infinite counts.
        up = std::isinf(up) ? 1.0 : 0.0;
        along = std::isinf(along) ? 1.0 : 0.0;
    }
    const bool is_steep = up > along;
    const double t = up == 0.0 ? 0.0 : is_steep ? along / up : up / along;
    Sum angle = atan_to_1(t);
    const auto complement = [&](const Sum& whole) {
        const Sum difference = exact_sum(whole.high, -angle.high);
        angle = {difference.high, difference.low + (whole.low - angle.low)};
    };
    if (is_steep) complement(half_pi);
    if (std::signbit(x)) complement(pi);
    return std::copysign(angle.high + angle.low, y);
}

double atan(double x) {
    return atan2(x, 1.0);
}

double log(double x) {
    if (std::isnan(x) || x < 0.0) return std::numeric_limits<double>::quiet_NaN();
    if (x == 0.0) return -std::numeric_limits<double>::infinity();
    if (std::isinf(x)) return x;
    int exponent = 0;
    double m = std::frexp(x, &exponent);  // [1/2, 1)
    if (m < std::numbers::sqrt2 / 2.0) {
        m *= 2.0;
        --exponent;
    }
    const double f = m - 1.0;
    const double s = f / (2.0 + f);
    const double z = s * s;
    // 2 s = f - s f; written so, only small parts are rounded.
    const double half_square = 0.5 * f * f;
    const double small = s * (half_square + z * polynomial(log_terms, z));
    const auto e = static_cast<double>(exponent);
    return e * log_2.high - ((half_square - (small + e * log_2.low)) - f);
}

double exp(double x) {
    if (std::isnan(x)) return x;
    if (x > 710.0) return std::numeric_limits<double>::infinity();
    if (x < -746.0) return 0.0;
    const double exponent = std::nearbyint(x / log_2.high);
    const Sum r = exact_sum(x - exponent * log_2.high, -exponent * log_2.low);
    const double small = r.low + r.high * r.high * polynomial(exp_terms, r.high);
    return std::ldexp(1.0 + (r.high + small), static_cast<int>(exponent));
}

}  // namespace camrig::portable

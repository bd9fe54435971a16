#include "core/base/portable_math.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace camrig {
namespace {

/// How far off, in units in the last place of the right answer. `right` has 64 bits where long double is x87's.
double ulps(double got, long double right) {
    const auto near = static_cast<double>(right);
    if (got == near) return 0.0;
    const double unit = std::abs(near - std::nextafter(near, 0.0));
    return static_cast<double>(std::abs(static_cast<long double>(got) - right)) / unit;
}

/// Angles of every size: around each multiple of pi/4, between them, tiny ones and large ones.
std::vector<double> angles() {
    std::vector<double> all;
    for (int i = 0; i < 200; ++i) {
        const double multiple = i * std::numbers::pi / 4.0;
        all.insert(all.end(), {multiple, std::nextafter(multiple, 1e9), std::nextafter(multiple, -1e9)});
    }
    for (std::uint64_t i = 0; i < 50'000; ++i) {
        const double unit = random_unit(1, 2, i);
        all.push_back((unit - 0.5) * 20.0);
        all.push_back((unit - 0.5) * 2e6);
        all.push_back(std::ldexp(unit, -static_cast<int>(i % 60)));
    }
    return all;
}

TEST(PortableMath, SineCosineAndTangentAreRightToTheStatedUnits) {
    double sine = 0.0, cosine = 0.0, tangent = 0.0;
    for (const double x : angles()) {
        const long double exact = x;
        sine = std::max(sine, ulps(portable::sin(x), std::sin(exact)));
        cosine = std::max(cosine, ulps(portable::cos(x), std::cos(exact)));
        tangent = std::max(tangent, ulps(portable::tan(x), std::tan(exact)));
    }
    EXPECT_LT(sine, 1.0);
    EXPECT_LT(cosine, 1.0);
    EXPECT_LT(tangent, 3.0);
}

TEST(PortableMath, ArcTangentIsRightToTheStatedUnitsInAllQuadrants) {
    double worst = 0.0, worst_of_one = 0.0;
    for (std::uint64_t i = 0; i < 100'000; ++i) {
        const double scale = std::ldexp(1.0, static_cast<int>(i % 80) - 40);
        const double y = random_unit(3, 1, i) - 0.5, x = scale * (random_unit(3, 2, i) - 0.5);
        worst = std::max(worst, ulps(portable::atan2(y, x), std::atan2(static_cast<long double>(y), x)));
        worst_of_one = std::max(worst_of_one, ulps(portable::atan(x), std::atan(static_cast<long double>(x))));
    }
    EXPECT_LT(worst, 1.5);
    EXPECT_LT(worst_of_one, 1.5);
}

TEST(PortableMath, LogarithmIsRightToTheStatedUnits) {
    double worst = 0.0;
    for (std::uint64_t i = 0; i < 100'000; ++i) {
        const double unit = random_unit(4, 1, i);
        for (const double x : {1.0 - unit, 0.9 + 0.2 * unit, std::ldexp(unit, static_cast<int>(i % 2000) - 1000)})
            if (x > 0.0) worst = std::max(worst, ulps(portable::log(x), std::log(static_cast<long double>(x))));
    }
    EXPECT_LT(worst, 1.0);
}

TEST(PortableMath, ExponentialIsRightToTheStatedUnits) {
    double worst = 0.0;
    for (std::uint64_t i = 0; i < 100'000; ++i) {
        const double unit = random_unit(5, 1, i) - 0.5;
        for (const double x : {unit, 20.0 * unit, 1400.0 * unit, std::ldexp(unit, -static_cast<int>(i % 60))})
            worst = std::max(worst, ulps(portable::exp(x), std::exp(static_cast<long double>(x))));
    }
    EXPECT_LT(worst, 1.0);
}

TEST(PortableMath, SpecialArgumentsAreAsInC) {
    const double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
    for (const double y : {0.0, -0.0, 1.0, -1.0, inf, -inf, 5e-324, 1e308})
        for (const double x : {0.0, -0.0, 1.0, -1.0, inf, -inf, 5e-324, 1e308}) {
            EXPECT_EQ(portable::atan2(y, x), std::atan2(y, x)) << y << ", " << x;
            EXPECT_EQ(std::signbit(portable::atan2(y, x)), std::signbit(std::atan2(y, x))) << y << ", " << x;
        }
    EXPECT_TRUE(std::isnan(portable::atan2(nan, 1.0)) && std::isnan(portable::atan2(1.0, nan)));
    for (const double x : {inf, -inf, nan})
        EXPECT_TRUE(std::isnan(portable::sin(x)) && std::isnan(portable::cos(x)) && std::isnan(portable::tan(x)));
    EXPECT_TRUE(std::signbit(portable::sin(-0.0)) && std::signbit(portable::tan(-0.0)));
    EXPECT_EQ(portable::cos(0.0), 1.0);
    EXPECT_EQ(portable::log(1.0), 0.0);
    EXPECT_EQ(portable::log(0.0), -inf);
    EXPECT_EQ(portable::log(inf), inf);
    EXPECT_TRUE(std::isnan(portable::log(-1.0)));
    for (const double x : {0.0, -0.0, inf, -inf, 709.9, -746.5, 1e300, -1e300})
        EXPECT_EQ(portable::exp(x), std::exp(x)) << x;
    EXPECT_TRUE(std::isnan(portable::exp(nan)));
    EXPECT_NEAR(portable::sin(1e15), std::sin(1e15), 0.2) << "beyond exact reduction: off by 1e-16 of the angle";
}

}  // namespace
}  // namespace camrig

#include "core/render/surface_tables.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace camrig::render {
namespace {

/// What a dielectric's surface mirrors to a view at that cosine of light that is the same all around, and what it
/// leaves to the base: glTF 2.0, appendix B, added up over lights.
struct Shares {
    double mirrored, left;
};
Shares shares(double nv, double roughness) {
    constexpr int cosines = 700, turns = 700;
    const double a2 = std::pow(roughness, 4);
    const auto visibility = [&](double cosine) {
        return 1.0 / (cosine + std::sqrt(a2 + (1.0 - a2) * cosine * cosine));
    };
    double mirrored = 0.0, left = 0.0;
    for (int j = 0; j < cosines; ++j) {
        // Evenly by the square of the cosine.
        const double nl = std::sqrt((j + 0.5) / cosines);
        for (int k = 0; k < turns; ++k) {
            const double turn = (k + 0.5) / turns * std::numbers::pi;
            const double vl = std::sqrt((1.0 - nv * nv) * (1.0 - nl * nl)) * std::cos(turn) + nv * nl;
            const double vh = std::sqrt(0.5 * (1.0 + vl)), nh = (nv + nl) / (2.0 * vh);
            const double fresnel = 0.04 + 0.96 * std::pow(1.0 - vh, 5);
            const double d = nh * nh * (a2 - 1.0) + 1.0;
            mirrored += fresnel * a2 / (d * d) * visibility(nl) * visibility(nv);
            left += 1.0 - fresnel;
        }
    }
    return {mirrored / (cosines * turns), left / (cosines * turns)};
}

TEST(SurfaceTables, AreTheSumsOverAllLightsOfGltfsFormulas) {
    const auto table = make_reflectance_table();
    for (const int row : {9, 16, 24, 31}) {
        for (const int column : {3, 8, 16, 31}) {
            const double cosine = column / (table_side - 1.0), roughness = row / (table_side - 1.0);
            const Shares expected = shares(cosine, roughness);
            const glm::vec2 found = table[static_cast<std::size_t>(row * table_side + column)];
            EXPECT_NEAR(dielectric_f0 * found.x + found.y, expected.mirrored, 0.002) << cosine << " " << roughness;
            EXPECT_NEAR(share_of_base(static_cast<float>(cosine)), expected.left, 0.0004) << cosine;
        }
    }
}

}  // namespace
}  // namespace camrig::render

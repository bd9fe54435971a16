#include "core/camera/lens_map.h"

#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/unit/camera/random_lens.h"

namespace camrig::camera::lens_map_test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double deg = pi / 180.0;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

LensMap map_of(const Lens& lens) {
    auto map = LensMap::create(lens);
    EXPECT_TRUE(map) << (map ? "" : map.error().message);
    return map ? *map : LensMap();
}

/// OpenCV's formulas, written down a second time in long double as its documentation has them.
glm::dvec2 opencv_formula(const Lens& lens, double x_in, double y_in) {
    const auto& k = lens.coefficients;
    const long double x = x_in, y = y_in;
    if (lens.model == LensModel::equidistant) {  // of the angle plane
        const long double t = std::hypot(x, y);
        if (t == 0) return {0, 0};
        const long double td = t * (1 + k[0] * std::pow(t, 2.0L) + k[1] * std::pow(t, 4.0L) + k[2] * std::pow(t, 6.0L) +
                                    k[3] * std::pow(t, 8.0L));
        return {static_cast<double>(td * x / t), static_cast<double>(td * y / t)};
    }
    const long double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
    const long double radial = (1 + k[0] * r2 + k[1] * r4 + k[4] * r6) / (1 + k[5] * r2 + k[6] * r4 + k[7] * r6);
    return {static_cast<double>(x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x)),
            static_cast<double>(y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y)};
}

/// The usable part of a valid disc: a plane model without a fold goes to infinity, no test needs to.
double test_radius(const LensMap& map) {
    return std::min(map.valid_radius(), std::tan(85 * deg));
}

TEST(LensMap, ForwardIsTheFormulaOfOpenCv) {
    for (std::uint64_t n = 0; n < 3000; ++n) {
        const Lens lens = random_lens(n);
        const auto map = LensMap::create(lens);
        if (!map) continue;
        Draw draw(n);
        for (int i = 0; i < 20; ++i) {
            const double r = test_radius(*map) * draw.uniform(0, 0.99), phi = draw.uniform(-pi, pi);
            const glm::dvec2 ideal(r * std::cos(phi), r * std::sin(phi));
            const glm::dvec2 expected = opencv_formula(lens, ideal.x, ideal.y);
            ASSERT_LT(glm::length(map->distort(ideal) - expected), 1e-12 * std::max(1.0, glm::length(expected))) << n;
        }
    }
}

TEST(LensMap, PinholeChangesNothingAndHasNoLimit) {
    const LensMap map = map_of({});
    EXPECT_TRUE(map.is_identity());
    EXPECT_FALSE(map.folds());
    EXPECT_EQ(map.valid_radius(), inf);
    EXPECT_EQ(map.valid_angle(), 0.5 * pi);
    const glm::dvec2 far(1e12, -3e7);
    EXPECT_EQ(map.distort(far), far);
    EXPECT_EQ(map.undistort(far), far);
    EXPECT_EQ(map.derivative(far), glm::dmat2(1.0));
    EXPECT_TRUE(map_of({LensModel::plumb_bob, {}}).is_identity());
    EXPECT_TRUE(map_of({LensModel::rational_polynomial, {}}).is_identity());
    EXPECT_FALSE(map_of({LensModel::equidistant, {}}).is_identity());
}

TEST(LensMap, DerivativeIsThatOfTheForwardMap) {
    for (std::uint64_t n = 0; n < 3000; ++n) {
        const auto map = LensMap::create(random_lens(n));
        if (!map) continue;
        Draw draw(n);
        for (int i = 0; i < 10; ++i) {
            const double r = test_radius(*map) * draw.uniform(0, 0.9), phi = draw.uniform(-pi, pi),
                         h = 1e-5 * (1e-3 + r);
            const glm::dvec2 v(r * std::cos(phi), r * std::sin(phi));
            const glm::dmat2 j = map->derivative(v);
            const glm::dvec2 dx = (map->distort(v + glm::dvec2(h, 0)) - map->distort(v - glm::dvec2(h, 0))) / (2 * h);
            const glm::dvec2 dy = (map->distort(v + glm::dvec2(0, h)) - map->distort(v - glm::dvec2(0, h))) / (2 * h);
            const double size = 1.0 + glm::length(j[0]) + glm::length(j[1]);
            ASSERT_LT(glm::length(j[0] - dx), 1e-5 * size) << n;
            ASSERT_LT(glm::length(j[1] - dy), 1e-5 * size) << n;
        }
    }
}

TEST(ValidRadius, KnownFolds) {
    // One coefficient: d(r + k1 r^3) = 0 at r = 1 / sqrt(-3 k1).
    const LensMap one = map_of({LensModel::plumb_bob, {-0.3}});
    EXPECT_TRUE(one.folds());
    EXPECT_NEAR(one.valid_radius(), 1 / std::sqrt(0.9), 1e-15);
    EXPECT_NEAR(one.valid_angle(), std::atan(1 / std::sqrt(0.9)), 1e-15);
    // The realistic lens of the notes whose fold lies just inside the corner of its picture: 57.3 deg.
    EXPECT_NEAR(map_of({LensModel::plumb_bob, {-0.32, 0.13, 0, 0, -0.025}}).valid_radius(), 1.557, 5e-4);
    // Pincushion never folds; a barrel with a strong k2 recovers before it does.
    EXPECT_FALSE(map_of({LensModel::plumb_bob, {0.3}}).folds());
    EXPECT_FALSE(map_of({LensModel::plumb_bob, {-0.3, 0.1}}).folds());
    EXPECT_TRUE(map_of({LensModel::plumb_bob, {-0.3, 0.04}}).folds());
    // A pole of the rational model ends it: 1 - r^2 / 4.
    const LensMap pole = map_of({LensModel::rational_polynomial, {0, 0, 0, 0, 0, -0.25, 0, 0}});
    EXPECT_TRUE(pole.folds());
    EXPECT_NEAR(pole.valid_radius(), 2.0 * (1 - 1e-4), 1e-14);
    // Fisheye: 1 + 3 k1 t^2 = 0.
    EXPECT_NEAR(map_of({LensModel::equidistant, {-0.1}}).valid_radius(), 1 / std::sqrt(0.3), 1e-15);
    EXPECT_FALSE(map_of({LensModel::equidistant, {}}).folds());
    EXPECT_EQ(map_of({LensModel::equidistant, {}}).valid_radius(), pi);
    // Tangential terms alone: in their worst direction the slope is 1 - 6 p r.
    EXPECT_NEAR(map_of({LensModel::plumb_bob, {0, 0, 3e-3, 4e-3}}).valid_radius(), 1 / (6 * 5e-3), 1e-12);
}

TEST(ValidRadius, IsTheFirstPlaceWhereTheRadialProfileStopsRising) {
    int folded = 0;
    for (std::uint64_t n = 0; n < 5000; ++n) {
        Lens lens = random_lens(n);
        if (lens.model != LensModel::equidistant) lens.coefficients[2] = lens.coefficients[3] = 0.0;
        const auto map = LensMap::create(lens);
        if (!map) continue;
        folded += map->folds();
        const double radius = test_radius(*map);
        double before = 0.0;
        for (int i = 1; i <= 400; ++i) {  // rises up to there ...
            const double now = map->distort({radius * (1 - 1e-9) * i / 400, 0}).x;
            ASSERT_GT(now, before) << n << " at " << i;
            before = now;
        }
        if (!map->folds() || radius < map->valid_radius()) continue;
        // ... and no further: it turns over, or jumps at a pole.
        const double inside = map->distort({radius * (1 - 1e-4), 0}).x,
                     beyond = map->distort({radius * (1 + 2e-4), 0}).x;
        ASSERT_LT(beyond, inside) << n;
    }
    EXPECT_GT(folded, 1500);
}

TEST(ValidRadius, WithTangentialTermsTheJacobianIsPositiveDefiniteOnTheWholeDisc) {
    for (std::uint64_t n = 0; n < 2000; ++n) {
        const auto map = LensMap::create(random_lens(n));
        if (!map) continue;
        Draw draw(n);
        for (int i = 0; i < 400; ++i) {
            const double r = test_radius(*map) * std::sqrt(draw.uniform(0, 0.999999)), phi = draw.uniform(-pi, pi);
            const glm::dmat2 j = map->derivative({r * std::cos(phi), r * std::sin(phi)});
            ASSERT_GT(j[0][0] + j[1][1], 0.0) << n;
            ASSERT_GT(glm::determinant(j), 0.0) << n;
        }
    }
}

// The gate: every lens, every point, both ways.
TEST(InverseMap, TenThousandLensesAndAMillionPointsHaveNoResidualAndNeverLeaveTheValidDisc) {
    double worst = 0.0;
    int lenses = 0, points = 0, refused = 0, made = 0;
    for (std::uint64_t n = 0; lenses < 10000; ++n) {
        ++made;
        const auto map = LensMap::create(random_lens(n));
        if (!map) continue;
        ++lenses;
        Draw draw(n);
        const double radius = test_radius(*map);
        for (int i = 0; i < 50; ++i) {  // directions the lens shows: all must be found again
            const double phi = draw.uniform(-pi, pi);
            const double r =
                radius * (i % 10 ? std::sqrt(draw.uniform(0, 1)) : 1 - std::pow(10.0, draw.uniform(-8, 0)));
            const glm::dvec2 ideal(r * std::cos(phi), r * std::sin(phi));
            if (!map->contains(ideal)) continue;
            const glm::dvec2 distorted = map->distort(ideal);
            const auto found = map->undistort(distorted);
            ASSERT_TRUE(found) << "lens " << n << " r " << r << " of " << map->valid_radius() << " phi " << phi;
            ASSERT_TRUE(map->contains(*found));
            const double size = std::max(1.0, glm::length(distorted));
            const double residual = glm::length(map->distort(*found) - distorted) / size;
            worst = std::max(worst, residual);
            ASSERT_LT(residual, 1e-9) << n;
            // One-to-one: where the map is well conditioned the very same point comes back.
            const glm::dmat2 j = map->derivative(ideal);
            if (glm::determinant(j) > 1e-3 * (j[0][0] + j[1][1])) {
                ASSERT_LT(glm::length(*found - ideal), 1e-9 * size) << n;
            }
            ++points;
        }
        for (int i = 0; i < 50; ++i) {  // pixels anywhere: found with no residual and inside, or refused
            const double reach = i % 2 ? 3.0 : 1.2 * glm::length(map->distort({radius, 0}));
            const glm::dvec2 distorted(draw.uniform(-reach, reach), draw.uniform(-reach, reach));
            const auto found = map->undistort(distorted);
            ++points;
            if (!found) {
                ++refused;
                continue;
            }
            ASSERT_TRUE(map->contains(*found)) << n;
            const double residual =
                glm::length(map->distort(*found) - distorted) / std::max(1.0, glm::length(distorted));
            worst = std::max(worst, residual);
            ASSERT_LT(residual, 1e-9) << n;
        }
    }
    RecordProperty("lenses_drawn", made);
    RecordProperty("points", points);
    RecordProperty("beyond_the_fold", refused);
    std::printf("%d lenses of %d drawn, %d points, %d beyond the fold, worst relative residual %.2e\n", lenses, made,
                points, refused, worst);
    EXPECT_LT(worst, 1e-9);
    EXPECT_GE(points, 990000);
}

TEST(InverseMap, BeyondTheFoldThereIsNothing) {
    const LensMap map = map_of({LensModel::plumb_bob, {-0.32, 0.13, 0, 0, -0.025}});
    const double edge = map.distort({map.valid_radius(), 0}).x;
    for (int i = 0; i < 3600; ++i) {
        const glm::dvec2 direction(std::cos(i * 0.1 * deg), std::sin(i * 0.1 * deg));
        EXPECT_TRUE(map.undistort(direction * (edge * (1 - 1e-12))));
        EXPECT_FALSE(map.undistort(direction * (edge * (1 + 1e-12))));
        EXPECT_FALSE(map.undistort(direction * (edge * 3)));
    }
}

TEST(InverseMap, TheLensesThatOpenCvFailsOnAreSolved) {
    // kornia #4285: k1 = 0.5, three focal lengths off axis; OpenCV's iteration diverges there.
    const LensMap pincushion = map_of({LensModel::plumb_bob, {0.5}});
    const auto found = pincushion.undistort({3, 0});
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->x + 0.5 * found->x * found->x * found->x, 3.0, 1e-14);
    // brush #538: Newton landed on the far branch of a fisheye polynomial; the answer must stay before the fold.
    const LensMap fisheye = map_of({LensModel::equidistant, {-0.02, -0.01, 0.002, -0.0015}});
    ASSERT_TRUE(fisheye.folds());
    const double edge = fisheye.distort({fisheye.valid_radius(), 0}).x;
    for (int i = 1; i < 1000; ++i) {
        const auto theta = fisheye.undistort({edge * i / 1000, 0});
        ASSERT_TRUE(theta);
        EXPECT_LT(theta->x, fisheye.valid_radius());
        EXPECT_NEAR(fisheye.distort(*theta).x, edge * i / 1000, 1e-14);
    }
}

TEST(InverseMap, NotFiniteAndHugeInputIsRefusedOrSolved) {
    for (std::uint64_t n = 0; n < 300; ++n) {
        const auto map = LensMap::create(random_lens(n));
        if (!map) continue;
        for (const double bad : {nan, inf, -inf}) {
            EXPECT_FALSE(map->undistort({bad, 0}));
            EXPECT_FALSE(map->undistort({0, bad}));
        }
        for (const double huge : {1e3, 1e9, 1e100, 1e200, 1.7e308}) {
            const auto found = map->undistort({huge, -huge});
            EXPECT_TRUE(!found || map->contains(*found)) << n << ' ' << huge;
        }
        for (const double small : {0.0, -0.0, 5e-324, 1e-310, 1e-200, 1e-20, 1e-9}) {
            const auto found = map->undistort({small, -small});
            ASSERT_TRUE(found) << n << ' ' << small;
            EXPECT_NEAR(found->x, small, 1e-9 * small) << n;
        }
    }
}

TEST(Directions, FisheyeSeesBehindItself) {
    const LensMap map = map_of({LensModel::equidistant, {}});
    for (const double angle : {0.0, 1e-12, 1e-9, 1e-8, 1e-4, 30.0, 89.999999, 90.0, 100.0, 110.0, 179.0, 179.999}) {
        for (const double phi : {0.0, 40.0, 90.0, 181.0, 300.0}) {
            const double t = angle * deg, p = phi * deg;
            const glm::dvec3 direction(std::sin(t) * std::cos(p), std::sin(t) * std::sin(p), std::cos(t));
            for (const double length : {1e-6, 1.0, 1e9}) {
                const auto ideal = map.ideal_from_direction(direction * length);
                ASSERT_TRUE(ideal) << angle;
                EXPECT_NEAR(ideal->x, t * std::cos(p), 1e-15 * (1 + t)) << angle;
                EXPECT_NEAR(ideal->y, t * std::sin(p), 1e-15 * (1 + t)) << angle;
                EXPECT_LT(glm::length(map.direction_from_ideal(*ideal) - direction), 1e-15);
            }
        }
    }
    EXPECT_FALSE(map.ideal_from_direction({0, 0, -1}));
    EXPECT_FALSE(map.ideal_from_direction({0, 0, 0}));
}

TEST(Directions, AnglesNearTheAxisKeepAllTheirDigits) {
    // acos(z) loses every digit below 1e-8 rad; atan2 and the series do not.
    const LensMap map = map_of({LensModel::equidistant, {0.1, 0.01, 0, 0}});
    for (int e = -300; e <= -2; ++e) {
        const double theta = std::pow(10.0, e);
        const auto ideal = map.ideal_from_direction({3 * std::tan(theta), 0, 3});
        ASSERT_TRUE(ideal);
        EXPECT_NEAR(ideal->x / theta, 1.0, 4e-16) << e;
        const auto back = map.undistort(map.distort(*ideal));
        ASSERT_TRUE(back);
        EXPECT_NEAR(map.direction_from_ideal(*back).x / std::sin(theta), 1.0, 1e-15) << e;
    }
}

TEST(Directions, PlaneModelsSeeOnlyWhatIsInFront) {
    const LensMap map = map_of({LensModel::plumb_bob, {-0.1}});
    EXPECT_TRUE(map.ideal_from_direction({1, 2, 1e-3}));
    for (const glm::dvec3 v : {glm::dvec3(1, 2, 0), glm::dvec3(1, 2, -3), glm::dvec3(0), glm::dvec3(nan, 0, 1),
                               glm::dvec3(0, inf, 1), glm::dvec3(0, 0, nan), glm::dvec3(1, 0, 5e-324)})
        EXPECT_FALSE(map.ideal_from_direction(v));
    const glm::dvec3 ray = map.direction_from_ideal({0.75, 1.0});
    EXPECT_NEAR(ray.x / ray.z, 0.75, 1e-16);
    EXPECT_NEAR(glm::length(ray), 1.0, 2e-16);
}

TEST(Directions, OutAndBackIsTheSameDirection) {
    for (const LensModel model : {LensModel::pinhole, LensModel::equidistant}) {
        const LensMap map = map_of({model, {}});
        Draw draw(77);
        for (int i = 0; i < 2000; ++i) {
            const double t = (model == LensModel::pinhole ? 80 : 170) * deg * draw.uniform(0, 1),
                         phi = draw.uniform(-pi, pi);
            const glm::dvec3 v(std::sin(t) * std::cos(phi), std::sin(t) * std::sin(phi), std::cos(t));
            const auto ideal = map.ideal_from_direction(std::pow(10.0, draw.uniform(-3, 3)) * v);
            ASSERT_TRUE(ideal);
            ASSERT_LT(glm::length(map.direction_from_ideal(*ideal) - v), 1e-14) << t / deg;
        }
    }
}

TEST(BadLenses, AreRefusedWithTheReason) {
    const auto refused = [](const Lens& lens, const char* reason) {
        const auto map = LensMap::create(lens);
        ASSERT_FALSE(map) << reason;
        EXPECT_EQ(map.error().kind, ErrorKind::invalid_argument);
        EXPECT_NE(map.error().message.find(reason), std::string::npos) << map.error().message;
    };
    for (const double bad : {nan, inf, -inf, 1e10}) {
        refused({LensModel::plumb_bob, {0, bad}}, "finite");
        refused({LensModel::equidistant, {0, 0, 0, bad}}, "finite");
        refused({LensModel::pinhole, {bad}}, "finite");
    }
    refused({LensModel::pinhole, {0.1}}, "one too many");
    refused({LensModel::equidistant, {0, 0, 0, 0, 0.1}}, "takes 4");
    refused({LensModel::plumb_bob, {0, 0, 0, 0, 0, 1e-3}}, "takes 5");
    // Coefficients in the wrong units (of pixels, not of focal lengths) fold at once.
    refused({LensModel::plumb_bob, {-1e6}}, "no rising branch");
    refused({LensModel::equidistant, {-5e8}}, "no rising branch");
    refused({LensModel::rational_polynomial, {0, 0, 0, 0, 0, -1e8}}, "no rising branch");
    refused({LensModel::plumb_bob, {0, 0, 1000.0, 0}}, "no rising branch");
}

TEST(BadLenses, AWrongNumberOfCoefficientsIsRefusedWithBothNumbers) {
    const double k[9] = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9};
    for (const auto model :
         {LensModel::pinhole, LensModel::plumb_bob, LensModel::rational_polynomial, LensModel::equidistant}) {
        for (std::size_t count = 0; count <= 9; ++count) {
            const auto lens = make_lens(model, std::span(k, count));
            ASSERT_EQ(lens.has_value(), static_cast<int>(count) == coefficient_count(model));
            if (!lens) {
                EXPECT_NE(lens.error().message.find("not " + std::to_string(count)), std::string::npos);
                continue;
            }
            for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(lens->coefficients[i], i < count ? k[i] : 0.0);
        }
    }
    const double bad[4] = {0, 0, nan, 0};
    EXPECT_FALSE(make_lens(LensModel::equidistant, bad));
}

}  // namespace
}  // namespace camrig::camera::lens_map_test

#include "core/camera/intrinsics.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

namespace camrig::camera::intrinsics_test {
namespace {

constexpr double deg = std::numbers::pi / 180.0;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

TEST(IntrinsicsFromFieldOfView, KnownAnswers) {
    // 90 deg: the focal length is half of the side, edge to edge; the middle lies between the two middle pixels.
    const auto vertical = intrinsics_from_vfov({640, 480}, 90 * deg);
    ASSERT_TRUE(vertical);
    EXPECT_NEAR(vertical->fx, 240.0, 1e-12);
    EXPECT_EQ(vertical->fx, vertical->fy);
    EXPECT_EQ(vertical->cx, 319.5);
    EXPECT_EQ(vertical->cy, 239.5);
    const auto horizontal = intrinsics_from_hfov({641, 481}, 60 * deg);
    ASSERT_TRUE(horizontal);
    EXPECT_NEAR(horizontal->fx, 320.5 * std::sqrt(3.0), 1e-11);
    EXPECT_EQ(horizontal->cx, 320.0);
    EXPECT_EQ(horizontal->cy, 240.0);
}

TEST(IntrinsicsFromFieldOfView, ComesBackFromATenthToNearly180Degrees) {
    for (const double angle : {0.0101, 0.1, 1.0, 30.0, 60.0, 90.0, 150.0, 179.0, 179.89}) {
        for (const ImageSize size : {ImageSize{16, 16}, ImageSize{101, 77}, ImageSize{8192, 8192}}) {
            const auto v = intrinsics_from_vfov(size, angle * deg);
            const auto h = intrinsics_from_hfov(size, angle * deg);
            ASSERT_TRUE(v && h) << angle;
            EXPECT_NEAR(vfov_rad(size, *v) / (angle * deg), 1.0, 1e-13);
            EXPECT_NEAR(hfov_rad(size, *h) / (angle * deg), 1.0, 1e-13);
            EXPECT_TRUE(size.width != size.height || check_intrinsics(size, *v)) << angle;
        }
    }
}

TEST(IntrinsicsFromFieldOfView, AnglesNoPinholeHasAreRefused) {
    for (const double angle :
         {0.0, -0.0, -1.0, 180 * deg, 179.95 * deg, 360 * deg, 0.005 * deg, 5e-324, nan, inf, -inf}) {
        const auto v = intrinsics_from_vfov({640, 480}, angle);
        const auto h = intrinsics_from_hfov({640, 480}, angle);
        ASSERT_FALSE(v) << angle;
        ASSERT_FALSE(h) << angle;
        EXPECT_EQ(v.error().kind, ErrorKind::invalid_argument);
        EXPECT_NE(v.error().message.find("vfov_deg"), std::string::npos);
        EXPECT_NE(h.error().message.find("hfov_deg"), std::string::npos);
    }
}

TEST(IntrinsicsFromFieldOfView, APictureWithoutPixelsIsRefused) {
    for (const ImageSize size : {ImageSize{0, 0}, ImageSize{640, 0}, ImageSize{-640, 480}}) {
        EXPECT_FALSE(intrinsics_from_vfov(size, 1.0));
        EXPECT_FALSE(intrinsics_from_hfov(size, 1.0));
        EXPECT_FALSE(check_intrinsics(size, {100, 100, 50, 50}));
    }
}

TEST(CheckIntrinsics, AcceptsRealCameras) {
    EXPECT_TRUE(check_intrinsics({1920, 1080}, {1050, 1049, 959.5, 539.5}));
    EXPECT_TRUE(check_intrinsics({1920, 1080}, {1050, 525, 200.0, 1200.0}));    // free principal point, fx != fy
    EXPECT_TRUE(check_intrinsics({640, 480}, {500, 500, -3000.0, 240.0}));      // a crop from the side of a sensor
    EXPECT_TRUE(check_intrinsics({1920, 1080}, {1.1e6, 1.1e6, 959.5, 539.5}));  // 0.1 deg
}

TEST(CheckIntrinsics, RefusesWhatNoCameraHas) {
    const Intrinsics good{1050, 1050, 959.5, 539.5};
    for (double Intrinsics::* field : {&Intrinsics::fx, &Intrinsics::fy, &Intrinsics::cx, &Intrinsics::cy}) {
        for (const double value : {nan, inf, -inf}) {
            Intrinsics bad = good;
            bad.*field = value;
            const auto result = check_intrinsics({1920, 1080}, bad);
            ASSERT_FALSE(result);
            EXPECT_EQ(result.error().kind, ErrorKind::invalid_argument);
        }
    }
    for (const double f : {0.0, -0.0, -1050.0, 5e-324, 1e-3, 1e300}) {
        EXPECT_FALSE(check_intrinsics({1920, 1080}, {f, 1050, 959.5, 539.5})) << f;
        EXPECT_FALSE(check_intrinsics({1920, 1080}, {1050, f, 959.5, 539.5})) << f;
    }
    EXPECT_FALSE(check_intrinsics({1920, 1080}, {1050, 1050, 2e6, 539.5}));
    EXPECT_FALSE(check_intrinsics({1920, 1080}, {1050, 1050, 959.5, -2e6}));
}

}  // namespace
}  // namespace camrig::camera::intrinsics_test

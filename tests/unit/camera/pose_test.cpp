#include "core/camera/pose.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace camrig::camera::pose_test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double deg = pi / 180.0;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();
constexpr double denormal = 5e-324;

/// Uniform in [low, high), the n-th number of a stream of this test.
double uniform(std::uint64_t stream, std::uint64_t n, double low, double high) {
    return low + (high - low) * random_unit(7, stream, n);
}

/// Largest departure of R^T R from the unit matrix, and of the determinant from +1.
double orthonormality_error(const glm::dmat3& r) {
    const glm::dmat3 product = glm::transpose(r) * r;
    double worst = std::abs(glm::determinant(r) - 1.0);
    for (int c = 0; c < 3; ++c)
        for (int row = 0; row < 3; ++row) worst = std::max(worst, std::abs(product[c][row] - (c == row ? 1.0 : 0.0)));
    return std::isfinite(worst) ? worst : inf;
}

double largest_difference(const glm::dmat3& a, const glm::dmat3& b) {
    double worst = 0.0;
    for (int c = 0; c < 3; ++c)
        for (int row = 0; row < 3; ++row) worst = std::max(worst, std::abs(a[c][row] - b[c][row]));
    return worst;
}

glm::dvec3 forward_of(const Pose& pose) {
    return glm::mat3_cast(pose.orientation)[0];
}
glm::dvec3 left_of(const Pose& pose) {
    return glm::mat3_cast(pose.orientation)[1];
}
glm::dvec3 up_of(const Pose& pose) {
    return glm::mat3_cast(pose.orientation)[2];
}

void expect_near(const glm::dvec3& actual, const glm::dvec3& expected, double tolerance = 1e-15) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(actual[i], expected[i], tolerance) << "component " << i;
}

TEST(LookAt, LevelDirectionsKeepTheHorizonLevel) {
    const auto east = pose_look_at({1, 2, 3}, {11, 2, 3});
    ASSERT_TRUE(east);
    EXPECT_EQ(east->position, glm::dvec3(1, 2, 3));
    expect_near(forward_of(*east), {1, 0, 0});
    expect_near(left_of(*east), {0, 1, 0});
    const auto north = pose_look_at({0, 0, 0}, {0, 5, 0});
    ASSERT_TRUE(north);
    expect_near(forward_of(*north), {0, 1, 0});
    expect_near(left_of(*north), {-1, 0, 0});
    const auto west_up = pose_look_at({0, 0, 0}, {-1, 0, 1});
    ASSERT_TRUE(west_up);
    expect_near(forward_of(*west_up), {-std::sqrt(0.5), 0, std::sqrt(0.5)});
    expect_near(left_of(*west_up), {0, -1, 0});
}

TEST(LookAt, StraightDownPutsPlusXAtTheTopOfTheImageAndStraightUpMinusX) {
    for (const double distance : {1e-8, 1.0, 1e9}) {
        const auto down = pose_look_at({0, 0, 0}, {0, 0, -distance});
        ASSERT_TRUE(down);
        expect_near(forward_of(*down), {0, 0, -1});
        expect_near(up_of(*down), {1, 0, 0});
        const auto up = pose_look_at({0, 0, 0}, {0, 0, distance});
        ASSERT_TRUE(up);
        expect_near(forward_of(*up), {0, 0, 1});
        expect_near(up_of(*up), {-1, 0, 0});
    }
}

TEST(LookAt, AsStraightDownIsApproachedAlongXTheImageDoesNotTurn) {
    const auto down = pose_look_at({0, 0, 10}, {0, 0, 0});
    ASSERT_TRUE(down);
    for (const double offset : {1e-2, 1e-5, 1e-8, 1.1e-9, 0.9e-9, 1e-12, 1e-300}) {
        const auto near = pose_look_at({0, 0, 1}, {offset, 0, 0});
        ASSERT_TRUE(near);
        EXPECT_LT(largest_difference(glm::mat3_cast(near->orientation), glm::mat3_cast(down->orientation)),
                  2 * offset + 1e-15);
    }
}

TEST(LookAt, EyeAtTheTargetIsAnErrorThatSaysSo) {
    const glm::dvec3 eye{1e6, -3, 2};
    for (const glm::dvec3 offset :
         {glm::dvec3(0), glm::dvec3(0, 0, 5e-10), glm::dvec3(0, denormal, 0), glm::dvec3(-0.0)}) {
        const auto pose = pose_look_at(eye, eye + offset);
        ASSERT_FALSE(pose);
        EXPECT_EQ(pose.error().kind, ErrorKind::invalid_argument);
        EXPECT_NE(pose.error().message.find("look_at"), std::string::npos);
    }
    EXPECT_TRUE(pose_look_at({0, 0, 0}, {2e-9, 0, 0}));
}

TEST(LookAt, NotFiniteOrAbsurdlyFarIsRefusedWithItsName) {
    for (const double bad : {nan, inf, -inf, 1.1e10, -1e300}) {
        for (int i = 0; i < 3; ++i) {
            glm::dvec3 p{1, 2, 3};
            p[i] = bad;
            const auto from = pose_look_at(p, {0, 0, 0});
            const auto to = pose_look_at({0, 0, 0}, p);
            ASSERT_FALSE(from);
            ASSERT_FALSE(to);
            EXPECT_EQ(from.error().message.find("position"), 0u);
            EXPECT_EQ(to.error().message.find("look_at"), 0u);
            EXPECT_FALSE(pose_from_angles(p, {}));
            EXPECT_FALSE(pose_from_quaternion(p, {1, 0, 0, 0}));
        }
    }
    EXPECT_TRUE(pose_look_at({max_coordinate_m, -max_coordinate_m, 0}, {-max_coordinate_m, max_coordinate_m, 1}));
}

TEST(LookAt, IsOrthonormalAndPointsAtTheTargetForRandomAndDegenerateDirections) {
    std::vector<glm::dvec3> directions;
    for (std::uint64_t n = 0; n < 20000; ++n) {
        const double length = std::pow(10.0, uniform(1, n, -8, 9));
        glm::dvec3 d;
        for (int i = 0; i < 3; ++i) d[i] = uniform(2, 3 * n + i, -1, 1);
        // A third of them lie close to a pole: 1e-18 to 1 off the vertical.
        if (n % 3 == 0)
            d = {d.x * std::pow(10.0, uniform(3, n, -18, 0)), d.y * std::pow(10.0, uniform(3, n, -18, 0)), d.z};
        if (glm::length(d) * length > 1e-9) directions.push_back(d * length);
    }
    for (const double a : {0.0, -0.0, denormal, 1e-300, 1e-16, 1.0, -1.0})
        for (const double b : {0.0, denormal, -1e-300, 1e-16, 1.0, -1.0})
            for (const double c : {0.0, 1e-16, 1.0, -1.0, 1e9})
                if (std::hypot(a, b, c) > 1e-9) directions.push_back({a, b, c});
    for (const glm::dvec3& d : directions) {
        const auto pose = pose_look_at({0, 0, 0}, d);
        ASSERT_TRUE(pose) << d.x << ' ' << d.y << ' ' << d.z;
        const glm::dmat3 r = world_from_optical_rotation(*pose);
        ASSERT_LT(orthonormality_error(r), 1e-12) << d.x << ' ' << d.y << ' ' << d.z;
        ASSERT_LT(glm::length(r[2] - d / std::hypot(d.x, d.y, d.z)), 2e-9);
        ASSERT_GE(-r[1].z, -1e-15) << "image upside down";
        ASSERT_NEAR(r[0].z, 0.0, 1e-12) << "horizon not level";
    }
}

TEST(PanTiltRollAngles, EachTurnsTheWayItSays) {
    const auto pose = [](double pan, double tilt, double roll) {
        const auto p = pose_from_angles({0, 0, 0}, {pan * deg, tilt * deg, roll * deg});
        EXPECT_TRUE(p);
        return *p;
    };
    expect_near(forward_of(pose(90, 0, 0)), {0, 1, 0});  // counter-clockwise from above
    expect_near(forward_of(pose(0, 90, 0)), {0, 0, 1});  // up
    expect_near(up_of(pose(0, 90, 0)), {-1, 0, 0});      // the limit of tilting
    expect_near(forward_of(pose(0, -90, 0)), {0, 0, -1});
    expect_near(up_of(pose(0, -90, 0)), {1, 0, 0});
    // Roll clockwise seen from behind: the camera's top goes to the right (-y), its left side up.
    expect_near(up_of(pose(0, 0, 90)), {0, -1, 0});
    expect_near(left_of(pose(0, 0, 90)), {0, 0, 1});
    expect_near(forward_of(pose(0, 0, 90)), {1, 0, 0});
}

TEST(PanTiltRollAngles, MatchTheMatrixWorkedOutByHand) {
    for (std::uint64_t n = 0; n < 5000; ++n) {
        const double p = uniform(4, 3 * n, -7, 7), t = uniform(4, 3 * n + 1, -7, 7), r = uniform(4, 3 * n + 2, -7, 7);
        const double cp = std::cos(p), sp = std::sin(p), ct = std::cos(t), st = std::sin(t), cr = std::cos(r),
                     sr = std::sin(r);
        // Rz(p) * Ry(-t) * Rx(r), multiplied out; columns are forward, left, up.
        const glm::dmat3 by_hand(glm::dvec3(cp * ct, sp * ct, st),
                                 glm::dvec3(-sp * cr - cp * st * sr, cp * cr - sp * st * sr, ct * sr),
                                 glm::dvec3(sp * sr - cp * st * cr, -cp * sr - sp * st * cr, ct * cr));
        const auto pose = pose_from_angles({0, 0, 0}, {p, t, r});
        ASSERT_TRUE(pose);
        ASSERT_LT(largest_difference(glm::mat3_cast(pose->orientation), by_hand), 2e-15);
    }
}

TEST(PanTiltRollAngles, ComeBackFromTheOrientation) {
    for (std::uint64_t n = 0; n < 20000; ++n) {
        const PanTiltRoll in{uniform(5, 3 * n, -pi, pi), uniform(5, 3 * n + 1, -1.5, 1.5),
                             uniform(5, 3 * n + 2, -pi, pi)};
        const auto pose = pose_from_angles({0, 0, 0}, in);
        ASSERT_TRUE(pose);
        const PanTiltRoll out = angles_of(pose->orientation);
        ASSERT_NEAR(out.pan, in.pan, 2e-14);
        ASSERT_NEAR(out.tilt, in.tilt, 2e-14);
        ASSERT_NEAR(out.roll, in.roll, 2e-14);
    }
}

TEST(PanTiltRollAngles, MakeTheSameOrientationAgainUpToThePolesAndAtThem) {
    for (std::uint64_t n = 0; n < 20000; ++n) {
        const double from_pole = n % 5 == 0 ? 0.0 : std::pow(10.0, uniform(6, 4 * n, -17, 0));
        const double tilt = (n % 2 ? 1 : -1) * (0.5 * pi - from_pole);
        const auto pose =
            pose_from_angles({0, 0, 0}, {uniform(6, 4 * n + 1, -pi, pi), tilt, uniform(6, 4 * n + 2, -pi, pi)});
        ASSERT_TRUE(pose);
        const PanTiltRoll angles = angles_of(pose->orientation);
        ASSERT_LE(std::abs(angles.tilt), 0.5 * pi);
        const auto again = pose_from_angles({0, 0, 0}, angles);
        ASSERT_TRUE(again);
        const double error = largest_difference(glm::mat3_cast(again->orientation), glm::mat3_cast(pose->orientation));
        ASSERT_LT(error, from_pole > 2e-9 ? 2e-15 : 4.1e-9) << from_pole;
        if (from_pole < 1e-10) {
            ASSERT_EQ(angles.roll, 0.0);
        }
    }
}

TEST(PanTiltRollAngles, NotFiniteOrRunawayAnglesAreRefused) {
    for (const double bad : {nan, inf, -inf, 1e7}) {
        EXPECT_FALSE(pose_from_angles({0, 0, 0}, {bad, 0, 0}));
        EXPECT_FALSE(pose_from_angles({0, 0, 0}, {0, bad, 0}));
        EXPECT_FALSE(pose_from_angles({0, 0, 0}, {0, 0, bad}));
    }
    EXPECT_TRUE(pose_from_angles({0, 0, 0}, {denormal, -denormal, 1e5}));
}

TEST(Quaternions, AreNormalisedWhateverTheirLength) {
    for (const double scale : {1e-149, 1e-20, 1.0, 3.0, 1e20, 1e300}) {
        const auto pose = pose_from_quaternion({0, 0, 0}, glm::dquat(scale, -scale, scale, scale));
        ASSERT_TRUE(pose) << scale;
        EXPECT_NEAR(glm::length(pose->orientation), 1.0, 4e-16);
        EXPECT_NEAR(pose->orientation.w, 0.5, 2e-16);
        EXPECT_NEAR(pose->orientation.x, -0.5, 2e-16);
    }
    const auto mixed = pose_from_quaternion({0, 0, 0}, glm::dquat(1.0, denormal, 0, 0));
    ASSERT_TRUE(mixed);
    EXPECT_EQ(mixed->orientation.w, 1.0);
}

TEST(Quaternions, ZeroDenormalAndNotFiniteAreRefused) {
    EXPECT_FALSE(pose_from_quaternion({0, 0, 0}, glm::dquat(0, 0, 0, 0)));
    EXPECT_FALSE(pose_from_quaternion({0, 0, 0}, glm::dquat(-0.0, 0, -0.0, 0)));
    EXPECT_FALSE(pose_from_quaternion({0, 0, 0}, glm::dquat(denormal, denormal, 0, 1e-310)));
    for (const double bad : {nan, inf, -inf}) {
        for (int i = 0; i < 4; ++i) {
            glm::dquat q(1, 0, 0, 0);
            q[i] = bad;
            const auto pose = pose_from_quaternion({0, 0, 0}, q);
            ASSERT_FALSE(pose);
            EXPECT_EQ(pose.error().kind, ErrorKind::invalid_argument);
            EXPECT_EQ(pose.error().message.find("orientation"), 0u);
        }
    }
}

TEST(Quaternions, AHundredMillionComposedTurnsStayOrthonormal) {
    // A camera that is turned a little and read back, over and over: every pose passes through pose_from_quaternion.
    const auto step = pose_from_angles({0, 0, 0}, {1e-3, 2e-4, -3e-4});
    ASSERT_TRUE(step);
    glm::dquat q(1, 0, 0, 0);
    for (int n = 0; n < 100'000'000; ++n) {
        q = q * step->orientation;
        if (n % 1000 == 0) q = pose_from_quaternion({0, 0, 0}, q)->orientation;
    }
    EXPECT_LT(orthonormality_error(glm::mat3_cast(pose_from_quaternion({0, 0, 0}, q)->orientation)), 1e-12);
    // One axis throughout, so the answer is known: n times the half angle about it.
    const glm::dquat s = step->orientation;
    const double half = std::fmod(1e8 * std::atan2(std::hypot(s.x, s.y, s.z), s.w), 2 * pi);
    EXPECT_NEAR(q.w, std::cos(half), 1e-6);
}

TEST(OpticalFrame, AxesAreThoseOfRep103) {
    const glm::dmat3 r = link_from_optical();
    EXPECT_EQ(r * glm::dvec3(0, 0, 1), glm::dvec3(1, 0, 0));   // into the scene: forward
    EXPECT_EQ(r * glm::dvec3(1, 0, 0), glm::dvec3(0, -1, 0));  // right of the image: -left
    EXPECT_EQ(r * glm::dvec3(0, 1, 0), glm::dvec3(0, 0, -1));  // down the image: -up
    EXPECT_EQ(orthonormality_error(r), 0.0);
    // REP 103's static transform as a quaternion: xyzw (-0.5, 0.5, -0.5, 0.5).
    EXPECT_EQ(largest_difference(r, glm::mat3_cast(glm::dquat(0.5, -0.5, 0.5, -0.5))), 0.0);
}

TEST(OpticalFrame, AnUnturnedCameraLooksAlongPlusX) {
    const glm::dmat3 r = world_from_optical_rotation(Pose{});
    EXPECT_EQ(r, link_from_optical());
    const auto north = pose_from_angles({5, 5, 5}, {90 * deg, 0, 0});
    ASSERT_TRUE(north);
    expect_near(world_from_optical_rotation(*north) * glm::dvec3(0, 0, 1), {0, 1, 0});
    expect_near(world_from_optical_rotation(*north) * glm::dvec3(1, 0, 0), {1, 0, 0});
}

}  // namespace
}  // namespace camrig::camera::pose_test

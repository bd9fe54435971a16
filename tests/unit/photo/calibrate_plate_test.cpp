#include "core/photo/calibrate_plate.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include <Eigen/Dense>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/photo/plate_view.h"

namespace camrig::photo {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr double deg = std::numbers::pi / 180.0;
constexpr ImageSize size{1280, 720};

PlateView camera_at(glm::dvec3 position, camera::PanTiltRoll angles, double focal, double k1 = 0.0) {
    PlateView view;
    view.k = {focal, focal, 639.5, 359.5};
    view.lens = *camera::LensMap::create({camera::LensModel::plumb_bob, {k1}});
    view.position = position;
    view.world_from_optical = camera::world_from_optical_rotation(*camera::pose_from_angles(position, angles));
    return view;
}

/// A place as a user finds it: points on the ground all over the picture, and some higher up.
struct Place {
    PlateView view;
    PlateTask task;
    std::mt19937_64 random;

    double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
    glm::dvec2 clicked(glm::dvec2 px, double error_px) {
        std::normal_distribution<double> off(0.0, 1.0);
        const double x = off(random), y = off(random);
        return px + error_px * glm::dvec2(x, y);
    }
    void add_points(std::size_t count, double error_px, std::function<double()> height) {
        while (task.points.size() < count) {
            const glm::dvec2 px(uniform(40, 1240), uniform(40, 700));
            const auto ground = view.on_ground(px, 0.0);
            if (!ground || glm::distance(*ground, view.position) > 60.0) continue;
            const glm::dvec3 m = *ground + glm::dvec3(0, 0, height());
            const auto seen = view.project(m);
            if (!seen || seen->x < 0 || seen->y < 0 || seen->x > 1279 || seen->y > 719) continue;
            task.points.push_back({clicked(*seen, error_px), m});
        }
    }
};

Place random_place(std::uint64_t seed, double k1 = 0.0) {
    Place place{{}, {.size = size}, std::mt19937_64(seed)};
    const double focal = 1280 * place.uniform(0.6, 1.5);
    const glm::dvec3 position(place.uniform(-20, 20), place.uniform(-20, 20), place.uniform(2.5, 9.0));
    const double pan = place.uniform(-180, 180), tilt = place.uniform(-38, -12), roll = place.uniform(-4, 4);
    place.view = camera_at(position, {pan * deg, tilt * deg, roll * deg}, focal, k1);
    return place;
}

/// Whether the truth is in the 95 % region of all that was sought together.
bool is_in_region(const PlateCalibration& found, const PlateView& truth, double true_k1 = 0.0) {
    const auto count = Eigen::Index(found.unknowns.size());
    const Eigen::Map<const Eigen::MatrixXd> covariance(found.covariance.data(), count, count);
    const glm::dquat is = found.pose.orientation, was = pose_of(truth).orientation;
    glm::dquat turn = was * glm::conjugate(is);
    if (turn.w < 0) turn = -turn;
    const glm::dvec3 about = 2.0 * glm::dvec3(turn.x, turn.y, turn.z);
    Eigen::VectorXd off(count);
    for (Eigen::Index n = 0; n < count; ++n) {
        const auto unknown = found.unknowns[std::size_t(n)];
        if (unknown <= PlateUnknown::turn_z)
            off[n] = about[int(unknown)];
        else if (unknown <= PlateUnknown::z)
            off[n] = (truth.position - found.pose.position)[int(unknown) - int(PlateUnknown::x)];
        else if (unknown == PlateUnknown::focal)
            off[n] = std::log(truth.k.fx / found.intrinsics.fx);
        else
            off[n] = true_k1 - found.lens.coefficients[0];
    }
    return off.dot(covariance.ldlt().solve(off)) <= found.region_95;
}

struct Case {
    const char* name;
    std::size_t points;
    bool on_ground, is_stated, knows_focal;
    double k1 = 0.0;
};

void PrintTo(const Case& of, std::ostream* out) {
    *out << of.name;
}

class Coverage : public testing::TestWithParam<Case> {};

TEST_P(Coverage, TheTruthIsInThe95PercentRegionAsOftenAsThat) {
    const Case& of = GetParam();
    int inside = 0, focal_inside = 0, refused = 0;
    const int places = 100;
    for (int seed = 0; seed < places; ++seed) {
        Place place = random_place(std::uint64_t(seed), of.k1);
        place.add_points(of.points, 0.7,
                         [&] { return of.on_ground || place.task.points.size() % 3 ? 0.0 : place.uniform(0.5, 2.5); });
        if (of.is_stated) place.task.click_px = 0.7;
        if (of.knows_focal) place.task.intrinsics = place.view.k;
        place.task.fit_k1 = of.k1 != 0.0;
        const auto found = calibrate_plate(place.task);
        if (!found) {
            ++refused;
            continue;
        }
        inside += is_in_region(*found, place.view, of.k1);
        focal_inside += std::abs(found->intrinsics.fx - place.view.k.fx) <= found->half_95.focal_px + 1e-9;
    }
    RecordProperty("inside", inside);
    EXPECT_LE(refused, places / 50);
    EXPECT_GE(inside, 0.90 * (places - refused));
    EXPECT_LE(inside, 0.99 * (places - refused));
    EXPECT_GE(focal_inside, 0.90 * (places - refused));
    RecordProperty("focal_inside", focal_inside);
}

INSTANTIATE_TEST_SUITE_P(Places, Coverage,
                         testing::Values(Case{"SpaceStated", 8, false, true, false},
                                         Case{"SpaceFromResiduals", 8, false, false, false},
                                         Case{"GroundStated", 8, true, true, false},
                                         Case{"GroundKnownFocal", 6, true, false, true},
                                         Case{"K1", 16, false, true, false, -0.12}),
                         [](const auto& of) { return of.param.name; });

TEST(CalibratePlate, ExactClicksGiveTheCameraBack) {
    for (int seed = 0; seed < 40; ++seed) {
        Place place = random_place(std::uint64_t(100 + seed));
        const bool on_ground = seed % 2;
        place.add_points(5, 0.0, [&] { return on_ground ? 0.0 : place.uniform(0.0, 2.0); });
        const auto found = calibrate_plate(place.task);
        ASSERT_TRUE(found) << seed << found.error().message;
        EXPECT_LT(glm::distance(found->pose.position, place.view.position), 1e-4) << seed;
        EXPECT_NEAR(found->intrinsics.fx, place.view.k.fx, 1e-3) << seed;
        EXPECT_LT(found->rms_px, 1e-4) << seed;
    }
}

// What people are drawn with is what the photo shows: their feet and heads where the true camera has them.
TEST(CalibratePlate, APersonHasItsHeightWithinAPixel) {
    double worst = 0.0;
    for (int seed = 0; seed < 60; ++seed) {
        Place place = random_place(std::uint64_t(400 + seed));
        place.add_points(8, 0.3, [&] { return place.task.points.size() % 2 ? 0.0 : place.uniform(1.0, 2.5); });
        place.task.click_px = 0.3;
        const auto found = calibrate_plate(place.task);
        ASSERT_TRUE(found) << found.error().message;
        PlateView view = place.view;
        view.k = found->intrinsics;
        view.lens = *camera::LensMap::create(found->lens);
        view.position = found->pose.position;
        view.world_from_optical = camera::world_from_optical_rotation(found->pose);
        for (const KnownPoint& each : place.task.points) {
            const glm::dvec3 foot(each.m.x, each.m.y, 0.0), head = foot + glm::dvec3(0, 0, 1.75);
            const auto was_foot = place.view.project(foot), was_head = place.view.project(head);
            if (!was_head || was_head->y < 0) continue;
            const double was = was_foot->y - was_head->y, is = view.project(foot)->y - view.project(head)->y;
            worst = std::max(worst, std::abs(was - is) / std::max(1.0, found->person_share_95.value() * was));
            EXPECT_NEAR(was, is, was < 120.0 ? 1.0 : 3.0) << seed;
        }
    }
    EXPECT_LT(worst, 2.0) << "in half widths of the stated uncertainty";
}

TEST(CalibratePlate, HeightsAndLinesAloneGiveTiltHeightAndFocalLength) {
    const PlateView truth = camera_at({0, 0, 4.5}, {0, -18 * deg, 2 * deg}, 1100);
    PlateTask task{.size = size};
    for (const glm::dvec2 at :
         {glm::dvec2(8, -3), glm::dvec2(10, 2), glm::dvec2(18, 4), glm::dvec2(25, -6), glm::dvec2(14, 0)})
        task.heights.push_back({*truth.project({at, 0}), *truth.project({at, 1.8}), 1.8, 0.0});
    const auto found = calibrate_plate(task);
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_NEAR(found->intrinsics.fx, 1100, 0.01);
    EXPECT_NEAR(found->pose.position.z, 4.5, 1e-4);
    EXPECT_NEAR(camera::angles_of(found->pose.orientation).tilt, -18 * deg, 1e-5);
    EXPECT_NEAR(camera::angles_of(found->pose.orientation).roll, 2 * deg, 1e-5);
}

PlateTask seen_by(const PlateView& view, std::initializer_list<glm::dvec3> points) {
    PlateTask task{.size = size};
    for (const glm::dvec3& each : points) task.points.push_back({*view.project(each), each});
    return task;
}

TEST(CalibratePlate, LinesAlongTheAxesAndTheCamerasHeightAreEnough) {
    const PlateView truth = camera_at({0, 0, 3.0}, {25 * deg, -14 * deg, 1 * deg}, 900);
    PlateTask task{.size = size, .camera_height_m = 3.0};
    const auto add = [&](Axis axis, glm::dvec3 from, glm::dvec3 to) {
        task.lines.push_back({axis, *truth.project(from), *truth.project(to)});
    };
    add(Axis::x, {6, -1, 0}, {14, -1, 0});
    add(Axis::x, {6, 6, 0}, {14, 6, 0});
    add(Axis::y, {9, 0, 0}, {9, 7, 0});
    add(Axis::y, {15, 0, 2}, {15, 9, 2});
    add(Axis::z, {9, 2, 0}, {9, 2, 2.5});
    add(Axis::z, {12, 9, 0}, {12, 9, 3});
    const auto found = calibrate_plate(task);
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_NEAR(found->intrinsics.fx, 900, 0.01);
    EXPECT_NEAR(camera::angles_of(found->pose.orientation).pan, 25 * deg, 1e-5);
    EXPECT_NEAR(camera::angles_of(found->pose.orientation).tilt, -14 * deg, 1e-5);
    // No place was clicked at: people are judged where the photo shows the ground.
    task.click_px = 2.0;
    const auto rough = calibrate_plate(task);
    ASSERT_TRUE(rough) << rough.error().message;
    EXPECT_GT(rough->person_share_95.value(), 0.001);
    EXPECT_GT(rough->ground_m_95.value(), 0.01);
    EXPECT_THAT(rough->verdict, HasSubstr("in the lower half of the photo"));
}

TEST(CalibratePlate, WhereNobodyIsSeenWholeNothingIsCalledGood) {
    const PlateView truth = camera_at({0, 0, 1.2}, {0, -89.9 * deg, 0}, 900);
    PlateTask task = seen_by(truth, {{-0.3, -0.2, 0}, {0.3, -0.2, 0}, {0.3, 0.3, 0}, {-0.3, 0.25, 0}, {0.1, 0.1, 0.2}});
    task.intrinsics = truth.k;
    task.click_px = 0.5;
    const auto found = calibrate_plate(task);
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_FALSE(found->person_share_95);
    EXPECT_GT(found->ground_m_95.value(), 0.0);
    EXPECT_EQ(found->grade, PlateGrade::poor);
    EXPECT_THAT(found->verdict, HasSubstr("nobody is seen whole where it was clicked"));
}

std::string refused(const PlateTask& task) {
    const auto found = calibrate_plate(task);
    return found ? "found: " + found->verdict : found.error().message;
}

const PlateView gate = camera_at({0, 0, 4}, {0, -15 * deg, 0}, 1000);

TEST(CalibratePlate, SaysWhatIsMissing) {
    EXPECT_THAT(refused({.size = size}), StartsWith("points: none are given"));
    EXPECT_THAT(refused(seen_by(gate, {{9, 0, 0}, {9, 3, 0}})), StartsWith("points: all are on one line"));
    PlateTask bent = seen_by(gate, {{9, 0, 0}, {9, 3, 0}, {15, 0, 0}, {15, 4, 0}, {12, 1, 1}});
    bent.lens = {camera::LensModel::plumb_bob, {-1e6}};
    EXPECT_THAT(refused(bent), StartsWith("lens"));
    EXPECT_THAT(refused(seen_by(gate, {{9, 0, 0}, {9, 3, 0}, {15, 0, 0}})),
                HasSubstr("6 numbers were clicked and 7 are sought"));
    EXPECT_THAT(refused(seen_by(gate, {{9, 0, 0}, {10, 0, 0}, {12, 0, 0}, {15, 0, 0}, {20, 0, 0}})),
                StartsWith("points: all are on one line"));
    PlateTask same = seen_by(gate, {{9, 0, 0}, {9, 0, 0}, {9, 0, 0}, {9, 0, 0}});
    EXPECT_THAT(refused(same), StartsWith("points[1]: is the same as points[0]"));
    for (std::size_t n = 0; n < 4; ++n) same.points[n].px.x += double(n);
    EXPECT_THAT(refused(same), StartsWith("points: all are the same place"));
    PlateTask one_pixel = seen_by(gate, {{9, 0, 0}, {9, 3, 0}, {15, 0, 0}, {15, 3, 0}});
    for (KnownPoint& each : one_pixel.points) each.px = {600, 400};
    EXPECT_THAT(refused(one_pixel), StartsWith("points: all are the same pixel"));
    EXPECT_THAT(refused({.size = size, .lines = {{Axis::x, {1, 1}, {50, 90}}}}),
                StartsWith("lines: tell nothing of sizes"));
    PlateTask not_a_number = seen_by(gate, {{9, 0, 0}, {9, 3, 0}, {15, 0, 0}, {15, 3, 0}});
    not_a_number.points[2].m.y = std::nan("");
    EXPECT_THAT(refused(not_a_number), StartsWith("points[2].m: "));
}

TEST(CalibratePlate, AFocalLengthIsNotReadOffAPlaneSeenStraightDown) {
    const PlateView above = camera_at({0, 0, 8}, {0, -90 * deg, 0}, 1000);
    PlateTask task = seen_by(above, {{-2, -3, 0}, {2, -3, 0}, {2, 3, 0}, {-2, 3, 0}, {0, 1, 0}});
    EXPECT_THAT(refused(task), HasSubstr("do not determine the focal length"));
    task.intrinsics = above.k;
    const auto found = calibrate_plate(task);
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_LT(glm::distance(found->pose.position, glm::dvec3(0, 0, 8)), 1e-4);
}

TEST(CalibratePlate, AClickThatContradictsTheOthersIsNamed) {
    PlateTask task =
        seen_by(gate, {{9, -2, 0}, {9, 3, 0}, {15, -3, 0}, {15, 3, 0}, {20, 0, 0}, {12, 0, 0}, {11, 2, 1}});
    PlateTask shifted = task;
    shifted.points[3].px.x += 200;
    EXPECT_THAT(refused(shifted), StartsWith("points[3]: is 200 px from where the other points have it"));
    PlateTask sky = task;
    sky.points[4].px = {640, 20};
    EXPECT_THAT(refused(sky), StartsWith("points[4].px: is over the horizon"));
    PlateTask slightly = task;
    slightly.points[3].px.x += 12;
    EXPECT_THAT(refused(slightly), StartsWith("found: poor: points[3] is 12 px from where the others have it"));
    PlateTask swapped = task;
    for (KnownPoint& each : swapped.points) std::swap(each.m.x, each.m.z);
    EXPECT_THAT(refused(swapped), testing::AnyOf(StartsWith("points: contradict"), StartsWith("points["),
                                                 StartsWith("points: no camera"), StartsWith("points: ")));
    std::swap(task.points[0].m, task.points[1].m);
    EXPECT_THAT(refused(task), StartsWith("points: contradict each other"));
}

TEST(CalibratePlate, AStatedClickErrorThatCannotBeIsDoubted) {
    Place place = random_place(7);
    place.add_points(10, 4.0, [] { return 0.0; });
    place.task.click_px = 0.5;
    const auto found = calibrate_plate(place.task);
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_EQ(found->grade, PlateGrade::poor);
    EXPECT_THAT(found->verdict, HasSubstr("and not by the 0.5 that were stated"));
}

}  // namespace
}  // namespace camrig::photo

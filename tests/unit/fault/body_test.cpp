#include "core/fault/body.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/unit/fault/faulty.h"

namespace camrig::fault {
namespace {

constexpr double deg = 0.017453292519943295;

camera::PanTiltRoll angles_at(const FaultKind& kind, double severity, double seconds) {
    FrameFaults faults = at_frame(fault_of(kind, severity), 0);
    faults.frame.world_ns = std::llround(seconds * 1e9);
    return camera::angles_of(moved(faults, {}).orientation);
}

TEST(Knock, TurnsTheCameraByItsAngles) {
    const auto angles = angles_at(Knock{.pan_deg = 10, .tilt_deg = 0, .roll_deg = 0}, 1.0, 5.0);
    EXPECT_NEAR(angles.pan, 10 * deg, 1e-12);
    EXPECT_NEAR(angles_at(Knock{.pan_deg = 0, .tilt_deg = -7, .roll_deg = 0}, 1.0, 5.0).tilt, -7 * deg, 1e-12);
    EXPECT_NEAR(angles_at(Knock{.pan_deg = 0, .tilt_deg = 0, .roll_deg = 4}, 1.0, 5.0).roll, 4 * deg, 1e-12);
    EXPECT_NEAR(angles_at(Knock{.pan_deg = 10, .tilt_deg = 0, .roll_deg = 0}, 0.25, 5.0).pan, 2.5 * deg, 1e-12);
}

TEST(Knock, IsAboutTheAxesOfTheCameraAndLeavesItWhereItIs) {
    const auto believed = camera::pose_from_angles({1, 2, 3}, {.pan = 1.0, .tilt = -0.4, .roll = 0.0}).value();
    const FrameFaults faults = at_frame(fault_of(Knock{.pan_deg = 0, .tilt_deg = -5, .roll_deg = 0}), 0);
    const auto pose = moved(faults, believed);
    EXPECT_EQ(pose.position, believed.position);
    const auto angles = camera::angles_of(pose.orientation);
    EXPECT_NEAR(angles.pan, 1.0, 1e-12);
    EXPECT_NEAR(angles.tilt, -0.4 - 5 * deg, 1e-12);
}

TEST(Sag, GrowsWithTimeFromItsBegin) {
    const Sag sag{.tilt_deg_per_h = -2.0};
    EXPECT_NEAR(angles_at(sag, 1.0, 0.0).tilt, 0.0, 1e-12);
    EXPECT_NEAR(angles_at(sag, 1.0, 1800.0).tilt, -1.0 * deg, 1e-12);
    EXPECT_NEAR(angles_at(sag, 0.5, 1800.0).tilt, -0.5 * deg, 1e-12);
}

TEST(Vibration, SwingsWithItsFrequencyAndAmplitude) {
    const Vibration vibration{.amplitude_deg = 0.5, .frequency_hz = 10};
    EXPECT_NEAR(angles_at(vibration, 1.0, 0.025).pan, 0.5 * deg, 1e-9) << "a quarter of a period";
    EXPECT_NEAR(angles_at(vibration, 1.0, 0.075).pan, -0.5 * deg, 1e-9);
    EXPECT_NEAR(angles_at(vibration, 1.0, 100.025).pan, 0.5 * deg, 1e-9);
    EXPECT_NEAR(angles_at(vibration, 0.4, 0.025).pan, 0.2 * deg, 1e-9);
}

TEST(BodyFaults, TurnTheCameraMoreAtAHigherSeverity) {
    for (const FaultKind& kind : {FaultKind(Knock{}), FaultKind(Sag{}), FaultKind(Vibration{})}) {
        double least = -1.0;
        for (const double severity : {0.1, 0.4, 0.7, 1.0}) {
            FrameFaults faults = at_frame(fault_of(kind, severity), 77);
            EXPECT_TRUE(moves_body(faults));
            const double turned = 1.0 - std::abs(moved(faults, {}).orientation.w);
            EXPECT_GT(turned, least) << name_of(kind);
            least = turned;
        }
    }
}

}  // namespace
}  // namespace camrig::fault

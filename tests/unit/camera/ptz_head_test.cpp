#include "core/camera/ptz_head.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace camrig::camera {
namespace {

constexpr TimeNs ms = ns_per_ms;

TimeNs seconds(double s) {
    return static_cast<TimeNs>(std::llround(s * 1e9));
}

PtzSpec plain() {
    PtzSpec spec = ptz_preset(PtzPreset::ideal);
    spec.speed_deg_s = 100.0;
    spec.acceleration_deg_s2 = 400.0;
    spec.latency_s = 0.15;
    return spec;
}

TEST(AxisMotion, TakesAsLongAsATrapezoidDoes) {
    const AxisLimits limits{100.0, 400.0};
    // A quarter of a second to 100/s, 12.5 long, and the same to a stand: 75 are left at full speed.
    EXPECT_DOUBLE_EQ(AxisMotion::to({}, 100.0, limits).duration_s(), 0.25 + 0.75 + 0.25);
    // 9: full speed is never reached, half of the time goes up: 4.5 = 400/2 t^2.
    EXPECT_DOUBLE_EQ(AxisMotion::to({}, -9.0, limits).duration_s(), 2.0 * std::sqrt(9.0 / 400.0));
    EXPECT_EQ(AxisMotion::to({}, 0.0, limits).duration_s(), 0.0);
    EXPECT_NEAR(AxisMotion::to_in({}, 100.0, limits, 3.0).duration_s(), 3.0, 1e-12);
    EXPECT_DOUBLE_EQ(AxisMotion::stop({7.0, 80.0}, 400.0).end(), 7.0 + 80.0 * 80.0 / 800.0);
}

TEST(AxisMotion, TakesTheTimeThatItIsToTakeHoweverLongAndHoweverStrongTheMotor) {
    std::uint64_t n = 0;
    const auto power = [&](double low, double high) { return low * std::pow(high / low, random_unit(4, 0, n++)); };
    for (int round = 0; round < 100'000; ++round) {
        const AxisLimits limits{power(1e-3, 1e3), power(0.1, 1e6)};
        const AxisState from{0.0, round % 2 == 0 ? 0.0 : power(1e-6, 1.0) * limits.speed};
        const double target = power(1e-3, 360.0);
        const double longer = AxisMotion::to(from, target, limits).duration_s() * power(1.0, 1e5);
        const AxisMotion motion = AxisMotion::to_in(from, target, limits, longer);
        ASSERT_NEAR(motion.duration_s(), longer, 1e-6 * longer) << limits.speed << " " << limits.acceleration;
        for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0 - 1e-9}) {
            const double t = share * longer, step = 1e-4 * longer;
            const double way = std::abs(motion.at(t + step).position - motion.at(t).position);
            ASSERT_LE(way, std::max(limits.speed, from.speed) * step + 1e-6 * target) << share;
        }
    }
}

TEST(AxisMotion, KeepsItsLimitsAndNeverJumpsFromAnyState) {
    std::uint64_t n = 0;
    const auto random = [&](double low, double high) { return low + (high - low) * random_unit(3, 0, n++); };
    for (int round = 0; round < 100'000; ++round) {
        const AxisLimits limits{random(0.1, 200.0), random(1.0, 2000.0)};
        const AxisState from{random(-180.0, 180.0), random(-1.5, 1.5) * limits.speed};
        const double target = round % 7 == 0 ? from.position : random(-180.0, 180.0);
        AxisMotion motion = AxisMotion::to(from, target, limits);
        if (round % 3 == 0) {
            const double longer = motion.duration_s() * random(1.0, 4.0);
            motion = AxisMotion::to_in(from, target, limits, longer);
            ASSERT_NEAR(motion.duration_s(), longer, 1e-7 * (1.0 + longer));
        }
        ASSERT_LT(std::abs(motion.at(0.0).position - from.position), 1e-12);
        const double top = std::max(limits.speed, std::abs(from.speed));
        AxisState last = from;
        constexpr int steps = 40;
        for (int i = 1; i <= steps; ++i) {
            const double step_s = motion.duration_s() / steps;
            const AxisState now = motion.at(i == steps ? motion.duration_s() : i * step_s);
            ASSERT_LE(std::abs(now.speed), top * (1.0 + 1e-9));
            ASSERT_LE(std::abs(now.position - last.position), top * step_s + 1e-7);
            ASSERT_LE(std::abs(now.speed - last.speed), limits.acceleration * step_s + 1e-6 * top);
            last = now;
        }
        ASSERT_EQ(last.position, target);
        ASSERT_EQ(last.speed, 0.0);
    }
}

TEST(PtzHead, BeginsAfterItsLatencyAndArrivesWhenTheFormulaSays) {
    PtzHead head(plain());
    ASSERT_TRUE(head.move({.pan_deg = 100.0, .tilt_deg = 10.0, .zoom = 4.0}, seconds(1.0)));
    EXPECT_NEAR(static_cast<double>(head.arrives_ns()), 1e9 * (1.0 + 0.15 + 1.25), 1.0);
    EXPECT_EQ(head.at(seconds(1.15)), (PtzPosition{0.0, 0.0, 1.0}));
    EXPECT_TRUE(head.status(seconds(1.0)).is_turning);
    EXPECT_FALSE(head.status(seconds(1.0) - 1).is_turning);
    // Both angles arrive together.
    EXPECT_LT(head.at(head.arrives_ns() - ms).pan_deg, 100.0);
    EXPECT_LT(head.at(head.arrives_ns() - ms).tilt_deg, 10.0);
    EXPECT_EQ(head.at(head.arrives_ns()), (PtzPosition{100.0, 10.0, 4.0}));
    EXPECT_FALSE(head.status(head.arrives_ns()).is_turning);
}

TEST(PtzHead, TurnsTheShorterWayRoundWhereNothingStopsIt) {
    PtzHead head(plain());
    ASSERT_TRUE(head.move({.pan_deg = 170.0}, 0));
    const TimeNs there = head.arrives_ns();
    ASSERT_TRUE(head.move({.pan_deg = -170.0}, there));
    EXPECT_EQ(head.arrives_ns(), there + seconds(0.15 + 2.0 * std::sqrt(20.0 / 400.0)) + 1);
    EXPECT_NEAR(head.at(head.arrives_ns()).pan_deg, -170.0, 1e-12);
}

TEST(PtzHead, AContinuousMoveEndsByItselfAtAStopOrAtItsLimit) {
    PtzSpec spec = plain();
    spec.pan_limits_deg = PtzLimits{-50.0, 50.0};
    PtzHead head(spec);
    ASSERT_TRUE(head.move({.mode = PtzMode::continuous, .pan_deg = 20.0, .timeout = seconds(1.0)}, 0));
    // To 20/s in 0.05 s, braking begins a second after the motion and takes as long.
    EXPECT_NEAR(head.at(seconds(10.0)).pan_deg, 20.0, 1e-9);
    ASSERT_TRUE(head.move({.mode = PtzMode::continuous, .pan_deg = 20.0}, seconds(10.0)));
    EXPECT_EQ(head.at(seconds(20.0)).pan_deg, 50.0);
    // It stands at its limit, whatever time it was given.
    ASSERT_TRUE(head.move({.mode = PtzMode::continuous, .pan_deg = 20.0, .timeout = seconds(60.0)}, seconds(19.0)));
    EXPECT_FALSE(head.status(seconds(19.5)).is_turning);
    ASSERT_TRUE(head.move({.mode = PtzMode::continuous, .pan_deg = -20.0}, seconds(20.0)));
    ASSERT_TRUE(head.stop(true, true, seconds(21.15)));
    EXPECT_NEAR(head.at(seconds(30.0)).pan_deg, 50.0 - 20.0, 1e-9);
}

TEST(PtzHead, WhatIsBeyondItsLimitsIsAnErrorOnlyWhereItWasAskedForByItself) {
    PtzHead head(ptz_preset(PtzPreset::cheap));
    EXPECT_EQ(head.move({.pan_deg = 176.0}, 0).error().kind, ErrorKind::invalid_argument);
    EXPECT_EQ(head.move({.zoom = 14.0}, 0).error().kind, ErrorKind::invalid_argument);
    EXPECT_TRUE(head.move({.mode = PtzMode::relative, .pan_deg = 1000.0, .zoom = 0.01}, 0));
    EXPECT_EQ(head.status(seconds(1000.0)).position.pan_deg, 175.0);
    EXPECT_EQ(head.status(seconds(1000.0)).position.zoom, 1.0);
}

TEST(PtzHead, StopsWithinItsRepeatabilityEachTimeElsewhereAndTellsWhatItBelieves) {
    PtzSpec spec = plain();
    spec.repeatability_deg = 0.25;
    spec.backlash_deg = 0.1;
    spec.quantum_deg = 0.5;
    PtzHead head(spec);
    std::vector<double> errors;
    for (int i = 0; i < 200; ++i) {
        const double target = i % 2 == 0 ? 30.2 : -12.9;
        ASSERT_TRUE(head.move({.pan_deg = target}, seconds(10.0 * i)));
        const TimeNs there = head.arrives_ns();
        EXPECT_EQ(head.status(there).position.pan_deg, i % 2 == 0 ? 30.0 : -13.0);
        errors.push_back(head.at(there).pan_deg - target + (i % 2 == 0 ? 0.05 : -0.05));
        EXPECT_LE(std::abs(errors.back()), 0.25 + 1e-12);
    }
    const auto [least, most] = std::ranges::minmax(errors);
    EXPECT_LT(least, -0.2);
    EXPECT_GT(most, 0.2);
}

TEST(PtzHead, SlowsDownByTheZoomWhereItIsProportional) {
    PtzSpec spec = plain();
    spec.is_proportional = true;
    PtzHead head(spec);
    ASSERT_TRUE(head.move({.zoom = 10.0}, 0));
    const TimeNs zoomed = head.arrives_ns();
    ASSERT_TRUE(head.move({.mode = PtzMode::continuous, .pan_deg = 100.0}, zoomed));
    const auto pan = [&](double s) { return head.at(zoomed + seconds(s)).pan_deg; };
    EXPECT_NEAR(pan(4.0) - pan(3.0), 10.0, 1e-9);
}

TEST(PtzHead, WhatNoDataSheetSaysHarmsNothing) {
    PtzSpec spec = plain();
    spec.quantum_deg = 1e-308;
    spec.latency_s = 10.0;
    PtzHead head(spec);
    ASSERT_TRUE(head.move({.pan_deg = 30.0, .speed = 1e-300}, 0));
    EXPECT_EQ(head.status(seconds(1e6)).position.pan_deg, head.at(seconds(1e6)).pan_deg);
    EXPECT_GT(head.arrives_ns(), seconds(1e6));
    // A command every ten milliseconds: what is under way stays so, and there is an end to what waits.
    PtzHead flooded(spec);
    ASSERT_TRUE(flooded.move({.mode = PtzMode::continuous, .pan_deg = 1.0}, 0));
    const PtzPosition before = flooded.at(seconds(11.0));
    TimeNs now = seconds(11.0);
    int taken = 0;
    while (flooded.move({.pan_deg = 90.0}, now + taken * 10 * ms)) ++taken;
    EXPECT_GT(taken, 50);
    EXPECT_LT(taken, 70);
    EXPECT_EQ(flooded.at(seconds(11.0)), before);
    EXPECT_EQ(flooded.stop(true, true, now + taken * 10 * ms).error().kind, ErrorKind::resource_exhausted);
}

TEST(PtzHead, GrowsWrongAlongItsWayWithoutAJump) {
    PtzSpec spec = ptz_preset(PtzPreset::cheap);
    spec.seed = 5;
    PtzHead head(spec);
    for (const double pan : {20.0, -20.0, 5.0}) {
        const TimeNs told = head.arrives_ns();
        ASSERT_TRUE(head.move({.pan_deg = pan}, told));
        ASSERT_GT(head.arrives_ns() - told, ns_per_s);
        for (TimeNs when = told; when <= head.arrives_ns(); when += ms) {
            const double way = std::abs(head.at(when + ms).pan_deg - head.at(when).pan_deg);
            ASSERT_LE(way, 1e-3 * (spec.speed_deg_s + 2.0 * (spec.repeatability_deg + spec.backlash_deg)) + 1e-9);
        }
        ASSERT_NE(head.at(head.arrives_ns()).pan_deg, pan);
    }
}

TEST(PtzHead, IsTheSameAtAnyTimeWhateverWasAskedBefore) {
    std::uint64_t n = 0;
    const auto random = [&](double low, double high) { return low + (high - low) * random_unit(8, 1, n++); };
    for (const PtzPreset preset : {PtzPreset::ideal, PtzPreset::dome, PtzPreset::cheap}) {
        PtzSpec spec = ptz_preset(preset);
        PtzHead head(spec), asked(spec);
        TimeNs now = 0;
        for (int i = 0; i < 30'000; ++i) {
            now += seconds(random(0.0, 0.4));
            const PtzMode mode = static_cast<PtzMode>(i % 3);
            PtzMove move{.mode = mode, .speed = random(0.05, 1.0)};
            if (random(0.0, 1.0) < 0.8) move.pan_deg = random(-170.0, 170.0);
            if (random(0.0, 1.0) < 0.8) move.tilt_deg = random(-90.0, 20.0);
            if (random(0.0, 1.0) < 0.5)
                move.zoom = mode == PtzMode::continuous ? random(-1.0, 1.0) : random(1.0, spec.zoom_max);
            if (random(0.0, 1.0) < 0.3) move.timeout = seconds(random(0.0, 2.0));
            if (random(0.0, 1.0) < 0.1) {
                ASSERT_TRUE(head.stop(true, true, now));
                ASSERT_TRUE(asked.stop(true, true, now));
            } else {
                ASSERT_TRUE(head.move(move, now));
                ASSERT_TRUE(asked.move(move, now));
            }
            // What was asked before, in any order, changes nothing.
            for (int k = 0; k < 3; ++k) static_cast<void>(asked.at(now + seconds(random(-0.2, 3.0))));
            const TimeNs when = now + seconds(random(-0.2, 1.0));
            const PtzPosition position = head.at(when);
            ASSERT_EQ(position, asked.at(when));
            ASSERT_GE(position.tilt_deg, spec.tilt_limits_deg.low);
            ASSERT_LE(position.tilt_deg, spec.tilt_limits_deg.high);
            ASSERT_GE(position.zoom, 1.0);
            ASSERT_LE(position.zoom, spec.zoom_max);
            if (spec.pan_limits_deg) {
                ASSERT_LE(std::abs(position.pan_deg), spec.pan_limits_deg->high);
            }
            // Nothing jumps: within a millisecond it turns no further than at its full speed, and by what it errs.
            const PtzPosition next = head.at(when + ms);
            const double turned = std::remainder(next.pan_deg - position.pan_deg, 360.0);
            ASSERT_LE(std::abs(turned),
                      1e-3 * spec.speed_deg_s + 2.0 * (spec.repeatability_deg + spec.backlash_deg) + 1e-9);
        }
    }
}

}  // namespace
}  // namespace camrig::camera

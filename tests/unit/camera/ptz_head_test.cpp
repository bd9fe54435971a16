#include "core/camera/ptz_head.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

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
    ASSERT_TRUE(head.move({.mode = PtzMode::continuous, .pan_deg = 20.0}, zoomed));
    EXPECT_NEAR(pan(4.0) - pan(3.0), 2.0, 1e-9) << "all speeds, so that a stick stays a stick";
}

TEST(PtzHead, AMoveToAPlaceInThePictureEndsAtTheLimitAndNotBehindIt) {
    PtzSpec spec = plain();
    spec.pan_limits_deg = PtzLimits{-175.0, 175.0};
    PtzHead head(spec);
    ASSERT_TRUE(head.move({.pan_deg = 170.0}, 0));
    const TimeNs there = head.arrives_ns();
    // What is 16 degrees further to the left.
    ASSERT_TRUE(head.move({.mode = PtzMode::fov, .pan_deg = -174.0}, there));
    EXPECT_LT(head.arrives_ns(), there + seconds(2.0));
    EXPECT_NEAR(head.at(head.arrives_ns()).pan_deg, 175.0, 1e-9);
}

TEST(PtzHead, GoesToPresetsAndHomeAtTheSpeedThatIsAsked) {
    PtzHead head(plain());
    ASSERT_TRUE(head.move({.pan_deg = 100.0}, 0));
    const TimeNs there = head.arrives_ns();
    ASSERT_TRUE(head.set_preset("there", there));
    PtzHead slow = head, fast = head;
    ASSERT_TRUE(slow.go_home(0.1, there));
    ASSERT_TRUE(fast.go_home(1.0, there));
    EXPECT_GT(slow.arrives_ns() - there, 5 * (fast.arrives_ns() - there));
    ASSERT_TRUE(head.move({.pan_deg = 0.0}, there));
    const TimeNs back = head.arrives_ns();
    slow = fast = head;
    ASSERT_TRUE(slow.go_to_preset("there", 0.1, back));
    ASSERT_TRUE(fast.go_to_preset("there", 1.0, back));
    EXPECT_GT(slow.arrives_ns() - back, 5 * (fast.arrives_ns() - back));
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

/// A head with presets and tours, and the time at which it stands at the last preset.
PtzHead with_tours(const PtzSpec& spec, TimeNs& now) {
    PtzHead head(spec);
    for (const auto& [name, place] :
         {std::pair("a", PtzPosition{170.0, -10.0, 1.0}), std::pair("b", PtzPosition{-170.0, -40.0, 1.0}),
          std::pair("d", PtzPosition{20.0, -10.0, 4.0}), std::pair("c", PtzPosition{20.0, -40.0, 4.0})}) {
        EXPECT_TRUE(head.move({.pan_deg = place.pan_deg, .tilt_deg = place.tilt_deg, .zoom = place.zoom}, now));
        now = head.arrives_ns();
        EXPECT_TRUE(head.set_preset(name, now));
    }
    EXPECT_TRUE(head.set_tour("round", {{"a", 2 * ns_per_s, 0.5}, {"b", 3 * ns_per_s}, {"c", ns_per_s}}));
    EXPECT_TRUE(head.set_tour("to and fro", {{"a", ns_per_s}, {"b", ns_per_s}}));
    EXPECT_TRUE(head.set_tour("up and down", {{"c", ns_per_s / 10}, {"d", ns_per_s / 10}}));
    return head;
}

TEST(PtzHead, ATourGoesFromStopToStopForDaysAndIsToldForAnyTime) {
    TimeNs now = 0;
    PtzHead head = with_tours(plain(), now);
    ASSERT_TRUE(head.start_tour("round", now));
    EXPECT_EQ(head.tour(), "round");
    EXPECT_TRUE(head.never_stands());
    // By the trapezoid: at half of the speed 150 degrees of pan to the first, 30 of tilt to the second (and 20 of pan,
    // the shorter way round), 170 of pan to the third, and back to the first.
    const TimeNs slow = later_by(0, 150.0 / 50.0 + 50.0 / 400.0), to_b = later_by(0, 30.0 / 100.0 + 100.0 / 400.0),
                 to_c = later_by(0, 170.0 / 100.0 + 100.0 / 400.0);
    const TimeNs at_a = now + seconds(0.15) + slow, at_b = at_a + 2 * ns_per_s + to_b,
                 at_c = at_b + 3 * ns_per_s + to_c;
    const TimeNs round = at_c + ns_per_s + slow - at_a;
    for (const TimeNs rounds : {0, 1, 10'000, 10'000'000}) {  // three years
        const TimeNs later = rounds * round;
        // Rounding to nanoseconds may make a leg one longer.
        const TimeNs late = 1 + 3 * rounds;
        const auto expect = [&](TimeNs time, const PtzPosition& there) {
            const PtzPosition position = head.at(later + time + late);
            EXPECT_NEAR(std::remainder(position.pan_deg - there.pan_deg, 360.0), 0.0, 1e-9) << rounds;
            EXPECT_NEAR(position.tilt_deg, there.tilt_deg, 1e-9);
            EXPECT_NEAR(position.zoom, there.zoom, 1e-9);
            EXPECT_FALSE(head.status(later + time + late).is_turning);
            EXPECT_TRUE(head.status(later + time - ms).is_turning);
        };
        expect(at_a, {170.0, -10.0, 1.0});
        expect(at_b, {-170.0, -40.0, 1.0});
        expect(at_c, {20.0, -40.0, 4.0});
    }
}

TEST(PtzHead, ATourEndsWithAnyOtherCommandAndNoAxisGoesOn) {
    const auto commands = std::to_array<std::function<Result<void>(PtzHead&, TimeNs)>>({
        [](PtzHead& head, TimeNs now) { return head.move({.pan_deg = 0.0}, now); },
        [](PtzHead& head, TimeNs now) { return head.move({.mode = PtzMode::relative, .zoom = 1.5}, now); },
        [](PtzHead& head, TimeNs now) {
            return head.move({.mode = PtzMode::fov, .pan_deg = 5.0, .tilt_deg = -5.0}, now);
        },
        [](PtzHead& head, TimeNs now) { return head.stop(false, true, now); },
        [](PtzHead& head, TimeNs now) { return head.go_to_preset("b", 1.0, now); },
        [](PtzHead& head, TimeNs now) { return head.go_home(1.0, now); },
    });
    for (const auto& command : commands)
        for (const double into_s : {0.05, 0.5, 3.4, 5.4, 500.1}) {
            TimeNs now = 0;
            PtzHead head = with_tours(plain(), now);
            ASSERT_TRUE(head.start_tour("round", now));
            const PtzHead undisturbed = head;
            const TimeNs then = now + seconds(into_s);
            ASSERT_TRUE(command(head, then));
            EXPECT_EQ(head.tour(), std::nullopt);
            ASSERT_LT(head.arrives_ns(), then + seconds(5.0));
            EXPECT_EQ(head.at(then), undisturbed.at(then));
            EXPECT_FALSE(head.status(head.arrives_ns()).is_turning);
            EXPECT_FALSE(head.status(head.arrives_ns() + 1000 * ns_per_s).is_zooming);
        }
    TimeNs now = 0;
    PtzHead head = with_tours(plain(), now);
    ASSERT_TRUE(head.start_tour("round", now));
    ASSERT_TRUE(head.set_preset("e", now) && head.set_tour("other", {{"e"}}) && head.remove_tour("round"));
    EXPECT_EQ(head.tour(), "round") << "these move nothing";
    ASSERT_TRUE(head.start_tour("other", now + ns_per_s));
    EXPECT_EQ(head.tour(), "other");
    EXPECT_FALSE(head.standing(now + ns_per_s).never_stands());
}

TEST(PtzHead, ToursHaveStopsOfPresetsAndBounds) {
    PtzHead head(plain());
    EXPECT_EQ(head.set_tour("t", {}).error().kind, ErrorKind::invalid_argument);
    EXPECT_EQ(head.set_tour("t", {{"a"}}).error().kind, ErrorKind::not_found);
    ASSERT_TRUE(head.set_preset("a", 0));
    EXPECT_EQ(head.set_tour("t", PtzTour(65, {"a"})).error().kind, ErrorKind::invalid_argument);
    for (int i = 0; i < 16; ++i) ASSERT_TRUE(head.set_tour("t" + std::to_string(i), PtzTour(64, {"a"})));
    EXPECT_EQ(head.set_tour("one more", {{"a"}}).error().kind, ErrorKind::resource_exhausted);
    EXPECT_EQ(head.start_tour("one more", 0).error().kind, ErrorKind::not_found);
    ASSERT_TRUE(head.remove_preset("a"));
    EXPECT_EQ(head.start_tour("t1", 0).error().kind, ErrorKind::not_found);
    EXPECT_EQ(head.tour(), std::nullopt);
}

TEST(PtzHead, OnATourItStopsEachTimeElsewhereWithinItsRepeatability) {
    PtzSpec spec = plain();
    spec.repeatability_deg = 0.25;
    spec.backlash_deg = 0.1;
    TimeNs now = 0;
    PtzHead head = with_tours(spec, now);
    ASSERT_TRUE(head.start_tour("to and fro", now));
    std::vector<double> errors;
    const TimeNs end = now + seconds(600.0);
    TimeNs stands_since = 0;
    for (TimeNs when = now + seconds(3.0); when < end; when += 10 * ms) {
        const PtzPosition position = head.at(when), next = head.at(when + ms);
        ASSERT_LE(std::abs(std::remainder(next.pan_deg - position.pan_deg, 360.0)), 1e-3 * (100.0 + 0.6 / 0.4));
        const PtzStatus status = head.status(when);
        if (status.is_turning) stands_since = 0;
        if (status.is_turning || stands_since != 0) continue;
        stands_since = when;
        const double left_or_right = status.position.pan_deg < 0.0 ? -0.05 : 0.05;
        errors.push_back(status.true_position.pan_deg - status.position.pan_deg - left_or_right);
        ASSERT_LE(std::abs(errors.back()), 0.25 + 1e-9);
    }
    ASSERT_GT(errors.size(), 300u);
    std::ranges::sort(errors);
    EXPECT_EQ(std::ranges::unique(errors).size(), 0u);
    EXPECT_LT(errors.front(), -0.2);
    EXPECT_GT(errors.back(), 0.2);
}

/// The time from a stand to a stand over a distance.
double trapezoid_s(double distance, const AxisLimits& limits) {
    const double way = std::abs(distance), full = limits.speed * limits.speed / limits.acceleration;
    if (way < 1e-9) return 0.0;
    return way < full ? 2.0 * std::sqrt(way / limits.acceleration)
                      : way / limits.speed + limits.speed / limits.acceleration;
}

/// Two heads that are told the same at random times; one of them is asked much more than the other.
class RandomCommands {
public:
    explicit RandomCommands(const PtzSpec& spec) : spec_(spec), head_(with_tours(spec, now_)), asked_(head_) {}

    void run(int count) {
        for (int i = 0; i < count && !testing::Test::HasFatalFailure(); ++i) {
            now_ += seconds(head_.tour() && random(0.0, 1.0) < 0.2 ? random(0.0, 1e5) : random(0.0, 0.8));
            const TimeNs before = now_ - seconds(random(0.0, 0.2));
            const PtzPosition was = head_.at(before);
            command();
            ASSERT_EQ(head_.at(before), was) << "a command changes nothing of what was before";
            for (int k = 0; k < 3; ++k) static_cast<void>(asked_.at(now_ + seconds(random(-0.2, 3.0))));
            look(now_ + seconds(random(-0.2, 1.0)));
        }
    }

private:
    double random(double low, double high) { return low + (high - low) * random_unit(8, 1, n_++); }

    void tell(const std::function<Result<void>(PtzHead&)>& command) {
        const auto a = command(head_), b = command(asked_);
        ASSERT_TRUE(a && b) << a.error().message;
    }

    void command() {
        const double which = random(0.0, 1.0);
        if (which < 0.08) return tell([&](PtzHead& head) { return head.start_tour("round", now_); });
        if (which < 0.12) return tell([&](PtzHead& head) { return head.start_tour("to and fro", now_); });
        if (which < 0.15) return tell([&](PtzHead& head) { return head.start_tour("up and down", now_); });
        if (which < 0.2) return tell([&](PtzHead& head) { return head.go_to_preset("b", 1.0, now_); });
        if (which < 0.3) {
            const bool turns = random(0.0, 1.0) < 0.7, zooms = random(0.0, 1.0) < 0.7;
            return tell([&](PtzHead& head) { return head.stop(turns, zooms, now_); });
        }
        const PtzMode mode = static_cast<PtzMode>(random(0.0, 4.0));
        PtzMove move{.mode = mode, .speed = random(0.05, 1.0)};
        if (random(0.0, 1.0) < 0.8) move.pan_deg = random(-170.0, 170.0);
        if (random(0.0, 1.0) < 0.8) move.tilt_deg = random(-90.0, 20.0);
        if (random(0.0, 1.0) < 0.5)
            move.zoom = mode == PtzMode::continuous ? random(-1.0, 1.0) : random(1.0, spec_.zoom_max);
        if (random(0.0, 1.0) < 0.3) move.timeout = seconds(random(0.0, 2.0));
        const PtzHead before = head_;
        tell([&](PtzHead& head) { return head.move(move, now_); });
        const TimeNs begin = later_by(now_, spec_.latency_s);
        if (mode == PtzMode::absolute && before.arrives_ns() <= now_)
            check_arrival(before.status(now_).position, move, begin);
    }

    /// From a stand it arrives when the formula says.
    void check_arrival(const PtzPosition& from, const PtzMove& move, TimeNs begin) {
        const AxisLimits turn{spec_.speed_deg_s * move.speed, spec_.acceleration_deg_s2};
        const double full = std::log(spec_.zoom_max) / spec_.zoom_s;
        double pan = move.pan_deg.value_or(from.pan_deg) - from.pan_deg;
        if (!spec_.pan_limits_deg) pan = std::remainder(pan, 360.0);
        const double longest = std::max(
            {trapezoid_s(pan, turn), trapezoid_s(move.tilt_deg.value_or(from.tilt_deg) - from.tilt_deg, turn),
             trapezoid_s(std::log(move.zoom.value_or(from.zoom) / from.zoom), {full * move.speed, full / 0.1})});
        const double taken = static_cast<double>(std::max<TimeNs>(0, head_.arrives_ns() - begin)) * 1e-9;
        ASSERT_NEAR(taken, longest, 2e-9 + 1e-12 * longest);
    }

    void look(TimeNs when) {
        const PtzStatus status = head_.status(when);
        ASSERT_EQ(status, asked_.status(when));
        // Two looks before it and after it: what its motors did in between.
        const PtzStatus next = head_.status(when + ms), last = head_.status(when + 2 * ms);
        for (const PtzPosition& position : {status.position, status.true_position, last.true_position}) {
            ASSERT_GE(position.tilt_deg, spec_.tilt_limits_deg.low);
            ASSERT_LE(position.tilt_deg, spec_.tilt_limits_deg.high);
            ASSERT_GE(position.zoom, 1.0);
            ASSERT_LE(position.zoom, spec_.zoom_max);
            if (!spec_.pan_limits_deg) continue;
            ASSERT_GE(position.pan_deg, spec_.pan_limits_deg->low);
            ASSERT_LE(position.pan_deg, spec_.pan_limits_deg->high);
        }
        const auto check = [](double first, double second, double third, const AxisLimits& limits) {
            const double a = std::remainder(second - first, 360.0), b = std::remainder(third - second, 360.0);
            ASSERT_LE(std::abs(a), 1e-3 * limits.speed + 1e-7);
            ASSERT_LE(std::abs(b - a), 1e-6 * limits.acceleration + 1e-7);
        };
        const AxisLimits turn{spec_.speed_deg_s, spec_.acceleration_deg_s2};
        const double full = std::log(spec_.zoom_max) / spec_.zoom_s;
        const PtzPosition &a = status.position, &b = next.position, &c = last.position;
        check(a.pan_deg, b.pan_deg, c.pan_deg, turn);
        check(a.tilt_deg, b.tilt_deg, c.tilt_deg, turn);
        check(std::log(a.zoom), std::log(b.zoom), std::log(c.zoom), {full, full / 0.1});
        // It is where it believes to be within what it errs, and that comes and goes along its way.
        const double most = spec_.repeatability_deg + 0.5 * spec_.backlash_deg + 1e-9;
        for (const PtzStatus& one : {status, next}) {
            ASSERT_LE(std::abs(std::remainder(one.true_position.pan_deg - one.position.pan_deg, 360.0)), most);
            ASSERT_LE(std::abs(one.true_position.tilt_deg - one.position.tilt_deg), most);
        }
    }

    PtzSpec spec_;
    TimeNs now_ = 0;
    PtzHead head_, asked_;
    std::uint64_t n_ = 0;
};

TEST(PtzHead, KeepsItsLimitsAndArrivesAsTheFormulaSaysWhateverItIsToldAndAsked) {
    for (const PtzPreset preset : {PtzPreset::ideal, PtzPreset::dome, PtzPreset::cheap}) {
        PtzSpec spec = ptz_preset(preset);
        spec.quantum_deg = 0.0;  // the encoders tell what the motors do
        RandomCommands(spec).run(34'000);
        ASSERT_FALSE(HasFatalFailure());
    }
}

}  // namespace
}  // namespace camrig::camera

#include "tools/probe/measure.h"

#include <gtest/gtest.h>

namespace camrig::probe {
namespace {

constexpr TimeNs period = 40 * ns_per_ms;

/// A source that delivers `count` pictures 40 ms apart, 7 ms after their instants, with strips and its own numbers.
SourceLog perfect_source(int count = 10) {
    SourceLog log{.source = "a", .kind = "device", .format = "YUYV", .size = {640, 480}};
    log.stamps_are_monotonic = true;
    for (int n = 0; n < count; ++n) {
        const TimeNs world = n * period;
        const TimeNs stamp = 1000 * ns_per_s + world;
        log.pictures.push_back(
            {stamp + 7 * ns_per_ms, stamp, n, frame::CodeStrip{1, static_cast<std::uint32_t>(n), world}, false});
    }
    return log;
}

SourceReport report_of_one(SourceLog log) {
    return measure({std::move(log)}).sources.at(0);
}

TEST(Measure, APerfectSourceHasNoFaults) {
    const SourceReport report = report_of_one(perfect_source());
    EXPECT_DOUBLE_EQ(report.rate_hz, 25);
    EXPECT_EQ(report.pictures, 10);
    EXPECT_EQ(report.strips, 10);
    EXPECT_EQ(report.drops + report.repeats + report.torn + report.out_of_order, 0);
    EXPECT_EQ(report.arrival_jitter->max_ns, 0);
    EXPECT_EQ(report.stamp_jitter->max_ns, 0);
    EXPECT_EQ(report.latency->p50_ns, 7 * ns_per_ms);
    EXPECT_EQ(report.latency_by, "stamp");
}

TEST(Measure, MissingNumbersAreDrops) {
    SourceLog log = perfect_source();
    log.pictures.erase(log.pictures.begin() + 3, log.pictures.begin() + 5);
    EXPECT_EQ(report_of_one(log).drops, 2);
    for (PictureRecord& picture : log.pictures) picture.sequence.reset();
    EXPECT_EQ(report_of_one(log).drops, 2);  // by the strip
}

TEST(Measure, AnOldPictureUnderANewNumberIsARepeat) {
    SourceLog log = perfect_source();
    log.pictures[4].strip = log.pictures[3].strip;
    const SourceReport report = report_of_one(log);
    EXPECT_EQ(report.repeats, 1);
    EXPECT_EQ(report.drops, 0);
}

TEST(Measure, GoingBackInTimeIsOutOfOrder) {
    SourceLog log = perfect_source();
    std::swap(log.pictures[4], log.pictures[5]);
    EXPECT_EQ(report_of_one(log).out_of_order, 1);
}

TEST(Measure, AnUnreadableStripIsTornOnlyWhereOthersCanBeRead) {
    SourceLog log = perfect_source();
    log.pictures[4].strip.reset();
    log.pictures[6].damaged = true;
    EXPECT_EQ(report_of_one(log).torn, 2);
    for (PictureRecord& picture : log.pictures) picture.strip.reset();
    EXPECT_EQ(report_of_one(log).torn, 1);
}

TEST(Measure, JitterIsTheDistanceFromTheUsualInterval) {
    SourceLog log = perfect_source(100);
    log.pictures[50].arrival_ns += 3 * ns_per_ms;
    const SourceReport report = report_of_one(log);
    EXPECT_EQ(report.arrival_jitter->p50_ns, 0);
    EXPECT_EQ(report.arrival_jitter->max_ns, 3 * ns_per_ms);
    EXPECT_EQ(report.stamp_jitter->max_ns, 0);
}

// A stream whose stamps have another clock gets its latency from the world time in its pixels, once some other source
// has shown how the world's time runs.
TEST(Measure, LatencyByStripNeedsAnotherSourcesStamps) {
    SourceLog rtsp = perfect_source();
    rtsp.source = "b";
    rtsp.stamps_are_monotonic = false;
    for (PictureRecord& picture : rtsp.pictures) {
        picture.stamp_ns = *picture.stamp_ns - 999 * ns_per_s;
        picture.arrival_ns += 20 * ns_per_ms;
    }
    EXPECT_FALSE(report_of_one(rtsp).latency);
    const ProbeReport both = measure({rtsp, perfect_source()});
    EXPECT_EQ(both.sources[0].latency->p50_ns, 27 * ns_per_ms);
    EXPECT_EQ(both.sources[0].latency_by, "strip");
}

TEST(Measure, SourcesOfOneInstantHaveNoSkew) {
    SourceLog other = perfect_source();
    other.source = "b";
    for (PictureRecord& picture : other.pictures) picture.arrival_ns += ns_per_ms;
    const ProbeReport report = measure({perfect_source(), other});
    ASSERT_EQ(report.skews.size(), 1u);
    EXPECT_EQ(report.skews[0].source, "b");
    EXPECT_EQ(report.skews[0].reference, "a");
    EXPECT_EQ(report.skews[0].common, 10);
    EXPECT_EQ(report.skews[0].world->max_ns, 0);
    EXPECT_EQ(report.skews[0].stamp_max_ns, 0);
    EXPECT_EQ(report.skews[0].arrival->p50_ns, ns_per_ms);
}

TEST(Measure, SourcesOfOtherInstantsShowTheirDistance) {
    SourceLog other = perfect_source();
    for (PictureRecord& picture : other.pictures) picture.strip->world_ns += 11 * ns_per_ms;
    const ProbeReport report = measure({perfect_source(), other});
    EXPECT_EQ(report.skews[0].common, 0);
    EXPECT_EQ(report.skews[0].pictures, 9);  // the last one came after the reference had ended
    EXPECT_EQ(report.skews[0].world->p50_ns, 11 * ns_per_ms);
    EXPECT_FALSE(report.skews[0].stamp_max_ns);
}

TEST(Measure, StampsThatDisagreeAboutOneInstantAreSeen) {
    SourceLog other = perfect_source();
    other.pictures[5].stamp_ns = *other.pictures[5].stamp_ns + 1000;
    EXPECT_EQ(measure({perfect_source(), other}).skews[0].stamp_max_ns, 1000);
}

TEST(Measure, NothingComesOfNothing) {
    const SourceReport report = report_of_one({});
    EXPECT_EQ(report.pictures, 0);
    EXPECT_FALSE(report.arrival_jitter || report.latency);
}

TEST(Spread, PercentilesAreByNearestRank) {
    std::vector<TimeNs> numbers;
    for (TimeNs n = 200; n >= 1; --n) numbers.push_back(n);
    const auto spread = Spread::of(numbers);
    EXPECT_EQ(spread->p50_ns, 100);
    EXPECT_EQ(spread->p99_ns, 198);
    EXPECT_EQ(spread->max_ns, 200);
}

}  // namespace
}  // namespace camrig::probe

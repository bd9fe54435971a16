#include "core/stream/reader_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/clock.h"

namespace camrig::stream {
namespace {

using testing::ElementsAre;

std::vector<std::uint64_t> numbers(const ReaderLog::Since& found) {
    std::vector<std::uint64_t> all;
    for (const ReaderEvent& event : found.events) all.push_back(event.number);
    return all;
}

TEST(ReaderLog, GivesWhatCameAfterANumberOfOneCameraOrOfAll) {
    ReaderLog log;
    for (const char* camera : {"hall", "lobby", "hall"}) log.add({.camera = camera});
    EXPECT_THAT(numbers(log.since(0, "")), ElementsAre(1, 2, 3));
    EXPECT_THAT(numbers(log.since(1, "hall")), ElementsAre(3));
    EXPECT_THAT(numbers(log.since(3, "")), ElementsAre());
    EXPECT_EQ(log.since(3, "").last, 3u);
}

TEST(ReaderLog, HasTheWorldTimeOfTheFrameOrOfTheNewestInstantAndBothClocks) {
    ReaderLog log;
    log.begin_instant(80);
    const TimeNs monotonic_ns = monotonic_now_ns(), real_ns = realtime_now_ns();
    log.add({.kind = ReaderEventKind::refused});
    log.add({.kind = ReaderEventKind::good, .world_ns = 40});
    const auto events = log.since(0, "").events;
    EXPECT_EQ(events[0].world_ns, 80);
    EXPECT_EQ(events[1].world_ns, 40);
    EXPECT_GE(events[0].monotonic_ns, monotonic_ns);
    EXPECT_GE(events[0].real_ns, real_ns);
    EXPECT_GE(events[1].monotonic_ns, events[0].monotonic_ns);
}

TEST(ReaderLog, KeepsTheNewestAndCountsTheRest) {
    ReaderLog log;
    for (std::size_t i = 0; i < ReaderLog::max_events + 3; ++i) log.add({});
    const auto found = log.since(1, "");
    EXPECT_EQ(found.events.size(), ReaderLog::max_events);
    EXPECT_EQ(found.missed, 2u);
    EXPECT_EQ(found.events.front().number, 4u);
    EXPECT_EQ(log.since(3, "").missed, 0u);
}

}  // namespace
}  // namespace camrig::stream

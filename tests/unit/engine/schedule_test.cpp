#include "core/engine/schedule.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace camrig::engine::schedule_test {
namespace {

using testing::ElementsAre;

Rate rate(const char* text) {
    return Rate::parse(text).value();
}
constexpr CameraId a{1}, b{2}, c{3};

std::vector<std::pair<int, std::int64_t>> pairs(const std::vector<Schedule::Due>& due) {
    std::vector<std::pair<int, std::int64_t>> out;
    for (const auto& d : due) out.emplace_back(static_cast<int>(d.camera), d.sequence);
    return out;
}

TEST(Schedule, CamerasOfDifferentRatesMeetAtCommonInstants) {
    Schedule schedule;
    schedule.set(a, rate("25"), 0, 1);
    schedule.set(b, rate("10"), 0, 1);
    schedule.set(c, rate("5"), 0, 1);
    EXPECT_EQ(schedule.next_due_ns(), 40 * ns_per_ms);
    while (schedule.next_due_ns() < 200 * ns_per_ms) schedule.take(schedule.next_due_ns());
    EXPECT_THAT(pairs(schedule.take(200 * ns_per_ms)), ElementsAre(std::pair{1, 5}, std::pair{2, 2}, std::pair{3, 1}));
}

TEST(Schedule, CamerasOfOneRateAreDueTogetherWheneverTheyWereMade) {
    Schedule schedule;
    schedule.set(a, rate("30000/1001"), 0, 1);
    schedule.set(b, rate("30000/1001"), 1'234'567, 1);
    EXPECT_EQ(schedule.next_due_ns(a), schedule.next_due_ns(b));
}

TEST(Schedule, SequenceNumbersGoOnAcrossAChangeOfRate) {
    Schedule schedule;
    schedule.set(a, rate("25"), 0, 1);
    for (int i = 0; i < 10; ++i) schedule.take(schedule.next_due_ns());
    const std::int64_t next = schedule.next_sequence(a);
    EXPECT_EQ(next, 11);
    schedule.set(a, rate("5"), 400 * ns_per_ms, next);
    EXPECT_EQ(schedule.next_due_ns(), 600 * ns_per_ms);
    EXPECT_EQ(schedule.take(600 * ns_per_ms).front().sequence, 11);
}

TEST(Schedule, UnderOverloadTheOldestNewestInstantIsChosen) {
    Schedule schedule;
    schedule.set(a, rate("25"), 0, 1);
    schedule.set(b, rate("25"), 0, 1);
    // Three instants are due; the last one supersedes the others, for all cameras alike.
    EXPECT_EQ(schedule.choose_instant(130 * ns_per_ms), 120 * ns_per_ms);
    const auto skipped = schedule.skip_before(120 * ns_per_ms);
    ASSERT_EQ(skipped.size(), 2u);
    EXPECT_EQ(skipped[0].frames, 2);
    EXPECT_EQ(skipped[1].frames, 2);
    EXPECT_EQ(schedule.take(120 * ns_per_ms).size(), 2u);
}

TEST(Schedule, PicturesThatTakeSeveralPeriodsFallDueAfterThemAndAreNumberedOnByOne) {
    Schedule schedule;
    schedule.set(a, rate("25"), 0, 1);
    EXPECT_EQ(schedule.take(40 * ns_per_ms).front().sequence, 1);
    schedule.set_stride(a, 3);
    EXPECT_EQ(schedule.next_due_ns(a), 160 * ns_per_ms);
    EXPECT_THAT(schedule.take(80 * ns_per_ms), testing::IsEmpty());
    EXPECT_EQ(schedule.take(160 * ns_per_ms).front().sequence, 2);
    schedule.set_stride(a, 1);
    EXPECT_EQ(schedule.next_due_ns(a), 200 * ns_per_ms);
    EXPECT_EQ(schedule.take(200 * ns_per_ms).front().sequence, 3);
}

TEST(Schedule, UnderOverloadOnlyPicturesThatWereDueAreLost) {
    Schedule schedule;
    schedule.set(a, rate("25"), 0, 1);
    schedule.set(b, rate("25"), 0, 1);
    schedule.take(40 * ns_per_ms);
    schedule.set_stride(a, 3);  // due at 160, 280, 400 ms
    schedule.set_stride(b, 4);  // due at 200, 360, 520 ms
    EXPECT_EQ(schedule.choose_instant(410 * ns_per_ms), 360 * ns_per_ms);
    const auto skipped = schedule.skip_before(360 * ns_per_ms);
    ASSERT_EQ(skipped.size(), 2u);
    EXPECT_EQ(skipped[0].frames, 2);
    EXPECT_EQ(skipped[0].first_ns, 160 * ns_per_ms);
    EXPECT_EQ(skipped[0].stride, 3);
    EXPECT_EQ(skipped[1].frames, 1);
    EXPECT_THAT(pairs(schedule.take(360 * ns_per_ms)), ElementsAre(std::pair{2, 3}));
    EXPECT_THAT(pairs(schedule.take(400 * ns_per_ms)), ElementsAre(std::pair{1, 4}));
}

TEST(Schedule, ASlowCameraLosesNothingToAFastOne) {
    Schedule schedule;
    schedule.set(a, rate("25"), 0, 1);
    schedule.set(b, rate("1000"), 0, 1);
    // Every picture takes 7 ms: the fast camera cannot keep up, the slow one must.
    std::int64_t slow = 0;
    for (TimeNs now = 0; now < ns_per_s; now += 7 * ns_per_ms) {
        if (schedule.next_due_ns() > now) continue;
        const TimeNs instant = schedule.choose_instant(now);
        for (const auto& skipped : schedule.skip_before(instant)) EXPECT_EQ(skipped.camera, b);
        for (const auto& due : schedule.take(instant)) slow += due.camera == a ? 1 : 0;
    }
    EXPECT_GE(slow, 23);
}

}  // namespace
}  // namespace camrig::engine::schedule_test

#include <future>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "core/base/bounded_queue.h"
#include "core/base/clock.h"
#include "core/base/latest_slot.h"

namespace camrig {
namespace {

TEST(BoundedQueue, GivesTheOldestFirstAndRefusesMoreThanFit) {
    BoundedQueue<std::string> queue(2);
    EXPECT_TRUE(queue.put("a"));
    EXPECT_TRUE(queue.put("b"));
    std::string third = "c";
    EXPECT_FALSE(queue.put(std::move(third)));
    EXPECT_EQ(third, "c");  // NOLINT: left untouched
    EXPECT_EQ(queue.take(), "a");
    EXPECT_TRUE(queue.put(std::move(third)));
    EXPECT_EQ(queue.take_all(), (std::deque<std::string>{"b", "c"}));
    EXPECT_FALSE(queue.take());
}

TEST(BoundedQueue, AReaderSleepsUntilAValueComesOrItIsWokenOrTimePasses) {
    BoundedQueue<int> queue(2);
    std::thread writer([&] { queue.put(7); });
    EXPECT_EQ(queue.wait(), 7);
    writer.join();
    queue.wake();
    queue.wait_until(max_time_ns);  // ends at once
    queue.put(8);
    queue.wait_until(max_time_ns);
    EXPECT_EQ(queue.take(), 8);
    queue.wait_until(monotonic_now_ns());
    EXPECT_TRUE(queue.is_empty());
}

TEST(BoundedQueue, ClosedItTakesNothingAndGivesWhatIsThere) {
    BoundedQueue<int> queue(2);
    queue.put(1);
    queue.close();
    EXPECT_FALSE(queue.put(2));
    EXPECT_EQ(queue.wait(), 1);
    EXPECT_EQ(queue.wait(), std::nullopt);
    queue.wait_until(max_time_ns);

    BoundedQueue<int> other(2);
    other.put(3);
    EXPECT_EQ(other.close_and_take(), std::deque{3});
    EXPECT_EQ(other.wait(), std::nullopt);
}

TEST(BoundedQueue, AReaderElsewhereIsWokenForEachValueAndNeverAfterTheEnd) {
    int woken = 0;
    BoundedQueue<int> queue(2, [&] { ++woken; });
    queue.put(1);
    queue.put(2);
    queue.put(3);  // has no room
    EXPECT_EQ(woken, 2);
    queue.take_all();
    queue.close();
    queue.put(4);
    EXPECT_EQ(woken, 2);
}

TEST(LatestSlot, TheNewestValueTakesThePlaceOfTheOneThatWaits) {
    LatestSlot<int> slot([] {});
    EXPECT_EQ(slot.put(1), std::nullopt);
    EXPECT_EQ(slot.put(2), 1);
    EXPECT_EQ(slot.take(), 2);
    EXPECT_EQ(slot.take(), std::nullopt);
}

TEST(LatestSlot, TheReaderIsToldOnceUntilItHasFoundNothing) {
    int told = 0;
    LatestSlot<int> slot([&] { ++told; });
    slot.put(1);
    slot.put(2);
    slot.take();
    slot.put(3);
    EXPECT_EQ(told, 1);
    slot.take();
    slot.take();  // nothing
    slot.put(4);
    EXPECT_EQ(told, 2);
}

TEST(LatestSlot, ClosedItGivesBackWhatIsPut) {
    int told = 0;
    LatestSlot<int> slot([&] { ++told; });
    slot.put(1);
    EXPECT_EQ(slot.close(), 1);
    EXPECT_EQ(slot.put(2), 2);
    EXPECT_EQ(slot.take(), std::nullopt);
    EXPECT_EQ(told, 1);
}

}  // namespace
}  // namespace camrig

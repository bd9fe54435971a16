#include "core/engine/draw_queue.h"

#include <array>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace camrig::engine::draw_queue_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class DrawQueueTest : public testing::Test {
protected:
    DueViews due(TimeNs at_ns, std::initializer_list<std::uint32_t> cameras, bool may_be_dropped = true) {
        auto snapshot = std::make_shared<world::Snapshot>();
        snapshot->world_ns = at_ns;
        DueViews views{std::move(snapshot), at_ns, {}, may_be_dropped};
        for (const std::uint32_t camera : cameras) views.views.emplace_back().camera = CameraId(camera);
        return views;
    }
    void add(int cost_class, DueViews views) { queue.add(cost_class, std::move(views), dropped); }
    static std::vector<std::uint32_t> cameras_of(const DueViews& views) {
        std::vector<std::uint32_t> cameras;
        for (const render::View& view : views.views) cameras.push_back(static_cast<std::uint32_t>(view.camera));
        return cameras;
    }
    std::vector<TimeNs> dropped_at() const {
        std::vector<TimeNs> times;
        for (const DueViews& views : dropped) times.push_back(views.monotonic_ns);
        return times;
    }
    /// Draws what is next, which takes so long a view.
    int draw(std::array<TimeNs, DrawQueue::all_classes> view_ns) {
        const int next = queue.next().value();
        const TimeNs cost_ns = view_ns[static_cast<std::size_t>(next)];
        if (next != DrawQueue::requests) queue.take(next, 1);
        queue.charge(next, cost_ns);
        return next;
    }

    DrawQueue queue;
    std::vector<DueViews> dropped;
};

TEST_F(DrawQueueTest, AnInstantIsTakenInPiecesInItsOrder) {
    add(0, due(10, {1, 2, 3}));
    EXPECT_EQ(queue.next(), 0);
    EXPECT_THAT(cameras_of(queue.take(0, 2)), ElementsAre(1, 2));
    EXPECT_FALSE(queue.empty());
    EXPECT_THAT(cameras_of(queue.take(0, 2)), ElementsAre(3));
    EXPECT_TRUE(queue.empty());
    EXPECT_EQ(queue.next(), std::nullopt);
}

TEST_F(DrawQueueTest, CamerasOfOneClassDropTheSameInstants) {
    add(0, due(10, {1, 2}));
    add(0, due(20, {1, 2}));
    add(0, due(30, {1, 2}));
    EXPECT_THAT(dropped_at(), ElementsAre(10, 20));
    EXPECT_EQ(queue.take(0, 9).monotonic_ns, 30);
}

TEST_F(DrawQueueTest, ASlowCameraKeepsItsNewestAndItsInstantIsDrawnWhole) {
    add(0, due(10, {1, 2}));
    add(0, due(20, {1}));
    add(0, due(30, {1}));
    EXPECT_THAT(dropped_at(), ElementsAre(20));
    const DueViews first = queue.take(0, 9);
    EXPECT_EQ(first.monotonic_ns, 10);
    EXPECT_THAT(cameras_of(first), ElementsAre(1, 2));
    EXPECT_EQ(queue.take(0, 9).monotonic_ns, 30);
}

TEST_F(DrawQueueTest, WhatIsBegunIsDrawnToItsEnd) {
    add(0, due(10, {1, 2, 3}));
    queue.take(0, 1);
    add(0, due(20, {1, 2, 3}));
    EXPECT_THAT(dropped, IsEmpty());
    EXPECT_THAT(cameras_of(queue.take(0, 9)), ElementsAre(2, 3));
    EXPECT_EQ(queue.take(0, 9).monotonic_ns, 20);
}

TEST_F(DrawQueueTest, WhatMayNotBeDroppedStays) {
    for (const TimeNs at_ns : {10, 20, 30}) add(0, due(at_ns, {1}, false));
    EXPECT_THAT(dropped, IsEmpty());
    for (const TimeNs at_ns : {10, 20, 30}) EXPECT_EQ(queue.take(0, 9).monotonic_ns, at_ns);
}

TEST_F(DrawQueueTest, WhatIsKeptIsAtMostAnInstantACamera) {
    for (TimeNs at_ns = 1; at_ns <= 1000; ++at_ns) {
        if (at_ns % 7 == 0) add(0, due(at_ns, {2}));
        add(0, due(at_ns, {1, 3}));
    }
    std::size_t kept = 0;
    for (; !queue.empty(); ++kept) queue.take(0, 9);
    EXPECT_LE(kept, 3U);
    EXPECT_EQ(kept + dropped.size(), 1000U + 1000 / 7);
}

TEST_F(DrawQueueTest, ADearCameraHasItsShareAndNoMore) {
    // One camera of 80 ms a picture and three of 2 ms, all with something to draw at any time.
    std::array<TimeNs, DrawQueue::all_classes> spent{};
    const std::array<TimeNs, DrawQueue::all_classes> view_ns = {2, 0, 0, 80};
    for (TimeNs at_ns = 1; at_ns <= 2000; ++at_ns) {
        add(0, due(at_ns, {1, 2, 3}));
        add(3, due(at_ns, {4}));
        const int drawn = draw(view_ns);
        spent[static_cast<std::size_t>(drawn)] += view_ns[static_cast<std::size_t>(drawn)];
    }
    const double dear = static_cast<double>(spent[3]) / static_cast<double>(spent[0] + spent[3]);
    EXPECT_NEAR(dear, 0.25, 0.02);
}

TEST_F(DrawQueueTest, RequestsHaveAThirdOfWhatCamerasHave) {
    std::array<TimeNs, DrawQueue::all_classes> spent{};
    std::array<TimeNs, DrawQueue::all_classes> view_ns = {2};
    view_ns[DrawQueue::requests] = 30;
    queue.set_requests(true);
    for (TimeNs at_ns = 1; at_ns <= 2000; ++at_ns) {
        add(0, due(at_ns, {1, 2, 3, 4, 5, 6}));
        const int drawn = draw(view_ns);
        spent[static_cast<std::size_t>(drawn)] += view_ns[static_cast<std::size_t>(drawn)];
    }
    const double requests = static_cast<double>(spent[DrawQueue::requests]);
    EXPECT_NEAR(requests / static_cast<double>(spent[0]), 1.0 / 3.0, 0.03);
}

TEST_F(DrawQueueTest, WhoHadNothingToDrawSavesNothingUp) {
    const std::array<TimeNs, DrawQueue::all_classes> view_ns = {2, 0, 0, 80};
    for (TimeNs at_ns = 1; at_ns <= 100; ++at_ns) {
        add(0, due(at_ns, {1}));
        draw(view_ns);
    }
    // Dear pictures begin now: after one of them it is the other's turn until that has had as much.
    add(0, due(200, {1}));
    add(3, due(200, {4}));
    int dear = 0;
    for (TimeNs at_ns = 201; at_ns <= 241; ++at_ns) {
        dear += draw(view_ns) == 3;
        add(0, due(at_ns, {1}));
        add(3, due(at_ns, {4}));
    }
    EXPECT_LE(dear, 2);
    EXPECT_GE(dear, 1);
}

TEST_F(DrawQueueTest, ACameraThatGoesTakesItsViewsAlong) {
    add(0, due(10, {1, 2}));
    add(2, due(10, {3}));
    std::vector<DueViews> removed;
    queue.remove(CameraId(3), removed);
    queue.remove(CameraId(2), removed);
    ASSERT_EQ(removed.size(), 2U);
    EXPECT_EQ(removed[0].snapshot->world_ns, 10);
    EXPECT_THAT(cameras_of(removed[0]), ElementsAre(3));
    EXPECT_THAT(cameras_of(removed[1]), ElementsAre(2));
    EXPECT_THAT(cameras_of(queue.take(0, 9)), ElementsAre(1));
    EXPECT_TRUE(queue.empty());
}

}  // namespace
}  // namespace camrig::engine::draw_queue_test

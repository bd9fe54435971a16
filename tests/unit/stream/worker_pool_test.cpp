#include "core/stream/worker_pool.h"

#include <future>

#include <gtest/gtest.h>

namespace camrig::stream {
namespace {

/// A pool of one thread, which is busy until go().
class BusyPool : public testing::Test {
protected:
    explicit BusyPool(std::size_t max_waiting = 2) : pool(1, max_waiting) {
        EXPECT_TRUE(pool.post([this] {
            started_.set_value();
            go_.get_future().wait();
            order.push_back(1);
        }));
        started_.get_future().wait();
    }
    void go() { go_.set_value(); }
    WorkerPool::Job job(int number) {
        return [this, number] { order.push_back(number); };
    }

    std::vector<int> order;
    WorkerPool pool;

private:
    std::promise<void> started_, go_;
};

TEST_F(BusyPool, RunsJobsInOrderAndRefusesMoreThanFit) {
    EXPECT_TRUE(pool.post(job(2)));
    EXPECT_TRUE(pool.post(job(3)));
    WorkerPool::Job fourth = job(4);
    EXPECT_FALSE(pool.post(std::move(fourth)));
    EXPECT_TRUE(fourth);  // NOLINT: left untouched
    go();
    std::promise<void> finished;
    while (!pool.post([&] { finished.set_value(); })) std::this_thread::yield();
    finished.get_future().wait();
    EXPECT_EQ(order, (std::vector{1, 2, 3}));
}

class RoomyPool : public BusyPool {
protected:
    RoomyPool() : BusyPool(1'000'000) {}
};

TEST_F(RoomyPool, StoppedRunsNoneOfThoseThatWait) {
    EXPECT_TRUE(pool.post(job(2)));
    const auto told = std::make_shared<int>();
    EXPECT_TRUE(pool.post([told] {}));
    auto stopping = std::async(std::launch::async, [&] { pool.stop(); });
    while (pool.post(job(3))) std::this_thread::yield();  // until it is stopped
    go();
    stopping.wait();
    EXPECT_EQ(order, std::vector{1});
    EXPECT_EQ(told.use_count(), 1);
}

TEST(WorkerPool, GoesWhenAllThatWaitsHasRun) {
    int done = 0;
    {
        WorkerPool pool(1, 100);
        for (int i = 0; i < 100; ++i)
            while (!pool.post([&] { ++done; })) std::this_thread::yield();
    }
    EXPECT_EQ(done, 100);
}

}  // namespace
}  // namespace camrig::stream

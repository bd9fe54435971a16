#include "core/render/software/thread_team.h"

#include <atomic>
#include <new>

#include <gtest/gtest.h>

namespace camrig::render::software {
namespace {

/// How often each index was done, and by which workers.
struct Tally {
    explicit Tally(std::size_t count) : done(count) {}
    std::vector<std::atomic<int>> done;
    std::atomic<int> bad_workers = 0;

    void run(ThreadTeam& team) {
        team.run(done.size(), [this, &team](int worker, std::size_t index) {
            ++done[index];
            if (worker < 0 || worker >= team.size()) ++bad_workers;
        });
    }
};

TEST(ThreadTeam, DoesEveryIndexOnceWhateverTheirNumber) {
    for (const int threads : {1, 2, 3, 8}) {
        ThreadTeam team(threads);
        EXPECT_EQ(team.size(), threads);
        for (const std::size_t count : {0u, 1u, 2u, 3u, 7u, 8u, 9u, 1000u}) {
            Tally tally(count);
            tally.run(team);
            for (const auto& done : tally.done) EXPECT_EQ(done, 1) << threads << " threads, " << count << " indices";
            EXPECT_EQ(tally.bad_workers, 0);
        }
    }
}

TEST(ThreadTeam, HasFinishedWhenItReturnsRunAfterRun) {
    ThreadTeam team(3);
    // Not atomic: what a run wrote must be there for the next, whichever thread does it.
    std::vector<int> sums(5, 0);
    for (int n = 1; n <= 20'000; ++n) {
        team.run(sums.size(), [&](int, std::size_t i) { sums[i] += static_cast<int>(i) + 1; });
        ASSERT_EQ(sums[4], 5 * n);
    }
    for (std::size_t i = 0; i < sums.size(); ++i) EXPECT_EQ(sums[i], 20'000 * (static_cast<int>(i) + 1));
}

TEST(ThreadTeam, AWorkerDoesOneThingAtATime) {
    // What each worker has (scratch memory) is not shared.
    ThreadTeam team(4);
    std::vector<std::atomic<int>> busy(4);
    std::atomic<int> clashes = 0;
    for (int n = 0; n < 500; ++n) {
        team.run(16, [&](int worker, std::size_t) {
            auto& mine = busy[static_cast<std::size_t>(worker)];
            if (++mine != 1) ++clashes;
            --mine;
        });
    }
    EXPECT_EQ(clashes, 0);
}

TEST(ThreadTeam, AJobThatThrowsReachesTheCallerWhenNobodyWorksAnyMore) {
    for (const int threads : {1, 2, 4}) {
        ThreadTeam team(threads);
        for (int n = 0; n < 200; ++n) {
            std::atomic<int> busy = 0;
            const auto work = [&](int, std::size_t i) {
                ++busy;
                const bool throws = i % 3 == 1;
                --busy;
                if (throws) throw std::bad_alloc();
            };
            EXPECT_THROW(team.run(16, work), std::bad_alloc);
            EXPECT_EQ(busy, 0);
            Tally tally(16);
            tally.run(team);
            for (const auto& done : tally.done) EXPECT_EQ(done, 1) << "in the next run";
        }
    }
}

TEST(ThreadTeam, StopsWithoutHavingWorked) {
    for (int n = 0; n < 50; ++n) ThreadTeam team(3);
}

}  // namespace
}  // namespace camrig::render::software

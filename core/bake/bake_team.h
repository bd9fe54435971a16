#pragma once

#include <algorithm>
#include <atomic>
#include <functional>
#include <utility>

#include "core/render/software/thread_team.h"

namespace camrig::bake {

/// The threads of one bake, and its progress. One thread calls; it takes part in the work.
class BakeTeam {
public:
    /// Items that a thread takes at a time, where each is little work.
    static constexpr std::size_t usual_block = 2048;

    /// `progress`: told the part that is done, 0 to 1, on the calling thread; false ends the bake. May be empty.
    BakeTeam(int threads, std::function<bool(double)> progress)
        : team_(std::max(1, threads)), progress_(std::move(progress)) {}

    /// Calls work(i) for each i below `count`, on all threads, `block` of them at a time. `share`: which part of the
    /// whole bake that is. False: the bake was ended, now or before, and calls were left out.
    bool run(std::size_t count, double share, std::size_t block, const std::function<void(std::size_t)>& work) {
        const std::size_t blocks = (count + block - 1) / block;
        std::atomic<std::size_t> finished = 0;
        std::atomic<bool> goes_on = !is_ended_;
        team_.run(blocks, [&](int worker, std::size_t number) {
            if (!goes_on) return;
            for (std::size_t i = number * block; i < std::min(count, (number + 1) * block); ++i) work(i);
            const std::size_t now = ++finished;
            // The first worker is the one that asks.
            if (worker == 0 && progress_)
                goes_on = progress_(done_ + share * static_cast<double>(now) / static_cast<double>(blocks));
        });
        done_ += share;
        is_ended_ = !goes_on;
        return goes_on;
    }
    bool is_ended() const { return is_ended_; }

    double done() const { return done_; }
    /// For work that needs not be done.
    void set_done(double done) { done_ = done; }

private:
    render::software::ThreadTeam team_;
    std::function<bool(double)> progress_;
    double done_ = 0.0;
    bool is_ended_ = false;
};

}  // namespace camrig::bake

#include "core/engine/draw_lane.h"

#include <future>
#include <utility>

#include <pthread.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "core/base/clock.h"

namespace camrig::engine {

Result<std::unique_ptr<DrawLane>> ThreadedLane::start(const Options& options, MakeRenderer make,
                                                      std::shared_ptr<DrawnTasks> drawn) {
    std::unique_ptr<ThreadedLane> lane(new ThreadedLane(std::move(drawn)));
    std::promise<Result<void>> promise;
    auto started = promise.get_future();
    lane->thread_ = std::thread([&lane = *lane, options, make = std::move(make), &promise] {
        lane.run(options, make, [&promise](Result<void> result) { promise.set_value(std::move(result)); });
    });
    pthread_setname_np(lane->thread_.native_handle(), options.name.c_str());
    if (auto result = started.get(); !result) return std::unexpected(result.error());
    return lane;
}

ThreadedLane::~ThreadedLane() {
    const auto not_drawn = tasks_.close_and_take();
    thread_.join();
}

void ThreadedLane::run(const Options& options, const MakeRenderer& make,
                       const std::function<void(Result<void>)>& started) {
    // Of this thread alone and of those that it starts (setpriority(2), "C library/kernel differences"). Where it is
    // forbidden all lanes are equal.
    if (options.niceness > 0) {
        const auto self = static_cast<id_t>(syscall(SYS_gettid));
        const int present = getpriority(PRIO_PROCESS, self);
        setpriority(PRIO_PROCESS, self, present + options.niceness);
    }
    auto renderer = make();
    if (!renderer) return started(std::unexpected(renderer.error()));
    renderer_ = std::move(*renderer);
    description_ = renderer_->description();
    started({});

    while (auto task = tasks_.wait()) {
        const TimeNs start_ns = monotonic_now_ns();
        task->draw(*renderer_);
        const TimeNs spent_ns = monotonic_now_ns() - start_ns;
        task->draw = nullptr;  // what it holds goes on this thread, before the engine hears of it
        const render::RenderCounters counters = renderer_->counters();
        {
            std::lock_guard lock(mutex_);
            counters_ = counters;
        }
        CHECK(drawn_->put([done = std::move(task->done), spent_ns] { done(spent_ns); }));
    }
    renderer_.reset();
}

void ThreadedLane::post(DrawTask task) {
    CHECK(tasks_.put(std::move(task)));
}

render::RenderCounters ThreadedLane::counters() const {
    std::lock_guard lock(mutex_);
    return counters_;
}

}  // namespace camrig::engine

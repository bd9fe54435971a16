#include "core/engine/draw_lane.h"

#include <future>
#include <utility>

#include <pthread.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace camrig {

void DrawnTasks::put(std::function<void()> done) {
    {
        std::lock_guard lock(mutex_);
        tasks_.push_back(std::move(done));
    }
    came_.notify_one();
    wake_();
}

std::vector<std::function<void()>> DrawnTasks::take() {
    std::lock_guard lock(mutex_);
    return std::exchange(tasks_, {});
}

bool DrawnTasks::empty() const {
    std::lock_guard lock(mutex_);
    return tasks_.empty();
}

void DrawnTasks::wait() {
    std::unique_lock lock(mutex_);
    came_.wait(lock, [this] { return !tasks_.empty(); });
}

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
    {
        std::lock_guard lock(mutex_);
        stops_ = true;
    }
    posted_.notify_one();
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

    std::unique_lock lock(mutex_);
    while (true) {
        posted_.wait(lock, [this] { return stops_ || !tasks_.empty(); });
        if (stops_) break;
        DrawTask task = std::move(tasks_.front());
        tasks_.pop_front();
        lock.unlock();
        task.draw(*renderer_);
        task.draw = nullptr;  // what it holds goes on this thread, before the engine hears of it
        const RenderCounters counters = renderer_->counters();
        lock.lock();
        counters_ = counters;
        lock.unlock();
        drawn_->put(std::move(task.done));
        lock.lock();
    }
    tasks_.clear();
    lock.unlock();
    renderer_.reset();
}

void ThreadedLane::post(DrawTask task) {
    {
        std::lock_guard lock(mutex_);
        tasks_.push_back(std::move(task));
    }
    posted_.notify_one();
}

RenderCounters ThreadedLane::counters() const {
    std::lock_guard lock(mutex_);
    return counters_;
}

}  // namespace camrig

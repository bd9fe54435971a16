#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "core/base/bounded_queue.h"
#include "core/base/result.h"
#include "core/base/time.h"
#include "core/render/renderer.h"

namespace camrig::engine {

/// Something to draw, and what the engine does once it is drawn.
struct DrawTask {
    std::function<void(render::Renderer&)> draw;  ///< on the lane's thread
    std::function<void(TimeNs spent_ns)> done;    ///< afterwards, on the engine's: the wall time that draw() took
};

/// Finished tasks on their way back to the engine, each as the call of its DrawTask::done. Lanes put, the engine's
/// thread takes.
using DrawnTasks = BoundedQueue<std::function<void()>>;
/// Capacity of the queues. DrawDesk keeps the number of tasks small; reaching this is a bug (CHECK).
inline constexpr std::size_t max_draw_tasks = 1'000'000;

/// Carries out draw tasks one after the other, with a renderer of its own. All calls but counters(): engine's thread.
class DrawLane {
public:
    virtual ~DrawLane() = default;
    /// Never blocks.
    virtual void post(DrawTask task) = 0;
    /// As of the end of the last task. Any thread.
    virtual render::RenderCounters counters() const = 0;
    /// Whether the lane's renderer gives colour pictures of this view in that format (Renderer::makes).
    virtual bool makes(frame::PixelFormat format, const render::View& view) const = 0;
    /// Whether the renderer draws this view by its fast path, without expensive set-up (Renderer::is_plain).
    virtual bool is_plain(const render::View& view) const = 0;
    /// An estimate of the drawing time of the view's first picture (Renderer::expected_cost_ns).
    virtual TimeNs expected_cost_ns(const render::View& view) const = 0;
    /// Whether a second lane with such a renderer is useful (Renderer::is_on_cpu).
    virtual bool wants_second() const = 0;
    virtual const std::string& description() const = 0;
};

/// A lane with a thread, on which the renderer is made, used and destroyed. Tasks that wait when the lane is destroyed
/// are not carried out.
class ThreadedLane final : public DrawLane {
public:
    using MakeRenderer = std::function<Result<std::unique_ptr<render::Renderer>>()>;
    struct Options {
        std::string name;  ///< of the thread, at most 15 characters
        /// Added to the thread's niceness, and to that of all threads that its renderer starts: the kernel lets others
        /// go first when there are not cores enough.
        int niceness = 0;
    };
    /// Blocks until the renderer is made. Errors are those of `make`.
    static Result<std::unique_ptr<DrawLane>> start(const Options& options, MakeRenderer make,
                                                   std::shared_ptr<DrawnTasks> drawn);
    ~ThreadedLane() override;

    void post(DrawTask task) override;
    render::RenderCounters counters() const override;
    bool makes(frame::PixelFormat format, const render::View& view) const override {
        return renderer_->makes(format, view);
    }
    bool is_plain(const render::View& view) const override { return renderer_->is_plain(view); }
    TimeNs expected_cost_ns(const render::View& view) const override { return renderer_->expected_cost_ns(view); }
    bool wants_second() const override { return renderer_->is_on_cpu(); }
    const std::string& description() const override { return description_; }

private:
    explicit ThreadedLane(std::shared_ptr<DrawnTasks> drawn) : drawn_(std::move(drawn)) {}
    void run(const Options& options, const MakeRenderer& make, const std::function<void(Result<void>)>& started);

    const std::shared_ptr<DrawnTasks> drawn_;
    /// Made and destroyed on the thread; others call const functions whose answers never change.
    std::unique_ptr<render::Renderer> renderer_;
    std::string description_;
    BoundedQueue<DrawTask> tasks_{max_draw_tasks};
    mutable std::mutex mutex_;
    render::RenderCounters counters_;  ///< guarded by it
    std::thread thread_;
};

}  // namespace camrig::engine

#pragma once

#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "core/engine/draw_lane.h"
#include "core/engine/draw_queue.h"
#include "core/stream/statistics.h"

namespace camrig::engine {

/// Views that a lane has drawn, or failed to.
struct DrawnViews {
    DueViews due;
    std::vector<frame::FrameRef> frames;
    std::vector<render::Renderer::Finished::Failure> failures;
    std::vector<TimeNs> cost_ns;  ///< of each view (Renderer::Finished); empty where all failed
};

/// Draws views with a lane's renderer, on its thread, and records the time in `timer`. If drawing fails as a whole,
/// each view is reported as failed.
DrawnViews draw_views(render::Renderer& renderer, DueViews due, stream::StageTimer& timer);

/// Schedules drawing: which lane draws what, in which order, and how much at once. Engine's thread.
///
/// One lane draws all, or there are two: the first for cameras whose pictures are quickly drawn, the second, of lower
/// priority to the kernel, for the dear ones and for requests. A camera's pictures are drawn one after the other, on
/// one lane at a time; cameras of a group (CameraSpec::group) are in one class on one lane, so that the pictures of an
/// instant are all drawn or all dropped.
class DrawDesk {
public:
    struct Callbacks {
        std::function<void(DrawnViews&)> drawn;
        std::function<void(const DueViews&, const render::View&, stream::DropReason)> dropped;
        /// It is the turn of requests: gives the next one that needs drawing; nullopt if none does.
        std::function<std::optional<DrawTask>()> next_request;
    };
    /// One lane or two.
    DrawDesk(std::vector<std::unique_ptr<DrawLane>> lanes, std::shared_ptr<DrawnTasks> finished, Callbacks callbacks);

    /// Views of one instant are due.
    void add(const DueViews& due);
    /// Requests wait for their turn; next_request is asked until it has none.
    void set_requests(bool are_waiting) { lanes_.back().queue.set_requests(are_waiting); }

    /// Runs the callbacks of what the lanes have finished since the last call: Callbacks::drawn, and DrawTask::done of
    /// requests.
    void take_finished();
    /// Whether take_finished() has something to do.
    bool has_finished() const { return !finished_->is_empty(); }
    /// Gives idle lanes their next task. The time is CLOCK_MONOTONIC.
    void dispatch(TimeNs monotonic_ns);
    /// Whether a view of the camera waits or is being drawn.
    bool is_pending(CameraId camera) const {
        const auto found = cameras_.find(camera);
        return found != cameras_.end() && found->second.pending > 0;
    }
    /// Whether no view of any camera waits or is being drawn. Requests do not count.
    bool is_idle() const { return pending_views_ == 0; }
    /// Blocks until is_idle().
    void finish();
    /// A camera was deleted: removes what waits of it, and what lanes keep for it.
    void forget(CameraId camera);
    /// Another world: every lane discards what it keeps of the scene before.
    void begin_world(const world::SnapshotRef& snapshot);
    /// Whether requests share a lane with the cameras' frames.
    bool has_one_lane() const { return lanes_.size() == 1; }

    /// DrawLane::makes.

    bool makes(frame::PixelFormat format, const render::View& view) const {
        return lanes_.front().lane->makes(format, view);
    }
    render::RenderCounters counters() const;
    /// Times of all drawing. Shared with the lanes, which may still draw when the desk is destroyed.
    const std::shared_ptr<stream::StageTimer>& timer() const { return timer_; }

private:
    struct Lane {
        std::unique_ptr<DrawLane> lane;
        DrawQueue queue;
        int tasks = 0;                                          ///< posted and not finished
        std::array<TimeNs, DrawQueue::cost_classes> view_ns{};  ///< by class: wall time of a view lately
        TimeNs requests_ns = 0, all_ns = 0;                     ///< time spent drawing for requests, and in all
    };
    /// Cameras that are drawn together: those of one CameraSpec::group, or one alone.
    struct Group {
        int cost_class = 0;                  ///< that of its dearest camera
        Lane* lane = nullptr;                ///< null: it has drawn nothing yet
        int pending = 0;                     ///< views that wait or are being drawn
        TimeNs requests_ns = 0, all_ns = 0;  ///< its lane's, when the view that waits longest was added
    };
    using GroupName = std::pair<std::string, CameraId>;  ///< CameraSpec::group, or else the camera
    /// What is known of a camera's cost.
    struct Camera {
        /// CPU time of its last views; 0: not known. The smallest counts: more than that is for set-up that other views
        /// share.
        std::array<TimeNs, 4> cpu_ns{};
        std::size_t next = 0;    ///< in cpu_ns
        TimeNs expected_ns = 0;  ///< an estimate, until one is known
        ImageSize size;          ///< this and what follows: what these costs were measured with
        world::Quality quality = world::Quality::simple;
        bool is_plain = true;
        int pending = 0;  ///< views that wait or are being drawn
        int drawing = 0;  ///< those that are being drawn
        GroupName group;  ///< of its last view
        /// 0: no cost is known.
        TimeNs known_ns() const;
    };
    /// Records what the camera's cost depends on, and its group.
    void note_settings(const render::View& view);
    /// Counts the view as pending and returns its group, which has a lane. note_settings() was called for all views of
    /// its instant.
    Group& assign(const render::View& view, bool may_be_dropped);
    /// The class of the group's dearest camera at present.
    int class_of(const GroupName& name) const;
    /// Drops the waiting views of a group of which none is being drawn.
    void give_up_waiting(const GroupName& name, Group& group);
    /// For a group with nothing pending: moves it, with what its lane keeps for it, to the lane for its cost.
    void choose_lane(const GroupName& name, Group& group);
    /// Removes the camera from this group.
    void leave_group(const GroupName& name, CameraId camera);
    stream::DropReason reason_for(const Group& group) const;
    void drop(const std::vector<DueViews>& dropped);
    /// The view was drawn or dropped: it is not pending any more.
    void end_view(const render::View& view);
    static void forget(Lane& lane, CameraId camera);
    static void hand_over(Lane& lane, CameraId camera);
    void dispatch(Lane& lane, TimeNs monotonic_ns);
    void post_views(Lane& lane, int cost_class, TimeNs monotonic_ns);
    void post_request(Lane& lane);
    void finish_views(Lane& lane, int cost_class, DrawnViews& drawn, TimeNs spent_ns);
    void charge(Lane& lane, int one_class, TimeNs spent_ns);

    std::vector<Lane> lanes_;
    const std::shared_ptr<DrawnTasks> finished_;
    const Callbacks callbacks_;
    const std::shared_ptr<stream::StageTimer> timer_ = std::make_shared<stream::StageTimer>();  ///< lanes write to it
    std::map<CameraId, Camera> cameras_;
    std::map<GroupName, Group> groups_;
    CostClasses classes_;
    std::vector<TimeNs> costs_;  ///< scratch for CostClasses::divide()
    std::size_t pending_views_ = 0;
};

}  // namespace camrig::engine

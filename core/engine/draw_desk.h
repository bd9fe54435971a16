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

/// Draws views with a lane's renderer, on its thread, and notes the time for statistics. An error is a failure of each
/// view.
DrawnViews draw_views(render::Renderer& renderer, DueViews due, stream::StageTimer& timer);

/// Hands out what is to be drawn: which lane, in which order, how much at once. Engine's thread.
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
        /// It is the turn of requests: the next that needs drawing; nothing if there is none (any more).
        std::function<std::optional<DrawTask>()> next_request;
    };
    /// One lane or two.
    DrawDesk(std::vector<std::unique_ptr<DrawLane>> lanes, std::shared_ptr<DrawnTasks> finished, Callbacks callbacks);

    /// Views of one instant are due.
    void add(const DueViews& due);
    /// Requests wait for their turn; next_request is asked until it has none.
    void set_requests(bool are_waiting) { lanes_.back().queue.set_requests(are_waiting); }

    /// Does what follows from what the lanes have drawn since (Callbacks::drawn, what done() of requests does).
    void take_finished();
    /// take_finished() has something to do.
    bool has_finished() const { return !finished_->is_empty(); }
    /// Gives lanes that have nothing to do what is next, at this time (CLOCK_MONOTONIC).
    void dispatch(TimeNs monotonic_ns);
    /// A view of the camera waits or is being drawn.
    bool is_pending(CameraId camera) const {
        const auto found = cameras_.find(camera);
        return found != cameras_.end() && found->second.pending > 0;
    }
    /// No view of a camera waits or is being drawn; requests may be.
    bool is_idle() const { return pending_views_ == 0; }
    /// Waits until is_idle().
    void finish();
    /// A camera is gone.
    void forget(CameraId camera);
    /// Another world: every lane discards what it keeps of the scene before.
    void begin_world(const world::SnapshotRef& snapshot);
    /// Requests share the lane of running cameras.
    bool has_one_lane() const { return lanes_.size() == 1; }

    bool makes(frame::PixelFormat format, const render::View& view) const {
        return lanes_.front().lane->makes(format, view);
    }
    render::RenderCounters counters() const;
    /// Of all drawing. Shared with the lanes, which may still draw when the desk goes.
    const std::shared_ptr<stream::StageTimer>& timer() const { return timer_; }

private:
    struct Lane {
        std::unique_ptr<DrawLane> lane;
        DrawQueue queue;
        int tasks = 0;                                          ///< posted and not finished
        std::array<TimeNs, DrawQueue::cost_classes> view_ns{};  ///< wall time a view took lately
        TimeNs requests_ns = 0, all_ns = 0;                     ///< drawn for requests, and in all
    };
    /// Cameras that are drawn together: those of one CameraSpec::group, or one alone.
    struct Group {
        int cost_class = 0;                  ///< that of its dearest camera
        Lane* lane = nullptr;                ///< null: it has drawn nothing yet
        int pending = 0;                     ///< views that wait or are being drawn
        TimeNs requests_ns = 0, all_ns = 0;  ///< of its lane, when the view that waits longest came
    };
    using GroupName = std::pair<std::string, CameraId>;  ///< CameraSpec::group, or else the camera
    /// What is known of a camera's cost.
    struct Camera {
        /// Of its last views; 0: not known. The least that is known counts: what a view sets up for others is not its
        /// cost.
        std::array<TimeNs, 4> cpu_ns{};
        std::size_t next = 0;    ///< in cpu_ns
        TimeNs expected_ns = 0;  ///< until one is known
        ImageSize size;          ///< this and what follows: what these costs were measured with
        world::Quality quality = world::Quality::simple;
        bool is_plain = true;
        int pending = 0;  ///< views that wait or are being drawn
        int drawing = 0;  ///< those that are being drawn
        GroupName group;  ///< of its last view
        /// 0: no cost is known.
        TimeNs known_ns() const;
    };
    /// Takes note of what the camera's cost depends on, and of its group.
    void note_settings(const render::View& view);
    /// The view is pending from now on, in the group and so on the lane that this says. The settings of all views of
    /// its instant have been noted.
    Group& assign(const render::View& view, bool may_be_dropped);
    /// The class that a group's costs are of now.
    int class_of(const GroupName& name) const;
    /// Drops what waits of a group of which nothing is being drawn.
    void give_up_waiting(const GroupName& name, Group& group);
    /// The group has nothing pending: it goes to the lane of cameras that cost as much, and takes along what the other
    /// one kept for it.
    void choose_lane(const GroupName& name, Group& group);
    /// The camera is not of this group any more.
    void leave_group(const GroupName& name, CameraId camera);
    stream::DropReason reason_for(const Group& group) const;
    void drop(const std::vector<DueViews>& dropped);
    /// The view is drawn or dropped.
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
    std::vector<TimeNs> costs_;  ///< while classes_ are divided
    std::size_t pending_views_ = 0;
};

}  // namespace camrig::engine

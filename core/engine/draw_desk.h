#pragma once

#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "core/engine/draw_lane.h"
#include "core/engine/draw_queue.h"
#include "core/stream/statistics.h"

namespace camrig {

/// Views that a lane has drawn, or failed to.
struct DrawnViews {
    DueViews due;
    std::vector<FrameRef> frames;
    std::vector<Renderer::Finished::Failure> failures;
    TimeNs wall_ns = 0;
    std::vector<TimeNs> cost_ns;  ///< of each view (Renderer::Finished); empty where all failed
};

/// Draws views with a lane's renderer, on its thread, and notes the time. An error is a failure of each view.
DrawnViews draw_views(Renderer& renderer, DueViews due, StageTimer& timer);

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
        std::function<void(const DueViews&, const View&, DropReason)> dropped;
        /// It is the turn of requests: the next that needs drawing; nothing if there is none (any more).
        std::function<std::optional<DrawTask>()> next_request;
    };
    /// One lane or two.
    DrawDesk(std::vector<std::unique_ptr<DrawLane>> lanes, std::shared_ptr<DrawnTasks> finished, Callbacks callbacks);

    /// Views of one instant are due.
    void add(const DueViews& due);
    /// Requests wait for their turn; next_request is asked until it has none.
    void set_requests(bool are_waiting) { lanes_.back().queue.set_requests(are_waiting); }

    /// Hears what has been drawn.
    void hear();
    /// hear() has something to hear.
    bool has_news() const { return !finished_->is_empty(); }
    /// Gives lanes that have nothing to do what is next, at this time (CLOCK_MONOTONIC).
    void hand_out(TimeNs monotonic_ns);
    /// A view of the camera waits or is being drawn.
    bool is_at_work(CameraId camera) const {
        const auto found = cameras_.find(camera);
        return found != cameras_.end() && found->second.at_work > 0;
    }
    /// No view of a camera waits or is being drawn; requests may be.
    bool is_idle() const { return views_at_work_ == 0; }
    /// Waits until is_idle().
    void finish();
    /// A camera is gone.
    void forget(CameraId camera);
    /// There is another world: no lane keeps what it had of the old one.
    void begin_world(const SnapshotRef& snapshot);
    /// Requests share the lane of running cameras.
    bool has_one_lane() const { return lanes_.size() == 1; }

    bool makes(PixelFormat format, const View& view) const { return lanes_.front().lane->makes(format, view); }
    RenderCounters counters() const;
    /// Of all drawing. Shared with the lanes, which may still draw when the desk goes.
    const std::shared_ptr<StageTimer>& timer() const { return timer_; }

private:
    struct Lane {
        std::unique_ptr<DrawLane> lane;
        DrawQueue queue;
        int tasks = 0;                                          ///< posted and not heard of
        std::array<TimeNs, DrawQueue::cost_classes> view_ns{};  ///< wall time a view took lately
        TimeNs requests_ns = 0, all_ns = 0;                     ///< drawn for requests, and in all
    };
    /// Cameras that are drawn together: those of a group, or one alone.
    struct Party {
        int cost_class = 0;                  ///< that of its dearest camera
        Lane* lane = nullptr;                ///< null: it has drawn nothing yet
        int at_work = 0;                     ///< views that wait or are being drawn
        TimeNs requests_ns = 0, all_ns = 0;  ///< of its lane, when the view that waits longest came
    };
    using PartyName = std::pair<std::string, CameraId>;  ///< of its group, or of the camera
    /// What is known of a camera's cost.
    struct Camera {
        /// Of its last views; 0: not known. The least of them counts: what a view sets up for others is not its cost.
        std::array<TimeNs, 4> cpu_ns{};
        std::size_t next = 0;  ///< in cpu_ns
        ImageSize size;        ///< it was drawn with, as what follows
        Quality quality = Quality::simple;
        bool is_plain = true;
        int at_work = 0;  ///< views that wait or are being drawn
        PartyName party;  ///< of its last view
        /// The class that it would have alone.
        int cost_class(int present) const;
    };
    /// What the camera's next view is like.
    void note(const View& view);
    /// The view is at work from now on: where and with whom. All views of its instant have been noted.
    Party& place(const View& view);
    /// The party has nothing at work: it goes where its cameras' costs are.
    void choose_lane(const PartyName& name, Party& party);
    /// The camera is not of this party any more.
    void leave(const PartyName& name, CameraId camera);
    DropReason reason_for(const Party& party) const;
    void drop(const std::vector<DueViews>& dropped);
    /// The view is drawn or dropped.
    void end_work(const View& view);
    static void forget(Lane& lane, CameraId camera);
    void hand_out(Lane& lane, TimeNs monotonic_ns);
    void post_views(Lane& lane, int cost_class, TimeNs monotonic_ns);
    void post_request(Lane& lane);
    void hear_of(Lane& lane, int cost_class, DrawnViews& drawn);
    void spend(Lane& lane, int one_class, TimeNs wall_ns);

    std::vector<Lane> lanes_;
    const std::shared_ptr<DrawnTasks> finished_;
    const Callbacks callbacks_;
    const std::shared_ptr<StageTimer> timer_ = std::make_shared<StageTimer>();  ///< lanes write to it
    std::map<CameraId, Camera> cameras_;
    std::map<PartyName, Party> parties_;
    std::size_t views_at_work_ = 0;
};

}  // namespace camrig

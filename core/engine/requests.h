#pragma once

#include <list>
#include <memory>

#include "core/engine/camera_desk.h"
#include "core/engine/rig_state.h"

namespace camrig::engine {

/// Answers requests for single pictures and truth: of a camera's latest due frame, drawn now from the snapshot of its
/// instant if that was not done already. Drawing for requests is a class of its own in DrawQueue. Engine's thread.
class Requests {
public:
    Requests(RigState& rig, CameraDesk& cameras) : rig_(rig), cameras_(cameras) {}
    /// Fails all requests that still wait.
    ~Requests();

    void fetch(stream::FetchRequest request, std::function<void(Result<stream::MediaUnit>)> done);
    void get_truth(Request<GetTruth>& request);

    /// Answers all whose picture is drawn or cannot come, and asks the DrawDesk for a turn if others need drawing.
    void turn(TimeNs monotonic_ns);
    /// The drawing of the next request that needs it (DrawDesk::Callbacks::next_request).
    std::optional<DrawTask> next();
    /// A camera's colour pictures were drawn for its readers: answers requests that wait for them.
    void colors_drawn(const CameraEntry& entry, std::span<const frame::FrameRef> frames);
    /// Adds the pixel formats in which requests wait for a camera's picture of this instant (LocalFrameBus::wanted).
    void add_awaited(const CameraEntry& entry, TimeNs world_ns, frame::PixelFormats& formats) const;
    /// When turn() has to be called next, if nothing else happens (CLOCK_MONOTONIC).
    TimeNs wake_time_ns() const;
    const stream::StageTimer& truth_time() const { return truth_time_; }

private:
    /// Somebody who waits for a camera's frame of min_ns or later, or for its turn to have it drawn.
    struct Waiter {
        CameraId camera{};
        std::string name;
        TimeNs min_ns = 0;
        stream::FetchRequest picture;                                ///< what is asked for, unless it is truth
        std::optional<truth::GroundGrid> ground = {};                ///< beside truth
        std::function<void(Result<stream::MediaUnit>)> got_picture;  ///< one of the two
        std::function<void(Result<truth::TruthRef>)> got_truth;
        TimeNs timeout_ns = 0, deadline_ns = 0;

        /// Whether it wants the colour picture of the camera's latest frame, which readers may want too.
        bool wants_color() const { return draws_color() && !picture.instant; }
        bool draws_color() const { return got_picture && picture.kind == frame::FrameKind::color; }
        /// The instant of the wanted picture; null: that of the camera's latest frame.
        const HeldInstant* instant() const { return static_cast<const HeldInstant*>(picture.instant.get()); }
        void fail(const Error& why) const;
    };
    using Waiters = std::list<Waiter>;

    void wait(Waiter waiter);
    /// Whether it was answered.
    bool answer(const Waiter& waiter, TimeNs monotonic_ns) const;
    bool is_there(const Waiter& waiter, const CameraEntry& entry) const {
        if (waiter.instant()) return true;
        return (waiter.wants_color() ? entry.latest.delivered() : entry.latest).state.world_ns >= waiter.min_ns;
    }
    bool is_to_be_drawn(const Waiter& waiter, const CameraEntry& entry) const;
    /// A picture that was drawn already and does for this format; nullptr: none.
    const frame::FrameRef* drawn_color(const CameraEntry& entry, std::span<const frame::FrameRef> frames,
                                       const stream::MediaFormat& format) const;
    /// Answers with a picture that was drawn already, if it is admitted.
    void give_drawn(const Waiter& waiter, const frame::FrameRef& drawn) const;
    DrawTask draw_picture(Waiters::iterator waiter, DueViews due);
    DrawTask draw_truth(Waiters::iterator waiter, const CameraEntry& entry, DueViews due);
    void end_drawing(Waiters::iterator waiter, TimeNs spent_ns);
    /// Where requests share the lane of running cameras: when the next may be drawn. At once when it will be done
    /// before a reader's picture is due, else when readers have had their share of the time.
    TimeNs next_turn_ns(TimeNs monotonic_ns) const;

    RigState& rig_;
    CameraDesk& cameras_;
    Waiters waiting_, drawing_;
    bool is_ready_ = false;           ///< a request could be drawn now and waits for the lane only
    bool is_offered_ = false;         ///< and the lane has been told
    TimeNs cost_ns_ = 8 * ns_per_ms;  ///< what a request took lately, on average
    TimeNs turn_ns_ = 0;              ///< time of the last turn()
    TimeNs from_ns_ = 0;              ///< until then the lane is for readers' frames (CLOCK_MONOTONIC)
    stream::StageTimer truth_time_;
};

}  // namespace camrig::engine

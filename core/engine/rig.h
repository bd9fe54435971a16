#pragma once

#include <deque>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <span>

#include "core/base/thread_check.h"
#include "core/engine/camera_table.h"
#include "core/engine/command.h"
#include "core/engine/engine.h"
#include "core/engine/schedule.h"
#include "core/engine/world_clock.h"
#include "core/render/renderer.h"
#include "core/stream/local_frame_bus.h"
#include "core/world/world.h"

namespace camrig {

/// World, cameras, schedule and renderer put together: what happens at an instant, and what each command does.
///
/// Thread: the engine's, for every call. Time enters as an argument or from the one monotonic clock; `wake` may be
/// called from other threads when a delivery has completed, and asks for another tick().
class Rig {
public:
    static Result<std::unique_ptr<Rig>> create(SceneRef scene, const EngineOptions& options,
                                               std::unique_ptr<Renderer> renderer, LocalFrameBus& bus,
                                               std::function<void()> wake);
    ~Rig();

    void apply(Command& command);
    void fetch(FetchRequest request, std::function<void(Result<MediaUnit>)> done);

    /// One turn of what is due at monotonic_ns: some ms of the world's steps or some views of one instant, and then at
    /// most one picture on request.
    void tick(TimeNs monotonic_ns);
    /// When tick() has to be called next, if nothing else happens (CLOCK_MONOTONIC).
    TimeNs wake_time_ns() const;

private:
    /// Somebody who waits for a camera's frame of min_ns or later, or for its turn to have it drawn.
    struct Waiter {
        std::string camera;
        TimeNs min_ns = 0;
        std::optional<MediaFormat> color;  ///< what its picture is for; none: something that is always drawn for it
        std::function<void(Result<CameraEntry*>)> done;
        TimeNs deadline_ns = 0;
    };
    struct StepJob {
        TimeNs target_ns = 0;
        TimeNs timeout_ns = 0;
        TimeNs deadline_ns = 0;                ///< for the delivery in progress
        std::shared_ptr<DeliveryLatch> latch;  ///< of the instant published last
        std::optional<FrameSet> ready;         ///< drawn, to be published when the latch is open
        std::function<void(Result<WorldState>)> done;
    };

    /// An instant while it is drawn, in turns of some views: what was drawn goes out and is encoded while the rest is
    /// drawn, and commands need not wait for all of it.
    struct Drawing {
        SnapshotRef snapshot;
        TimeNs monotonic_ns = 0;
        std::vector<View> views;
        std::size_t drawn = 0;  ///< views
        bool is_late = false;   ///< it began long after it was due
        bool is_done() const { return drawn == views.size(); }
    };

    Rig(const EngineOptions& options, std::unique_ptr<Renderer> renderer, LocalFrameBus& bus,
        std::function<void()> wake);

    // Instants (rig.cpp).
    void run_realtime(TimeNs monotonic_ns);
    void advance_step(TimeNs monotonic_ns);
    /// The world's steps up to `world_ns`, for some ms at most. False: it is not there yet and needs more turns,
    /// between which commands are served.
    bool advance_world(TimeNs world_ns);
    /// The world, which is there, at this instant, and what is to be drawn of it.
    Drawing begin_instant(TimeNs world_ns, TimeNs monotonic_ns);
    /// The next views of it, and what became of them in the books.
    FrameSet draw_some(Drawing& drawing, std::size_t count);
    /// Draws and publishes the views of one turn.
    void draw_turn();
    /// The instant in turns is drawn to its end now.
    void finish_turns();
    void account_skipped(TimeNs instant_ns);
    /// Where the camera is in this snapshot. Without its actor a mounted camera stays where it was.
    static Pose pose_at(CameraEntry& entry, const Snapshot& snapshot);
    View view_of(const CameraEntry& entry, const LatestDue& latest) const;
    void publish(const FrameSet& set, const std::shared_ptr<DeliveryLatch>& latch);
    FrameSet draw(const SnapshotRef& snapshot, TimeNs monotonic_ns, std::span<const View> views);
    /// World time now, but never past an instant that is still to be drawn, nor far from where the world's steps are:
    /// commands never wait for a world that has much to catch up.
    TimeNs world_now_ns(TimeNs monotonic_ns) const;
    void note_failure(const CameraEntry& entry, const Error& why);

    // Pictures and truth on request (rig_fetch.cpp).
    void wait_for_frame(Waiter waiter);
    void answer(CameraEntry& entry, const FetchRequest& request, std::function<void(Result<MediaUnit>)> done);
    void get_truth(Request<GetTruth>& request);
    Result<TruthRef> truth_of(CameraEntry& entry);
    /// Answers all whose picture is drawn or cannot come, and has at most one drawn.
    void answer_waiting(TimeNs monotonic_ns);
    /// When the next picture on request may be drawn: at once when it will be done before a reader's picture is due,
    /// else when readers have had their share of the time.
    TimeNs next_request_ns(TimeNs monotonic_ns) const;
    /// A picture that was drawn already and does for this format; nullptr: none.
    const FrameRef* drawn_color(const CameraEntry& entry, const MediaFormat& format) const;
    bool is_to_be_drawn(const Waiter& waiter, const CameraEntry& entry) const {
        return !waiter.color || !drawn_color(entry, *waiter.color);
    }
    /// Adds what waiters for pictures of this instant want (LocalFrameBus::wanted).
    void add_awaited(const CameraEntry& entry, TimeNs world_ns, PixelFormats& formats) const;
    /// `wanted`, with rgba8 in place of those that the renderer does not make of this view.
    PixelFormats made_of(const View& view, PixelFormats wanted) const;

    // Commands (rig_commands.cpp).
    Result<CameraState> run(CreateCamera& command);
    Result<CameraState> run(SetCamera& command);
    Result<Applied> run(DeleteCamera& command);
    Result<CameraState> run(GetCamera& command);
    Result<std::vector<CameraState>> run(ListCameras& command);
    Result<WorldState> run(LoadWorld& command);
    Result<WorldState> run(GetWorld& command);
    Result<WorldState> run(PauseWorld& command);
    Result<WorldState> run(ResumeWorld& command);
    Result<RigReport> run(GetStats& command);
    // Actors and events (rig_world.cpp).
    Result<ActorList> run(ListActors& command);
    Result<ActorChange> run(SpawnActor& command);
    Result<Applied> run(RemoveActor& command);
    Result<ActorChange> run(SetActor& command);
    Result<Applied> run(SteerActors& command);
    Result<std::vector<EventReport>> run(ListEvents& command);
    Result<EventChange> run(AddEvent& command);
    Result<Applied> run(RemoveEvent& command);
    void wait_events(Request<WaitEvents>& request);
    EventLog events_since(std::uint64_t since) const;
    void answer_waits(TimeNs monotonic_ns);
    /// The world as of now; commands act on it.
    World& world_of_now();
    /// Takes what has happened in the world since the last call.
    void collect_world();
    /// Events may move cameras: those moved until `world_ns` are there.
    void move_cameras(TimeNs world_ns);
    void start_step(Request<StepWorld>& request);
    Result<void> load(SceneRef scene);
    Result<CameraEntry*> add_camera(CameraSpec spec);
    /// A camera that is in the table takes part from now on.
    void start_camera(CameraEntry& entry);
    /// What a camera is to be mounted on is there.
    Result<void> check_mount(const CameraPatch& patch);
    /// Every output is of a kind somebody serves, and no number is taken twice.
    Result<void> check_outputs(const CameraSpec& spec);
    /// Those that `present` has not: can they be served on this machine?
    Result<void> check_new_outputs(const CameraSpec& spec, const std::vector<OutputSpec>& present);
    /// The camera's newest picture shows the world of now with its present spec.
    void renew_latest(CameraEntry& entry, std::int64_t sequence);
    /// Draws the camera's newest picture and, when somebody reads it, sends it out.
    void show_latest(CameraEntry& entry);
    CameraState state_of(const CameraEntry& entry) const;
    WorldState world_state() const;

    ThreadCheck thread_;
    const EngineOptions options_;
    LocalFrameBus& bus_;
    const std::function<void()> wake_;
    std::unique_ptr<Renderer> renderer_;
    std::unique_ptr<World> world_;
    SceneRef scene_;
    std::uint64_t seed_ = 0;
    CameraTable cameras_;
    Schedule schedule_;
    WorldClock clock_;
    /// In real time: so late the instant that is due next was when it was chosen; none is chosen before the world has
    /// come to it.
    std::optional<TimeNs> chosen_late_ns_;
    std::optional<Drawing> drawing_;  ///< in real time; a step draws its instants whole
    bool is_world_behind_ = false;    ///< its steps go on at once
    TimeNs world_spent_ns_ = 0;       ///< on steps towards the instant due next
    TimeNs view_cost_ns_;             ///< what a view took lately, on average
    TimeNs request_cost_ns_;          ///< what a picture on request took lately, on average
    TimeNs requests_from_ns_ = 0;     ///< until then the time is the readers' (CLOCK_MONOTONIC)
    bool is_request_ready_ = false;   ///< somebody who waits needs but his turn
    std::deque<StepJob> steps_;
    std::list<Waiter> waiting_;
    struct PendingWait {
        std::uint64_t since = 0;
        TimeNs deadline_ns = 0;
        std::function<void(Result<EventLog>)> done;
    };
    std::list<PendingWait> waits_;
    std::deque<EventRecord> event_log_;  ///< the newest, in order
    std::uint64_t last_event_ = 0;
    std::uint64_t event_base_ = 0;          ///< events of the worlds before this one
    std::vector<CameraMove> camera_moves_;  ///< still to come

    std::uint64_t instants_ = 0;
    std::uint64_t dropped_instants_ = 0;
    StageTimer wakeup_, world_time_, submit_, collect_, publish_, truth_;
    TimeNs last_failure_log_ns_ = 0;
};

}  // namespace camrig

#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "core/engine/agenda.h"
#include "core/engine/camera_table.h"
#include "core/engine/draw_desk.h"
#include "core/engine/engine.h"
#include "core/engine/schedule.h"
#include "core/engine/world_clock.h"
#include "core/world/world.h"

namespace camrig::engine {

/// What all parts of a rig work on. Engine's thread.
struct RigState {
    RigState(const EngineOptions& rig_options, stream::LocalFrameBus& frame_bus, std::function<void()> wake_up)
        : options(rig_options), bus(frame_bus), wake(std::move(wake_up)) {}

    const EngineOptions options;
    stream::LocalFrameBus& bus;
    const std::function<void()> wake;  ///< asks for another Rig::tick(); any thread
    std::unique_ptr<world::World> world;
    world::SceneRef scene;
    std::uint64_t seed = 0;
    CameraTable cameras;
    std::vector<world::CameraMove> camera_moves;  ///< of events, still to come
    Schedule schedule;
    WorldClock clock;
    /// Lockstep: the instant drawn ahead while the previous one is delivered; the world has already advanced to it.
    std::optional<TimeNs> step_instant_ns;
    std::unique_ptr<DrawDesk> drawing;
    Agenda agenda;
    /// The time of the command that is being done, of one that says it.
    std::optional<TimeNs> command_ns;
    /// Frames due until then that were not begun were so because the world was held.
    TimeNs held_until_ns = -1;
    /// The latest time at which something was done that a command of an earlier time would have had to come before.
    TimeNs done_ns = 0;

    /// World time now, but never past an instant that is still to begin, nor far from where the world's steps are:
    /// commands never wait for a world that has much to catch up.
    TimeNs world_now_ns(TimeNs monotonic_ns) const;
    /// What a camera with a sensor may have to look back at now; null: there is none. The same for all of one instant.
    std::shared_ptr<const world::WorldPast> world_past(TimeNs now_ns) const;
    /// CameraTable::show, with the past.
    void show(CameraEntry& entry, std::int64_t sequence, const world::SnapshotRef& snapshot, TimeNs monotonic_ns,
              const std::shared_ptr<const world::WorldPast>& past);
    render::View view_of(const CameraEntry& entry, const LatestDue& latest) const;
    /// The picture before it, of one that is torn; null: it is not.
    std::shared_ptr<const render::EarlierPicture> torn_with(const CameraEntry& entry, const LatestDue& latest) const;
    /// The view with what comes until the camera's next frame, for optical flow. unavailable: other things have come
    /// since, and are not kept.
    Result<void> look_ahead(const CameraEntry& entry, const LatestDue& latest, render::View& view) const;
    /// The colour picture of the camera's latest frame that comes: its own, or one that it shows again.
    DueViews picture_of(const CameraEntry& entry) const;
    /// Makes the view one of what readers want: colour in these formats, numbers of its sensor, or both.
    void ask_for(render::View& view, frame::PixelFormats wanted) const;
    /// Of the colour formats those, with rgba8 in place of what the renderer does not make of this view.
    frame::PixelFormats made_of(const render::View& view, frame::PixelFormats wanted) const;
    /// Sends frames to who reads them.
    void publish(const frame::FrameSet& set, const std::shared_ptr<stream::DeliveryLatch>& latch);
    /// Logs why a picture could not be drawn, once a second at most.
    void note_failure(const std::string& camera, const Error& why);

    stream::StageTimer publish_time;
    TimeNs last_failure_log_ns = 0;
};

/// With no camera due, the world still keeps up this often, so that it never has to catch up much at once.
inline constexpr TimeNs idle_tick_ns = 100 * ns_per_ms;

}  // namespace camrig::engine

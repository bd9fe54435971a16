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

/// The state that all desks of a rig share. Engine's thread.
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
    std::vector<world::CameraMove> camera_moves;  ///< changes of cameras by events, not carried out yet
    Schedule schedule;
    WorldClock clock;
    /// Lockstep: the instant drawn ahead while the previous one is delivered; the world has already advanced to it.
    std::optional<TimeNs> step_instant_ns;
    std::unique_ptr<DrawDesk> drawing;
    Agenda agenda;
    /// World time of the command that is being carried out, if it was given one (Request::at_ns).
    std::optional<TimeNs> command_ns;
    /// World time up to which frames that were not begun count as dropped for `held` (SetLimit).
    TimeNs held_until_ns = -1;
    /// World time of the latest instant or command: later commands with an earlier at_ns are refused.
    TimeNs done_ns = 0;

    /// World time now, but never past an instant that has not begun yet, nor far from the world's last step: commands
    /// do not wait for a world that has much to catch up.
    TimeNs world_now_ns(TimeNs monotonic_ns) const;
    /// The recent past that exposures of cameras with a sensor may need at now_ns; null: no camera has a sensor. One
    /// for all cameras of an instant.
    std::shared_ptr<const world::WorldPast> world_past(TimeNs now_ns) const;
    /// CameraTable::show, and keeps the past for a camera with a sensor.
    void show(CameraEntry& entry, std::int64_t sequence, const world::SnapshotRef& snapshot, TimeNs monotonic_ns,
              const std::shared_ptr<const world::WorldPast>& past);
    /// The view to draw for this frame; ask_for() says what of it.
    render::View view_of(const CameraEntry& entry, const LatestDue& latest) const;
    /// The earlier frame to draw for the other part of a torn picture; null: the picture is not torn.
    std::shared_ptr<const render::EarlierPicture> torn_with(const CameraEntry& entry, const LatestDue& latest) const;
    /// Adds to the view the motion until the camera's next frame, for optical flow. unavailable: the world has moved on
    /// and no longer keeps that time.
    Result<void> look_ahead(const CameraEntry& entry, const LatestDue& latest, render::View& view) const;
    /// The colour picture of the camera's latest frame as it is delivered: its own, or one that a fault repeats.
    DueViews picture_of(const CameraEntry& entry) const;
    /// Makes the view one of what readers want: colour in these formats, raw sensor data, or both.
    void ask_for(render::View& view, frame::PixelFormats wanted) const;
    /// The colour formats of `wanted`, with rgba8 in place of those that the renderer cannot make of this view.
    frame::PixelFormats made_of(const render::View& view, frame::PixelFormats wanted) const;
    /// Publishes frames to the bus.
    void publish(const frame::FrameSet& set, const std::shared_ptr<stream::DeliveryLatch>& latch);
    /// Logs why a picture could not be drawn, once a second at most.
    void note_failure(const std::string& camera, const Error& why);

    stream::StageTimer publish_time;
    TimeNs last_failure_log_ns = 0;
};

/// With no camera due, the world still keeps up this often, so that it never has to catch up much at once.
inline constexpr TimeNs idle_tick_ns = 100 * ns_per_ms;

}  // namespace camrig::engine

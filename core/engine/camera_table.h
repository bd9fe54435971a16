#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/engine/command.h"
#include "core/frame/frame.h"
#include "core/render/renderer.h"
#include "core/sensor/camera_sensor.h"
#include "core/stream/frame_bus.h"
#include "core/stream/statistics.h"
#include "core/truth/make_truth.h"
#include "core/world/camera.h"
#include "core/world/camera_past.h"

namespace camrig::engine {

/// A camera's latest due frame: drawn already, or drawable at any time from the snapshot of its instant.
struct LatestDue {
    std::shared_ptr<const world::CameraSpec> spec;  ///< as it was at that instant, with the intrinsics of it
    std::uint64_t spec_revision = 0;
    std::uint64_t source_revision = 0;  ///< of the camera's spec that `spec` derives from
    std::int64_t sequence = -1;
    camera::CameraState state;  ///< at that instant
    TimeNs monotonic_ns = 0;
    world::SnapshotRef snapshot;
    std::shared_ptr<const world::CameraPast> past;    ///< of a camera with a sensor
    std::vector<frame::FrameRef> colors;              ///< as published, one per pixel format; empty until then
    fault::FrameFaultsRef faults;                     ///< what fails at that instant; null: nothing
    std::shared_ptr<const LatestDue> torn_with = {};  ///< of a torn picture: the frame with its other part
    /// If a fault drops this frame or freezes its picture: the earlier frame whose picture is still shown.
    std::shared_ptr<LatestDue> shown = {};

    bool is_dropped() const { return faults && faults->is_dropped; }
    /// The frame that requests for a picture are answered with: this, or if it is dropped, the one before.
    const LatestDue& delivered() const { return is_dropped() && shown ? *shown : *this; }
    /// The frame whose picture is shown at present.
    const LatestDue& seen() const { return shown ? *shown : *this; }
};

/// A camera as the engine holds it.
struct CameraEntry {
    CameraId id{};
    std::uint8_t number = 0;  ///< what the code strip carries; free again when the camera is deleted
    std::shared_ptr<const std::string> name;
    world::Camera camera;
    std::uint64_t spec_revision = 0;
    std::pair<std::uint64_t, std::uint64_t> spec_digest = {};  ///< (revision, digest), made when it is asked for
    LatestDue latest;
    /// Cache for ground truth. Its contents are for the lane that draws the camera only.
    std::shared_ptr<truth::StandingObjects> standing = std::make_shared<truth::StandingObjects>();
    /// State of its sensor from frame to frame; shared with the lane that draws the camera.
    std::shared_ptr<sensor::CameraSensor> sensor = std::make_shared<sensor::CameraSensor>();

    const world::CameraSpec& spec() const { return *camera.spec(); }
    camera::ExposureTimes exposure_times() const { return world::exposure_times_of(spec()); }
    TimeNs applied_ns = 0;  ///< world time from which its last command shows
    std::uint64_t due = 0, rendered = 0, idle = 0;
    std::array<std::uint64_t, stream::drop_reason_count> dropped{};  ///< by DropReason
    /// World times of the newest wanted frames that were not drawn, and why; at most max_not_drawn.
    std::deque<std::pair<TimeNs, stream::DropReason>> not_drawn = {};
    static constexpr std::size_t max_not_drawn = 64;
    /// Sequence of the last frame whose pixels a fault changed after they were drawn. FrameInfo::damage of a later
    /// frame must not refer to it or to an earlier one.
    std::int64_t altered_sequence = -1;
    fault::Standing failing = {};  ///< what fails for programs that open its outputs, as of its newest picture
    /// The fault that keeps its user-space devices unplugged; nullopt: they are there.
    std::optional<fault::Unplug> unplugged = {};
};

/// The format of the raw sensor data that it offers beside pictures; nullopt: it has no sensor.
std::optional<stream::SensorNumbers> numbers_of(const world::CameraSpec& spec);
/// The camera as subscribers of the frame bus see it: without devices that are unplugged.
stream::CameraStream stream_of(const CameraEntry& entry);

/// The cameras of the rig by name, with the limits on their number and size. Thread: the engine's.
class CameraTable {
public:
    /// Adds a camera; already_exists, invalid name and resource_exhausted are errors and change nothing.
    Result<CameraEntry*> add(world::CameraSpec spec);
    /// Replaces the camera's spec and motion; name, id and sequence numbers stay. An error changes nothing.
    Result<void> replace(CameraEntry& entry, world::Camera camera);
    /// Makes the frame of this instant the camera's latest.
    void show(CameraEntry& entry, std::int64_t sequence, world::SnapshotRef snapshot, TimeNs monotonic_ns);
    /// The frame that the camera would have at an instant that a client holds. It does not become its latest. Faults
    /// that change pixels act as on its latest frame; those of sending do not.
    LatestDue at_instant(const CameraEntry& entry, const HeldInstant& instant);
    /// Keeps colour pictures of a view that have been published, to answer requests with and for faults that repeat.
    void keep_colors(CameraEntry& entry, const render::View& view, std::span<const frame::FrameRef> frames);
    /// Gives the camera a fault. Errors as of FaultPlan::set(), and change nothing.
    Result<fault::FaultRef> set_fault(CameraEntry& entry, const fault::FaultSpec& spec, std::uint64_t rig_seed,
                                      TimeNs now_ns);
    /// Updates `failing` and `unplugged` to the newest picture. True: they changed, and outputs have to be told.
    bool follow_outputs(CameraEntry& entry, TimeNs world_ns);
    /// Fails if another camera has an output that a rig can have only once (a device number).
    Result<void> check_free(const world::CameraSpec& spec) const;
    Result<CameraEntry*> find(const std::string& name);
    /// Null if it is gone.
    CameraEntry* find_id(CameraId id);
    CameraEntry& at(CameraId id);
    /// Removes and returns it.
    Result<CameraEntry> remove(const std::string& name);

    std::size_t size() const { return by_id_.size(); }
    /// In the order they were made.
    std::map<CameraId, CameraEntry>& all() { return by_id_; }
    const std::map<CameraId, CameraEntry>& all() const { return by_id_; }

private:
    /// Updates `unplugged`. True: it changed.
    bool follow_plug(CameraEntry& entry, TimeNs world_ns);
    Result<void> check_pixels(std::int64_t added) const;

    std::map<CameraId, CameraEntry> by_id_;
    std::uint32_t last_id_ = 0;
    std::uint64_t last_revision_ = 0;
    std::uint64_t last_fault_ = 0;
};

}  // namespace camrig::engine

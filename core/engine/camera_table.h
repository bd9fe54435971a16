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

/// The latest picture a camera should have made: drawn already, or drawable at any time from the snapshot of its
/// instant.
struct LatestDue {
    std::shared_ptr<const world::CameraSpec> spec;  ///< as it was at that instant, with the intrinsics of it
    std::uint64_t spec_revision = 0;
    std::uint64_t source_revision = 0;  ///< of the camera's spec that `spec` derives from
    std::int64_t sequence = -1;
    camera::CameraState state;  ///< at that instant
    TimeNs monotonic_ns = 0;
    world::SnapshotRef snapshot;
    std::shared_ptr<const world::CameraPast> past;    ///< of a camera with a sensor
    std::vector<frame::FrameRef> colors;              ///< as they went out, a pixel format each; none until then
    fault::FrameFaultsRef faults;                     ///< what fails at that instant; null: nothing
    std::shared_ptr<const LatestDue> torn_with = {};  ///< of a torn picture: the one before it
    /// Of a frame that does not come, or shows the picture before it again: the frame with that picture.
    std::shared_ptr<LatestDue> shown = {};

    bool is_dropped() const { return faults && faults->is_dropped; }
    /// The frame that requests for a picture are answered with.
    const LatestDue& delivered() const { return is_dropped() && shown ? *shown : *this; }
    /// The frame whose picture was last to be seen.
    const LatestDue& seen() const { return shown ? *shown : *this; }
};

/// A camera as the engine holds it.
struct CameraEntry {
    CameraId id{};
    std::uint8_t number = 0;  ///< what the code strip carries; free again when the camera is deleted
    std::shared_ptr<const std::string> name;
    world::Camera camera;
    std::uint64_t spec_revision = 0;
    std::pair<std::uint64_t, std::uint64_t> spec_digest = {};  ///< of this revision, made when it is asked for
    LatestDue latest;
    /// For its truths. What is in it belongs to the lane that draws.
    std::shared_ptr<truth::StandingObjects> standing = std::make_shared<truth::StandingObjects>();

    std::shared_ptr<sensor::CameraSensor> sensor = std::make_shared<sensor::CameraSensor>();

    const world::CameraSpec& spec() const { return *camera.spec(); }
    camera::ExposureTimes exposure_times() const { return world::exposure_times_of(spec()); }
    TimeNs applied_ns = 0;  ///< world time from which its last command shows
    std::uint64_t due = 0, rendered = 0, idle = 0;
    std::array<std::uint64_t, stream::drop_reason_count> dropped{};  ///< by DropReason
    /// Of the newest frames that were not drawn though somebody wanted them, at most max_not_drawn.
    std::deque<std::pair<TimeNs, stream::DropReason>> not_drawn = {};
    static constexpr std::size_t max_not_drawn = 64;
    /// Of the last frame whose picture went out otherwise than it was drawn: no later one may be told by what is
    /// damaged since.
    std::int64_t altered_sequence = -1;
    fault::Standing failing = {};  ///< what fails for those who come, as of its newest picture
    /// Its user-space devices are unplugged, by this fault.
    std::optional<fault::Unplug> unplugged = {};
};

/// What its sensor gives beside the picture; nullopt: it has none.
std::optional<stream::SensorNumbers> numbers_of(const world::CameraSpec& spec);
/// As readers of the bus know it: without devices that are unplugged.
stream::CameraStream stream_of(const CameraEntry& entry);

/// The cameras of the rig by name, with the limits on their number and size. Thread: the engine's.
class CameraTable {
public:
    static constexpr std::size_t max_cameras = 256;
    /// All cameras together; at 8 bytes per pixel on the device and 4 in each frame this is about 2 GiB. A GPU that
    /// converts colours gives a frame for each pixel format that readers take, 1.5 bytes a pixel for most.
    static constexpr std::int64_t max_total_pixels = std::int64_t{160} << 20;

    /// Adds a camera; already_exists, invalid name and resource_exhausted are errors and change nothing.
    Result<CameraEntry*> add(world::CameraSpec spec);
    /// Makes it another camera of the same name.
    Result<void> replace(CameraEntry& entry, world::Camera camera);
    /// Makes this instant's the camera's latest frame.
    void show(CameraEntry& entry, std::int64_t sequence, world::SnapshotRef snapshot, TimeNs monotonic_ns);
    /// What the camera would show at an instant that somebody holds. Its pictures are not the camera's: nothing is
    /// kept. Faults that change pixels act as on its latest frame; those of sending do not.
    LatestDue at_instant(const CameraEntry& entry, const HeldInstant& instant);
    /// Takes note of colour pictures of a view that have gone out.
    void keep_colors(CameraEntry& entry, const render::View& view, std::span<const frame::FrameRef> frames);
    /// Gives the camera a fault. Errors as of FaultPlan::set(), and change nothing.
    Result<fault::FaultRef> set_fault(CameraEntry& entry, const fault::FaultSpec& spec, std::uint64_t rig_seed,
                                      TimeNs now_ns);
    /// Takes note of what fails at its newest picture of its outputs themselves. True: they have to be told.
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
    /// True: its devices go, or come back.
    bool follow_plug(CameraEntry& entry, TimeNs world_ns);
    Result<void> check_pixels(std::int64_t added) const;

    std::map<CameraId, CameraEntry> by_id_;
    std::uint32_t last_id_ = 0;
    std::uint64_t last_revision_ = 0;
    std::uint64_t last_fault_ = 0;
};

}  // namespace camrig::engine

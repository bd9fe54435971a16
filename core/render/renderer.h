#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/camera/ptz_status.h"
#include "core/fault/fault_plan.h"
#include "core/frame/frame.h"
#include "core/frame/silhouette.h"
#include "core/sensor/camera_sensor.h"
#include "core/world/backdrop/film_player.h"
#include "core/world/camera_future.h"
#include "core/world/camera_past.h"
#include "core/world/camera_spec.h"
#include "core/world/snapshot.h"

namespace camrig::render {

struct EarlierPicture;

/// What becomes of a colour picture when it is there, of a camera that fails. Renderers do not ask for it.
struct FailingPicture {
    fault::FrameFaultsRef faults;                  ///< what they do to its pixels; null: nothing
    std::optional<fault::FrameKey> shown_as = {};  ///< the frame that shows it again; nullopt: it is of its own frame
    std::vector<frame::FrameRef> kept = {};        ///< of a picture shown again: as it was, drawn or not
    std::shared_ptr<const world::CameraPast> shown_past = {};  ///< of shown_as, where the camera has a sensor
    std::shared_ptr<const EarlierPicture> torn_with = {};      ///< what the lower part of it is of; null: of its own
};

/// One picture to draw: a camera at an instant.
struct View {
    CameraId camera{};
    std::shared_ptr<const std::string> name;
    std::shared_ptr<const world::CameraSpec> spec;
    std::uint64_t spec_revision = 0;  ///< changes whenever spec does; with the camera id the key of per-camera caches
    camera::Pose pose;  ///< world_from_link at this instant (a mounted camera moves without a new revision)
    std::optional<camera::Pose> believed_pose;      ///< as CameraState has it, for ground truth
    std::optional<camera::PtzStatus> head;          ///< what it says of itself goes with the pose, for ground truth
    std::optional<ClockReading> clock;              ///< goes with the frame
    fault::FrameFaultsRef faults;                   ///< the same; null: none
    std::shared_ptr<const FailingPicture> failing;  ///< null: the picture goes out as it is drawn
    /// Of a camera with a sensor: what it knows from picture to picture; null: this picture stands alone.
    std::shared_ptr<sensor::CameraSensor> sensor;
    /// Of the same: what it saw until the instant; null: nothing moved.
    std::shared_ptr<const world::CameraPast> past;
    world::Quality quality = world::Quality::simple;
    std::int64_t sequence = 0;
    std::uint32_t camera_number = 0;           ///< what the code strip carries
    std::optional<world::FilmShot> film = {};  ///< of a camera with a film: what of it shows; nullopt: that of its time
    /// Where flow is wanted: what comes until the camera's next frame, which is so much later.
    std::shared_ptr<world::CameraFuture> future = {};
    TimeNs frame_ns = 0;
    bool kinds[frame::frame_kind_count] = {true};  ///< which FrameKinds are wanted; colour
    /// The pixel formats that colour is wanted in, if it is; only those that the renderer makes().
    frame::PixelFormats color_formats = {frame::PixelFormat::rgba8};
    /// Not empty: instance, semantic and normal pictures show these objects alone. Ground truth asks what an object
    /// would show if nothing stood in front of it.
    std::vector<ObjectId> only_objects;
};

/// A picture that is due no more.
struct EarlierPicture {
    View view;
    world::SnapshotRef snapshot;
    TimeNs monotonic_ns = 0;
};

/// What a renderer keeps between instants, and since the start how often what saves work did so.
struct RenderCounters {
    int layers = 0;                    ///< static layers that are kept
    std::int64_t layer_bytes = 0;      ///< their memory on the device
    std::int64_t draw_data_bytes = 0;  ///< memory for uniforms and deformed vertices
    std::uint64_t layers_drawn = 0;    ///< made
    std::uint64_t layers_reused = 0;   ///< copied instead of drawing
    std::uint64_t layers_stale = 0;    ///< thrown away because what they show changed
    std::uint64_t layers_evicted = 0;  ///< thrown away to make room
    std::uint64_t views = 0;           ///< pictures drawn, of any kind
    std::uint64_t views_in_parts = 0;  ///< those drawn only where something may move
    std::uint64_t meshes_skinned = 0;  ///< skinned or morphed meshes of movers, once per instant for all cameras
    std::uint64_t meshes_unseen = 0;   ///< those that no camera saw, and that were not made
    std::uint64_t draws = 0;           ///< surfaces
    std::uint64_t draw_calls = 0;      ///< of OpenGL for them, of one or more surfaces each
    std::uint64_t draws_coarse = 0;    ///< those with a coarser level of detail
    std::uint64_t conversions = 0;     ///< colour pictures that the device gave in another format than rgba8

    RenderCounters& operator+=(const RenderCounters& other);
};

/// Draws views of snapshots into frames.
///
/// Thread: every call comes from the same one, that created it. Several renderers may live on as many threads.
/// draw() gives one frame per view and wanted kind (of colour one per pixel format), in the order of the views. Frames
/// come from the pool given at creation. A view that fails (too large for the device) costs its frame, not the instant:
/// the error is in `failures`.
class Renderer {
public:
    struct Finished {
        frame::FrameSet set;
        struct Failure {
            CameraId camera{};
            Error error;
        };
        std::vector<Failure> failures;
        /// What each view took, in the order of the views: CPU time where the rasteriser is camrig's own, else its
        /// share of the time that passed, by samples. What all views of an instant share is nobody's.
        std::vector<TimeNs> cost_ns;
    };

    virtual ~Renderer() = default;
    virtual Result<Finished> draw(const world::SnapshotRef& snapshot, TimeNs monotonic_ns,
                                  std::span<const View> views) = 0;
    /// Which pixels each of these objects would show in the view's instance picture if nothing else were there, in
    /// their order. Nothing: this renderer can only draw them (View::only_objects).
    virtual std::optional<std::vector<frame::Silhouette>> silhouettes(const world::SnapshotRef& snapshot,
                                                                      const View& view,
                                                                      std::span<const ObjectId> objects) {
        (void)snapshot, (void)view, (void)objects;
        return std::nullopt;
    }
    /// Whether it gives colour pictures of this view in that format. rgba8 always; others are converted from it. Any
    /// thread.
    virtual bool makes(frame::PixelFormat format, const View& view) const {
        (void)view;
        return format == frame::PixelFormat::rgba8;
    }
    /// Whether the view's colour is drawn with what this renderer draws best; else it may have to set up something
    /// dear first (shadow maps, another renderer). Any thread.
    virtual bool is_plain(const View& view) const {
        (void)view;
        return true;
    }
    /// CPU time that a whole colour picture of the view may take, told from its pixels alone, for who must place it
    /// before one was drawn; 0: little, or not known. Any thread.
    virtual TimeNs expected_cost_ns(const View& view) const {
        (void)view;
        return 0;
    }
    /// Whether it draws on threads of the CPU, so that a second one beside it has its own time. Any thread.
    virtual bool is_on_cpu() const { return false; }
    /// Frees what was kept for a camera that is gone.
    virtual void forget(CameraId camera) = 0;
    /// Another renderer draws the camera from now on. What was kept for it is freed, or left for that one to take
    /// (SharedCaches).
    virtual void hand_over(CameraId camera) { forget(camera); }
    virtual RenderCounters counters() const { return {}; }
    /// "llvmpipe (LLVM 15.0.6, 256 bits), OpenGL 4.5, Mesa 22.3.6" for server.info and reports.
    virtual std::string description() const = 0;
};

}  // namespace camrig::render

#pragma once

#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "core/base/thread_check.h"
#include "core/render/software/software_drawer.h"

namespace camrig::render {

/// Pictures by camrig's own rasteriser and by a renderer of OpenGL, which share the views of an instant.
class ComposedRenderer final : public Renderer {
public:
    using MakeRenderer = std::function<Result<std::unique_ptr<Renderer>>()>;

    /// Of a machine without a GPU: our rasteriser draws what it can, another one, made when it is first needed, the
    /// rest: colour with several samples a pixel.
    ComposedRenderer(const software::SoftwareDrawer::Options& options, MakeRenderer make_other)
        : drawer_(options), make_other_(std::move(make_other)) {}
    /// Of a machine with one: the device draws, our rasteriser what OpenGL has no light, plates or motion for: cameras
    /// with a sensor or a backdrop, and optical flow.
    ComposedRenderer(const software::SoftwareDrawer::Options& options, std::unique_ptr<Renderer> device)
        : drawer_(options), is_first_(false), other_(std::move(device)) {}

    Result<Finished> draw(const world::SnapshotRef& snapshot, TimeNs monotonic_ns,
                          std::span<const View> views) override;
    std::optional<std::vector<frame::Silhouette>> silhouettes(const world::SnapshotRef& snapshot, const View& view,
                                                              std::span<const ObjectId> objects) override;
    bool is_plain(const View& view) const override;
    TimeNs expected_cost_ns(const View& view) const override;
    bool makes(frame::PixelFormat format, const View& view) const override;
    bool is_on_cpu() const override { return is_first_ || other_->is_on_cpu(); }
    void forget(CameraId camera) override;
    void hand_over(CameraId camera) override;
    RenderCounters counters() const override;
    std::string description() const override;

private:
    void begin_instant(const world::SnapshotRef& snapshot);
    Result<Finished> draw_all(const world::SnapshotRef& snapshot, TimeNs monotonic_ns, std::span<const View> views);
    Result<Finished> draw_rest(const world::SnapshotRef& snapshot, TimeNs monotonic_ns);

    /// Our rasteriser draws the camera no more; with the last one it lets go of the world that it drew.
    void forget_here(CameraId camera);
    void release(CameraId camera);
    /// Whether our rasteriser draws such a picture of the view, where it can.
    bool is_ours(const View& view, frame::FrameKind kind) const;
    bool is_ours(const View& view) const { return is_ours(view, frame::FrameKind::color); }

    software::SoftwareDrawer drawer_;
    std::map<CameraId, std::uint64_t> ours_;  ///< cameras that it has drawn, with the View::spec_revision
    bool is_first_ = true;                    ///< it draws whatever it can
    MakeRenderer make_other_;
    std::unique_ptr<Renderer> other_;
    std::optional<Error> other_failed_;  ///< why it could not be made
    // Of one call of draw(), kept for their memory.
    std::vector<const View*> here_;
    std::vector<View> parts_;                                ///< of views that both draw: what is drawn here
    std::vector<View> rest_;                                 ///< what the other renderer draws
    std::vector<std::size_t> places_here_, places_of_rest_;  ///< among all views
    ThreadCheck thread_;
};

}  // namespace camrig::render

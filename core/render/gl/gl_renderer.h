#pragma once

#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/thread_check.h"
#include "core/render/gl/color_converter.h"
#include "core/render/gl/egl_context.h"
#include "core/render/gl/view_painter.h"
#include "core/render/renderer_factory.h"
#include "core/render/shown_picture.h"

namespace camrig::render::gl {

/// The Renderer on OpenGL 4.5.
///
/// Models are uploaded when first seen, everything is posed once, then each view is culled and drawn into targets of
/// its own; nothing is read until every view is drawn.
class GlRenderer final : public Renderer {
public:
    static Result<std::unique_ptr<Renderer>> create(const RendererOptions& options);
    ~GlRenderer() override;

    Result<Finished> draw(const world::SnapshotRef& snapshot, TimeNs monotonic_ns,
                          std::span<const View> views) override;
    bool makes(frame::PixelFormat format, const View& view) const override;
    void forget(CameraId camera) override;
    RenderCounters counters() const override;
    std::string description() const override { return context_->description(); }

private:
    /// A picture that is drawn and not read yet.
    struct Pending {
        std::size_t view = 0;
        frame::FrameKind kind = frame::FrameKind::color;
        frame::PixelFormat format = frame::PixelFormat::rgba8;
        PictureSource source{};
        std::size_t buffer_offset = 0;
        ViewTransform transform;
        std::shared_ptr<const LensOnDevice> lens;  ///< null: none
        frame::Damage damage{};
    };
    GlRenderer(std::unique_ptr<EglContext> context, std::optional<ColorConverter> converter,
               const RendererOptions& options);
    Result<Finished> draw_views(const world::SnapshotRef& snapshot, TimeNs monotonic_ns, std::span<const View> views);
    /// Discards what a failed instant left half made, before the next one.
    void forget_instant();
    void begin_instant(const world::SnapshotRef& snapshot);
    Result<void> draw_view(const View& view, std::size_t index);
    /// Brings the pictures to the readback buffer.
    Result<void> read_back(std::span<const View> views);
    frame::FrameRef finish(const View& view, const Pending& pending, TimeNs monotonic_ns);

    std::unique_ptr<EglContext> context_;
    const GlFunctions& gl_;
    std::shared_ptr<frame::FramePool> pool_;
    std::optional<ColorConverter> converter_;  ///< none: colours are converted on the host
    std::uint64_t conversions_ = 0;
    ReadbackMode readback_mode_;
    ShaderCache shaders_;
    SamplerCache samplers_;
    ViewPainter painter_;
    GpuScene scene_;
    std::size_t stream_limit_ = 0;  ///< of what is written for the scene, before the same instant is begun anew
    ReadbackBuffer readback_;
    std::map<CameraId, ViewTargets> targets_;
    std::vector<Pending> pending_;  ///< of one call of draw()
    std::map<CameraId, ShownPicture> shown_;
    ThreadCheck thread_;
};

}  // namespace camrig::render::gl

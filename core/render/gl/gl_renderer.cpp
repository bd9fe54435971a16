#include "core/render/gl/gl_renderer.h"

#include <algorithm>
#include <cstring>
#include <new>

#include <spdlog/spdlog.h>

#include "core/base/clock.h"
#include "core/render/view_frames.h"

namespace camrig::render::gl {
namespace {

constexpr std::size_t least_stream_limit = std::size_t{4} << 20;

}  // namespace

Result<std::unique_ptr<Renderer>> GlRenderer::create(const RendererOptions& options) {
    auto context = EglContext::create(options.device);
    if (!context) return std::unexpected(context.error());
    std::optional<ColorConverter> converter;
    if (options.conversion == Conversion::device ||
        (options.conversion == Conversion::automatic && !(*context)->is_software())) {
        auto made = ColorConverter::create((*context)->gl());
        if (!made && options.conversion == Conversion::device) return std::unexpected(made.error());
        if (!made) spdlog::warn("colours are converted on the host: {}", made.error().message);
        if (made) converter.emplace(std::move(*made));
    }
    return std::unique_ptr<Renderer>(new GlRenderer(std::move(*context), std::move(converter), options));
}

GlRenderer::GlRenderer(std::unique_ptr<EglContext> context, std::optional<ColorConverter> converter,
                       const RendererOptions& options)
    : context_(std::move(context)),
      gl_(context_->gl()),
      pool_(options.pool),
      converter_(std::move(converter)),
      readback_mode_(context_->is_software() && !converter_ && !options.buffered_readback ? ReadbackMode::direct
                                                                                          : ReadbackMode::buffered),
      shaders_(gl_),
      samplers_(gl_),
      painter_(gl_, shaders_,
               {.max_side = context_->max_texture_size(),
                .has_float_units = context_->is_software(),
                .has_codes = converter_.has_value(),
                .scene = {.static_layer_bytes = options.static_layer_bytes,
                          .max_detail_error_px = options.max_detail_error_px,
                          .batch_draws = context_->has_draw_id() && options.batch_draws}}),
      scene_(gl_, samplers_,
             options.caches.prepared != nullptr ? options.caches.prepared : std::make_shared<scene::PreparedModels>()),
      readback_(gl_) {
    thread_.check();
}

GlRenderer::~GlRenderer() {
    thread_.check();
    gl_.Finish();
}

void GlRenderer::begin_instant(const world::SnapshotRef& snapshot) {
    scene_.place(snapshot);
    painter_.begin_instant();
}

Result<Renderer::Finished> GlRenderer::draw(const world::SnapshotRef& snapshot, TimeNs monotonic_ns,
                                            std::span<const View> views) {
    thread_.check();
    const TimeNs start_ns = monotonic_now_ns();
    try {
        auto finished = draw_views(snapshot, monotonic_ns, views);
        if (!finished) return finished;
        finished->cost_ns.resize(views.size());
        share_cost(monotonic_now_ns() - start_ns, views, finished->cost_ns);
        return finished;
    } catch (const std::bad_alloc&) {
        forget_instant();
        return error(ErrorKind::resource_exhausted, "no memory for the models or pictures of this instant (" +
                                                        context_->description() +
                                                        "); fewer or smaller cameras and models need less");
    }
}

void GlRenderer::forget_instant() {
    gl_.Finish();
    scene_.clear();
}

Result<Renderer::Finished> GlRenderer::draw_views(const world::SnapshotRef& snapshot, TimeNs monotonic_ns,
                                                  std::span<const View> views) {
    // More views of the instant that was drawn last find its movers as they are; as long as what draws need, view after
    // view, leaves room: a world that stands still may be asked for pictures without end.
    const bool is_new = snapshot != scene_.placed().snapshot() || scene_.stream().used() > stream_limit_;
    if (is_new) begin_instant(snapshot);
    Finished finished;
    finished.set.world_ns = snapshot->world_ns;
    finished.set.monotonic_ns = monotonic_ns;
    pending_.clear();
    painter_.prepare(views, scene_, targets_);
    for (std::size_t i = 0; i < views.size(); ++i) {
        if (auto drawn = draw_view(views[i], i); !drawn) {
            finished.failures.push_back({views[i].camera, at(*views[i].name, drawn.error()).error()});
        }
    }
    if (is_new) stream_limit_ = std::max(least_stream_limit, 4 * scene_.stream().used());
    if (readback_mode_ == ReadbackMode::buffered) {
        if (auto arrived = read_back(views); !arrived) return std::unexpected(arrived.error());
    } else {
        gl_.Flush();
    }
    finished.set.frames.reserve(pending_.size());
    for (const Pending& picture : pending_)
        finished.set.frames.push_back(finish(views[picture.view], picture, monotonic_ns));
    return finished;
}

bool GlRenderer::makes(frame::PixelFormat format, const View& view) const {
    if (format == frame::PixelFormat::rgba8) return true;
    // What comes after drawing is done on the host.
    return converter_ && finished_pixels(view) == FinishedPixels::none && converter_->can_make(format, view.spec->size);
}

Result<void> GlRenderer::draw_view(const View& view, std::size_t index) {
    if (view.spec->sensor && (wants(view, frame::FrameKind::color) || wants(view, frame::FrameKind::sensor)))
        return error(
            ErrorKind::unsupported,
            "sensor: drawn by camrig's own rasteriser only: with the lens method auto, antialias auto, coverage or "
            "none, and the principal point no farther than 8192 pixels from any edge of the picture");
    if (wants(view, frame::FrameKind::flow)) return error(ErrorKind::unsupported, no_flow);
    if (view.spec->backdrop)
        return error(ErrorKind::unsupported,
                     "backdrop: drawn by camrig's own rasteriser only: with the principal point no farther than 8192 "
                     "pixels from any edge of the picture");
    auto painted = painter_.paint(view, index, scene_, targets_[view.camera]);
    if (!painted) return std::unexpected(painted.error());
    for (int k = 0; k < frame::frame_kind_count; ++k) {
        const auto kind = static_cast<frame::FrameKind>(k);
        if (!wants(view, kind)) continue;
        Pending pending{.view = index,
                        .kind = kind,
                        .format = format_of(kind),
                        .transform = painted->transform,
                        .lens = painted->lens};
        pending.source = kind == frame::FrameKind::color   ? painted->color
                         : kind == frame::FrameKind::depth ? painted->depth
                                                           : painted->truth;
        if (kind != frame::FrameKind::color) {
            pending_.push_back(std::move(pending));
            continue;
        }
        pending.damage = shown_[view.camera].next(view.sequence, painted->damage);
        for (const frame::PixelFormat format : frame::color_formats) {
            if (!view.color_formats.contains(format)) continue;
            CHECK(makes(format, view));
            pending.format = format;
            pending_.push_back(pending);
        }
    }
    return {};
}

Result<void> GlRenderer::read_back(std::span<const View> views) {
    const auto bytes = [&](const Pending& picture) { return bytes_of(picture.format, views[picture.view].spec->size); };
    std::size_t room = 0;
    for (const Pending& picture : pending_) room += ReadbackBuffer::room_for(bytes(picture));
    readback_.reset(room);
    for (Pending& picture : pending_) {
        const ImageSize size = views[picture.view].spec->size;
        picture.buffer_offset = readback_.allocate(bytes(picture));
        if (picture.format == format_of(picture.kind)) {
            readback_.read(picture.source, picture.kind, size, picture.buffer_offset);
            continue;
        }
        converter_->convert(picture.source.codes, size, picture.format, readback_.name(),
                            static_cast<GLintptr>(picture.buffer_offset));
        ++conversions_;
    }
    return readback_.wait();
}

frame::FrameRef GlRenderer::finish(const View& view, const Pending& pending, TimeNs monotonic_ns) {
    auto frame = acquire_frame(*pool_, view, pending.kind, pending.format, scene_.placed().snapshot()->world_ns,
                               monotonic_ns, exposure_of(view, *scene_.placed().snapshot()).value());
    const std::span<std::byte> bytes = frame->mutable_bytes();
    if (readback_mode_ == ReadbackMode::buffered) {
        const auto source = readback_.bytes(pending.buffer_offset, bytes.size());
        std::memcpy(bytes.data(), source.data(), bytes.size());
    } else {
        read_pixels(gl_, pending.source, pending.kind, view.spec->size, bytes.data());
    }
    frame->set_damage(pending.damage);
    if (pending.kind == frame::FrameKind::color && pending.format == frame::PixelFormat::rgba8)
        finish_color(view, *frame);
    if (pending.kind == frame::FrameKind::semantic) ids_to_classes(*scene_.placed().snapshot(), *frame);
    if (pending.kind == frame::FrameKind::depth) {
        const std::span depth(reinterpret_cast<float*>(bytes.data()), bytes.size() / sizeof(float));
        for (float& value : depth) value = metres_of_depth(pending.transform, value);
        if (pending.lens != nullptr) pending.lens->to_optical_axis(depth);
    }
    return frame;
}

RenderCounters GlRenderer::counters() const {
    RenderCounters counters = painter_.counters();
    counters.meshes_skinned = scene_.placed().meshes_made();
    counters.meshes_unseen = scene_.placed().meshes_unseen();
    counters.conversions = conversions_;
    counters.draw_data_bytes = static_cast<std::int64_t>(scene_.stream_bytes());
    return counters;
}

void GlRenderer::forget(CameraId camera) {
    thread_.check();
    targets_.erase(camera);
    shown_.erase(camera);
    painter_.forget(camera);
    pool_->release_idle();
}

}  // namespace camrig::render::gl

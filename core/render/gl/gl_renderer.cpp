#include "core/render/gl/gl_renderer.h"

#include <cmath>
#include <cstring>

#include "core/render/view_frames.h"

namespace camrig {
namespace {

float srgb_of(float linear) {
    const float c = std::fmin(std::fmax(linear, 0.0f), 1.0f);
    return c <= 0.0031308f ? 12.92f * c : 1.055f * std::pow(c, 1.0f / 2.4f) - 0.055f;
}

bool wants_truth(const View& view) {
    const bool depth_alone = wants(view, FrameKind::depth) && !wants(view, FrameKind::color);
    return depth_alone || wants(view, FrameKind::instance) || wants(view, FrameKind::normal);
}

}  // namespace

Result<std::unique_ptr<Renderer>> GlRenderer::create(const RendererOptions& options) {
    auto context = EglContext::create({.device = options.device, .raster_threads = options.raster_threads});
    if (!context) return std::unexpected(context.error());
    return std::unique_ptr<Renderer>(new GlRenderer(std::move(*context), options.pool));
}

GlRenderer::GlRenderer(std::unique_ptr<EglContext> context, std::shared_ptr<FramePool> pool)
    : context_(std::move(context)),
      gl_(context_->gl()),
      pool_(std::move(pool)),
      readback_mode_(context_->is_software() ? ReadbackMode::direct : ReadbackMode::buffered),
      shaders_(gl_),
      samplers_(gl_),
      models_(gl_, samplers_),
      pass_(gl_, shaders_),
      static_stream_(gl_),
      slots_{Slot(gl_), Slot(gl_)} {
    thread_.check();
}

GlRenderer::~GlRenderer() {
    thread_.check();
    gl_.Finish();
}

void GlRenderer::update_statics(const std::shared_ptr<const StaticSet>& statics) {
    // By identity, not by revision: two worlds may count alike.
    if (statics == statics_) return;
    gl_.Finish();  // static_stream_ may still be read
    statics_ = statics;
    static_items_.clear();
    light_sets_.truncate(0);
    static_stream_.reset();
    for (const Instance& object : statics->objects) {
        static_items_.add(object, models_, light_sets_, statics->lights, statics->environment.exposure, static_stream_);
    }
    for (SceneItem& item : static_items_.items) {
        if (item.deformation >= 0) static_items_.deformed(item, static_stream_);
    }
    static_light_sets_ = light_sets_.size();
    models_.evict_unused();
}

void GlRenderer::update_movers(const Snapshot& snapshot, Slot& slot) {
    mover_items_.clear();
    light_sets_.truncate(static_light_sets_);
    for (const Instance& mover : snapshot.movers) {
        mover_items_.add(mover, models_, light_sets_, statics_->lights, statics_->environment.exposure, slot.stream);
    }
}

Result<void> GlRenderer::submit(SnapshotRef snapshot, TimeNs monotonic_ns, std::span<const View> views) {
    thread_.check();
    CHECK(in_flight() < max_in_flight);
    Instant instant{.snapshot = std::move(snapshot),
                    .monotonic_ns = monotonic_ns,
                    .slot = next_slot_,
                    .views = {views.begin(), views.end()},
                    .pending = {},
                    .failures = {}};
    next_slot_ = (next_slot_ + 1) % max_in_flight;
    Slot& slot = slots_[instant.slot];
    slot.stream.reset();
    update_statics(instant.snapshot->statics);
    update_movers(*instant.snapshot, slot);

    if (readback_mode_ == ReadbackMode::buffered) {
        std::size_t bytes = 0;
        for (const View& view : views) {
            for (int k = 0; k < frame_kind_count; ++k) {
                if (view.kinds[k]) bytes += bytes_of(format_of(static_cast<FrameKind>(k)), view.spec->size);
            }
        }
        slot.readback.reset(bytes);
    }
    pass_.begin_instant();
    for (std::size_t i = 0; i < views.size(); ++i) {
        if (auto drawn = draw_view(instant, i); !drawn) {
            instant.failures.push_back({views[i].camera, at(*views[i].name, drawn.error()).error()});
        }
    }
    if (readback_mode_ == ReadbackMode::buffered) {
        slot.readback.start_fence();
    } else {
        gl_.Flush();
    }
    submitted_.push_back(std::move(instant));
    return {};
}

Result<void> GlRenderer::draw_view(Instant& instant, std::size_t index) {
    const View& view = instant.views[index];
    const CameraSpec& spec = *view.spec;
    if (std::max(spec.size.width, spec.size.height) > context_->max_texture_size()) {
        return error(ErrorKind::unsupported, spec.size.to_string() + " is larger than the device draws; at most " +
                                                 std::to_string(context_->max_texture_size()) + " pixels a side");
    }
    if (spec.lens.model != LensModel::pinhole) {
        return error(ErrorKind::unsupported,
                     "lens model " + std::string(to_string(spec.lens.model)) + " is not drawn yet; use pinhole");
    }
    if (wants(view, FrameKind::semantic)) {
        return error(ErrorKind::unsupported, "semantic pictures are not drawn yet");
    }
    Slot& slot = slots_[instant.slot];
    Targets& targets = slot.targets[view.camera];

    PassView pass{.transform = make_view_transform(view.pose, spec.size, spec.intrinsics, spec.near_m, spec.far_m),
                  .frustum = {},
                  .quality = view.quality,
                  .environment = &statics_->environment,
                  .lights = statics_->lights,
                  .light_sets = &light_sets_};
    pass.frustum = make_frustum(pass.transform, spec.far_m);
    pass_.begin_view(pass, slot.stream);
    opaque_.clear();
    blended_.clear();
    pass_.cull(static_items_, opaque_, blended_);
    pass_.cull(mover_items_, opaque_, blended_);

    if (wants(view, FrameKind::color)) {
        if (auto drawn = draw_color(pass, targets); !drawn) return drawn;
    }
    if (wants_truth(view)) {
        if (auto drawn = draw_truth(targets, spec.size); !drawn) return drawn;
    }
    for (int k = 0; k < frame_kind_count; ++k) {
        const auto kind = static_cast<FrameKind>(k);
        if (!wants(view, kind)) continue;
        // Depth comes with the colours where those are drawn anyway.
        const bool from_color = kind == FrameKind::color || (kind == FrameKind::depth && wants(view, FrameKind::color));
        const GLuint framebuffer = from_color ? targets.color->framebuffer.name() : targets.truth->framebuffer.name();
        Pending pending{.view = index, .kind = kind, .framebuffer = framebuffer, .transform = pass.transform};
        if (readback_mode_ == ReadbackMode::buffered) {
            pending.buffer_offset =
                slot.readback.read(framebuffer, kind, spec.size, bytes_of(format_of(kind), spec.size));
        }
        instant.pending.push_back(pending);
    }
    return {};
}

Result<void> GlRenderer::draw_color(const PassView& view, Targets& targets) {
    const ImageSize size = view.transform.size;
    if (!targets.color || targets.color->size != size) {
        targets.color.reset();
        auto made = make_color_target(gl_, size);
        if (!made) return std::unexpected(made.error());
        targets.color = std::move(*made);
    }
    const GLuint framebuffer = targets.color->framebuffer.name();
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl_.Viewport(0, 0, size.width, size.height);
    const glm::vec3 background = view.environment->background * view.environment->exposure;
    const float color[4] = {srgb_of(background.r), srgb_of(background.g), srgb_of(background.b), 1.0f};
    const float farthest = 0.0f;
    gl_.ClearNamedFramebufferfv(framebuffer, GL_COLOR, 0, color);
    gl_.ClearNamedFramebufferfv(framebuffer, GL_DEPTH, 0, &farthest);
    pass_.draw_opaque(opaque_);
    pass_.draw_blended(blended_);
    return {};
}

Result<void> GlRenderer::draw_truth(Targets& targets, ImageSize size) {
    if (!targets.truth || targets.truth->size != size) {
        targets.truth.reset();
        auto made = make_truth_target(gl_, size);
        if (!made) return std::unexpected(made.error());
        targets.truth = std::move(*made);
    }
    const GLuint framebuffer = targets.truth->framebuffer.name();
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl_.Viewport(0, 0, size.width, size.height);
    const GLuint nothing[4] = {0, 0, 0, 0};
    const float no_normal[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    const float farthest = 0.0f;
    gl_.ClearNamedFramebufferuiv(framebuffer, GL_COLOR, 0, nothing);
    gl_.ClearNamedFramebufferfv(framebuffer, GL_COLOR, 1, no_normal);
    gl_.ClearNamedFramebufferfv(framebuffer, GL_DEPTH, 0, &farthest);
    pass_.draw_truth(opaque_);
    return {};
}

FrameRef GlRenderer::finish(const Instant& instant, const Pending& pending) {
    const View& view = instant.views[pending.view];
    auto frame = acquire_frame(*pool_, view, pending.kind, instant.snapshot->world_ns, instant.monotonic_ns);
    const std::span<std::byte> bytes = frame->mutable_bytes();
    if (readback_mode_ == ReadbackMode::buffered) {
        const auto source = slots_[instant.slot].readback.bytes(pending.buffer_offset, bytes.size());
        std::memcpy(bytes.data(), source.data(), bytes.size());
    } else {
        read_pixels(gl_, pending.framebuffer, pending.kind, view.spec->size, bytes.data());
    }
    if (pending.kind == FrameKind::color) finish_color(view, *frame);
    if (pending.kind == FrameKind::depth) {
        auto* depth = reinterpret_cast<float*>(bytes.data());
        for (std::int64_t i = 0; i < view.spec->size.pixels(); ++i) {
            depth[i] = metres_of_depth(pending.transform, depth[i]);
        }
    }
    return frame;
}

Result<Renderer::Finished> GlRenderer::collect() {
    thread_.check();
    CHECK(!submitted_.empty());
    Instant instant = std::move(submitted_.front());
    submitted_.pop_front();
    if (readback_mode_ == ReadbackMode::buffered) {
        if (auto arrived = slots_[instant.slot].readback.wait(); !arrived) return std::unexpected(arrived.error());
    }
    Finished finished;
    finished.set.world_ns = instant.snapshot->world_ns;
    finished.set.monotonic_ns = instant.monotonic_ns;
    finished.failures = std::move(instant.failures);
    for (const Pending& pending : instant.pending) finished.set.frames.push_back(finish(instant, pending));
    return finished;
}

void GlRenderer::forget(CameraId camera) {
    thread_.check();
    for (Slot& slot : slots_) slot.targets.erase(camera);
}

}  // namespace camrig

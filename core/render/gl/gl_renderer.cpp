#include "core/render/gl/gl_renderer.h"

#include <algorithm>
#include <cstring>
#include <new>

#include <spdlog/spdlog.h>

#include "core/frame/tone.h"
#include "core/render/view_frames.h"

namespace camrig {
namespace {

constexpr std::size_t least_stream_limit = std::size_t{4} << 20;

bool same_objects(const StaticSet& a, const StaticSet& b) {
    return std::ranges::equal(a.objects, b.objects, [](const Instance& x, const Instance& y) {
        return x.info == y.info && x.position == y.position && x.orientation == y.orientation && x.scale == y.scale &&
               x.clips.empty() && y.clips.empty();
    });
}

}  // namespace

Result<std::unique_ptr<Renderer>> GlRenderer::create(const RendererOptions& options) {
    auto context = EglContext::create({.device = options.device, .raster_threads = options.raster_threads});
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
      models_(gl_, samplers_),
      painter_(gl_, shaders_,
               {.max_side = context_->max_texture_size(),
                .has_float_units = context_->is_software(),
                .has_codes = converter_.has_value(),
                .scene = {.static_layer_bytes = options.static_layer_bytes,
                          .max_detail_error_px = options.max_detail_error_px,
                          .batch_draws = context_->has_draw_id() && options.batch_draws}}),
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
    objects_number_ += statics_ == nullptr || !same_objects(*statics_, *statics);
    statics_ = statics;
    ++statics_number_;
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
}

void GlRenderer::update_movers(const Snapshot& snapshot, Slot& slot) {
    mover_items_.clear();
    light_sets_.truncate(static_light_sets_);
    for (const Instance& mover : snapshot.movers) {
        mover_items_.add(mover, models_, light_sets_, statics_->lights, statics_->environment.exposure, slot.stream);
    }
}

void GlRenderer::begin_instant(SnapshotRef snapshot) {
    count_meshes(meshes_skinned_, meshes_unseen_);
    snapshot_ = std::move(snapshot);
    slot_ = (slot_ + 1) % max_in_flight;
    slots_[slot_].stream.reset();
    update_statics(snapshot_->statics);
    update_movers(*snapshot_, slots_[slot_]);
    models_.evict_unused();
    painter_.begin_instant();
}

void GlRenderer::count_meshes(std::uint64_t& skinned, std::uint64_t& unseen) const {
    for (const Deformation& job : mover_items_.deformations) ++(job.is_done ? skinned : unseen);
}

Result<void> GlRenderer::submit(SnapshotRef snapshot, TimeNs monotonic_ns, std::span<const View> views) {
    thread_.check();
    CHECK(in_flight() < max_in_flight);
    try {
        submit_views(std::move(snapshot), monotonic_ns, views);
        return {};
    } catch (const std::bad_alloc&) {
        forget_instant();
        return error(ErrorKind::resource_exhausted, "no memory for the models or pictures of this instant (" +
                                                        context_->description() +
                                                        "); fewer or smaller cameras and models need less");
    }
}

void GlRenderer::forget_instant() {
    gl_.Finish();
    mover_items_.clear();
    snapshot_.reset();
    statics_.reset();  // what is kept of it counts as stale from now on
}

void GlRenderer::submit_views(SnapshotRef snapshot, TimeNs monotonic_ns, std::span<const View> views) {
    // More views of the instant that was drawn last find its movers as they are; as long as what draws need, view after
    // view, leaves room: a world that stands still may be asked for pictures without end.
    const bool is_new = snapshot != snapshot_ || !submitted_.empty() || slots_[slot_].stream.used() > stream_limit_;
    if (is_new) begin_instant(std::move(snapshot));
    Instant instant{.snapshot = snapshot_,
                    .monotonic_ns = monotonic_ns,
                    .slot = slot_,
                    .views = {views.begin(), views.end()},
                    .pending = {},
                    .failures = {}};
    Slot& slot = slots_[slot_];

    instant.pending.reserve(views.size());
    PaintScene scene = paint_scene(slot);
    painter_.prepare(views, scene, slot.targets);
    for (std::size_t i = 0; i < views.size(); ++i) {
        if (auto drawn = draw_view(instant, i); !drawn) {
            instant.failures.push_back({views[i].camera, at(*views[i].name, drawn.error()).error()});
        }
    }
    if (is_new) stream_limit_ = std::max(least_stream_limit, 4 * slot.stream.used());
    if (readback_mode_ == ReadbackMode::buffered) {
        read_back(instant);
    } else {
        gl_.Flush();
    }
    submitted_.push_back(std::move(instant));
}

bool GlRenderer::makes(PixelFormat format, const View& view) const {
    if (format == PixelFormat::rgba8) return true;
    // Image controls and code strip come after drawing, on the host (finish_color).
    return converter_ && changes_nothing(view.spec->controls) && !view.spec->code_strip &&
           converter_->can_make(format, view.spec->size);
}

PaintScene GlRenderer::paint_scene(Slot& slot) {
    return {.statics_number = statics_number_,
            .objects_number = objects_number_,
            .statics = static_items_,
            .movers = mover_items_,
            .environment = statics_->environment,
            .lights = statics_->lights,
            .light_sets = light_sets_,
            .stream = slot.stream};
}

Result<void> GlRenderer::draw_view(Instant& instant, std::size_t index) {
    const View& view = instant.views[index];
    Slot& slot = slots_[instant.slot];
    PaintScene scene = paint_scene(slot);
    auto painted = painter_.paint(view, index, scene, slot.targets[view.camera]);
    if (!painted) return std::unexpected(painted.error());
    for (int k = 0; k < frame_kind_count; ++k) {
        const auto kind = static_cast<FrameKind>(k);
        if (!wants(view, kind)) continue;
        Pending pending{.view = index,
                        .kind = kind,
                        .format = format_of(kind),
                        .transform = painted->transform,
                        .lens = painted->lens};
        pending.source = kind == FrameKind::color   ? painted->color
                         : kind == FrameKind::depth ? painted->depth
                                                    : painted->truth;
        if (kind != FrameKind::color) {
            instant.pending.push_back(std::move(pending));
            continue;
        }
        find_changes(view, *painted, pending);
        for (const PixelFormat format : color_formats) {
            if (!view.color_formats.contains(format)) continue;
            CHECK(makes(format, view));
            pending.format = format;
            instant.pending.push_back(pending);
        }
    }
    return {};
}

void GlRenderer::find_changes(const View& view, const PaintedView& painted, Pending& picture) {
    Shown& last = shown_[view.camera];
    // A layer is of one revision of the camera: image controls and everything else are as they were.
    if (painted.layer != 0 && painted.layer == last.layer) {
        picture.same_as = last.sequence;
        picture.changed_rows = last.drawn_rows;
        picture.changed_rows |= painted.drawn_rows;
    }
    last = {view.sequence, painted.layer, painted.drawn_rows};
}

void GlRenderer::read_back(Instant& instant) {
    ReadbackBuffer& buffer = slots_[instant.slot].readback;
    const auto bytes = [&](const Pending& picture) {
        return bytes_of(picture.format, instant.views[picture.view].spec->size);
    };
    std::size_t room = 0;
    for (const Pending& picture : instant.pending) room += ReadbackBuffer::room_for(bytes(picture));
    buffer.reset(room);
    for (Pending& picture : instant.pending) {
        const ImageSize size = instant.views[picture.view].spec->size;
        picture.buffer_offset = buffer.allocate(bytes(picture));
        if (picture.format == format_of(picture.kind)) {
            buffer.read(picture.source, picture.kind, size, picture.buffer_offset);
            continue;
        }
        converter_->convert(picture.source.codes, size, picture.format, buffer.name(),
                            static_cast<GLintptr>(picture.buffer_offset));
        ++conversions_;
    }
    buffer.start_fence();
}

FrameRef GlRenderer::finish(const Instant& instant, const Pending& pending) {
    const View& view = instant.views[pending.view];
    auto frame =
        acquire_frame(*pool_, view, pending.kind, pending.format, instant.snapshot->world_ns, instant.monotonic_ns);
    const std::span<std::byte> bytes = frame->mutable_bytes();
    if (readback_mode_ == ReadbackMode::buffered) {
        const auto source = slots_[instant.slot].readback.bytes(pending.buffer_offset, bytes.size());
        std::memcpy(bytes.data(), source.data(), bytes.size());
    } else {
        read_pixels(gl_, pending.source, pending.kind, view.spec->size, bytes.data());
    }
    if (pending.same_as >= 0) frame->mark_changes(pending.same_as, pending.changed_rows);
    if (pending.kind == FrameKind::color && pending.format == PixelFormat::rgba8) finish_color(view, *frame);
    if (pending.kind == FrameKind::semantic) ids_to_classes(*instant.snapshot, *frame);
    if (pending.kind == FrameKind::depth) {
        const std::span depth(reinterpret_cast<float*>(bytes.data()), bytes.size() / sizeof(float));
        for (float& value : depth) value = metres_of_depth(pending.transform, value);
        if (pending.lens != nullptr) pending.lens->to_optical_axis(depth);
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
    finished.set.frames.reserve(instant.pending.size());
    for (const Pending& pending : instant.pending) finished.set.frames.push_back(finish(instant, pending));
    return finished;
}

RenderCounters GlRenderer::counters() const {
    RenderCounters counters = painter_.counters();
    counters.meshes_skinned = meshes_skinned_;
    counters.meshes_unseen = meshes_unseen_;
    count_meshes(counters.meshes_skinned, counters.meshes_unseen);
    counters.conversions = conversions_;
    counters.draw_data_bytes = static_cast<std::int64_t>(static_stream_.capacity());
    for (const Slot& slot : slots_) counters.draw_data_bytes += static_cast<std::int64_t>(slot.stream.capacity());
    return counters;
}

void GlRenderer::forget(CameraId camera) {
    thread_.check();
    for (Slot& slot : slots_) slot.targets.erase(camera);
    shown_.erase(camera);
    painter_.forget(camera);
    pool_->release_idle();
}

}  // namespace camrig

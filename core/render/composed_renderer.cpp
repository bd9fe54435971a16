#include "core/render/composed_renderer.h"

#include <algorithm>

#include "core/base/clock.h"
#include "core/base/out_of_memory.h"
#include "core/render/view_frames.h"

namespace camrig::render {
namespace {

/// CPU time of a pixel of a whole picture of the hall, as tests/render/cost_test.cpp measures it, and what else a
/// picture has adds to it. Of a standing camera the first two are whole; then what is measured counts.
constexpr double plain_pixel_ns = 80.0, areas_pixel_ns = 200.0, beautiful_pixel_ns = 180.0, lens_pixel_ns = 20.0,
                 areas_by_lens_pixel_ns = 200.0, sensor_pixel_ns = 30.0;

}  // namespace

bool ComposedRenderer::is_ours(const View& view, frame::FrameKind kind) const {
    return is_first_ || view.spec->sensor || view.spec->backdrop || kind == frame::FrameKind::flow;
}

Result<Renderer::Finished> ComposedRenderer::draw(const world::SnapshotRef& snapshot, TimeNs monotonic_ns,
                                                  std::span<const View> views) {
    thread_.check();
    auto finished = or_out_of_memory("drawing", [&] { return draw_all(snapshot, monotonic_ns, views); });
    // What was being made is half made.
    if (!finished) drawer_.clear();
    return finished;
}

Result<Renderer::Finished> ComposedRenderer::draw_all(const world::SnapshotRef& snapshot, TimeNs monotonic_ns,
                                                      std::span<const View> views) {
    const auto wants_ours = [&](const View& view) {
        for (int k = 0; k < frame::frame_kind_count; ++k)
            if (view.kinds[k] && is_ours(view, static_cast<frame::FrameKind>(k))) return true;
        return false;
    };
    for (const View& view : views) {
        const auto known = ours_.find(view.camera);
        if (known != ours_.end() && known->second != view.spec_revision && !wants_ours(view)) forget_here(view.camera);
    }
    // Placing the scene for nobody costs.
    if (!is_first_ && std::ranges::none_of(views, wants_ours)) {
        if (views.empty()) drawer_.clear();  // another world
        return other_->draw(snapshot, monotonic_ns, views);
    }
    begin_instant(snapshot);
    const auto draws = [&](const View& view, frame::FrameKind kind) {
        return is_ours(view, kind) && drawer_.can_draw(view, kind);
    };
    Finished finished;
    finished.set.world_ns = snapshot->world_ns;
    finished.set.monotonic_ns = monotonic_ns;
    finished.set.frames.reserve(views.size());
    finished.cost_ns.resize(views.size());
    here_.clear();
    places_here_.clear();
    parts_.clear();
    parts_.reserve(views.size());
    rest_.clear();
    places_of_rest_.clear();
    for (std::size_t i = 0; i < views.size(); ++i) {
        const View& view = views[i];
        const TimeNs begin_ns = thread_cpu_ns();  // a new lens is made with the first question for it
        bool is_here = false, is_elsewhere = false;
        for (int k = 0; k < frame::frame_kind_count; ++k) {
            if (!wants(view, static_cast<frame::FrameKind>(k))) continue;
            (draws(view, static_cast<frame::FrameKind>(k)) ? is_here : is_elsewhere) = true;
        }
        finished.cost_ns[i] = thread_cpu_ns() - begin_ns;
        if (is_here) {
            ours_[view.camera] = view.spec_revision;
            here_.push_back(is_elsewhere ? &parts_.emplace_back(view) : &view);
            places_here_.push_back(i);
        }
        if (!is_elsewhere) continue;
        rest_.push_back(view);
        places_of_rest_.push_back(i);
        for (int k = 0; k < frame::frame_kind_count; ++k) {
            const bool is_drawn_here = draws(view, static_cast<frame::FrameKind>(k));
            if (is_here) parts_.back().kinds[k] &= is_drawn_here;
            rest_.back().kinds[k] &= !is_drawn_here;
        }
    }
    drawer_.draw(here_, monotonic_ns, finished.set.frames);
    for (std::size_t i = 0; i < here_.size(); ++i) finished.cost_ns[places_here_[i]] += drawer_.cost_ns()[i];
    if (rest_.empty()) return finished;

    auto others = draw_rest(snapshot, monotonic_ns);
    if (!others) {
        for (const View& view : rest_)
            finished.failures.push_back({view.camera, at(*view.name, others.error()).error()});
        return finished;
    }
    for (std::size_t i = 0; i < rest_.size(); ++i) finished.cost_ns[places_of_rest_[i]] += others->cost_ns[i];
    finished.failures = std::move(others->failures);
    auto& frames = finished.set.frames;
    frames.insert(frames.end(), others->set.frames.begin(), others->set.frames.end());
    const auto place = [&](const frame::FrameRef& frame) {
        return std::pair(std::ranges::find(views, frame->info().camera_id, &View::camera), frame->info().kind);
    };
    std::ranges::sort(frames, [&](const frame::FrameRef& a, const frame::FrameRef& b) { return place(a) < place(b); });
    return finished;
}

void ComposedRenderer::begin_instant(const world::SnapshotRef& snapshot) {
    if (snapshot != drawer_.snapshot()) drawer_.begin_instant(snapshot);
}

Result<Renderer::Finished> ComposedRenderer::draw_rest(const world::SnapshotRef& snapshot, TimeNs monotonic_ns) {
    if (other_ == nullptr && !other_failed_) {
        auto made = make_other_();
        if (made) {
            other_ = std::move(*made);
        } else {
            other_failed_ = made.error();
        }
    }
    if (other_ == nullptr) return std::unexpected(*other_failed_);
    return other_->draw(snapshot, monotonic_ns, rest_);
}

std::optional<std::vector<frame::Silhouette>> ComposedRenderer::silhouettes(const world::SnapshotRef& snapshot,
                                                                            const View& view,
                                                                            std::span<const ObjectId> objects) {
    thread_.check();
    if (!is_ours(view)) return std::nullopt;
    try {
        begin_instant(snapshot);
        if (!drawer_.can_draw(view, frame::FrameKind::instance) || drawer_.is_exposed(view)) return std::nullopt;
        return drawer_.silhouettes(view, objects);
    } catch (const std::bad_alloc&) {
        drawer_.clear();
        return std::nullopt;
    }
}

void ComposedRenderer::forget_here(CameraId camera) {
    drawer_.forget(camera);
    release(camera);
}

void ComposedRenderer::release(CameraId camera) {
    if (ours_.erase(camera) > 0 && ours_.empty()) drawer_.clear();
}

void ComposedRenderer::forget(CameraId camera) {
    thread_.check();
    forget_here(camera);
    if (other_ != nullptr) other_->forget(camera);
}

RenderCounters ComposedRenderer::counters() const {
    RenderCounters sum = drawer_.counters();
    if (other_ != nullptr) sum += other_->counters();
    return sum;
}

void ComposedRenderer::hand_over(CameraId camera) {
    thread_.check();
    drawer_.hand_over(camera);
    release(camera);
    if (other_ != nullptr) other_->forget(camera);
}

bool ComposedRenderer::makes(frame::PixelFormat format, const View& view) const {
    return is_ours(view) ? format == frame::PixelFormat::rgba8 : other_->makes(format, view);
}

bool ComposedRenderer::is_plain(const View& view) const {
    if (!is_ours(view)) return other_->is_plain(view);
    // Shadow maps are made for all beautiful views of a renderer, and textures for their materials.
    return view.quality != world::Quality::beautiful && software::SoftwareDrawer::may_draw(view);
}

TimeNs ComposedRenderer::expected_cost_ns(const View& view) const {
    if (!is_ours(view)) return other_->expected_cost_ns(view);
    const bool has_lens = view.spec->lens.model != camera::LensModel::pinhole;
    const bool has_areas = software::SoftwareDrawer::has_areas(view);
    double pixel_ns = plain_pixel_ns;
    if (has_areas) pixel_ns += areas_pixel_ns;
    if (has_lens) pixel_ns += has_areas ? areas_by_lens_pixel_ns : lens_pixel_ns;
    if (view.quality == world::Quality::beautiful) pixel_ns += beautiful_pixel_ns;
    if (view.spec->sensor) pixel_ns += sensor_pixel_ns;
    return static_cast<TimeNs>(pixel_ns * static_cast<double>(view.spec->size.pixels()));
}

std::string ComposedRenderer::description() const {
    if (!is_first_) return other_->description();
    const std::string own = "camrig's rasteriser (" + std::string(software::has_wide_lanes() ? "AVX2" : "SSE2") + ")";
    return other_ == nullptr ? own : own + "; " + other_->description();
}

}  // namespace camrig::render

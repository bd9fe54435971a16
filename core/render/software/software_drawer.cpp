#include "core/render/software/software_drawer.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>

#include "core/frame/tone.h"
#include "core/render/view_frames.h"

namespace camrig {
namespace {

/// Vertices are snapped to 1/256 pixel in 32 bits (geometry.h).
constexpr int max_side = 16384;
/// Of what moves in one view; more are joined.
constexpr std::size_t max_rects = 16;

template <typename T>
void copy(Rows<T> from, Rows<T> to, const PixelRect& rect) {
    if (rect.width() <= 0) return;
    const auto bytes = static_cast<std::size_t>(rect.width()) * sizeof(T);
    for (int y = rect.y0; y < rect.y1; ++y) std::memcpy(to(y) + rect.x0, from(y) + rect.x0, bytes);
}

template <typename T>
void fill(Rows<T> rows, ImageSize size, T value) {
    for (int y = 0; y < size.height; ++y) std::fill_n(rows(y), size.width, value);
}

Rows<std::uint32_t> rows_of(Frame& frame) {
    return {reinterpret_cast<std::uint32_t*>(frame.mutable_bytes().data()), frame.info().size.width};
}

/// Never the same twice, whatever drawer asks.
std::uint64_t next_mark() {
    static std::atomic<std::uint64_t> last = 0;
    return ++last;
}

std::uint32_t pixel_of(const glm::vec3& linear) {
    return srgb_code(linear.r) | std::uint32_t{srgb_code(linear.g)} << 8 | std::uint32_t{srgb_code(linear.b)} << 16 |
           0xFFu << 24;
}

void sort_by_distance(std::vector<ViewDraw>& draws) {
    // By hand, because stable_sort() allocates.
    for (std::size_t i = 0; i < draws.size(); ++i) draws[i].order = i;
    std::ranges::sort(draws, [](const ViewDraw& a, const ViewDraw& b) {
        return a.distance_m != b.distance_m ? a.distance_m > b.distance_m : a.order < b.order;
    });
}

/// Triangles are cut max_side / 2 or more beside a picture and its principal point, which may lie far outside of it.
bool is_within_reach(double principal_point, int side) {
    return std::abs(principal_point) + std::max(std::abs(principal_point), std::abs(side - principal_point)) <=
           max_side;
}

bool is_blended(const SoftwareItem& item) {
    return item.primitive->material->alpha_mode == AlphaMode::blend;
}

/// May be of less than no height.
PixelRect common(const PixelRect& a, const PixelRect& b) {
    return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

PixelRect hull_of(std::span<const PixelRect> rects) {
    PixelRect hull = rects.front();
    for (const PixelRect& rect : rects)
        hull = {std::min(hull.x0, rect.x0), std::min(hull.y0, rect.y0), std::max(hull.x1, rect.x1),
                std::max(hull.y1, rect.y1)};
    return hull;
}

}  // namespace

SoftwareDrawer::SoftwareDrawer(const Options& options)
    : options_(options), team_(std::max(1, options.threads)), layers_(options.static_layer_bytes) {
    while (scratch_.size() < static_cast<std::size_t>(team_.size())) scratch_.emplace_back();
}

void SoftwareDrawer::begin_instant(const SnapshotRef& snapshot) {
    meshes_skinned_ += movers_.made();
    meshes_unseen_ += movers_.unseen();
    snapshot_ = snapshot;
    layers_.next_instant();
    const Environment& environment = snapshot->statics->environment;
    const std::span<const Light> lights = snapshot->statics->lights;
    // By identity, not by revision: two worlds may count alike.
    if (snapshot->statics != static_set_) {
        static_set_ = snapshot->statics;
        ++statics_number_;
        statics_.clear();
        for (const Instance& object : static_set_->objects) statics_.add(object, models_, lights, environment.exposure);
        blended_statics_.clear();
        for (const SoftwareItem& item : statics_.items()) {
            if (item.deformation >= 0) statics_.deform(item);
            if (is_blended(item)) blended_statics_.push_back(&item);
        }
        models_.evict_unused();
    }
    movers_.clear();
    for (const Instance& mover : snapshot->movers) movers_.add(mover, models_, lights, environment.exposure);
}

bool SoftwareDrawer::can_draw(const View& view) const {
    const CameraSpec& spec = *view.spec;
    return is_within_reach(spec.intrinsics.cx, spec.size.width) &&
           is_within_reach(spec.intrinsics.cy, spec.size.height) && view.quality != Quality::beautiful &&
           spec.lens.model == LensModel::pinhole && spec.lens_sampling.method == LensMethod::automatic &&
           antialias_of(spec, view.quality) == Antialias::none && statics_.has_only_triangles() &&
           movers_.has_only_triangles();
}

void SoftwareDrawer::prepare(const View& view, ViewWork& work) {
    const CameraSpec& spec = *view.spec;
    work.view = &view;
    work.scope.transform = make_view_transform(view.pose, spec.size, spec.intrinsics, spec.near_m, spec.far_m);
    work.scope.frustum = make_frustum(work.scope.transform, spec.far_m);
    work.scope.quality = view.quality;
    work.scope.max_detail_error_px = options_.max_detail_error_px;
    work.scope.wide_lanes = options_.wide_lanes;
    work.scope.environment = &static_set_->environment;
    work.scope.lights = static_set_->lights;
    work.layer = layers_.layer_of(view.camera, {view.spec_revision, view.pose, view.quality, statics_number_});
    work.history = &histories_[view.camera];
    work.movers.clear();
    work.blended.clear();
    work.rects.clear();
    work.draws = work.draws_coarse = 0;
    for (const SoftwareItem& item : movers_.items()) {
        auto draw = work.scope.draw_of(item);
        if (!draw) continue;
        const auto rect =
            screen_bounds(work.scope.transform, draw->optical_from_local, item.bounds.min, item.bounds.max);
        if (!rect) continue;
        work.rects.push_back(*rect);
        (is_blended(item) ? work.blended : work.movers).push_back(*draw);
    }
}

void SoftwareDrawer::deform_seen(std::span<ViewWork* const> works) {
    unmade_.clear();
    for (const ViewWork* work : works) {
        for (const auto* list : {&work->movers, &work->blended}) {
            for (const ViewDraw& draw : *list) {
                if (draw.item->deformation >= 0 && !movers_.deformed(*draw.item).is_done &&
                    std::ranges::find(unmade_, draw.item) == unmade_.end())
                    unmade_.push_back(draw.item);
            }
        }
    }
    team_.run(unmade_.size(), [&](int, std::size_t i) { movers_.deform(*unmade_[i]); });
}

void SoftwareDrawer::draw(std::span<const View* const> views, TimeNs monotonic_ns, std::vector<FrameRef>& frames) {
    while (works_.size() < views.size()) works_.emplace_back();
    in_work_.clear();
    for (std::size_t i = 0; i < views.size(); ++i) {
        prepare(*views[i], works_[i]);
        in_work_.push_back(&works_[i]);
    }
    deform_seen(in_work_);
    if (views.size() >= static_cast<std::size_t>(team_.size())) {
        team_.run(views.size(), [&](int worker, std::size_t i) {
            draw_view(*in_work_[i], scratch_[static_cast<std::size_t>(worker)], 1, monotonic_ns);
        });
    } else {
        // Few views: all threads together on each, in pieces of its rows.
        for (ViewWork* work : in_work_) draw_view(*work, scratch_.front(), team_.size(), monotonic_ns);
    }
    for (ViewWork* work : in_work_) {
        frames.push_back(std::move(work->frame));
        ++views_;
        views_in_parts_ += work->is_in_parts;
        draws_ += work->draws;
        draws_coarse_ += work->draws_coarse;
        if (work->is_in_parts) layers_.count_reused();
    }
}

void SoftwareDrawer::draw_view(ViewWork& work, Scratch& scratch, int bands, TimeNs monotonic_ns) {
    const View& view = *work.view;
    const ImageSize size = view.spec->size;
    work.is_in_frame = size.width % lane_count == 0;
    scratch.numbers.fit(size);
    scratch.depth.fit(size);
    if (!work.is_in_frame) scratch.color.fit(size);
    scratch.geometry.begin_view(work.scope);
    scratch.first_triangle = 0;
    work.frame = acquire_frame(*options_.pool, view, FrameKind::color, snapshot_->world_ns, monotonic_ns);
    work.canvas = {work.is_in_frame ? rows_of(*work.frame) : scratch.color.rows(), scratch.depth.rows()};
    work.is_in_parts = work.layer != nullptr && work.layer->number != 0;
    if (work.is_in_parts) {
        draw_changes(work, scratch, bands);
    } else {
        draw_all(work, scratch, bands);
    }
    finish_color(view, *work.frame);
    remember(work);
}

void SoftwareDrawer::remember(ViewWork& work) {
    const View& view = *work.view;
    History& history = *work.history;
    history.sequence = view.sequence;
    history.last = (history.last + 1) % history.frames.size();
    Shown& shown = history.frames[history.last];
    shown.mark = 0;
    shown.layer = work.is_in_parts ? work.layer->number : 0;
    shown.rects.assign(work.rects.begin(), work.rects.end());
    // A code strip lies in the same place in all frames of a layer, and is drawn anew.
    if (!work.is_in_parts || !changes_nothing(view.spec->controls)) return;
    shown.mark = next_mark();
    work.frame->mark_content(shown.mark);
}

const ViewDraw& SoftwareDrawer::add(ViewWork& work, Scratch& scratch, const ViewDraw& draw) {
    ++work.draws;
    work.draws_coarse += draw.level->error > 0.0f;
    return scratch.geometry.add(draw, draw.is_static ? statics_ : movers_);
}

template <typename Work>
void SoftwareDrawer::in_bands(const PixelRect& rect, int bands, const Work& work) {
    team_.run(static_cast<std::size_t>(bands), [&](int, std::size_t band) {
        const auto row = [&](std::size_t i) { return rect.y0 + rect.height() * static_cast<int>(i) / bands; };
        work(PixelRect{rect.x0, row(band), rect.x1, row(band + 1)});
    });
}

void SoftwareDrawer::draw_opaque(Scratch& scratch, const Canvas& canvas, std::span<const PixelRect> rects, int bands) {
    const auto count = static_cast<std::uint32_t>(scratch.geometry.triangles().size());
    if (count == scratch.first_triangle || rects.empty()) return;
    const PixelRect hull = hull_of(rects);
    in_bands(hull, bands, [&](const PixelRect& band) {
        // What was added lies in the rectangles: once for all of them.
        find_visible(scratch.geometry, scratch.first_triangle, count - scratch.first_triangle, band, canvas,
                     scratch.numbers);
        for (const PixelRect& rect : rects)
            shade_visible(scratch.geometry, common(rect, band), canvas, scratch.numbers);
    });
    scratch.first_triangle = count;
}

void SoftwareDrawer::draw_blended(ViewWork& work, Scratch& scratch, std::vector<ViewDraw>& draws,
                                  std::span<const PixelRect> rects, int bands) {
    sort_by_distance(draws);
    for (ViewDraw& draw : draws) draw = add(work, scratch, draw);
    in_bands(scratch.geometry.whole(), bands, [&](const PixelRect& band) {
        for (const PixelRect& rect : rects) {
            for (const ViewDraw& draw : draws)
                blend(scratch.geometry, draw.first_triangle, draw.triangle_count, common(rect, band), work.canvas);
        }
    });
    scratch.first_triangle = static_cast<std::uint32_t>(scratch.geometry.triangles().size());
}

void SoftwareDrawer::draw_changes(ViewWork& work, Scratch& scratch, int bands) {
    const Layer& layer = *work.layer;
    const Canvas& canvas = work.canvas;
    const History& history = *work.history;
    work.rects = disjoint_cover(std::move(work.rects), max_rects);
    const PixelRect whole = scratch.geometry.whole();
    // The layer's key has the camera's revision in it: tone and everything else are those of the frame before.
    if (const Shown& last = history.frames[history.last]; last.layer == layer.number) {
        ChangedRows rows;
        for (const PixelRect& rect : last.rects) rows.add(rect.y0, rect.y1);
        for (const PixelRect& rect : work.rects) rows.add(rect.y0, rect.y1);
        work.frame->mark_changes(history.sequence, rows);
    }
    const std::uint64_t held = work.frame->held_before();
    const auto found = std::ranges::find_if(history.frames, [&](const Shown& shown) {
        return held != 0 && shown.mark == held && shown.layer == layer.number;
    });
    const std::span<const PixelRect> stale =
        found == history.frames.end() ? std::span<const PixelRect>(&whole, 1) : std::span(found->rects);
    const Rows<std::uint32_t> picture = rows_of(*work.frame), color = layer.color.rows();
    const Rows<std::uint32_t> finished = layer.finished ? layer.finished.rows() : color;
    in_bands(whole, bands, [&](const PixelRect& band) {
        for (const PixelRect& rect : stale) copy(finished, picture, common(rect, band));
        for (const PixelRect& rect : work.rects) {
            if (!work.is_in_frame || layer.finished) copy(color, canvas.color, common(rect, band));
            copy(layer.depth.rows(), canvas.depth, common(rect, band));
        }
    });

    for (const ViewDraw& draw : work.movers) add(work, scratch, draw);
    draw_opaque(scratch, canvas, work.rects, bands);
    scratch.blended.clear();
    for (const SoftwareItem* item : blended_statics_) {
        auto draw = work.scope.draw_of(*item);
        if (!draw) continue;
        const auto bounds =
            screen_bounds(work.scope.transform, draw->optical_from_local, item->bounds.min, item->bounds.max);
        if (!bounds || std::ranges::none_of(work.rects, [&](const PixelRect& r) { return r.intersects(*bounds); }))
            continue;
        draw->is_static = true;
        scratch.blended.push_back(*draw);
    }
    scratch.blended.insert(scratch.blended.end(), work.blended.begin(), work.blended.end());
    draw_blended(work, scratch, scratch.blended, work.rects, bands);
    if (work.is_in_frame) return;
    for (const PixelRect& rect : work.rects) copy(canvas.color, picture, rect);
}

void SoftwareDrawer::draw_all(ViewWork& work, Scratch& scratch, int bands) {
    const Canvas& canvas = work.canvas;
    const Environment& environment = *work.scope.environment;
    const PixelRect whole = scratch.geometry.whole();
    const ImageSize size = work.view->spec->size;
    fill(canvas.color, size, pixel_of(environment.background * environment.exposure));
    fill(canvas.depth, size, 0.0f);
    const std::span<const PixelRect> everywhere(&whole, 1);
    scratch.blended.clear();
    for (const SoftwareItem& item : statics_.items()) {
        auto draw = work.scope.draw_of(item);
        if (!draw) continue;
        draw->is_static = true;
        if (is_blended(item)) {
            scratch.blended.push_back(*draw);
        } else {
            add(work, scratch, *draw);
        }
    }
    if (work.layer != nullptr) {
        draw_opaque(scratch, canvas, everywhere, bands);
        keep(work, scratch);
    }
    for (const ViewDraw& draw : work.movers) add(work, scratch, draw);
    draw_opaque(scratch, canvas, everywhere, bands);
    scratch.blended.insert(scratch.blended.end(), work.blended.begin(), work.blended.end());
    draw_blended(work, scratch, scratch.blended, everywhere, bands);
    if (!work.is_in_frame) copy(canvas.color, rows_of(*work.frame), whole);
}

void SoftwareDrawer::keep(ViewWork& work, Scratch& scratch) {
    const Canvas& canvas = work.canvas;
    const PixelRect whole = scratch.geometry.whole();
    const ImageSize size = work.view->spec->size;
    const bool has_blended = !scratch.blended.empty();
    const std::int64_t bytes = (has_blended ? 3 : 2) * Plane<float>::bytes_for(size);
    Layer& layer = *work.layer;
    {
        const std::lock_guard lock(layers_mutex_);
        if (!layers_.make_room(bytes)) return;
        layers_.charge(layer, bytes);
        layers_.count_kept();
        layer.number = ++layer_number_;
    }
    layer.color = Plane<std::uint32_t>(size);
    layer.depth = Plane<float>(size);
    copy(canvas.color, layer.color.rows(), whole);
    copy(canvas.depth, layer.depth.rows(), whole);
    if (!has_blended) return;
    std::vector<ViewDraw> blended = scratch.blended;
    draw_blended(work, scratch, blended, {&whole, 1}, 1);
    layer.finished = Plane<std::uint32_t>(size);
    copy(canvas.color, layer.finished.rows(), whole);
    copy(layer.color.rows(), canvas.color, whole);
}

void SoftwareDrawer::forget(CameraId camera) {
    histories_.erase(camera);
    layers_.forget(camera);
}

RenderCounters SoftwareDrawer::counters() const {
    RenderCounters counters = layers_.counters();
    counters.views = views_;
    counters.views_in_parts = views_in_parts_;
    counters.meshes_skinned = meshes_skinned_ + movers_.made();
    counters.meshes_unseen = meshes_unseen_ + movers_.unseen();
    counters.draws = draws_;
    counters.draws_coarse = draws_coarse_;
    return counters;
}

}  // namespace camrig

#include "core/render/software/software_drawer.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "core/base/clock.h"
#include "core/frame/tone.h"
#include "core/render/software/view_rows.h"
#include "core/render/view_frames.h"

namespace camrig {
namespace {

/// Vertices are snapped to 1/256 pixel in 32 bits (geometry.h).
constexpr int max_side = 16384;
/// Of what moves in one view; more are joined.
constexpr std::size_t max_rects = 16;

/// Never the same twice, whatever drawer asks.
std::uint64_t next_mark() {
    static std::atomic<std::uint64_t> last = 0;
    return ++last;
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

/// Adds the CPU time of a piece of work.
class CpuMeter {
public:
    explicit CpuMeter(std::atomic<TimeNs>& sum_ns) : sum_ns_(sum_ns), start_ns_(thread_cpu_ns()) {}
    ~CpuMeter() { sum_ns_ += thread_cpu_ns() - start_ns_; }
    CpuMeter(const CpuMeter&) = delete;
    CpuMeter& operator=(const CpuMeter&) = delete;

private:
    std::atomic<TimeNs>& sum_ns_;
    TimeNs start_ns_;
};

bool is_blended(const SoftwareItem& item) {
    return item.primitive->material->alpha_mode == AlphaMode::blend;
}

bool touches(std::span<const PixelRect> rects, const ViewTransform& transform, const ViewDraw& draw) {
    const Box& box = draw.item->bounds;
    const auto bounds = screen_bounds(transform, draw.optical_from_local, box.min, box.max);
    return bounds && std::ranges::any_of(rects, [&](const PixelRect& rect) { return rect.intersects(*bounds); });
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
                const SoftwareItem& item = *draw.item;
                if (item.deformation < 0) continue;
                const LevelSet levels = movers_.deformed(item).missing(LevelSet{1} << draw.level_number());
                if (levels == 0) continue;
                const auto found = std::ranges::find(unmade_, &item, &Unmade::item);
                if (found == unmade_.end()) {
                    unmade_.push_back({&item, levels});
                } else {
                    found->levels |= levels;
                }
            }
        }
    }
    team_.run(unmade_.size(), [&](int, std::size_t i) { movers_.deform(*unmade_[i].item, unmade_[i].levels); });
}

void SoftwareDrawer::draw(std::span<const View* const> views, TimeNs monotonic_ns, std::vector<FrameRef>& frames) {
    cost_ns_.clear();
    while (works_.size() < views.size()) works_.emplace_back();
    in_work_.clear();
    for (std::size_t i = 0; i < views.size(); ++i) {
        works_[i].cost_ns = 0;
        const CpuMeter meter(works_[i].cost_ns);
        prepare(*views[i], works_[i]);
        in_work_.push_back(&works_[i]);
    }
    deform_seen(in_work_);
    const auto threads = static_cast<std::size_t>(team_.size());
    if (views.size() >= threads) {
        team_.run(views.size(), [&](int worker, std::size_t i) {
            ViewWork& work = *in_work_[i];
            const CpuMeter meter(work.cost_ns);
            ViewScratch& scratch = scratch_[static_cast<std::size_t>(worker)];
            begin_view(work, scratch, 1, monotonic_ns);
            draw_rows(work, scratch, work.whole);
            end_band(work);
        });
    } else {
        // Fewer views than threads: each in bands of its rows.
        team_.run(views.size(), [&](int, std::size_t i) {
            const CpuMeter meter(in_work_[i]->cost_ns);
            begin_view(*in_work_[i], scratch_[i], team_.size(), monotonic_ns);
        });
        team_.run(views.size() * threads, [&](int, std::size_t i) {
            ViewWork& work = *in_work_[i / threads];
            const CpuMeter meter(work.cost_ns);
            draw_rows(work, scratch_[i / threads], band_of(work, static_cast<int>(i % threads), team_.size()));
            end_band(work);
        });
    }
    for (ViewWork* work : in_work_) {
        frames.push_back(std::move(work->frame));
        cost_ns_.push_back(work->cost_ns);
        ++views_;
        views_in_parts_ += work->is_in_parts;
        draws_ += work->draws;
        draws_coarse_ += work->draws_coarse;
        if (work->is_in_parts) layers_.count_reused();
    }
}

void SoftwareDrawer::begin_view(ViewWork& work, ViewScratch& scratch, int bands, TimeNs monotonic_ns) {
    const View& view = *work.view;
    const ImageSize size = view.spec->size;
    work.whole = {0, 0, size.width, size.height};
    work.bands_left = bands;
    work.is_in_frame = size.width % lane_count == 0;
    scratch.numbers.fit(size);
    scratch.depth.fit(size);
    if (!work.is_in_frame) scratch.color.fit(size);
    work.frame =
        acquire_frame(*options_.pool, view, FrameKind::color, PixelFormat::rgba8, snapshot_->world_ns, monotonic_ns);
    work.canvas = {work.is_in_frame ? rows_of(*work.frame) : scratch.color.rows(), scratch.depth.rows()};
    work.is_in_parts = work.layer != nullptr && work.layer->number != 0;
    if (work.is_in_parts) {
        find_changes(work);
    } else {
        work.rects.assign(1, work.whole);
    }
    add_triangles(work, scratch);
    if (work.layer != nullptr && !work.is_in_parts) make_layer(work, !scratch.blended_statics.empty());
    // Nobody keeps the statics alone: what movers hide of them is not shaded.
    if (work.layer == nullptr) scratch.movers = {0, scratch.movers.first + scratch.movers.count};
}

void SoftwareDrawer::find_changes(ViewWork& work) {
    const StaticLayer& layer = *work.layer;
    const FrameHistory& history = *work.history;
    work.rects = disjoint_cover(std::move(work.rects), max_rects);
    // The layer's key has the camera's revision in it: tone and everything else are those of the frame before.
    if (const ShownFrame& last = history.frames[history.last]; last.layer == layer.number) {
        ChangedRows rows;
        for (const PixelRect& rect : last.rects) rows.add(rect.y0, rect.y1);
        for (const PixelRect& rect : work.rects) rows.add(rect.y0, rect.y1);
        work.frame->mark_changes(history.sequence, rows);
    }
    const std::uint64_t held = work.frame->held_before();
    const auto found = std::ranges::find_if(history.frames, [&](const ShownFrame& shown) {
        return held != 0 && shown.mark == held && shown.layer == layer.number;
    });
    work.stale = found == history.frames.end() ? std::span<const PixelRect>(&work.whole, 1) : std::span(found->rects);
}

void SoftwareDrawer::add_triangles(ViewWork& work, ViewScratch& scratch) {
    const auto add = [&](const ViewDraw& draw) -> const ViewDraw& {
        ++work.draws;
        work.draws_coarse += draw.level->error > 0.0f;
        return scratch.geometry.add(draw, draw.is_static ? statics_ : movers_);
    };
    const auto count = [&] { return static_cast<std::uint32_t>(scratch.geometry.triangles().size()); };
    const auto add_static = [&](const SoftwareItem& item) {
        auto draw = work.scope.draw_of(item);
        if (!draw) return;
        draw->is_static = true;
        if (!is_blended(item)) {
            add(*draw);
        } else if (!work.is_in_parts || touches(work.rects, work.scope.transform, *draw)) {
            scratch.blended_statics.push_back(*draw);
        }
    };
    scratch.geometry.begin_view(work.scope);
    scratch.blended_statics.clear();
    if (work.is_in_parts) {
        for (const SoftwareItem* item : blended_statics_) add_static(*item);
    } else {
        for (const SoftwareItem& item : statics_.items()) add_static(item);
    }
    scratch.statics = {0, count()};
    for (const ViewDraw& draw : work.movers) add(draw);
    scratch.movers = {scratch.statics.count, count() - scratch.statics.count};
    for (ViewDraw& draw : scratch.blended_statics) draw = add(draw);
    scratch.blended.assign(scratch.blended_statics.begin(), scratch.blended_statics.end());
    for (const ViewDraw& draw : work.blended) scratch.blended.push_back(add(draw));
    sort_by_distance(scratch.blended_statics);
    sort_by_distance(scratch.blended);
}

void SoftwareDrawer::make_layer(ViewWork& work, bool has_blended) {
    const ImageSize size = work.view->spec->size;
    const std::int64_t bytes = (has_blended ? 3 : 2) * Plane<float>::bytes_for(size);
    StaticLayer& layer = *work.layer;
    {
        const std::lock_guard lock(layers_mutex_);
        if (!layers_.make_room(bytes)) {
            work.layer = nullptr;
            return;
        }
        layers_.charge(layer, bytes);
        layers_.count_kept();
        layer.number = ++layer_number_;
    }
    layer.color = Plane<std::uint32_t>(size);
    layer.depth = Plane<float>(size);
    if (has_blended) layer.finished = Plane<std::uint32_t>(size);
}

void SoftwareDrawer::end_band(ViewWork& work) {
    if (--work.bands_left > 0) return;
    const View& view = *work.view;
    finish_color(view, *work.frame);
    FrameHistory& history = *work.history;
    history.sequence = view.sequence;
    history.last = (history.last + 1) % history.frames.size();
    ShownFrame& shown = history.frames[history.last];
    shown.mark = 0;
    shown.layer = work.is_in_parts ? work.layer->number : 0;
    shown.rects.clear();
    if (work.is_in_parts) shown.rects.assign(work.rects.begin(), work.rects.end());
    // A code strip lies in the same place in all frames of a layer, and is drawn anew.
    if (!work.is_in_parts || !changes_nothing(view.spec->controls)) return;
    shown.mark = next_mark();
    work.frame->mark_content(shown.mark);
}

void SoftwareDrawer::forget(CameraId camera) {
    histories_.erase(camera);
    layers_.forget(camera);
    // Working memory fits the largest view so far, which may have been this camera's.
    for (ViewScratch& scratch : scratch_) scratch = {};
    options_.pool->release_idle();
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

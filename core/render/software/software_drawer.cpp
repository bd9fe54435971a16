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

}  // namespace

SoftwareDrawer::SoftwareDrawer(const Options& options)
    : options_(options),
      team_(std::max(1, options.threads)),
      models_(options.models.software != nullptr ? options.models : make_shared_models()),
      scene_(models_.prepared),
      layers_(options.static_layer_bytes) {
    while (scratch_.size() < static_cast<std::size_t>(team_.size())) scratch_.emplace_back();
}

void SoftwareDrawer::begin_instant(const SnapshotRef& snapshot) {
    layers_.next_instant();
    const std::uint64_t statics_before = scene_.statics_number();
    scene_.place(snapshot);
    find_primitives(scene_.movers(), mover_primitives_);
    if (scene_.statics_number() != statics_before) find_primitives(scene_.statics(), static_primitives_);
    models_.software->evict_unused();
}

void SoftwareDrawer::find_primitives(const PlacedSurfaces& placed, std::vector<const SoftwarePrimitive*>& to) {
    to.clear();
    const PreparedModel* last = nullptr;
    const SoftwareModel* model = nullptr;
    for (const PlacedSurface& surface : placed.all()) {
        if (surface.model != last) {
            last = surface.model;
            const ModelRef& source = surface.object->model;
            model = &models_.software->of(
                source, [&](const ModelRef& made) { return make_software_model(*made, *surface.model); });
        }
        to.push_back(&model->primitives[surface.primitive->number]);
    }
}

bool SoftwareDrawer::is_plain(const View& view) {
    const CameraSpec& spec = *view.spec;
    return is_within_reach(spec.intrinsics.cx, spec.size.width) &&
           is_within_reach(spec.intrinsics.cy, spec.size.height) && view.quality != Quality::beautiful &&
           (spec.lens.model == LensModel::pinhole ? spec.lens_sampling.method == LensMethod::automatic
                                                  : spec.lens_sampling == LensSampling{}) &&
           antialias_of(spec, view.quality) == Antialias::none;
}

void SoftwareDrawer::prepare(const View& view, ViewWork& work) {
    const CameraSpec& spec = *view.spec;
    work.view = &view;
    work.scene =
        make_scene_view(scene_, make_view_transform(view.pose, spec.size, spec.intrinsics, spec.near_m, spec.far_m),
                        spec.far_m, view.quality, options_.max_detail_error_px, *lenses_.of(view));
    work.layer = layers_.layer_of(view.camera, {view.spec_revision, view.pose, view.quality, scene_.statics_number()});
    work.history = &histories_[view.camera];
    work.draws = work.draws_coarse = 0;
    work.movers.see(work.scene);
}

void SoftwareDrawer::deform_seen(std::span<ViewWork* const> works) {
    unmade_.clear();
    for (const ViewWork* work : works) {
        for (const auto* list : {&work->movers.opaque, &work->movers.blended}) {
            for (const SeenSurface& seen : *list) {
                const PlacedSurface& surface = *seen.placed;
                if (surface.deformation < 0) continue;
                const LevelSet levels = scene_.movers().deformed(surface).missing(LevelSet{1} << seen.level);
                if (levels == 0) continue;
                const auto found = std::ranges::find(unmade_, &surface, &Unmade::surface);
                if (found == unmade_.end()) {
                    unmade_.push_back({&surface, levels});
                } else {
                    found->levels |= levels;
                }
            }
        }
    }
    team_.run(unmade_.size(),
              [&](int, std::size_t i) { scene_.movers().deform(*unmade_[i].surface, unmade_[i].levels); });
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
    work.frame = acquire_frame(*options_.pool, view, FrameKind::color, PixelFormat::rgba8, scene_.snapshot()->world_ns,
                               monotonic_ns);
    work.canvas = {work.is_in_frame ? rows_of(*work.frame) : scratch.color.rows(), scratch.depth.rows()};
    work.is_in_parts = work.layer != nullptr && work.layer->number != 0;
    if (work.is_in_parts) {
        find_changes(work);
    } else {
        work.rects.assign(1, work.whole);
        work.history->picture.next(view.sequence, 0, {});
    }
    add_triangles(work, scratch);
    if (work.layer != nullptr && !work.is_in_parts) make_layer(work, !scratch.blended_statics.empty());
    // Nobody keeps the statics alone: what movers hide of them is not shaded.
    if (work.layer == nullptr) scratch.movers = {0, scratch.movers.first + scratch.movers.count};
}

void SoftwareDrawer::find_changes(ViewWork& work) {
    const StaticLayer& layer = *work.layer;
    const FrameHistory& history = *work.history;
    work.rects.swap(work.movers.rects);
    work.rects = disjoint_cover(std::move(work.rects), max_rects);
    ChangedRows rows;
    for (const PixelRect& rect : work.rects) rows.add(rect.y0, rect.y1);
    const auto change = work.history->picture.next(work.view->sequence, layer.number, rows);
    if (change.same_as >= 0) work.frame->mark_changes(change.same_as, change.rows);
    const std::uint64_t held = work.frame->held_before();
    const auto found = std::ranges::find_if(history.frames, [&](const ShownFrame& shown) {
        return held != 0 && shown.mark == held && shown.layer == layer.number;
    });
    work.stale = found == history.frames.end() ? std::span<const PixelRect>(&work.whole, 1) : std::span(found->rects);
}

void SoftwareDrawer::add_triangles(ViewWork& work, ViewScratch& scratch) {
    const auto add = [&](const SeenSurface& seen) -> const ViewDraw& {
        ++work.draws;
        work.draws_coarse += seen.level > 0;
        const auto& primitives = seen.is_static ? static_primitives_ : mover_primitives_;
        return scratch.geometry.add(seen, *primitives[seen.placed->index]);
    };
    const auto count = [&] { return static_cast<std::uint32_t>(scratch.geometry.triangles().size()); };
    scratch.geometry.begin_view(work.scene, options_.wide_lanes);
    scratch.opaque.clear();
    scratch.blending.clear();
    work.scene.see_all(true, work.is_in_parts ? nullptr : &scratch.opaque, &scratch.blending);
    if (work.is_in_parts)
        std::erase_if(scratch.blending, [&](const SeenSurface& seen) { return !work.scene.touches(seen, work.rects); });
    for (const SeenSurface& seen : scratch.opaque) add(seen);
    scratch.statics = {0, count()};
    for (const SeenSurface& seen : work.movers.opaque) add(seen);
    scratch.movers = {scratch.statics.count, count() - scratch.statics.count};
    scratch.blended_statics.clear();
    for (const SeenSurface& seen : scratch.blending) scratch.blended_statics.push_back(add(seen));
    scratch.blended.assign(scratch.blended_statics.begin(), scratch.blended_statics.end());
    for (const SeenSurface& seen : work.movers.blended) scratch.blended.push_back(add(seen));
    sort_far_to_near(scratch.blended_statics);
    sort_far_to_near(scratch.blended);
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
    lenses_.forget(camera);
    layers_.forget(camera);
    // Working memory fits the largest view so far, which may have been this camera's.
    for (ViewScratch& scratch : scratch_) scratch = {};
    options_.pool->release_idle();
}

RenderCounters SoftwareDrawer::counters() const {
    RenderCounters counters = layers_.counters();
    counters.views = views_;
    counters.views_in_parts = views_in_parts_;
    counters.meshes_skinned = scene_.meshes_made();
    counters.meshes_unseen = scene_.meshes_unseen();
    counters.draws = draws_;
    counters.draws_coarse = draws_coarse_;
    return counters;
}

}  // namespace camrig

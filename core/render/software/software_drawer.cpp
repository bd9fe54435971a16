#include "core/render/software/software_drawer.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include "core/base/cpu_meter.h"
#include "core/render/software/taken_picture.h"
#include "core/render/software/view_changes.h"
#include "core/render/software/view_rows.h"
#include "core/render/view_frames.h"

namespace camrig::render::software {
SoftwareDrawer::SoftwareDrawer(const Options& options)
    : options_(options),
      team_(std::max(1, options.threads)),
      caches_(options.caches.software != nullptr ? options.caches : make_shared_caches()),
      scene_(caches_.prepared),
      ahead_(caches_.prepared),
      layers_(options.static_layer_bytes, caches_.layers) {
    while (scratch_.size() < static_cast<std::size_t>(team_.size())) scratch_.emplace_back();
}

void SoftwareDrawer::begin_instant(const world::SnapshotRef& snapshot) {
    layers_.next_instant();
    ++instant_;
    instant_ns_ = snapshot->world_ns;
    asked_.next_instant();
    place(snapshot);
    caches_.software->evict_unused();
}

void SoftwareDrawer::place(const world::SnapshotRef& snapshot) {
    const std::uint64_t statics_before = scene_.statics_number();
    scene_.place(snapshot);
    find_primitives(scene_.movers(), mover_primitives_);
    if (scene_.statics_number() != statics_before) find_primitives(scene_.statics(), static_primitives_);
}

void SoftwareDrawer::find_primitives(const scene::PlacedSurfaces& placed, std::vector<const SoftwarePrimitive*>& to) {
    to.clear();
    const scene::PreparedModel* last = nullptr;
    const SoftwareModel* model = nullptr;
    for (const scene::PlacedSurface& surface : placed.all()) {
        if (surface.model != last) {
            last = surface.model;
            const world::ModelRef& source = *surface.source;
            model = &caches_.software->of(
                source, [&](const world::ModelRef& made) { return make_software_model(*made, *surface.model); });
        }
        to.push_back(&model->primitives[surface.primitive->number]);
    }
}

void SoftwareDrawer::deform_seen(std::span<ViewWork* const> works) {
    unmade_.clear();
    unmade_levels_.assign(scene_.movers().all().size(), 0);
    for (const ViewWork* work : works) {
        for (const auto* list : {&work->movers.opaque, &work->movers.blended}) {
            for (const scene::SeenSurface& seen : *list) {
                const scene::PlacedSurface& surface = *seen.placed;
                if (surface.deformation < 0 || (work->is_moment && !work->scene.touches(seen, work->rects))) continue;
                const scene::LevelSet levels =
                    scene_.movers().deformed(surface).missing(scene::LevelSet{1} << seen.level);
                if (levels == 0) continue;
                if (unmade_levels_[surface.index] == 0) unmade_.push_back(&surface);
                unmade_levels_[surface.index] |= levels;
            }
        }
    }
    team_.run(unmade_.size(),
              [&](int, std::size_t i) { scene_.movers().deform(*unmade_[i], unmade_levels_[unmade_[i]->index]); });
}

void SoftwareDrawer::draw(std::span<const View* const> views, TimeNs monotonic_ns,
                          std::vector<frame::FrameRef>& frames) {
    cost_ns_.clear();
    while (works_.size() < views.size()) works_.emplace_back();
    in_work_.clear();
    exposed_.clear();
    flows_.clear();
    // What shadows fall on is known before the first layer is looked for.
    for (const View* view : views) scene_.proxies_of(view->spec->backdrop_here);
    for (std::size_t i = 0; i < views.size(); ++i) {
        works_[i].cost_ns = 0;
        const CpuMeter meter(works_[i].cost_ns);
        works_[i].kinds = kinds_to_draw(*views[i], works_[i]);
        if (works_[i].kinds.none() && !works_[i].wants_flow) continue;
        prepare(*views[i], works_[i]);
        if (works_[i].motion) {
            works_[i].kinds.set(index_of(frame::FrameKind::flow), works_[i].wants_flow);
            exposed_.push_back(&works_[i]);
            continue;
        }
        if (works_[i].kinds.any()) in_work_.push_back(&works_[i]);
        if (works_[i].wants_flow) flows_.push_back(&works_[i]);
    }
    const std::size_t plain = in_work_.size();
    in_work_.insert(in_work_.end(), exposed_.begin(), exposed_.end());
    make_shadows(in_work_);
    in_work_.resize(plain);
    deform_seen(in_work_);
    const auto threads = static_cast<std::size_t>(team_.size());
    if (in_work_.size() >= threads) {
        team_.run(in_work_.size(), [&](int worker, std::size_t i) {
            ViewWork& work = *in_work_[i];
            const CpuMeter meter(work.cost_ns);
            ViewScratch& scratch = scratch_[static_cast<std::size_t>(worker)];
            begin_view(work, scratch, 1, monotonic_ns);
            for (int pass = 0; pass < passes_of(work); ++pass) draw_rows(work, scratch, pass, 0, 1);
            end_band(work, scratch);
        });
    } else {
        // Fewer views than threads: each in bands of its rows.
        team_.run(in_work_.size(), [&](int, std::size_t i) {
            const CpuMeter meter(in_work_[i]->cost_ns);
            begin_view(*in_work_[i], scratch_[i], team_.size(), monotonic_ns);
        });
        int passes = 0;
        for (const ViewWork* work : in_work_) passes = std::max(passes, passes_of(*work));
        for (int pass = 0; pass < passes; ++pass) {
            team_.run(in_work_.size() * threads, [&](int, std::size_t i) {
                ViewWork& work = *in_work_[i / threads];
                if (pass >= passes_of(work)) return;
                const CpuMeter meter(work.cost_ns);
                draw_rows(work, scratch_[i / threads], pass, static_cast<int>(i % threads), team_.size());
                if (pass + 1 == passes_of(work)) end_band(work, scratch_[i / threads]);
            });
        }
    }
    for (ViewWork* const work : flows_) draw_flow(*work, monotonic_ns);
    draw_exposed(monotonic_ns);
    for (const ViewWork* work : in_work_) {
        views_in_parts_ += work->is_in_parts;
        draws_ += work->draws;
        draws_coarse_ += work->draws_coarse;
        if (work->is_in_parts) layers_.count_reused();
    }
    draws_ += std::exchange(moment_.draws, 0);
    draws_coarse_ += std::exchange(moment_.draws_coarse, 0);
    for (std::size_t i = 0; i < views.size(); ++i) {
        views_ += works_[i].kinds.any();
        give_frames(works_[i], *views[i], frames);
        cost_ns_.push_back(works_[i].cost_ns);
    }
}

void SoftwareDrawer::give_frames(ViewWork& work, const View& view, std::vector<frame::FrameRef>& frames) {
    for (std::size_t k = 0; k < work.kinds.size(); ++k) {
        frame::FrameRef frame;
        if (work.kinds[k]) frame = std::move(k == 0 ? work.frame : work.channels[k].frame);
        if (work.asked != nullptr && k != index_of(frame::FrameKind::flow)) {
            if (frame != nullptr) work.asked->frames[k] = frame;
            frame = work.asked->frames[k];
        }
        if (view.kinds[k] && frame != nullptr) frames.push_back(std::move(frame));
    }
}

void SoftwareDrawer::make_shadows(std::span<ViewWork* const> works) {
    std::atomic<TimeNs> cost_ns = 0;
    if (bodies_instant_ != instant_) moving_bodies_ = scene_.movers().bodies();
    bodies_instant_ = instant_;
    const auto looks_at_shadows = [](const ViewWork* work) {
        const auto& backdrop = work->view->spec->backdrop;
        return work->scene.quality == world::Quality::beautiful &&
               (!backdrop || backdrop->shadow == world::BackdropShadow::mapped);
    };
    for (ViewWork* const work : works) {
        work->shadows.clear();
        find_bodies(*work);
        if (!looks_at_shadows(work)) continue;
        if (shadows_instant_ != instant_)
            shadows_.update(scene_, {static_primitives_, mover_primitives_}, team_, cost_ns, options_.wide_lanes,
                            options_.max_detail_error_px > 0.0);
        shadows_instant_ = instant_;
        if (shadows_.empty()) continue;
        work->shadows = shadows_.in_view(work->scene.transform);
    }
    if (cost_ns == 0) return;
    const TimeNs share_ns = cost_ns / std::ranges::count_if(works, looks_at_shadows);
    for (ViewWork* const work : works)
        if (looks_at_shadows(work)) work->cost_ns += share_ns;
}

void SoftwareDrawer::find_bodies(ViewWork& work) const {
    work.bodies.clear();
    if (work.scene.has_contact_occlusion) work.bodies.see(work.scene, scene_.statics().bodies(), moving_bodies_);
}

void SoftwareDrawer::end_band(ViewWork& work, ViewScratch& scratch) {
    if (--work.bands_left > 0) return;
    layers_.keep_what_was_drawn(work, scratch);
    if (work.takes_picture()) end_taking(work);
    if (work.frame != nullptr) finish_color(*work.view, *work.frame);
    note_shown(work);
}

void SoftwareDrawer::forget(CameraId camera) {
    caches_.lenses->forget(camera);
    layers_.forget(camera);
    forget_here(camera);
}

void SoftwareDrawer::hand_over(CameraId camera) {
    layers_.hand_over(camera, scene_);
    forget_here(camera);
}

void SoftwareDrawer::forget_here(CameraId camera) {
    histories_.erase(camera);
    asked_.forget(camera);
    // Working memory fits the largest view so far, which may have been this camera's.
    for (ViewScratch& scratch : scratch_) scratch = {};
    exposure_scratch_ = {};
    options_.pool->release_idle();
}

void SoftwareDrawer::clear() {
    works_.clear();
    exposed_.clear();
    flows_.clear();
    ahead_.clear();
    exposure_scratch_ = {};
    in_work_.clear();
    unmade_.clear();
    for (ViewScratch& scratch : scratch_) scratch = {};
    histories_.clear();
    asked_.clear();
    layers_.clear();
    shadows_ = {};
    shadows_instant_ = 0;
    static_primitives_.clear();
    mover_primitives_.clear();
    scene_.clear();
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

}  // namespace camrig::render::software

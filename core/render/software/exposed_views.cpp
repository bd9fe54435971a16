#include <algorithm>
#include <functional>

#include "core/base/cpu_meter.h"
#include "core/render/aperture.h"
#include "core/render/moments.h"
#include "core/render/software/channels.h"
#include "core/render/software/rows.h"
#include "core/render/software/software_drawer.h"
#include "core/render/software/taken_picture.h"
#include "core/render/view_frames.h"

namespace camrig::render::software {

bool SoftwareDrawer::is_exposed(const View& view) const {
    const auto exposure = exposure_of(view, *scene_.snapshot());
    return exposure && *exposure && motion_of(view, (*exposure)->times);
}

void SoftwareDrawer::draw_exposed(TimeNs monotonic_ns) {
    if (exposed_.empty()) return;
    const world::SnapshotRef instant = scene_.snapshot();
    for (ViewWork* const work : exposed_) {
        const CpuMeter meter(work->cost_ns);
        draw_exposed(*work, monotonic_ns);
    }
    place(instant);
}

void SoftwareDrawer::draw_exposed(ViewWork& work, TimeNs monotonic_ns) {
    const ImageSize size = work.view->spec->size;
    work.whole = {0, 0, size.width, size.height};
    work.rects.assign(1, work.whole);
    work.bands_left = 1;
    work.is_in_parts = work.has_areas = false;
    work.is_in_frame = true;
    acquire_frames(work, monotonic_ns);
    const Spread spread = spread_of(work, monotonic_ns);
    if (work.takes_picture()) {
        begin_taking(work, exposure_scratch_.sum, exposure_scratch_.numbers);
        work.history->picture.next(work.view->sequence, {});
        sum_light(work, spread);
        if (work.motion->flicker_hz.empty()) layers_.keep_sites(work);
        in_bands(work, work.whole, [&](int, const PixelRect& band) { expose_rows(work, band); });
        in_bands(work, work.whole, [&](int, const PixelRect& band) { develop_rows(work, band); });
    }
    if (std::ranges::any_of(channel_kinds,
                            [&](frame::FrameKind kind) { return work.channels[index_of(kind)].frame != nullptr; }))
        draw_moment_channels(work, spread.moved.most);
    work.layer = nullptr;
    end_band(work, scratch_[0]);
    work.cost_ns += moment_.cost_ns.exchange(0);
}

void SoftwareDrawer::in_bands(ViewWork& work, const PixelRect& rows,
                              const std::function<void(int, const PixelRect&)>& draw) {
    const int bands = team_.size();
    team_.run(static_cast<std::size_t>(bands), [&](int worker, std::size_t number) {
        // The first worker is the one that asks, whose time counts as a whole.
        std::atomic<TimeNs> counted = 0;
        const CpuMeter meter(worker == 0 ? counted : work.cost_ns);
        const int i = static_cast<int>(number);
        const PixelRect band{rows.x0, rows.y0 + rows.height() * i / bands, rows.x1,
                             rows.y0 + rows.height() * (i + 1) / bands};
        draw(i, band);
    });
}

void SoftwareDrawer::begin_moment(const ViewWork& work, const world::CameraPast::Moment& at, double lamps_hz,
                                  glm::dvec2 point) {
    place(at.snapshot);
    moment_view_ = view_at(*work.view, at.state);
    if (point != glm::dvec2(0.0)) moment_view_ = seen_from(moment_view_, *aperture_of(*moment_view_.spec), point);
    const bool is_shaded = work.kinds[index_of(frame::FrameKind::color)];
    ViewWork& moment = moment_;
    moment.view = &moment_view_;
    moment.backdrop = work.backdrop;
    moment.picture = work.picture;
    moment.film_frame = work.film_frame;
    moment.proxies = work.proxies;
    moment.whole = work.whole;
    moment.scene = scene_view_of(moment_view_, is_shaded ? moment_view_.quality : world::Quality::simple);
    moment.scene.lamps_hz = lamps_hz;
    moment.rays = lens_of(moment_view_)->rays;
    moment.channels = {};
    moment.shadows.clear();
    if (moment.scene.quality == world::Quality::beautiful && !shadows_.empty())
        moment.shadows = shadows_.in_view(moment.scene.transform);
    // As shadows, they stay where they are while a picture is taken.
    find_bodies(moment);
    moment.movers.see(moment.scene);
    ViewScratch& scratch = scratch_[0];
    scratch.numbers.fit(work.view->spec->size);
    scratch.depth.fit(work.view->spec->size);
    moment.canvas = {{}, scratch.depth.rows(), {}};
    moment.ahead = nullptr;
    moment.layer = nullptr;
    moment.stale = {};
    moment.is_moment = true;
    moment.is_light = moment.has_areas = moment.is_in_parts = moment.is_in_frame = false;
}

SoftwareDrawer::Spread SoftwareDrawer::spread_of(ViewWork& work, TimeNs monotonic_ns) {
    const View& view = *work.view;
    const auto aperture = aperture_of(*view.spec);
    if (!needs_depth(*work.motion) && !aperture) return {.moved = moved_pixels(*work.motion, view, nullptr)};
    begin_moment(work, work.motion->moments[1], 0.0);
    auto& depth = moment_.channels[index_of(frame::FrameKind::depth)].frame;
    depth = acquire_frame(*options_.pool, view, frame::FrameKind::depth, frame::PixelFormat::depth32f,
                          work.exposure->times.end_ns(), monotonic_ns);
    draw_moment_rows_of_channels(work.whole);
    const Spread spread{moved_pixels(*work.motion, view, depth.get()),
                        aperture ? largest_disc_px(*aperture, *moment_view_.spec, *depth) : 0.0};
    moment_.channels = {};
    return spread;
}

void SoftwareDrawer::draw_moment_rows_of_channels(const PixelRect& rows) {
    ViewScratch& scratch = scratch_[0];
    moment_.rects.assign(1, rows);
    deform_seen(std::vector<ViewWork*>{&moment_});
    add_triangles(moment_, scratch);
    name_draws(scratch);
    if (moment_.ahead != nullptr) moment_.ahead->follow(scratch.geometry.draws());
    scratch.movers = {0, scratch.movers.first + scratch.movers.count};
    in_bands(moment_, rows, [&](int, const PixelRect& band) { draw_channel_rows(moment_, scratch, band); });
}

void SoftwareDrawer::draw_moment_channels(ViewWork& work, double moved_px) {
    const Moments moments(work.motion->times.middles(), moved_px);
    for (int cell = 0; cell < moments.count(); ++cell) {
        const auto [first, end] = moments.rows(cell);
        if (first >= end) continue;
        begin_moment(work, work.moment_at(moments.time(cell)), 0.0);
        moment_.channels = work.channels;
        if (work.wants_flow) look_ahead(work, moments.time(cell));
        draw_moment_rows_of_channels({0, first, work.whole.x1, end});
    }
    moment_.channels = {};
}

void SoftwareDrawer::look_ahead(const ViewWork& work, TimeNs moment_ns) {
    const View& view = *work.view;
    world::CameraPast::Moment then = view.future->at(moment_ns + view.frame_ns);
    // As view_at().
    if (view.spec->lens.model != camera::LensModel::pinhole)
        then.state.intrinsics = view.future->at(instant_ns_ + view.frame_ns).state.intrinsics;
    ahead_.begin(scene_, *moment_view_.spec, moment_.scene.transform, then);
    moment_.ahead = &ahead_;
}

void SoftwareDrawer::draw_flow(ViewWork& work, TimeNs monotonic_ns) {
    const CpuMeter meter(work.cost_ns);
    const View& view = *work.view;
    work.whole = {0, 0, view.spec->size.width, view.spec->size.height};
    auto& flow = work.channels[index_of(frame::FrameKind::flow)].frame;
    flow = acquire_frame(*options_.pool, view, frame::FrameKind::flow, frame::PixelFormat::flow32f, instant_ns_,
                         monotonic_ns, work.exposure);
    const world::SnapshotRef instant = scene_.snapshot();
    camera::CameraState state;
    state.pose = view.pose;
    state.intrinsics = view.spec->intrinsics;
    begin_moment(work, {instant, state}, 0.0);
    moment_.channels[index_of(frame::FrameKind::flow)].frame = flow;
    look_ahead(work, instant_ns_);
    draw_moment_rows_of_channels(work.whole);
    moment_.channels = {};
    work.cost_ns += moment_.cost_ns.exchange(0);
    work.kinds.set(index_of(frame::FrameKind::flow));
}

}  // namespace camrig::render::software

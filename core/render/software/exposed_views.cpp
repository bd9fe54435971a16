#include <algorithm>
#include <functional>

#include "core/base/cpu_meter.h"
#include "core/render/aperture.h"
#include "core/render/moments.h"
#include "core/render/software/channels.h"
#include "core/render/software/rows.h"
#include "core/render/software/software_drawer.h"
#include "core/render/software/taken_picture.h"
#include "core/render/software/view_rows.h"
#include "core/render/view_frames.h"

namespace camrig::render::software {
namespace {

constexpr std::size_t max_moving_rects = 16;
/// Pixels of areas look at so many pixels beside theirs.
constexpr int area_margin = 2;

/// to += weight of the row * (from - minus), in a rectangle.
void add(const LightRows& to, const LightRows& from, const LightRows& minus, const PixelRect& rect,
         std::span<const float> weights) {
    const auto add_plane = [&](Rows<float> sum, Rows<float> light, Rows<float> less) {
        for (int y = rect.y0; y < rect.y1; ++y) {
            const float weight = weights[static_cast<std::size_t>(y)];
            if (weight == 0.0f) continue;
            float* const row = sum(y);
            const float* const a = light(y);
            if (less.data == nullptr) {
                for (int x = rect.x0; x < rect.x1; ++x) row[x] += weight * a[x];
            } else {
                const float* const b = less(y);
                for (int x = rect.x0; x < rect.x1; ++x) row[x] += weight * (a[x] - b[x]);
            }
        }
    };
    add_plane(to.red, from.red, minus.red);
    add_plane(to.green, from.green, minus.green);
    add_plane(to.blue, from.blue, minus.blue);
}

/// How much of each row's light comes of a cell, with lamps of no frequency (0) or of one at their peak.
class RowShares {
public:
    RowShares(const ViewMotion& motion, const Moments& moments) : motion_(motion), moments_(moments) {}

    float of(int cell, int row, std::size_t lamps) const {
        const float weight = moments_.weight(cell, row);
        if (motion_.flicker_hz.empty() || weight == 0.0f) return lamps == 0 ? weight : 0.0f;
        auto [begin_ns, end_ns] = moments_.shared(cell, row);
        if (begin_ns >= end_ns) {
            begin_ns = motion_.times.begin_ns + row * motion_.times.row_ns;
            end_ns = begin_ns + motion_.times.exposure_ns;
        }
        if (lamps > 0) return weight * static_cast<float>(mean_sine(motion_.flicker_hz[lamps - 1], begin_ns, end_ns));
        double rest = 1.0;
        for (const double hz : motion_.flicker_hz) rest -= mean_sine(hz, begin_ns, end_ns);
        return weight * static_cast<float>(rest);
    }

private:
    const ViewMotion& motion_;
    const Moments& moments_;
};

/// Each row as if it counted in the middle of its exposure alone.
sensor::RowTimes middles_of(const sensor::RowTimes& times) {
    return {.begin_ns = times.middle_ns(0), .exposure_ns = 0, .row_ns = times.row_ns, .rows = times.rows};
}

world::CameraPast::Moment moment_at(const ViewWork& work, TimeNs world_ns) {
    return work.view->past ? work.view->past->at(world_ns) : work.motion->moments[1];
}

/// Disjoint, as these are.
std::vector<PixelRect> with_margin(std::vector<PixelRect> rects, const PixelRect& whole) {
    for (PixelRect& rect : rects)
        rect =
            common({rect.x0 - area_margin, rect.y0 - area_margin, rect.x1 + area_margin, rect.y1 + area_margin}, whole);
    return disjoint_cover(std::move(rects), max_moving_rects);
}

bool is_moving(const ViewMotion& motion, const scene::SeenSurface& seen) {
    return std::ranges::binary_search(motion.moving, seen.placed->object->id);
}

}  // namespace

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
        in_bands(work, work.whole, [&](int, const PixelRect& band) { expose_rows(work, band); });
        in_bands(work, work.whole, [&](int, const PixelRect& band) { develop_rows(work, band); });
    }
    if (std::ranges::any_of(channel_kinds, [&](frame::FrameKind kind) {
            return work.channels[static_cast<std::size_t>(kind)].frame != nullptr;
        }))
        draw_moment_channels(work, spread.moved_px);
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
    const bool is_shaded = work.kinds[static_cast<std::size_t>(frame::FrameKind::color)];
    ViewWork& moment = moment_;
    moment.view = &moment_view_;
    moment.whole = work.whole;
    moment.scene = scene_view_of(moment_view_, is_shaded ? moment_view_.quality : world::Quality::simple);
    moment.scene.lamps_hz = lamps_hz;
    moment.rays = lens_of(moment_view_)->rays;
    moment.channels = {};
    moment.shadows.clear();
    if (moment.scene.quality == world::Quality::beautiful && !shadows_.empty())
        moment.shadows = shadows_.in_view(moment.scene.transform);
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
    if (!needs_depth(*work.motion) && !aperture) return {.moved_px = moved_px(*work.motion, view, nullptr)};
    begin_moment(work, work.motion->moments[1], 0.0);
    auto& depth = moment_.channels[static_cast<std::size_t>(frame::FrameKind::depth)].frame;
    depth = acquire_frame(*options_.pool, view, frame::FrameKind::depth, frame::PixelFormat::depth32f,
                          work.exposure->times.end_ns(), monotonic_ns);
    draw_moment_rows_of_channels(work.whole);
    const Spread spread{moved_px(*work.motion, view, depth.get()),
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
    const Moments moments(middles_of(work.motion->times), moved_px);
    for (int cell = 0; cell < moments.count(); ++cell) {
        const auto [first, end] = moments.rows(cell);
        if (first >= end) continue;
        begin_moment(work, moment_at(work, moments.time(cell)), 0.0);
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
    auto& flow = work.channels[static_cast<std::size_t>(frame::FrameKind::flow)].frame;
    flow = acquire_frame(*options_.pool, view, frame::FrameKind::flow, frame::PixelFormat::flow32f, instant_ns_,
                         monotonic_ns, work.exposure);
    const world::SnapshotRef instant = scene_.snapshot();
    camera::CameraState state;
    state.pose = view.pose;
    state.intrinsics = view.spec->intrinsics;
    begin_moment(work, {instant, state}, 0.0);
    moment_.channels[static_cast<std::size_t>(frame::FrameKind::flow)].frame = flow;
    moment_.backdrop = work.backdrop;
    moment_.picture = work.picture;
    moment_.film_frame = work.film_frame;
    moment_.proxies = work.proxies;
    look_ahead(work, instant_ns_);
    draw_moment_rows_of_channels(work.whole);
    moment_.channels = {};
    moment_.backdrop = nullptr;
    moment_.picture = nullptr;
    moment_.film_frame = -1;
    moment_.proxies = nullptr;
    work.kinds.set(static_cast<std::size_t>(frame::FrameKind::flow));
}

void SoftwareDrawer::draw_moment_light(const ViewWork& work) {
    ViewScratch& scratch = scratch_[0];
    ViewWork& moment = moment_;
    moment.is_light = true;
    moment.has_areas = has_areas(*work.view);
    for (Plane<float>& plane : scratch.light) plane.fit(work.view->spec->size);
    moment.canvas.light = light_rows(scratch.light);
    moment.is_in_parts = moment.layer != nullptr && moment.layer->picture;
    deform_seen(std::vector<ViewWork*>{&moment});
    begin_drawing(moment, scratch, team_.size());
    for (int pass = 0; pass < passes_of(moment); ++pass)
        in_bands(moment, moment.whole,
                 [&](int i, const PixelRect&) { draw_rows(moment, scratch, pass, i, team_.size()); });
    keep_what_was_drawn(moment, scratch);
}

void SoftwareDrawer::draw_standing_light(ViewWork& work, bool with_moving) {
    ViewWork& moment = moment_;
    moment.is_moment = false;
    moment.layer = moment.scene.lamps_hz == 0.0 ? work.layer : nullptr;
    if (moment.layer != nullptr && moment.layer->picture) {
        find_changed_rects(moment);
        moment.stale = std::span(&work.whole, 1);
    } else {
        moment.rects.assign(1, work.whole);
    }
    for (auto* const list : {&moment.movers.opaque, &moment.movers.blended})
        std::erase_if(*list,
                      [&](const scene::SeenSurface& seen) { return !with_moving && is_moving(*work.motion, seen); });
    draw_moment_light(work);
    if (moment.scene.lamps_hz == 0.0) work.layer = moment.layer;
}

std::vector<PixelRect> SoftwareDrawer::moving_rects(const ViewWork& work, int first_row, int end_row) const {
    std::vector<PixelRect> rects;
    for (const auto* const list : {&moment_.movers.opaque, &moment_.movers.blended}) {
        for (const scene::SeenSurface& seen : *list) {
            if (!is_moving(*work.motion, seen)) continue;
            const PixelRect rect =
                common(moment_.scene.pixels_of(seen).value_or(PixelRect{}), {0, first_row, work.whole.x1, end_row});
            if (rect.width() > 0 && rect.height() > 0) rects.push_back(rect);
        }
    }
    return disjoint_cover(std::move(rects), max_moving_rects);
}

void SoftwareDrawer::sum_light(ViewWork& work, const Spread& spread) {
    const ViewMotion& motion = *work.motion;
    const bool blurs = work.view->spec->sensor->blur;
    const Moments moments(blurs ? motion.times : middles_of(motion.times), spread.moved_px);
    const RowShares shares(motion, moments);
    // The points of the opening are dealt out to the cells in turn, so that each row has all of them.
    const int cells_of_row = moments.cells_of_row();
    const int count = count_of_points(spread.disc_px);
    const int points_of_cell = count == 1 ? 1 : (count + cells_of_row - 1) / cells_of_row;
    const auto points = points_of_opening(count == 1 ? 1 : points_of_cell * cells_of_row);
    const bool stands = !motion.camera_moves && !motion.statics_change && points.size() == 1;
    const bool is_one = moments.count() == 1;
    const LightRows sum = work.canvas.light;
    std::vector<float> weights(static_cast<std::size_t>(work.whole.y1));
    const auto add_moment = [&](std::span<const PixelRect> rects, const LightRows& minus) {
        in_bands(work, {0, 0, 0, work.whole.y1}, [&](int, const PixelRect& band) {
            for (const PixelRect& rect : rects)
                add(sum, moment_.canvas.light, minus,
                    {rect.x0, std::max(rect.y0, band.y0), rect.x1, std::min(rect.y1, band.y1)}, weights);
        });
    };
    const bool flickers = !motion.flicker_hz.empty();
    if (!stands || flickers)
        for (const auto& rows : {sum.red, sum.green, sum.blue}) fill(rows, work.whole, 0.0f);
    for (std::size_t lamps = 0; lamps <= motion.flicker_hz.size(); ++lamps) {
        const double lamps_hz = lamps == 0 ? 0.0 : motion.flicker_hz[lamps - 1];
        if (stands) {
            begin_moment(work, is_one ? moment_at(work, moments.time(0)) : motion.moments[1], lamps_hz);
            draw_standing_light(work, is_one);
            std::ranges::fill(weights, 0.0f);
            for (int y = 0; y < work.whole.y1 && flickers; ++y)
                for (int cell = 0; cell < moments.count(); ++cell)
                    weights[static_cast<std::size_t>(y)] += shares.of(cell, y, lamps);
            if (flickers) {
                add_moment(std::span(&work.whole, 1), {});
            } else {
                // All shares of a row make a whole.
                in_bands(work, work.whole,
                         [&](int, const PixelRect& band) { copy_picture(moment_.canvas, work.canvas, band); });
            }
            if (is_one) continue;
            std::swap(scratch_[0].light, exposure_scratch_.standing);
        }
        for (int cell = 0; cell < moments.count(); ++cell) {
            const auto [first, end] = moments.rows(cell);
            if (first >= end) continue;
            for (int y = first; y < end; ++y)
                weights[static_cast<std::size_t>(y)] = shares.of(cell, y, lamps) / static_cast<float>(points_of_cell);
            for (int i = 0; i < points_of_cell; ++i) {
                const auto number = static_cast<std::size_t>(cell % cells_of_row + i * cells_of_row);
                begin_moment(work, moment_at(work, moments.time(cell)), lamps_hz, points[number % points.size()]);
                const std::vector<PixelRect> rects =
                    stands ? moving_rects(work, first, end) : std::vector<PixelRect>{{0, first, work.whole.x1, end}};
                if (rects.empty()) continue;
                moment_.rects = with_margin(rects, work.whole);
                moment_.layer = stands && lamps == 0 ? work.layer : nullptr;
                draw_moment_light(work);
                add_moment(rects, stands ? light_rows(exposure_scratch_.standing) : LightRows{});
            }
        }
    }
}

}  // namespace camrig::render::software

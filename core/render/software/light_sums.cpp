#include <algorithm>

#include "core/render/aperture.h"
#include "core/render/moments.h"
#include "core/render/software/rows.h"
#include "core/render/software/software_drawer.h"
#include "core/render/software/taken_picture.h"
#include "core/render/software/view_changes.h"
#include "core/render/software/view_rows.h"

/// The light of a picture that takes time: the sum of its moments.
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

/// When the rows of the picture count light, as it is summed.
sensor::RowTimes times_of(const ViewWork& work) {
    return work.view->spec->sensor->blur ? work.motion->times : work.motion->times.middles();
}

double lamps_hz_of(const ViewMotion& motion, std::size_t lamps) {
    return lamps == 0 ? 0.0 : motion.flicker_hz[lamps - 1];
}

/// Disjoint, as these are.
std::vector<PixelRect> with_margin(std::vector<PixelRect> rects, const PixelRect& whole) {
    for (PixelRect& rect : rects)
        rect =
            common({rect.x0 - area_margin, rect.y0 - area_margin, rect.x1 + area_margin, rect.y1 + area_margin}, whole);
    return disjoint_cover(std::move(rects), max_moving_rects);
}

/// Nothing lies over what stands still.
bool is_layer_alone(const ViewWork& work) {
    return work.movers.opaque.empty() && work.movers.blended.empty() && !work.movers_darken();
}

bool is_moving(const ViewMotion& motion, ObjectId id) {
    return std::ranges::binary_search(motion.moving, id);
}

/// Without what moves and is not of the group.
world::SnapshotRef with_group(const world::SnapshotRef& snapshot, const ViewMotion& motion, const MovingGroup& group) {
    if (group.movers.size() == motion.moving.size()) return snapshot;
    auto some = std::make_shared<world::Snapshot>();
    some->world_ns = snapshot->world_ns;
    some->statics = snapshot->statics;
    for (const world::Instance& mover : snapshot->movers)
        if (!is_moving(motion, mover.info->id) || std::ranges::binary_search(group.movers, mover.info->id))
            some->movers.push_back(mover);
    return some;
}

}  // namespace

void SoftwareDrawer::draw_moment_light(const LightRows& to) {
    ViewScratch& scratch = scratch_[0];
    ViewWork& moment = moment_;
    moment.is_light = true;
    moment.has_areas = has_areas(*moment.view);
    moment.canvas.light = to;
    moment.is_in_parts = moment.layer != nullptr && moment.layer->picture;
    deform_seen(std::vector<ViewWork*>{&moment});
    begin_drawing(moment, scratch, team_.size());
    for (int pass = 0; pass < passes_of(moment); ++pass)
        in_bands(moment, moment.whole,
                 [&](int i, const PixelRect&) { draw_rows(moment, scratch, pass, i, team_.size()); });
    layers_.keep_what_was_drawn(moment, scratch);
}

void SoftwareDrawer::draw_standing_light(ViewWork& work, bool with_moving, const LightRows& to) {
    ViewWork& moment = moment_;
    moment.is_moment = false;
    moment.layer = moment.scene.lamps_hz == 0.0 ? work.layer : nullptr;
    for (auto* const list : {&moment.movers.opaque, &moment.movers.blended})
        std::erase_if(*list, [&](const scene::SeenSurface& seen) {
            return !with_moving && is_moving(*work.motion, seen.placed->object->id);
        });
    if (moment.layer != nullptr && moment.layer->picture) {
        find_changed_rects(moment, shadows_);
        if (work.motion->flicker_hz.empty()) look_at_light(work, *moment.layer, moment.rects);
        moment.stale = work.has_sites ? std::span<const PixelRect>(work.new_tiles) : std::span(&work.whole, 1);
    } else {
        moment.rects.assign(1, work.whole);
    }
    draw_moment_light(to);
    if (moment.scene.lamps_hz == 0.0) work.layer = moment.layer;
}

void SoftwareDrawer::copy_in_bands(ViewWork& work, const LightRows& from, std::span<const PixelRect> rects,
                                   const LightRows& to) {
    in_bands(work, work.whole, [&](int, const PixelRect& band) {
        for (const PixelRect& rect : rects) copy_picture({{}, {}, from}, {{}, {}, to}, common(rect, band));
    });
}

LightRows SoftwareDrawer::keep_standing_light(ViewWork& work) {
    const StaticLayer* const layer = moment_.layer;
    if (layer != nullptr && layer->picture && is_layer_alone(moment_)) return layer->shown().canvas().light;
    for (Plane<float>& plane : exposure_scratch_.standing) plane.fit(work.view->spec->size);
    const LightRows kept = light_rows(exposure_scratch_.standing);
    const auto drawn = work.has_sites ? std::span<const PixelRect>(work.new_tiles) : std::span(&work.whole, 1);
    copy_in_bands(work, moment_.canvas.light, drawn, kept);
    return kept;
}

std::vector<PixelRect> SoftwareDrawer::moving_rects(const ViewWork& work, int first_row, int end_row) const {
    std::vector<PixelRect> rects;
    for (const auto* const list : {&moment_.movers.opaque, &moment_.movers.blended}) {
        for (const scene::SeenSurface& seen : *list) {
            if (!is_moving(*work.motion, seen.placed->object->id)) continue;
            const PixelRect rect =
                common(moment_.scene.pixels_of(seen).value_or(PixelRect{}), {0, first_row, work.whole.x1, end_row});
            if (rect.width() > 0 && rect.height() > 0) rects.push_back(rect);
        }
    }
    return disjoint_cover(std::move(rects), max_moving_rects);
}

void SoftwareDrawer::add_moment(ViewWork& work, std::span<const PixelRect> rects, const LightRows& minus,
                                std::span<const float> weights) {
    in_bands(work, {0, 0, 0, work.whole.y1}, [&](int, const PixelRect& band) {
        for (const PixelRect& rect : rects)
            add(work.canvas.light, moment_.canvas.light, minus,
                {rect.x0, std::max(rect.y0, band.y0), rect.x1, std::min(rect.y1, band.y1)}, weights);
    });
}

void SoftwareDrawer::add_standing(ViewWork& work, std::span<const MovingGroup> groups, std::size_t lamps) {
    const ViewMotion& motion = *work.motion;
    const Moments whole(times_of(work), 1.0);
    const bool is_one = std::ranges::all_of(
        groups, [&](const MovingGroup& group) { return Moments(times_of(work), group.moved_px).count() == 1; });
    begin_moment(work, is_one ? work.moment_at(whole.time(0)) : motion.moments[1], lamps_hz_of(motion, lamps));
    const LightRows beside = light_rows(exposure_scratch_.moment);
    if (motion.flicker_hz.empty()) {
        // All shares of a row make a whole.
        draw_standing_light(work, is_one, work.canvas.light);
    } else {
        draw_standing_light(work, is_one, beside);
        const RowShares shares(motion, whole);
        std::vector<float> weights(static_cast<std::size_t>(work.whole.y1));
        for (int y = 0; y < work.whole.y1; ++y) weights[static_cast<std::size_t>(y)] = shares.of(0, y, lamps);
        add_moment(work, std::span(&work.whole, 1), {}, weights);
    }
    if (is_one) return;
    const LightRows standing = keep_standing_light(work);
    for (const MovingGroup& group : groups) add_movers(work, group, lamps, standing);
}

void SoftwareDrawer::add_movers(ViewWork& work, const MovingGroup& group, std::size_t lamps,
                                const LightRows& standing) {
    const ViewMotion& motion = *work.motion;
    const Moments moments(times_of(work), group.moved_px);
    const RowShares shares(motion, moments);
    std::vector<float> weights(static_cast<std::size_t>(work.whole.y1));
    for (int cell = 0; cell < moments.count(); ++cell) {
        const auto [first, end] = moments.rows(cell);
        if (first >= end) continue;
        for (int y = first; y < end; ++y) weights[static_cast<std::size_t>(y)] = shares.of(cell, y, lamps);
        world::CameraPast::Moment at = work.moment_at(moments.time(cell));
        at.snapshot = with_group(at.snapshot, motion, group);
        begin_moment(work, at, lamps_hz_of(motion, lamps));
        const std::vector<PixelRect> rects = moving_rects(work, first, end);
        if (rects.empty()) continue;
        moment_.rects = with_margin(rects, work.whole);
        moment_.layer = lamps == 0 ? work.layer : nullptr;
        draw_moment_light(light_rows(exposure_scratch_.moment));
        if (work.has_sites) {
            mark_drawn(work, rects);
            const LightRows layer = work.layer->shown().canvas().light;
            copy_in_bands(work, layer, work.new_tiles, work.canvas.light);
            if (standing.red.data != layer.red.data) copy_in_bands(work, layer, work.new_tiles, standing);
        }
        add_moment(work, rects, standing, weights);
    }
}

void SoftwareDrawer::add_moments(ViewWork& work, const Spread& spread, std::size_t lamps) {
    const ViewMotion& motion = *work.motion;
    const Moments moments(times_of(work), spread.moved.most);
    const RowShares shares(motion, moments);
    // The points of the opening are dealt out to the cells in turn, so that each row has all of them.
    const int cells_of_row = moments.cells_of_row();
    const int count = count_of_points(spread.disc_px);
    const int points_of_cell = count == 1 ? 1 : (count + cells_of_row - 1) / cells_of_row;
    const auto points = points_of_opening(count == 1 ? 1 : points_of_cell * cells_of_row);
    std::vector<float> weights(static_cast<std::size_t>(work.whole.y1));
    for (int cell = 0; cell < moments.count(); ++cell) {
        const auto [first, end] = moments.rows(cell);
        if (first >= end) continue;
        for (int y = first; y < end; ++y)
            weights[static_cast<std::size_t>(y)] = shares.of(cell, y, lamps) / static_cast<float>(points_of_cell);
        for (int i = 0; i < points_of_cell; ++i) {
            const auto number = static_cast<std::size_t>(cell % cells_of_row + i * cells_of_row);
            begin_moment(work, work.moment_at(moments.time(cell)), lamps_hz_of(motion, lamps),
                         points[number % points.size()]);
            const PixelRect rows{0, first, work.whole.x1, end};
            moment_.rects = with_margin({rows}, work.whole);
            moment_.layer = nullptr;
            draw_moment_light(light_rows(exposure_scratch_.moment));
            add_moment(work, std::span(&rows, 1), {}, weights);
        }
    }
}

void SoftwareDrawer::sum_light(ViewWork& work, const Spread& spread) {
    const ViewMotion& motion = *work.motion;
    for (Plane<float>& plane : exposure_scratch_.moment) plane.fit(work.view->spec->size);
    const bool stands = !motion.camera_moves && !motion.statics_change && count_of_points(spread.disc_px) == 1;
    const LightRows sum = work.canvas.light;
    if (!stands || !motion.flicker_hz.empty())
        for (const auto& rows : {sum.red, sum.green, sum.blue}) fill(rows, work.whole, 0.0f);
    const auto groups = stands ? moving_groups(spread.moved.movers) : std::vector<MovingGroup>{};
    for (std::size_t lamps = 0; lamps <= motion.flicker_hz.size(); ++lamps) {
        if (stands)
            add_standing(work, groups, lamps);
        else
            add_moments(work, spread, lamps);
    }
}

}  // namespace camrig::render::software

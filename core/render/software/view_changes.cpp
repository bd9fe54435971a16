#include "core/render/software/view_changes.h"

#include <algorithm>

#include "core/render/pixel_rect.h"
#include "core/render/software/matched_actors.h"
#include "core/render/software/rows.h"
#include "core/render/software/static_layers.h"
#include "core/render/software/taken_picture.h"
#include "core/render/view_frames.h"

namespace camrig::render::software {
namespace {

/// Of what moves in one view; more are joined.
constexpr std::size_t max_rects = 16;

/// Of what lies below what moves, the view's layer: with a film each of its pictures makes another one of it.
std::uint64_t number_below(ViewWork& work) {
    if (!work.has_film()) return work.layer->number;
    FrameHistory& history = *work.history;
    if (history.film_layer != work.layer->number || history.film_frame != work.film_frame) {
        history.film_layer = work.layer->number;
        history.film_frame = work.film_frame;
        history.film_below = next_content_number();
    }
    return history.film_below;
}

void note(ViewWork& work, frame::Frame& frame, bool is_as_drawn, std::uint64_t below) {
    FrameHistory::OfKind& history = work.history->kinds[static_cast<std::size_t>(frame.info().kind)];
    history.last = (history.last + 1) % history.frames.size();
    ShownFrame& shown = history.frames[history.last];
    shown.mark = 0;
    shown.layer = below;
    shown.rects.clear();
    if (work.is_in_parts) shown.rects.assign(work.rects.begin(), work.rects.end());
    if (!work.is_in_parts || !is_as_drawn) return;
    shown.mark = next_content_number();
    frame.mark_content(shown.mark);
}

}  // namespace

void find_changed_rects(ViewWork& work, const SoftwareShadows& shadows) {
    work.rects.assign(work.movers.rects.begin(), work.movers.rects.end());
    if (!work.shadows.empty()) shadows.find_changed_pixels(work.scene, work.whole, work.rects);
    work.rects.insert(work.rects.end(), work.bodies.moving_rects.begin(), work.bodies.moving_rects.end());
    if (is_matched(work))
        for (PixelRect& rect : work.rects) rect = common(grown(rect, match_reach(work)), work.whole);
    work.rects = disjoint_cover(std::move(work.rects), max_rects);
    if (work.has_film() && work.layer->is_blended) work.rects.assign(1, work.whole);
}

void find_changes(ViewWork& work, const SoftwareShadows& shadows) {
    const StaticLayer& layer = *work.layer;
    const FrameHistory& history = *work.history;
    find_changed_rects(work, shadows);
    const auto stale = [&](const frame::Frame& frame, std::uint64_t below) {
        const std::uint64_t held = frame.held_before();
        const auto& frames = history.kinds[static_cast<std::size_t>(frame.info().kind)].frames;
        const auto found = std::ranges::find_if(
            frames, [&](const ShownFrame& shown) { return held != 0 && shown.mark == held && shown.layer == below; });
        return found == frames.end() ? std::span<const PixelRect>(&work.whole, 1) : std::span(found->rects);
    };
    for (ChannelFrame& channel : work.channels)
        if (channel.frame != nullptr) channel.stale = stale(*channel.frame, layer.number);
    if (work.frame == nullptr) return;
    if (work.takes_picture()) {
        // Light is in memory of all cameras, and no two pictures have the same noise.
        look_at_light(work, layer, work.rects);
        work.stale = work.has_sites ? std::span<const PixelRect>(work.new_tiles) : std::span(&work.whole, 1);
        work.history->picture.next(work.view->sequence, {});
        return;
    }
    work.below = number_below(work);
    work.stale = stale(*work.frame, work.below);
    frame::Damage since_layer = frame::Damage::since(static_cast<std::int64_t>(work.below));
    for (const PixelRect& rect : work.rects) since_layer.add(rect.y0, rect.y1);
    work.frame->set_damage(work.history->picture.next(work.view->sequence, since_layer));
}

void note_shown(ViewWork& work) {
    for (const ChannelFrame& channel : work.channels)
        if (channel.frame != nullptr) note(work, *channel.frame, true, work.is_in_parts ? work.layer->number : 0);
    if (work.frame == nullptr) return;
    note(work, *work.frame, !work.takes_picture() && finished_pixels(*work.view) != FinishedPixels::all,
         work.is_in_parts ? work.below : 0);
}

}  // namespace camrig::render::software

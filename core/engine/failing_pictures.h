#pragma once

#include <span>

#include "core/render/renderer.h"

namespace camrig::engine {

/// In Renderer::Finished::cost_ns: the view was not drawn, so its cost is not known.
inline constexpr TimeNs not_drawn_ns = -1;

/// Renderer::draw() for views of which some have faults (View::failing): draws what is visible, applies the faults that
/// change pixels, and gives the kept picture where a fault repeats it. The frame kind soiling, a mask of the pixels
/// that faults hide, is made here; a view that wants it must want no other kind. On the renderer's thread.
Result<render::Renderer::Finished> draw_failing(render::Renderer& renderer, const world::SnapshotRef& snapshot,
                                                TimeNs monotonic_ns, std::span<const render::View> views);

/// The world time in the view's frame, which a fault may make another than the snapshot's.
TimeNs shown_ns(const render::View& view, const world::Snapshot& snapshot);

}  // namespace camrig::engine

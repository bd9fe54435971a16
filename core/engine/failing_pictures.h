#pragma once

#include <span>

#include "core/render/renderer.h"

namespace camrig::engine {

/// The cost of a view that was not drawn: there is none to be learnt.
inline constexpr TimeNs not_drawn_ns = -1;

/// Renderer::draw() for cameras of which some fail (View::failing): draws what is to be seen, changes pixels as their
/// faults do, and gives again what was there before. A view that wants soiling wants
/// nothing else. On the renderer's thread.
Result<render::Renderer::Finished> draw_failing(render::Renderer& renderer, const world::SnapshotRef& snapshot,
                                                TimeNs monotonic_ns, std::span<const render::View> views);

/// The world time that the view's frame shows, or says that it shows.
TimeNs shown_ns(const render::View& view, const world::Snapshot& snapshot);

}  // namespace camrig::engine

#pragma once

#include "core/render/software/pyramid_sampling.h"
#include "core/world/backdrop/panorama.h"

namespace camrig::render::software {

/// Light of a panorama, with places in pixels of its whole: `sampled` where it has no finer pixels. Where it has, and
/// the view's pixel is smaller than one of the whole, the same of these; they end within one of their pixels, over
/// which what is coarser takes their place. So nothing jumps, neither beside them nor while a head zooms.
glm::dvec3 sampled(const world::Panorama& panorama, const Footprint& of);

}  // namespace camrig::render::software

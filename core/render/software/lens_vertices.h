#pragma once

#include <span>

#include "core/render/software/lens_numbers.h"
#include "core/render/software/screen_triangles.h"

namespace camrig {

/// project() through a lens; also where the vertices lie on the ideal plane. Those before the near plane or not of a
/// number lie anywhere.
void project_through(const LensNumbers& lens, ImageSize size, const glm::dmat4& optical_from_local,
                     const glm::vec3* positions, std::span<const std::uint32_t> which, bool wide, ScreenVertex* to,
                     glm::vec2* ideal, std::int32_t* outside);

}  // namespace camrig

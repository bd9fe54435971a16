#pragma once

#include <array>

#include "core/render/software/lanes.h"
#include "core/render/software/software_model.h"

/// Filtered texels at the points that a group of pixels shows.
namespace camrig::render::software {

/// Where a group of pixels looks at a texture. A pixel shows a strip of it, along the longer of its steps to the next
/// pixel and row.
struct TexturePoints {
    Lanes u, v;
    Lanes longer2;                   ///< the square of the longer step, in texels of the full size
    bool has_footprints = false;     ///< the mean over the strip is taken, else what lies at (u, v)
    bool blends_levels = false;      ///< without footprints: between two levels, else of the nearest
    Lanes u_step, v_step, shorter2;  ///< if has_footprints: the longer step, and the square of the shorter one
};

using SampledLanes = std::array<Lanes, 4>;
enum class TextureChannels { red, rgb, rgba, alpha };

/// Writes these channels, each in its place; wide: with Avx2Isa. is_opaque: alpha is not looked at, and comes out as 1.
/// Not inlined: it is the largest part of all that shades.
[[gnu::noinline]] void sample_wide(const SampledTexture& texture, const TexturePoints& points, TextureChannels channels,
                                   bool is_opaque, SampledLanes& to);
[[gnu::noinline]] void sample_plain(const SampledTexture& texture, const TexturePoints& points,
                                    TextureChannels channels, bool is_opaque, SampledLanes& to);

}  // namespace camrig::render::software

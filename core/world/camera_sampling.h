#pragma once

#include <cstdint>

#include "core/base/field_table.h"
#include "core/base/named.h"

namespace camrig::world {

/// How many samples make a pixel of a colour picture; ids, depth and normals always have one, at the pixel's centre.
/// `coverage`: each surface by how much of the pixel it covers, shaded once; msaa4 where camrig's own rasteriser does
/// not draw. `msaa4`: coverage at four places, shading once. `ssaa2` to `ssaa4`: 2x2 to 4x4 full samples. `automatic`:
/// coverage at quality `beautiful`, else none (antialias_of in camera_spec.h).
enum class Antialias : std::uint8_t { none, coverage, msaa4, ssaa2, ssaa3, ssaa4, automatic };
std::span<const Named<Antialias>> names_of(std::type_identity<Antialias>);
/// Samples along one side of a pixel: 1 to 4 (1 for coverage and msaa4). Not of `automatic`.
int supersampling_of(Antialias antialias);
/// Coverage samples of one drawn texel: 1 or 4.
int multisampling_of(Antialias antialias);

/// What a picture through a lens is resampled from: one oversized pinhole picture, or the faces of a cube. `automatic`
/// takes what needs fewer texels (docs/decisions/0021).
enum class LensMethod : std::uint8_t { automatic, warp, cube };
std::span<const Named<LensMethod>> names_of(std::type_identity<LensMethod>);

/// How source texels become a pixel: 2x2 or 4x4 (Catmull-Rom) of them. `automatic`: 4x4 at quality
/// `beautiful`, else 2x2.
enum class LensFilter : std::uint8_t { automatic, bilinear, bicubic };
std::span<const Named<LensFilter>> names_of(std::type_identity<LensFilter>);

/// How a lens is drawn; nothing of this moves anything in the picture.
struct LensSampling {
    LensMethod method = LensMethod::automatic;
    LensFilter filter = LensFilter::automatic;
    friend bool operator==(const LensSampling&, const LensSampling&) = default;
};
FieldTable<LensSampling> fields_of(std::type_identity<LensSampling>);

}  // namespace camrig::world

#pragma once

#include "core/render/software/surface_point.h"

/// Quality beautiful: shaders/forward.frag for CPUs.
namespace camrig::render::software {

struct Rgba {
    Lanes3 rgb;
    Lanes a;
    Lanes3 tint{lanes(1.0f), lanes(1.0f), lanes(1.0f)};  ///< of what is behind
};

/// Linear light of a group of points of a lit surface. has_movers: in the shadows of what moves, too. Not inlined: it
/// is large, and shading is in many places.
[[gnu::noinline]] void shade_material_wide(const ViewGeometry& geometry, const ViewDraw& draw,
                                           const SurfacePoints& points, const Lanes3& rays, bool has_movers, Rgba& to);
[[gnu::noinline]] void shade_material_plain(const ViewGeometry& geometry, const ViewDraw& draw,
                                            const SurfacePoints& points, const Lanes3& rays, bool has_movers, Rgba& to);

/// The light that comes to a group of points of a matt surface, whatever its material is.
[[gnu::noinline]] void arriving_light_wide(const ViewGeometry& geometry, const ViewDraw& draw,
                                           const SurfacePoints& points, const Lanes3& rays, bool has_movers,
                                           Lanes3& to);
[[gnu::noinline]] void arriving_light_plain(const ViewGeometry& geometry, const ViewDraw& draw,
                                            const SurfacePoints& points, const Lanes3& rays, bool has_movers,
                                            Lanes3& to);

}  // namespace camrig::render::software

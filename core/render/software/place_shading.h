#pragma once

#include <cstdint>
#include <vector>

#include "core/render/software/geometry.h"

namespace camrig::render::software {

/// Instead of a number among places.
inline constexpr std::uint32_t no_place = ~0u;

/// A point of a triangle to be shaded.
struct ShadedPlace {
    std::uint32_t triangle = 0;
    float share = 1.0f;       ///< of the pixel that the surface covers: textures are filtered over so much less
    double x = 0.0, y = 0.0;  ///< in subpixels of the screen
};

/// Points to shade, and their colours. Those of one draw are shaded together, eight at a time.
struct ShadedPlaces {
    bool are_blended = false;  ///< of surfaces that let through what lies behind
    std::vector<ShadedPlace> places;
    std::vector<glm::vec3> colors;   ///< linear light; of what is blended its own, to be added to what comes through
    std::vector<glm::vec3> through;  ///< of what is blended: how much of the light behind
    std::vector<std::uint32_t> order, first_of_draw;

    void clear() { places.clear(); }
    std::uint32_t add(const ShadedPlace& place) {
        places.push_back(place);
        return static_cast<std::uint32_t>(places.size()) - 1;
    }
};
/// Not cut at white: parts of a pixel are mixed before, as on a sensor. has_movers: as of shade().
void shade_places(const ViewGeometry& geometry, ShadedPlaces& of, bool has_movers = true);

}  // namespace camrig::render::software

#pragma once

#include <functional>
#include <variant>

#include <glm/glm.hpp>

#include "core/world/model.h"

/// Models that need no file: what a scene file asks for by `shape` (docs/scene-format.md). Sizes in metres, colours
/// linear. The caller has checked ranges.
namespace camrig::world {

/// A level rectangle about the origin, seen from above. Every `grid_m` there is a thin line, every ten cells a bolder
/// one, and cells are lighter and darker in turn, so that scale and motion show; 0: plain.
struct GroundShape {
    glm::dvec2 size{100.0, 100.0};
    glm::vec3 color{0.35f, 0.34f, 0.32f};
    float roughness = 0.9f;
    double grid_m = 1.0;
};

/// Stands on the origin: the middle of its bottom.
struct BoxShape {
    glm::dvec3 size{1.0};
    glm::vec3 color{0.5f};
    float roughness = 0.8f;
};

/// A sphere about the origin, seen from within: `color` above, `horizon` level and below. Shines by itself, casts no
/// shadow.
struct SkyShape {
    double radius_m = 500.0;
    glm::vec3 color{0.18f, 0.36f, 0.72f};
    glm::vec3 horizon{0.70f, 0.80f, 0.90f};
};

using Shape = std::variant<GroundShape, BoxShape, SkyShape>;

ModelRef shape_model(const Shape& shape);

/// Corners of a SkyShape: around, and from horizon to zenith; so many more are below.
inline constexpr int sky_columns = 48, sky_rows = 16;
/// Unit, z up. Columns go to the right for who looks at them from within; rows, from -rows to rows, are finer near the
/// horizon, where the colour changes fastest.
glm::dvec3 sky_corner(int column, int columns, int row, int rows);

/// A SkyShape of any colours: of what is seen along a unit vector, z up. `fineness`: so many times as many corners
/// around, and as many from horizon to zenith. `picture`: a factor on the colours above the horizon, sRGB, from its
/// first row, the horizon, to the zenith, and around as corners are; none: 1.
ModelRef sky_model(double radius_m, int fineness, const std::function<glm::vec3(const glm::dvec3& towards)>& color,
                   Image picture = {});

}  // namespace camrig::world

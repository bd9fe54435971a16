#pragma once

#include <optional>
#include <string>

#include "core/base/result.h"
#include "core/world/scene.h"

namespace camrig::world {

/// What of the scene leaves the ground that the pictures of its cameras say is walkable: all points of routes, and the
/// borders of areas, lie on that of at least one of them, and so does all of the way between. Nothing, where no camera
/// says anything. The error has the path in the file: "routes.across.points[2]: ...".
std::optional<Error> find_unwalkable(const Scene& scene);

/// Why nobody may be put at this place or sent there: "is outside of what is walkable (...)". Nothing: it lies on that
/// ground, or no camera says anything.
std::optional<std::string> why_unwalkable(const Scene& scene, const glm::dvec3& place);

}  // namespace camrig::world

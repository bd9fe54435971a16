#pragma once

#include <optional>

#include "core/base/result.h"
#include "core/world/scene.h"

namespace camrig::world {

/// What of the scene leaves the ground that the pictures of its cameras say is walkable: all points of routes, and the
/// borders of areas, lie on that of at least one of them, and so does all of the way between. Nothing, where no camera
/// says anything. The error has the path in the file: "routes.across.points[2]: ...".
std::optional<Error> find_unwalkable(const Scene& scene);

}  // namespace camrig::world

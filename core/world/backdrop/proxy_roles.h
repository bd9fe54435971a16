#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "core/base/result.h"
#include "core/world/model.h"

namespace camrig::world {

/// What a glTF file says of a place.
struct ModelProxies {
    ModelRef shapes;                                ///< that hide; null: none
    ModelRef catchers;                              ///< that shadows fall on only; null: none
    std::vector<std::vector<glm::dvec2>> walkable;  ///< its triangles, seen from above
};

/// Nodes say by extras.camrig_proxy what they and those below them are: `ground`, `obstacle` and `wall` are shapes,
/// `catcher` and `holdout` are such with that role only (ProxyRole), and `walkable` is where people may go. Where no
/// node says anything, all of the model are shapes; where one does, what says nothing is nothing: helpers, lights, a
/// picture to model by. Errors name the node: another word, more than 5000 walkable triangles.
Result<ModelProxies> proxies_of_model(const ModelRef& model);

}  // namespace camrig::world

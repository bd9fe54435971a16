#pragma once

#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "core/base/time.h"
#include "core/world/model.h"

namespace camrig::world {

/// Spherical interpolation of unit quaternions along the shorter arc, unit to 1e-15 for every input. Nearly equal and
/// opposite keys are exact: the angle comes from atan2(|a - b|, |a + b|), not from acos. q and -q are one rotation; at
/// exactly half a turn apart the arc through +b is taken.
glm::dquat slerp_shortest(const glm::dquat& a, const glm::dquat& b, double t);

/// A channel at a moment: before the first key its value, after the last key its value, between them as glTF 2.0,
/// appendix C says. Exact keys are found in integer nanoseconds.
glm::dvec3 sample_vector(const Channel& channel, TimeNs phase_ns);
glm::dquat sample_rotation(const Channel& channel, TimeNs phase_ns);
void sample_weights(const Channel& channel, TimeNs phase_ns, std::vector<float>& out);

}  // namespace camrig::world

#pragma once

#include "core/world/model.h"
#include "core/world/snapshot.h"

/// Light in units: where so many lux make white white, lights and what shines have their strengths in candela, lux and
/// candela per square metre.
namespace camrig::world {

/// Lux that make white white; nullopt: the scene has no unit.
std::optional<double> unit_lux(const Environment& environment);

/// Why something in candela or lux is refused where it has none.
constexpr std::string_view needs_unit = "needs environment.lux, the lux that make white white, or environment.daylight";

/// A model whose light is in the units of glTF, as the scene has it. A lamp of `lux` candela lights white at 1 m as
/// light 1 does; white in the light of `lux` has a luminance of lux / pi and is drawn as 1. What is emitted counts
/// with KHR_materials_emissive_strength.
ModelRef in_scene_units(const Model& model, double lux);

}  // namespace camrig::world

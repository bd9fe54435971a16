#pragma once

#include <functional>

#include <nlohmann/json.hpp>

namespace camrig::view {

/// Draws one control for each parameter that the rig describes (server.describe) and that is a number, a word, a truth
/// value, numbers in a list or an object of these; what may be null is empty then, or an object that is switched off.
/// What the rig sets, and values of other forms, are text. `wish` gets {name: value} when the person has changed one.
void draw_described(const nlohmann::json& fields, const nlohmann::json& values,
                    const std::function<void(const nlohmann::json&)>& wish);

}  // namespace camrig::view

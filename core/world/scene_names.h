#pragma once

#include <map>
#include <string>

#include "core/world/model.h"

namespace camrig {

/// "hall, person_1, person_2" for messages; long lists are cut.
template <typename Value>
std::string known_names(const std::map<std::string, Value>& entries) {
    std::string names;
    for (const auto& [name, value] : entries) {
        if (names.size() > 400) return names + ", ...";
        names += (names.empty() ? "" : ", ") + name;
    }
    return names.empty() ? "none" : names;
}

inline std::string known_clips(const Model& model) {
    std::map<std::string, int> names;
    for (const Animation& animation : model.animations) names.emplace(animation.name, 0);
    return known_names(names);
}

}  // namespace camrig

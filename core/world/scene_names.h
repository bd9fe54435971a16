#pragma once

#include <string>

namespace camrig::world {

/// "hall, person_1, person_2" for messages, of a set or of the keys of a map; long lists are cut.
template <typename Names>
std::string known_names(const Names& entries) {
    std::string names;
    for (const auto& entry : entries) {
        if (names.size() > 400) return names + ", ...";
        if (!names.empty()) names += ", ";
        if constexpr (requires { entry.first; })
            names += entry.first;
        else
            names += entry;
    }
    return names.empty() ? "none" : names;
}

}  // namespace camrig::world

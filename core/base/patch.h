#pragma once

#include <optional>

namespace camrig {

/// One field of a patch: what is empty leaves the target as it is.
template <typename From, typename To>
void assign_if(const std::optional<From>& from, To& to) {
    if (from) to = *from;
}

}  // namespace camrig

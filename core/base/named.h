#pragma once

#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "core/base/result.h"

namespace camrig {

/// A value of an enum and its name in JSON and on the command line. An enum E has names when there is
///     std::span<const Named<E>> names_of(std::type_identity<E>);
/// beside it, in the order in which people are told them.
template <typename E>
struct Named {
    E value;
    std::string_view name;
};

template <typename E>
concept HasNames = std::is_enum_v<E> && requires { names_of(std::type_identity<E>{}); };

template <HasNames E>
std::string_view to_string(E value) {
    for (const Named<E>& each : names_of(std::type_identity<E>{}))
        if (each.value == value) return each.name;
    CHECK(false);
    return {};
}

/// Error invalid_argument with the names that there are.
template <HasNames E>
Result<E> parse_name(std::string_view name) {
    std::string known;
    for (const Named<E>& each : names_of(std::type_identity<E>{})) {
        if (each.name == name) return each.value;
        known += (known.empty() ? "" : ", ") + std::string(each.name);
    }
    return error(ErrorKind::invalid_argument, "'" + std::string(name.substr(0, 40)) + "' is none of " + known);
}

}  // namespace camrig

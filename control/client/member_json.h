#pragma once

#include <algorithm>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <camrig/error.h>
#include <camrig/parameters.h>
#include <nlohmann/json.hpp>

/// Structs of camrig/parameters.h to and from JSON, by their members.
namespace camrig::client {

/// "25/1", or a number.
Rate rate_of(const nlohmann::json& value);

template <typename T>
inline constexpr bool has_members = requires(T& value) { T::each_member(value, [](const char*, auto&) {}); };
template <typename>
inline constexpr bool is_optional = false;
template <typename T>
inline constexpr bool is_optional<std::optional<T>> = true;
template <typename>
inline constexpr bool is_list_of_objects = false;
template <typename T>
inline constexpr bool is_list_of_objects<std::vector<T>> = has_members<T>;

/// An answer, of which every member must be there.
template <typename T>
inline constexpr bool is_answer = requires { T::is_answer; };

inline bool is_null_when_empty(std::string_view name) {
    return std::ranges::find(null_when_empty, name) != std::end(null_when_empty);
}

template <typename T>
nlohmann::json json_of(const T& value) {
    if constexpr (has_members<T>) {
        nlohmann::json object = nlohmann::json::object();
        T::each_member(value, [&](const char* name, const auto& member) {
            if constexpr (is_optional<std::decay_t<decltype(member)>>) {
                if (!member) return;
            }
            object[name] = json_of(member);
            if (is_null_when_empty(name) && object[name] == "") object[name] = nullptr;
        });
        return object;
    } else if constexpr (is_optional<T>) {
        return value ? json_of(*value) : nlohmann::json(nullptr);
    } else if constexpr (is_list_of_objects<T>) {
        nlohmann::json list = nlohmann::json::array();
        for (const auto& item : value) list.push_back(json_of(item));
        return list;
    } else if constexpr (std::is_same_v<T, NumberOrAuto>) {
        return value.number ? nlohmann::json(*value.number) : nlohmann::json("auto");
    } else if constexpr (std::is_same_v<T, Rate>) {
        return std::to_string(value.num) + "/" + std::to_string(value.den);
    } else if constexpr (std::is_same_v<T, Size>) {
        return {value.width, value.height};
    } else {
        return value;
    }
}

/// Members of an answer must be there, but for those of objects that have defaults.
template <typename T>
void read(const nlohmann::json& value, T& into) {
    if constexpr (is_answer<T>) {
        T::each_member(into, [&](const char* name, auto& member) { read(value.at(name), member); });
    } else if constexpr (has_members<T>) {
        T::each_member(into, [&](const char* name, auto& member) {
            if (const auto found = value.find(name); found != value.end()) read(*found, member);
        });
    } else if constexpr (is_optional<T>) {
        if (!value.is_null()) read(value, into.emplace());
    } else if constexpr (is_list_of_objects<T>) {
        for (const nlohmann::json& item : value) read(item, into.emplace_back());
    } else if constexpr (std::is_same_v<T, NumberOrAuto>) {
        if (value.is_number()) into = value.get<double>();
    } else if constexpr (std::is_same_v<T, Rate>) {
        into = rate_of(value);
    } else if constexpr (std::is_same_v<T, Size>) {
        into = {value.at(0).get<int>(), value.at(1).get<int>()};
    } else if constexpr (std::is_same_v<T, nlohmann::json>) {
        into = value;
    } else if constexpr (std::is_same_v<T, std::string>) {
        into = value.is_null() ? "" : value.get<std::string>();
    } else {
        value.get_to(into);
    }
}

template <typename T>
T read_answer(const char* what, const nlohmann::json& answer) {
    try {
        T value;
        read(answer, value);
        return value;
    } catch (const nlohmann::json::exception& problem) {
        throw Error("internal", std::string(what) + ": the rig's answer is not as expected: " + problem.what());
    }
}

/// What was made or changed, and applied_ns.
template <typename State>
Applied<State> read_applied(const char* what, const nlohmann::json& answer) {
    Applied<State> applied;
    static_cast<State&>(applied) = read_answer<State>(what, answer);
    applied.applied_ns = answer.value("applied_ns", std::int64_t{0});
    return applied;
}

/// The list under `key` of an answer.
template <typename State>
std::vector<State> read_list(const char* key, const nlohmann::json& answer) {
    std::vector<State> all;
    for (const nlohmann::json& one : answer.value(key, nlohmann::json::array()))
        all.push_back(read_answer<State>(key, one));
    return all;
}

}  // namespace camrig::client

#include "control/client/camera_json.h"

#include <algorithm>
#include <iterator>
#include <string_view>
#include <type_traits>

#include <camrig/error.h>

#include "core/base/rate.h"

namespace camrig::client {
namespace {

using nlohmann::json;

Rate rate_of(const Result<camrig::Rate>& exact) {
    if (!exact) throw Error("invalid_argument", "fps: " + exact.error().message);
    return {exact->num(), exact->den()};
}

template <typename T>
constexpr bool has_members = requires(T& value) { T::each_member(value, [](const char*, auto&) {}); };
template <typename>
constexpr bool is_optional = false;
template <typename T>
constexpr bool is_optional<std::optional<T>> = true;
template <typename>
constexpr bool is_list_of_objects = false;
template <typename T>
constexpr bool is_list_of_objects<std::vector<T>> = has_members<T>;

/// By its members: the program that makes the structs is built with this file.
template <typename T>
constexpr bool is_backdrop = requires(const T& value) {
    value.file;
    value.proxies;
};

bool is_null_when_empty(std::string_view name) {
    return std::ranges::find(null_when_empty, name) != std::end(null_when_empty);
}

template <typename T>
json json_of(const T& value) {
    if constexpr (has_members<T>) {
        json object = json::object();
        T::each_member(value, [&](const char* name, const auto& member) {
            if constexpr (is_optional<std::decay_t<decltype(member)>>) {
                if (!member) return;
            }
            object[name] = json_of(member);
            if (is_null_when_empty(name) && object[name] == "") object[name] = nullptr;
        });
        if constexpr (std::is_same_v<T, Mount>) return value.actor.empty() ? json(nullptr) : object;
        if constexpr (is_backdrop<T>) return value.file.empty() ? json(nullptr) : object;
        return object;
    } else if constexpr (is_optional<T>) {
        return value ? json_of(*value) : json(nullptr);
    } else if constexpr (is_list_of_objects<T>) {
        json list = json::array();
        for (const auto& item : value) list.push_back(json_of(item));
        return list;
    } else if constexpr (std::is_same_v<T, NumberOrAuto>) {
        return value.number ? json(*value.number) : json("auto");
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
void read(const json& value, T& into) {
    if constexpr (std::is_same_v<T, CameraState> || std::is_same_v<T, WorldStatus>) {
        T::each_member(into, [&](const char* name, auto& member) { read(value.at(name), member); });
    } else if constexpr (has_members<T>) {
        T::each_member(into, [&](const char* name, auto& member) {
            if (const auto found = value.find(name); found != value.end()) read(*found, member);
        });
    } else if constexpr (is_optional<T>) {
        if (!value.is_null()) read(value, into.emplace());
    } else if constexpr (is_list_of_objects<T>) {
        for (const json& item : value) read(item, into.emplace_back());
    } else if constexpr (std::is_same_v<T, NumberOrAuto>) {
        if (value.is_number()) into = value.get<double>();
    } else if constexpr (std::is_same_v<T, Rate>) {
        into = rate_of(value.is_string() ? camrig::Rate::parse(value.get<std::string>())
                                         : camrig::Rate::from_number(value.get<double>()));
    } else if constexpr (std::is_same_v<T, Size>) {
        into = {value.at(0).get<int>(), value.at(1).get<int>()};
    } else if constexpr (std::is_same_v<T, std::string>) {
        into = value.is_null() ? "" : value.get<std::string>();
    } else {
        value.get_to(into);
    }
}

template <typename T>
T read_answer(const char* what, const json& answer) {
    try {
        T value;
        read(answer, value);
        return value;
    } catch (const json::exception& problem) {
        throw Error("internal", std::string(what) + ": the rig's answer is not as expected: " + problem.what());
    }
}

}  // namespace

Rate::Rate(double hertz) : Rate(rate_of(camrig::Rate::from_number(hertz))) {}

json params_of(const CameraOptions& options) {
    json params = json_of(options), pose = json::object();
    for (const char* name : {"position", "look_at", "pan_deg", "tilt_deg", "roll_deg", "orientation"}) {
        const auto found = params.find(name);
        if (found == params.end()) continue;
        pose[name] = std::move(*found);
        params.erase(found);
    }
    if (!pose.empty()) params["pose"] = std::move(pose);
    return params;
}

CameraState camera_state_of(const json& answer) {
    return read_answer<CameraState>("camera", answer);
}

WorldStatus world_status_of(const json& answer) {
    return read_answer<WorldStatus>("world", answer);
}

}  // namespace camrig::client

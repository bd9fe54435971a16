#pragma once

#include <string>
#include <utility>
#include <vector>

#include "control/rpc/methods.h"
#include "core/base/names.h"
#include "core/world/world_fields.h"

/// Parameters that several methods have, and what is the same in the answers of several.
namespace camrig::control {

/// The name of a camera.
template <auto member>
auto camera_name_at(const char* name) {
    return world::entry_by<member>(
        {.name = name, .type = "string", .doc = "name of the camera, `[a-z0-9_]{1,24}`", .required = true},
        [](JsonReader& reader, std::string_view key, std::string& out) {
            reader.required(key, out);
            if (!reader.ok(key)) return;
            if (auto good = check_name(key, out); !good) reader.fail(good.error());
        });
}

/// How new a picture must be.
template <auto member>
auto min_ns_at() {
    return field_at<member>(
        {.name = "min_ns",
         .doc = "world time the frame must show or be later than; waits for it up to 10 s, or two frames of a "
                "slower camera. 0: from which the camera's last command shows",
         .unit = "ns"});
}

/// When a frame of a camera is, in the answers about it.
inline const Field time_field{"time_ns", "integer", "world time it shows", false, "ns"};
inline const Field monotonic_field{"monotonic_ns", "integer", "CLOCK_MONOTONIC time of that instant", false, "ns"};
inline const Field stamp_field{"stamp_ns", "integer",
                               "of a camera with a clock or a sensor, beside `time_ns`: the instant as its clock has "
                               "it; with a sensor the begin of the exposure",
                               false, "ns"};
inline const Field steady_field{"steady_ns", "integer",
                                "of such a camera, beside `monotonic_ns`: the same as its monotonic clock has it",
                                false, "ns"};

/// The method THING.remove, of the command that takes what has a name out of the world.
template <typename C>
Method remove_method(RpcContext& context, const std::string& thing, std::string summary, const std::string& example) {
    const std::vector<FieldOf<C>> params{
        world::name_at<&C::name>({.name = "name", .doc = "name of the " + thing, .required = true})};
    return {.name = thing + ".remove",
            .summary = std::move(summary),
            .params = descriptions_of(params),
            .result = {{"applied_ns", "integer", "world time from which it is gone", false, "ns"}},
            .errors = {ErrorKind::invalid_argument, ErrorKind::not_found},
            .handler = handler_of(context, params, applied_json),
            .example = R"({"name": ")" + example + R"("})"};
}

}  // namespace camrig::control

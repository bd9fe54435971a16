#pragma once

#include "core/base/names.h"
#include "core/world/world_fields.h"

/// Parameters that several methods have.
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
         .doc = "world time the frame must show or be later than; waits up to 10 s for it. 0: from which the camera's "
                "last command shows",
         .unit = "ns"});
}

}  // namespace camrig::control

#include "control/client/camera_json.h"

#include "control/client/member_json.h"
#include "core/base/rate.h"

namespace camrig::client {
namespace {

using nlohmann::json;

Rate checked(const Result<camrig::Rate>& exact) {
    if (!exact) throw Error("invalid_argument", "fps: " + exact.error().message);
    return {exact->num(), exact->den()};
}

}  // namespace

Rate rate_of(const json& value) {
    return checked(value.is_string() ? camrig::Rate::parse(value.get<std::string>())
                                     : camrig::Rate::from_number(value.get<double>()));
}

Rate::Rate(double hertz) : Rate(checked(camrig::Rate::from_number(hertz))) {}

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

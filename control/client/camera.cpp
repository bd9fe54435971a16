#include <cstdio>
#include <fstream>

#include <camrig/camera.h>
#include <camrig/error.h>

#include "control/client/camera_json.h"
#include "control/client/connections.h"
#include "core/base/base64.h"

namespace camrig::client {
namespace {

using nlohmann::json;

Frame frame_of(const json& answer) {
    try {
        auto bytes = base64_decode(answer.at("data").get_ref<const std::string&>());
        if (!bytes) throw Error("internal", "frame.get: data: " + bytes.error().message);
        Frame frame;
        frame.camera = answer.at("camera").get<std::string>();
        frame.kind = answer.at("kind").get<std::string>();
        frame.format = answer.at("format").get<std::string>();
        frame.pixels = answer.value("pixels", "");
        frame.size = {answer.at("size").at(0).get<int>(), answer.at("size").at(1).get<int>()};
        frame.sequence = answer.at("sequence").get<std::int64_t>();
        frame.time_ns = answer.at("time_ns").get<std::int64_t>();
        frame.monotonic_ns = answer.at("monotonic_ns").get<std::int64_t>();
        frame.stamp_ns = answer.value("stamp_ns", frame.time_ns);
        frame.steady_ns = answer.value("steady_ns", frame.monotonic_ns);
        frame.data = std::move(*bytes);
        return frame;
    } catch (const json::exception& problem) {
        throw Error("internal", std::string("frame.get: the rig's answer is not as expected: ") + problem.what());
    }
}

}  // namespace

CameraState Camera::get() const {
    return camera_state_of(connections_->call("camera.get", {{"name", name_}}));
}

CameraState Camera::set(const CameraOptions& options, double seconds) const {
    json params = params_of(options);
    params["name"] = name_;
    if (seconds != 0.0) params["seconds"] = seconds;
    return camera_state_of(connections_->call("camera.set", params));
}

std::int64_t Camera::remove() const {
    return connections_->call("camera.delete", {{"name", name_}}).value("applied_ns", std::int64_t{0});
}

Frame Camera::frame(const FrameRequest& request) const {
    json params{{"camera", name_}, {"kind", request.kind}, {"format", request.format}};
    if (request.min_ns != 0) params["min_ns"] = request.min_ns;
    if (request.format == "jpeg") params["quality"] = request.quality;
    return frame_of(connections_->call("frame.get", params));
}

Frame Camera::depth(std::int64_t min_ns) const {
    FrameRequest request;
    request.kind = "depth";
    request.min_ns = min_ns;
    return frame(request);
}

Frame Camera::flow(std::int64_t min_ns) const {
    FrameRequest request;
    request.kind = "flow";
    request.min_ns = min_ns;
    return frame(request);
}

Frame Camera::soiling(std::int64_t min_ns) const {
    FrameRequest request;
    request.kind = "soiling";
    request.min_ns = min_ns;
    return frame(request);
}

Frame Camera::instances(std::int64_t min_ns) const {
    FrameRequest request;
    request.kind = "instance";
    request.min_ns = min_ns;
    return frame(request);
}

json Camera::truth(std::int64_t min_ns) const {
    json params{{"camera", name_}};
    if (min_ns != 0) params["min_ns"] = min_ns;
    return connections_->call("truth.get", params);
}

json PtzHead::call(const char* method, json params) const {
    params["camera"] = camera_;
    return connections_->call(method, params);
}
json PtzHead::status() const {
    return call("ptz.status");
}
json PtzHead::move(json params) const {
    return call("ptz.move", std::move(params));
}
json PtzHead::stop(bool pan_tilt, bool zoom) const {
    return call("ptz.stop", {{"pan_tilt", pan_tilt}, {"zoom", zoom}});
}
json PtzHead::preset_set(const std::string& preset) const {
    return call("ptz.preset_set", {{"preset", preset}});
}
json PtzHead::preset_goto(const std::string& preset) const {
    return call("ptz.preset_goto", {{"preset", preset}});
}
json PtzHead::preset_remove(const std::string& preset) const {
    return call("ptz.preset_remove", {{"preset", preset}});
}
json PtzHead::tour_set(const std::string& tour, json stops) const {
    return call("ptz.tour_set", {{"tour", tour}, {"stops", std::move(stops)}});
}
json PtzHead::tour_start(const std::string& tour) const {
    return call("ptz.tour_start", {{"tour", tour}});
}
json PtzHead::tour_remove(const std::string& tour) const {
    return call("ptz.tour_remove", {{"tour", tour}});
}
json PtzHead::home_set() const {
    return call("ptz.home_set");
}
json PtzHead::home_goto() const {
    return call("ptz.home_goto");
}

void Camera::snapshot(const std::filesystem::path& file) const {
    const std::string ending = file.extension();
    FrameRequest request;
    request.format = ending == ".png" ? "png" : "jpeg";
    if (ending != ".png" && ending != ".jpg" && ending != ".jpeg")
        throw Error("invalid_argument", "snapshot: " + file.string() + " ends in none of .jpg, .jpeg and .png");
    const Frame picture = frame(request);
    std::ofstream stream(file, std::ios::binary | std::ios::trunc);
    stream.write(reinterpret_cast<const char*>(picture.data.data()), static_cast<std::streamsize>(picture.data.size()));
    stream.close();
    if (!stream) throw Error("unavailable", "snapshot: " + file.string() + " cannot be written");
}

std::string Camera::url(const std::string& kind) const {
    if (kind == "rtsp") return connections_->url_of("rtsp") + "/" + name_;
    if (kind == "rtsp-sub") return connections_->url_of("rtsp") + "/" + name_ + "/sub";
    if (kind == "rtsp-mjpeg") return connections_->url_of("rtsp") + "/" + name_ + "/mjpeg";
    const std::string file = kind == "mjpeg" ? "stream.mjpg" : kind == "jpg" || kind == "png" ? "snapshot." + kind : "";
    if (file.empty())
        throw Error("invalid_argument",
                    "url: kind is '" + kind + "'; it is mjpeg, jpg, png, rtsp, rtsp-sub or rtsp-mjpeg");
    const std::string& token = connections_->options().token;
    return connections_->url_of("http") + "/cameras/" + name_ + "/" + file + (token.empty() ? "" : "?token=" + token);
}

}  // namespace camrig::client

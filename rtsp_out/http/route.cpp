#include "rtsp_out/http/route.h"

#include <algorithm>
#include <charconv>
#include <initializer_list>

#include "core/base/names.h"
#include "core/frame/kind_format.h"

namespace camrig::http {
namespace {

std::string names_of_camera() {
    std::string all;
    for (const HttpPath& one : camera_paths()) all.append(all.empty() ? "" : ", ").append(one.path);
    return all;
}

Result<void> only_params(const Target& target, std::initializer_list<std::string_view> known) {
    for (const auto& [name, value] : target.query) {
        // "t": browsers ask again for a picture only if its URL differs, so pages put the time there.
        if (name == "token" || name == "t" || std::ranges::find(known, name) != known.end()) continue;
        std::string all;
        for (const std::string_view one : known) all += (all.empty() ? "" : ", ") + std::string(one);
        return error(ErrorKind::invalid_argument,
                     "query: unknown parameter '" + name.substr(0, 40) + "'; " +
                         (all.empty() ? "this path takes none" : "this path takes: " + all));
    }
    return {};
}

template <typename Integer>
Result<Integer> parse_integer(std::string_view name, const std::string& text, Integer low, Integer high) {
    Integer value{};
    const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (failed != std::errc{} || end != text.data() + text.size() || value < low || value > high)
        return error(ErrorKind::invalid_argument, "query: " + std::string(name) + " must be a whole number from " +
                                                      std::to_string(low) + " to " + std::to_string(high));
    return value;
}

Result<std::optional<int>> quality_of(const Target& target) {
    const std::string* text = target.find("quality");
    if (!text) return std::nullopt;
    return parse_integer<int>("quality", *text, 1, 100);
}

Result<std::optional<Rate>> rate_of(const Target& target) {
    const std::string* text = target.find("fps");
    if (!text) return std::nullopt;
    auto rate = Rate::parse(*text);
    if (!rate) return at("query: fps", rate.error());
    return *rate;
}

/// Of /live: names between commas.
Result<std::vector<std::string>> cameras_of(const Target& target) {
    const std::string* text = target.find("cameras");
    if (!text) return error(ErrorKind::invalid_argument, "query: 'cameras' is missing; name some, as in cameras=a,b");
    std::vector<std::string> cameras;
    for (std::string_view rest = *text;;) {
        const std::size_t comma = rest.find(',');
        const std::string_view name = rest.substr(0, comma);
        if (auto good = check_name("camera", name); !good) return at("query", good.error());
        if (std::ranges::find(cameras, name) != cameras.end())
            return error(ErrorKind::invalid_argument, "query: camera '" + std::string(name) + "' is named twice");
        if (cameras.size() == max_live_cameras)
            return error(ErrorKind::invalid_argument,
                         "query: more than " + std::to_string(max_live_cameras) + " cameras");
        cameras.emplace_back(name);
        if (comma == std::string_view::npos) return cameras;
        rest.remove_prefix(comma + 1);
    }
}

Result<HttpRoute> camera_route(std::string_view camera, std::string_view leaf) {
    if (auto name = check_name("camera", camera); !name) return error(ErrorKind::not_found, name.error().message);
    const auto found = std::ranges::find(camera_paths(), leaf, &HttpPath::path);
    if (found != camera_paths().end()) return HttpRoute{*found, std::string(camera)};
    return error(ErrorKind::not_found, "/cameras/" + std::string(camera) + " has no '" +
                                           std::string(leaf.substr(0, 40)) + "'; it has " + names_of_camera());
}

}  // namespace

std::span<const HttpPath> rig_paths() {
    using enum RouteKind;
    static constexpr HttpPath paths[] = {
        {.path = "/", .kind = file},
        {.path = "/cameras", .kind = cameras, .is_guarded = true},
        {.path = "/live", .kind = live, .is_guarded = true},
        {.path = "/healthz", .kind = healthz, .is_guarded = true},
        {.path = "/metrics", .kind = metrics, .is_guarded = true},
        {.path = "/rpc", .kind = rpc, .takes_post = true},
    };
    return paths;
}

std::span<const HttpPath> camera_paths() {
    using enum RouteKind;
    constexpr bool get = false, guarded = true;
    static constexpr HttpPath paths[] = {
        {"stream.mjpg", stream, get, guarded, frame::FrameKind::color, codec::Codec::jpeg, "stream"},
        {"snapshot.jpg", picture, get, guarded, frame::FrameKind::color, codec::Codec::jpeg, "jpeg"},
        {"snapshot.png", picture, get, guarded, frame::FrameKind::color, codec::Codec::png, "png"},
        {"depth.png", picture, get, guarded, frame::FrameKind::depth, codec::Codec::png, "depth_png"},
        {"depth.npy", floats, get, guarded, frame::FrameKind::depth, codec::Codec::raw, "depth_npy"},
        {"flow.npy", floats, get, guarded, frame::FrameKind::flow, codec::Codec::raw, "flow_npy"},
        {"instance.png", picture, get, guarded, frame::FrameKind::instance, codec::Codec::png, "instance"},
        {"soiling.png", picture, get, guarded, frame::FrameKind::soiling, codec::Codec::png, "soiling"},
        {"truth", truth, get, guarded, frame::FrameKind::color, codec::Codec::png, "truth"},
    };
    return paths;
}

Result<HttpRoute> route_of(std::string_view path) {
    const auto found = std::ranges::find(rig_paths(), path, &HttpPath::path);
    if (found != rig_paths().end()) return HttpRoute{*found, {}};
    const auto parts = segments_of(path);
    if (parts.empty() || parts.front() != "cameras") return HttpRoute{};
    if (parts.size() == 3) return camera_route(parts[1], parts[2]);
    return error(ErrorKind::not_found,
                 "no such path; a camera's pictures are /cameras/NAME/ and one of " + names_of_camera());
}

Result<HttpRoute> device_route_of(std::string_view path) {
    if (path.starts_with("/onvif/"))
        return HttpRoute{{.path = "/onvif/", .kind = RouteKind::device, .takes_post = true}, {}};
    auto route = route_of(path);
    if (route && route->path == "snapshot.jpg") return route;
    return error(ErrorKind::not_found,
                 "no such path; a network camera has POST /onvif/device_service and /cameras/NAME/snapshot.jpg");
}

Result<StreamParams> stream_params(const Target& target) {
    if (auto known = only_params(target, {"fps", "quality"}); !known) return std::unexpected(known.error());
    StreamParams params;
    auto rate = rate_of(target);
    if (!rate) return std::unexpected(rate.error());
    params.rate = *rate;
    auto quality = quality_of(target);
    if (!quality) return std::unexpected(quality.error());
    params.quality = *quality;
    return params;
}

Result<LiveParams> live_params(const Target& target) {
    if (auto known = only_params(target, {"cameras", "width", "fps", "quality"}); !known)
        return std::unexpected(known.error());
    auto cameras = cameras_of(target);
    if (!cameras) return std::unexpected(cameras.error());
    auto rate = rate_of(target);
    if (!rate) return std::unexpected(rate.error());
    auto quality = quality_of(target);
    if (!quality) return std::unexpected(quality.error());
    LiveParams params{std::move(*cameras), 0, *rate, quality->value_or(codec::default_jpeg_quality)};
    if (const std::string* text = target.find("width")) {
        const auto found = std::ranges::find(live_widths, *text, [](int width) { return std::to_string(width); });
        if (found == std::end(live_widths))
            return error(ErrorKind::invalid_argument,
                         "query: width must be 160, 320, 640 or 1280, or left out for each camera's own");
        params.width = *found;
    }
    return params;
}

Result<stream::FetchRequest> fetch_request(const HttpRoute& route, const Target& target) {
    const bool jpeg = route.codec == codec::Codec::jpeg;
    auto known = jpeg ? only_params(target, {"quality", "min_ns"}) : only_params(target, {"min_ns"});
    if (!known) return std::unexpected(known.error());
    stream::FetchRequest request;
    request.camera = route.camera;
    request.kind = route.frame;
    request.format.codec = route.codec;
    if (route.kind == RouteKind::floats) request.format.pixels = format_of(route.frame);
    if (jpeg) {
        auto quality = quality_of(target);
        if (!quality) return std::unexpected(quality.error());
        request.format.quality = quality->value_or(codec::default_jpeg_quality);
    }
    if (const std::string* text = target.find("min_ns")) {
        auto min_ns = parse_integer<TimeNs>("min_ns", *text, 0, max_time_ns);
        if (!min_ns) return std::unexpected(min_ns.error());
        request.min_ns = *min_ns;
    }
    return request;
}

Result<void> no_params(const Target& target) {
    return only_params(target, {});
}

}  // namespace camrig::http

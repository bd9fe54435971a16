#include "rtsp_out/http/route.h"

#include <algorithm>
#include <charconv>
#include <initializer_list>

#include "core/base/names.h"

namespace camrig {
namespace {

constexpr std::string_view camera_paths =
    "stream.mjpg, snapshot.jpg, snapshot.png, depth.png, depth.npy, instance.png, truth";

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

Result<int> quality_of(const Target& target) {
    const std::string* text = target.find("quality");
    return text ? parse_integer<int>("quality", *text, 1, 100) : default_jpeg_quality;
}

Result<HttpRoute> camera_route(std::string_view camera, std::string_view leaf) {
    if (auto name = check_name("camera", camera); !name) return error(ErrorKind::not_found, name.error().message);
    HttpRoute route{RouteKind::picture, std::string(camera), FrameKind::color, Codec::png};
    if (leaf == "stream.mjpg") {
        route.kind = RouteKind::stream;
        route.codec = Codec::jpeg;
    } else if (leaf == "snapshot.jpg") {
        route.codec = Codec::jpeg;
    } else if (leaf == "snapshot.png") {
        route.codec = Codec::png;
    } else if (leaf == "depth.png") {
        route.frame = FrameKind::depth;
    } else if (leaf == "instance.png") {
        route.frame = FrameKind::instance;
    } else if (leaf == "depth.npy") {
        route = {RouteKind::depth_npy, std::string(camera), FrameKind::depth, Codec::raw};
    } else if (leaf == "truth") {
        route.kind = RouteKind::truth;
    } else {
        return error(ErrorKind::not_found, "/cameras/" + std::string(camera) + " has no '" +
                                               std::string(leaf.substr(0, 40)) + "'; it has " +
                                               std::string(camera_paths));
    }
    return route;
}

}  // namespace

Result<HttpRoute> route_of(std::string_view path) {
    const auto parts = segments_of(path);
    if (path == "/cameras") return HttpRoute{RouteKind::cameras, {}, {}, {}};
    if (path == "/rpc") return HttpRoute{RouteKind::rpc, {}, {}, {}};
    if (path == "/healthz") return HttpRoute{RouteKind::healthz, {}, {}, {}};
    if (path == "/metrics") return HttpRoute{RouteKind::metrics, {}, {}, {}};
    if (parts.empty() || parts.front() != "cameras") return HttpRoute{};
    if (parts.size() == 3) return camera_route(parts[1], parts[2]);
    return error(ErrorKind::not_found,
                 "no such path; a camera's pictures are /cameras/NAME/ and one of " + std::string(camera_paths));
}

Result<StreamParams> stream_params(const Target& target) {
    if (auto known = only_params(target, {"fps", "quality"}); !known) return std::unexpected(known.error());
    StreamParams params;
    if (const std::string* fps = target.find("fps")) {
        auto rate = Rate::parse(*fps);
        if (!rate) return at("query", rate.error());
        params.rate = *rate;
    }
    auto quality = quality_of(target);
    if (!quality) return std::unexpected(quality.error());
    params.quality = *quality;
    return params;
}

Result<FetchRequest> fetch_request(const HttpRoute& route, const Target& target) {
    const bool jpeg = route.codec == Codec::jpeg;
    auto known = jpeg ? only_params(target, {"quality", "min_ns"}) : only_params(target, {"min_ns"});
    if (!known) return std::unexpected(known.error());
    FetchRequest request;
    request.camera = route.camera;
    request.kind = route.frame;
    request.format.codec = route.codec;
    if (route.kind == RouteKind::depth_npy) request.format.pixels = PixelFormat::depth32f;
    if (jpeg) {
        auto quality = quality_of(target);
        if (!quality) return std::unexpected(quality.error());
        request.format.quality = *quality;
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

}  // namespace camrig

#include "tools/camrig/onvif_parts.h"

#include <future>
#include <utility>

#include <spdlog/spdlog.h>

#include "core/base/clock.h"
#include "tools/camrig/version.h"

namespace camrig::cli {
namespace {

/// The streams of a camera that can be read, as ONVIF tells them.
std::vector<onvif::VideoStream> onvif_streams(const world::CameraSpec& camera) {
    std::vector<onvif::VideoStream> streams;
    for (const rtsp::StreamSettings& stream : rtsp::streams_of(camera.outputs, camera.size, camera.rate)) {
        if (!rtsp::can_be_carried(stream)) continue;
        std::string_view ending = rtsp::path_ending(stream.options);
        if (!ending.empty()) ending.remove_prefix(1);
        streams.push_back({.ending = std::string(ending),
                           .codec = std::string(to_string(stream.options.codec)),
                           .size = stream.size,
                           .rate = stream.rate,
                           .bitrate_kbps = stream.bitrate_kbps,
                           .key_interval_s = stream.options.key_interval_s,
                           .profile = stream.options.profile,
                           .quality = stream.options.quality});
    }
    return streams;
}

}  // namespace

http::DeviceHooks device_hooks(onvif::OnvifService& onvif) {
    http::DeviceHooks hooks;
    hooks.caller = [&onvif](std::string_view method, std::string_view target, std::string_view authorization,
                            bool shows_token) -> http::DeviceHooks::Caller {
        onvif::Authentication& access = onvif.authentication();
        if (access.is_open() || shows_token) return {.rank = static_cast<int>(onvif::Role::administrator)};
        const TimeNs now_ns = realtime_now_ns();
        const auto told = access.http_caller(method, target, authorization, now_ns);
        if (told.role) return {.rank = static_cast<int>(*told.role)};
        return {.is_stale = told.is_stale, .challenge = access.http_challenge(now_ns, told.is_stale)};
    };
    hooks.call = [&onvif](http::DeviceCall call, std::function<void(http::DeviceAnswer)> reply) {
        onvif.handle({.device = std::move(call.device),
                      .host = std::move(call.host),
                      .path = std::move(call.path),
                      .role = call.rank ? std::optional(static_cast<onvif::Role>(*call.rank)) : std::nullopt,
                      .body = std::move(call.body),
                      .port = call.port},
                     [reply = std::move(reply)](onvif::OnvifReply made) {
                         reply({.status = made.status,
                                .content_type = "application/soap+xml; charset=utf-8",
                                .text = std::move(made.text),
                                .is_refused = made.is_refused,
                                .asks_digest = made.asks_digest});
                     });
    };
    return hooks;
}

Result<std::uint16_t> open_onvif(std::optional<std::uint16_t> wanted, http::HttpServer& http) {
    if (!wanted) return 0;
    std::promise<Result<std::uint16_t>> opened;
    http.open_device_port("", *wanted, [&opened](Result<std::uint16_t> port) { opened.set_value(std::move(port)); });
    return opened.get_future().get();
}

onvif::Site onvif_site(const rtsp::RtspServer& rtsp, bool is_discoverable) {
    return {.version = version,
            .rtsp_scheme = rtsp.scheme(),
            .rtsp_port = rtsp.port(),
            .streams = onvif_streams,
            .has_h265 = rtsp::has_h265_encoder(),
            .is_discoverable = is_discoverable};
}

onvif::OnvifPorts::Doors onvif_doors(http::HttpServer& http, onvif::DiscoveryServer* discovery) {
    onvif::OnvifPorts::Doors doors{
        .open =
            [&http](const std::string& camera, std::uint16_t port, onvif::OnvifPorts::Done done) {
                http.open_device_port(camera, port,
                                      [camera, done = std::move(done)](const Result<std::uint16_t>& opened) {
                                          if (!opened)
                                              spdlog::warn("onvif: camera {}: {}", camera, opened.error().message);
                                          done(opened.has_value());
                                      });
            },
        .close = [&http](const std::string& camera, std::uint16_t port,
                         onvif::OnvifPorts::Done done) { http.close_device_port(camera, port, std::move(done)); }};
    if (discovery)
        doors.tell = [discovery](const std::string& camera, std::uint16_t port, bool is_there) {
            is_there ? discovery->add(camera, port) : discovery->remove(camera, port);
        };
    return doors;
}

}  // namespace camrig::cli

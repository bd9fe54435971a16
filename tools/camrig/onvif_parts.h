#pragma once

#include <cstdint>
#include <optional>

#include "control/onvif/discovery_server.h"
#include "control/onvif/onvif_output.h"
#include "control/onvif/onvif_service.h"
#include "rtsp_out/http/http_server.h"
#include "rtsp_out/rtsp/rtsp_server.h"

// ONVIF plugged into the rig: its devices are ports of the HTTP server, and tell of the streams of the RTSP server.
namespace camrig::cli {

/// What ONVIF devices answer over HTTP.
http::DeviceHooks device_hooks(onvif::OnvifService& onvif);
/// Opens the device with every camera and returns its port; 0: none is wanted.
Result<std::uint16_t> open_onvif(std::optional<std::uint16_t> wanted, http::HttpServer& http);
onvif::Site onvif_site(const rtsp::RtspServer& rtsp, bool is_discoverable);
/// How outputs {kind: "onvif"} are opened and closed. `discovery` is told of what can be found; nullptr: nobody is.
onvif::OnvifPorts::Doors onvif_doors(http::HttpServer& http, onvif::DiscoveryServer* discovery);

}  // namespace camrig::cli

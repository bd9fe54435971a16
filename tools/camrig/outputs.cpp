#include "tools/camrig/outputs.h"

#include "control/onvif/onvif_output.h"
#include "core/base/output_family.h"
#include "rtsp_out/http/mjpeg_output.h"
#include "rtsp_out/rtsp/rtsp_output.h"
#include "tools/camrig/device_outputs.h"
#include "v4l2_sink/loopback/loopback_output.h"
#include "v4l2_sink/loopback/loopback_server.h"
#include "v4l2_sink/preload/device_output.h"

namespace camrig::cli {
namespace {

using Opened = Result<std::unique_ptr<stream::CameraObserver>>;

Opened open_loopback_outputs(const OutputHost& host) {
    return std::make_unique<device::LoopbackServer>(
        host.bus, host.fetcher, device::LoopbackHost::Options{.always_subscribed = host.is_lockstep});
}

Opened open_device_outputs(const OutputHost& host) {
    return DeviceOutputs::create(host.bus, host.commands, host.device_socket);
}

/// The outputs that camrig has: to add a family is a line here.
struct {
    OutputFamily (*family)();
    Opened (*open)(
        const OutputHost& host);  ///< null: a server has such a stream of every camera, and reads the options
} constexpr outputs[] = {
    {device::loopback_family, open_loopback_outputs},
    {device::device_family, open_device_outputs},
    {rtsp::rtsp_family, nullptr},
    {http::mjpeg_family, nullptr},
};

}  // namespace

void register_outputs(std::shared_ptr<onvif::DevicePorts> ports) {
    std::vector<OutputFamily> families;
    for (const auto& output : outputs) families.push_back(output.family());
    families.push_back(onvif::onvif_family(std::move(ports)));  // whose ports are the HTTP server's
    set_output_families(std::move(families));
}

Result<std::vector<std::unique_ptr<stream::CameraObserver>>> open_outputs(const OutputHost& host) {
    std::vector<std::unique_ptr<stream::CameraObserver>> all;
    for (const auto& output : outputs) {
        if (!output.open) continue;
        auto opened = output.open(host);
        if (!opened) return std::unexpected(opened.error());
        all.push_back(std::move(*opened));
    }
    return all;
}

}  // namespace camrig::cli

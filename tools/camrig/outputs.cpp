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
    return std::make_unique<device::LoopbackServer>(host.bus, host.fetcher,
                                                    device::LoopbackHost::Options{.is_lockstep = host.is_lockstep});
}

Opened open_device_outputs(const OutputHost& host) {
    return DeviceOutputs::create(host.bus, host.commands, host.device_socket, host.is_lockstep);
}

/// What families are made with.
struct RegisterContext {
    std::shared_ptr<onvif::DevicePorts> ports;  ///< of cameras that are ONVIF devices: the HTTP server's
};

template <OutputFamily (*family)()>
OutputFamily made_with_nothing(const RegisterContext&) {
    return family();
}

OutputFamily made_with_ports(const RegisterContext& context) {
    return onvif::onvif_family(context.ports);
}

/// The outputs that camrig has: to add a family is a line here.
struct {
    OutputFamily (*family)(const RegisterContext& context);
    Opened (*open)(
        const OutputHost& host);  ///< null: a server has such a stream of every camera, and reads the options
} constexpr outputs[] = {
    {made_with_nothing<device::loopback_family>, open_loopback_outputs},
    {made_with_nothing<device::device_family>, open_device_outputs},
    {made_with_nothing<rtsp::rtsp_family>, nullptr},
    {made_with_nothing<http::mjpeg_family>, nullptr},
    {made_with_ports, nullptr},
};

}  // namespace

void register_outputs(std::shared_ptr<onvif::DevicePorts> ports) {
    std::vector<OutputFamily> families;
    const RegisterContext context{std::move(ports)};
    for (const auto& output : outputs) families.push_back(output.family(context));
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

#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "control/onvif/discovery_server.h"
#include "control/onvif/onvif_output.h"
#include "control/onvif/onvif_service.h"
#include "control/rpc/rpc_server.h"
#include "control/server/control_server.h"
#include "control/unrealcv/unrealcv_server.h"
#include "core/base/command_key.h"
#include "rtsp_out/http/http_server.h"
#include "rtsp_out/rtsp/rtsp_server.h"
#include "tools/camrig/rig_inputs.h"
#include "tools/camrig/running_rig.h"
#include "tools/camrig/server_facts.h"

namespace camrig::cli {

/// All that a rig is reached by. Who is told of another stands after it, and ends before it.
class RigServers {
public:
    /// `options`, `inputs` and `rig` outlive it. The users of `inputs` are taken. log: as RpcContext::log.
    RigServers(const ServeOptions& options, RigInputs& inputs, RunningRig& rig,
               std::function<Result<control::LogPlace>()> log);
    /// After an error some may be open.
    Result<void> open();

    /// What they all ask; also before they are open.
    control::RpcServer& rpc() { return rpc_; }
    /// What server.info tells.
    nlohmann::json facts() const { return facts_.get(); }
    /// What a person wants to know who has started the rig by hand, on stdout.
    void print_addresses() const;
    /// Nobody is let in any more. However far open() came; what the rig has in work for them may still be answered, so
    /// they are destroyed when the rig has stopped.
    void stop();

private:
    Result<void> open_rtsp();
    /// HTTP, and the ONVIF devices behind it.
    Result<void> open_http();
    Result<void> open_control();
    Result<void> open_unrealcv();

    const ServeOptions& options_;
    RigInputs& inputs_;
    RunningRig& rig_;
    ServerFacts facts_;
    control::RpcServer rpc_;
    std::unique_ptr<rtsp::RtspServer> rtsp_;
    std::optional<onvif::OnvifService> onvif_;
    std::unique_ptr<onvif::DiscoveryServer> discovery_;  ///< null: nobody is told
    std::unique_ptr<http::HttpServer> http_;
    std::uint16_t onvif_port_ = 0;  ///< of the device with every camera; 0: none is wanted
    std::optional<onvif::OnvifPorts> onvif_ports_;
    std::unique_ptr<control::ControlServer> control_;
    std::unique_ptr<unrealcv::UnrealCvServer> unrealcv_;  ///< null: it is not wanted
    std::vector<CommandKeyFile> keys_;
};

}  // namespace camrig::cli

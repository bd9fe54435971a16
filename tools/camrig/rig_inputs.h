#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "control/onvif/onvif_output.h"
#include "control/onvif/onvif_service.h"
#include "control/rpc/rpc_server.h"
#include "core/world/scene.h"
#include "tools/camrig/rig_folder.h"
#include "tools/camrig/serve.h"

namespace camrig::cli {

/// Who may command over HTTP and TCP; the owner of the Unix socket always may.
struct NetworkAccess {
    std::string key = {};     ///< asked for with commands; empty: none, or the token's matter
    std::string secret = {};  ///< what TCP asks for: the token, else the key
    control::Authority authority = control::Authority::command;
    std::string how_to_command = {};  ///< told to whom a command was refused
};

/// What a rig is made from: read, checked and claimed before there are threads.
struct RigInputs {
    std::string token = {};  ///< of --token-file; empty: none
    std::vector<onvif::User> users = {};
    NetworkAccess access = {};
    RigFolder folder;
    std::shared_ptr<onvif::DevicePorts> device_ports;
    world::SceneRef scene;
    std::string scene_name = {};
    std::filesystem::path scenes = {};  ///< the folder of the scene's file
};

/// Makes the families of outputs known, too. Errors name the option.
Result<RigInputs> read_inputs(const ServeOptions& options);

}  // namespace camrig::cli

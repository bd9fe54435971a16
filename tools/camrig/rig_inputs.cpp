#include "tools/camrig/rig_inputs.h"

#include <utility>

#include "core/base/command_key.h"
#include "core/base/tcp_listener.h"
#include "core/base/token.h"
#include "tools/camrig/outputs.h"

namespace camrig::cli {
namespace {

Result<NetworkAccess> network_access(const ServeOptions& options, const std::string& token) {
    NetworkAccess access{.secret = token};
    if (options.read_only) {
        access.authority = control::Authority::look;
        access.how_to_command = "this rig takes commands on its control socket " + options.control +
                                " only (it was started with --read-only)";
    } else if (token.empty() && !options.open_loopback) {
        auto key = new_command_key();
        if (!key) return std::unexpected(key.error());
        access.key = access.secret = std::move(*key);
        access.how_to_command =
            "commands need this rig's key: open the page by the link that camrig serve printed (it ends in #key=...), "
            "or "
            "send 'Authorization: Bearer KEY' with the line in the rig's key file, which camrig call server.info names";
    }
    return access;
}

}  // namespace

Result<RigInputs> read_inputs(const ServeOptions& options) {
    auto token = options.token_file.empty() ? Result<std::string>(std::string()) : read_token_file(options.token_file);
    if (!token) return at("--token-file", token.error());
    auto users =
        options.onvif_users.empty() ? Result<std::vector<onvif::User>>() : onvif::read_users_file(options.onvif_users);
    if (!users) return at("--onvif-users", users.error());
    auto access = network_access(options, *token);
    if (!access) return std::unexpected(access.error());
    auto folder = RigFolder::claim(options.control);
    if (!folder) return std::unexpected(folder.error());
    auto address = resolve_address("http", options.host);
    if (!address) return std::unexpected(address.error());
    auto device_ports = std::make_shared<onvif::DevicePorts>(std::move(*address));
    register_outputs(device_ports);  // before the scene is read, whose cameras have outputs
    auto scene = load_scene(options.scene, options.scene_options);
    if (!scene) return std::unexpected(scene.error());
    std::string name = (*scene)->name;
    auto scenes = std::filesystem::absolute((*scene)->file).parent_path();
    return RigInputs{.token = std::move(*token),
                     .users = std::move(*users),
                     .access = std::move(*access),
                     .folder = std::move(*folder),
                     .device_ports = std::move(device_ports),
                     .scene = std::move(*scene),
                     .scene_name = std::move(name),
                     .scenes = std::move(scenes)};
}

}  // namespace camrig::cli

#include "tools/camrig/rig_servers.h"

#include <cstdio>
#include <utility>

#include <signal.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "core/base/tcp_listener.h"
#include "tools/camrig/command_history.h"
#include "tools/camrig/http_hooks.h"
#include "tools/camrig/onvif_parts.h"
#include "tools/camrig/version.h"

namespace camrig::cli {
namespace {

/// Where clients of this user find the key by themselves. Without them the rig goes on: the printed link carries the
/// key, so that nobody stops a rig by taking a name in /tmp.
std::vector<CommandKeyFile> write_key_files(const std::string& key, const http::HttpServer& http,
                                            const control::ControlServer& control, ServerFacts& facts) {
    std::vector<CommandKeyFile> files;
    if (key.empty()) return files;
    const auto write = [&](const std::string& address, std::uint16_t port) {
        auto file = CommandKeyFile::create(key, address, port);
        if (!file)
            return spdlog::warn("{}; until then no client finds the key for commands by itself", file.error().message);
        if (files.empty()) facts.add("key_file", file->path());
        files.push_back(std::move(*file));
    };
    write(http.address(), http.port());
    if (control.tcp_port() != 0) write(control.tcp_address(), control.tcp_port());
    return files;
}

/// UnrealCV's protocol knows no passwords.
std::string unrealcv_host(const ServeOptions& options) {
    return is_loopback_address(options.host) ? options.host : "127.0.0.1";
}

/// As it stands in a URL: an address of IPv6 goes into brackets.
std::string in_url(const std::string& host) {
    return host.contains(':') ? "[" + host + "]" : host;
}

/// Null: it is not wanted.
Result<std::unique_ptr<unrealcv::UnrealCvServer>> make_unrealcv(const ServeOptions& options, const std::string& scene,
                                                                engine::Engine& engine) {
    if (!options.unrealcv_port) return nullptr;
    if (options.read_only)
        return error(ErrorKind::invalid_argument,
                     "--unrealcv: its clients command, and this rig was started with --read-only");
    return unrealcv::UnrealCvServer::create(
        engine, engine,
        {.host = unrealcv_host(options),
         .port = *options.unrealcv_port,
         .name = scene,
         .folder = options.unrealcv_folder,
         .depth = options.unrealcv_ray_depth ? unrealcv::Depth::ray_m : unrealcv::Depth::plane_cm});
}

http::HttpOptions http_options(const ServeOptions& options, const std::string& token, const std::string& command_key,
                               stream::FrameBus& bus, stream::FrameFetcher& fetcher, http::HttpHooks hooks) {
    return {.host = options.host,
            .port = options.http_port,
            .token = token,
            .command_key = command_key,
            .bus = &bus,
            .fetcher = &fetcher,
            .embedders = options.embed_origins,
            .hooks = std::move(hooks),
            .limits = {}};
}

rtsp::RtspOptions rtsp_options(const ServeOptions& options, const std::string& token, stream::FrameBus& bus,
                               stream::FrameFetcher& fetcher) {
    return {.host = options.host,
            .port = options.rtsp_port,
            .token = token,
            .certificate = options.rtsp_cert,
            .key = options.rtsp_key,
            .bus = &bus,
            .fetcher = &fetcher,
            .h264_elements = options.rtsp_encoder.empty() ? rtsp::h264_elements : std::vector{options.rtsp_encoder},
            .limits = {}};
}

}  // namespace

RigServers::RigServers(const ServeOptions& options, RigInputs& inputs, RunningRig& rig,
                       std::function<Result<control::LogPlace>()> log)
    : options_(options),
      inputs_(inputs),
      rig_(rig),
      rpc_({.commands = *rig.engine,
            .frames = *rig.engine,
            .info = [this] { return facts_.get(); },
            .shutdown = [] { ::kill(::getpid(), SIGTERM); },  // StopSignal waits for it
            .token = inputs.access.secret,
            .how_to_command = inputs.access.how_to_command,
            .scenes = inputs.scenes,
            .identity = program_identity,
            .log = std::move(log),
            .keeps_text = options.is_held || !options.log.empty() || !options.replay.empty()}) {
    facts_.add("version", version);
    facts_.add("pid", ::getpid());
    facts_.add("renderer", rig.engine->renderer_description());
    facts_.add("control", options.control);
    facts_.add("host", options.host);
    facts_.add("devices", real_device_socket_of(options.control));
}

Result<void> RigServers::open() {
    for (const auto step :
         {&RigServers::open_rtsp, &RigServers::open_http, &RigServers::open_control, &RigServers::open_unrealcv})
        if (auto opened = (this->*step)(); !opened) return opened;
    keys_ = write_key_files(inputs_.access.key, *http_, *control_, facts_);
    return {};
}

Result<void> RigServers::open_rtsp() {
    auto made = rtsp::RtspServer::create(rtsp_options(options_, inputs_.token, rig_.bus, *rig_.engine));
    if (!made) return std::unexpected(made.error());
    rtsp_ = std::move(*made);
    facts_.add("rtsp", rtsp_->port());
    facts_.add("rtsp_scheme", rtsp_->scheme());
    facts_.add_connections("rtsp", [server = rtsp_.get()] { return server->counts(); });
    return {};
}

Result<void> RigServers::open_http() {
    const bool is_discoverable = !options_.onvif_discovery.empty();
    onvif_.emplace(*rig_.engine, *rig_.engine,
                   onvif::OnvifService::Options{.site = onvif_site(*rtsp_, is_discoverable),
                                                .token = inputs_.token,
                                                .users = std::move(inputs_.users),
                                                .may_command = !options_.read_only});
    if (is_discoverable) {
        auto made = onvif::DiscoveryServer::create(options_.onvif_discovery, options_.host, *rig_.engine);
        if (!made) return std::unexpected(made.error());
        discovery_ = std::move(*made);
    }
    auto hooks = http_hooks(rpc_, inputs_.access.authority, *rig_.engine, rig_.truth_text);
    hooks.device = device_hooks(*onvif_);
    auto made = http::HttpServer::create(
        http_options(options_, inputs_.token, inputs_.access.key, rig_.bus, *rig_.engine, std::move(hooks)));
    if (!made) return std::unexpected(made.error());
    http_ = std::move(*made);
    facts_.add("http", http_->port());
    facts_.add_connections("http", [server = http_.get()] { return server->counts().connections; });
    const auto port = open_onvif(options_.onvif_port, *http_);
    if (!port) return std::unexpected(port.error());
    onvif_port_ = *port;
    if (options_.onvif_port) facts_.add("onvif", onvif_port_);
    if (discovery_ && options_.onvif_port) discovery_->add("", onvif_port_);
    onvif_ports_.emplace(rig_.bus, inputs_.device_ports, onvif_doors(*http_, discovery_.get()));
    return {};
}

Result<void> RigServers::open_control() {
    auto made = control::ControlServer::create({.unix_path = options_.control,
                                                .host = options_.host,
                                                .tcp_port = options_.tcp_port,
                                                .token = inputs_.access.secret,
                                                .tcp_authority = inputs_.access.authority,
                                                .rpc = &rpc_});
    if (!made) return std::unexpected(made.error());
    control_ = std::move(*made);
    facts_.add("tcp", control_->tcp_port());
    facts_.add_connections("control", [server = control_.get()] { return server->counts(); });
    return {};
}

Result<void> RigServers::open_unrealcv() {
    auto made = make_unrealcv(options_, inputs_.scene_name, *rig_.engine);
    if (!made) return std::unexpected(made.error());
    unrealcv_ = std::move(*made);
    if (!unrealcv_) return {};
    facts_.add("unrealcv", unrealcv_->port());
    facts_.add_connections("unrealcv", [server = unrealcv_.get()] { return server->counts(); });
    return {};
}

void RigServers::print_addresses() const {
    const std::string renderer = rig_.engine->renderer_description();
    std::printf("camrig %s  %s\n  control  %s\n", version, renderer.c_str(), options_.control.c_str());
    const std::string address = in_url(options_.host);
    const char* const host = address.c_str();
    if (options_.tcp_port) std::printf("  control  %s:%u\n", host, control_->tcp_port());
    // As a fragment the key stays in the browser: it is neither sent nor logged when the page is asked for.
    const std::string key = inputs_.access.key.empty() ? "" : "#key=" + inputs_.access.key;
    std::printf("  http     http://%s:%u/%s\n", host, http_->port(), key.c_str());
    for (const auto& camera : rig_.bus.cameras()) {
        const char* const name = camera.name.c_str();
        std::printf("  camera   http://%s:%u/cameras/%s/stream.mjpg\n", host, http_->port(), name);
        std::printf("  camera   %s://%s:%u/%s\n", rtsp_->scheme(), host, rtsp_->port(), name);
        for (const OutputSpec& output : camera.outputs)
            if (output.kind == "onvif")
                std::printf("  camera   http://%s:%d/onvif/device_service\n", host,
                            options_of<onvif::OnvifOutput>(output).port);
    }
    if (onvif_port_ != 0) std::printf("  onvif    http://%s:%u/onvif/device_service\n", host, onvif_port_);
    if (unrealcv_) std::printf("  unrealcv %s:%u\n", in_url(unrealcv_host(options_)).c_str(), unrealcv_->port());
    std::fflush(stdout);
}

void RigServers::stop() {
    if (unrealcv_) unrealcv_->stop();
    keys_.clear();  // before their ports are free for another rig
    if (control_) control_->stop();
    if (rtsp_) rtsp_->stop();
    onvif_ports_.reset();
    if (http_) http_->stop();
    if (discovery_) discovery_->stop();
    if (onvif_) onvif_->stop();
    rpc_.stop();
}

}  // namespace camrig::cli

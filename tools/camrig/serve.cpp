#include "tools/camrig/serve.h"

#include <csignal>
#include <cstdio>
#include <new>
#include <string_view>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <malloc.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "control/onvif/discovery_server.h"
#include "control/onvif/onvif_output.h"
#include "control/onvif/onvif_service.h"
#include "control/rpc/rpc_server.h"
#include "control/server/control_server.h"
#include "control/unrealcv/unrealcv_server.h"
#include "control/web/page_files.h"
#include "core/base/clock.h"
#include "core/base/command_key.h"
#include "core/base/descriptors.h"
#include "core/base/tcp_listener.h"
#include "core/base/token.h"
#include "core/stream/local_frame_bus.h"
#include "core/truth/truth_json.h"
#include "rtsp_out/http/http_server.h"
#include "rtsp_out/rtsp/rtsp_server.h"
#include "tools/camrig/onvif_parts.h"
#include "tools/camrig/outputs.h"
#include "tools/camrig/rig_folder.h"
#include "tools/camrig/server_facts.h"
#include "tools/camrig/version.h"

// The composition root: makes every part, plugs them together, and takes them down in the opposite order.
namespace camrig::cli {
namespace {

constexpr std::size_t max_truths_waiting = 64;
constexpr int max_heaps = 2;
/// Memory of this size and more goes back to the system when it is freed.
constexpr int mapped_bytes = 1 << 18;

int fail(const Error& why) {
    std::fprintf(stderr, "camrig: %s\n", why.message.c_str());
    return 1;
}

/// While it lives, and its is_over() was not called, a program without memory ends with a message instead of an
/// exception in whichever thread it was. Once the rig serves, a request that finds no memory is an error of its own.
class EndWithoutMemory {
public:
    EndWithoutMemory() {
        std::set_new_handler([] {
            constexpr std::string_view text = "camrig: there is not enough memory to start (see ulimit -v)\n";
            static_cast<void>(!::write(STDERR_FILENO, text.data(), text.size()));
            ::_exit(1);
        });
    }
    ~EndWithoutMemory() { is_over(); }
    void is_over() const { std::set_new_handler(nullptr); }
};

/// The signals that end the rig are blocked in every thread and waited for in one.
class StopSignal {
public:
    StopSignal() {
        sigemptyset(&signals_);
        sigaddset(&signals_, SIGINT);
        sigaddset(&signals_, SIGTERM);
        pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
    }
    void wait() {
        int signal = 0;
        sigwait(&signals_, &signal);
    }
    /// From any thread.
    static void raise() { ::kill(::getpid(), SIGTERM); }

private:
    sigset_t signals_{};
};

void tell_ready(int fd, const nlohmann::json& facts) {
    if (fd < 0) return;
    const std::string line = facts.dump() + "\n";
    if (::write(fd, line.data(), line.size()) != static_cast<ssize_t>(line.size()))
        spdlog::warn("--ready-fd {}: could not be written", fd);
    if (fd > STDERR_FILENO) ::close(fd);
}

/// To be asked before anything else is opened: a number that nobody opened for us would soon be one of our own files.
Result<void> check_ready_fd(int fd) {
    const int flags = fd < 0 ? O_WRONLY : ::fcntl(fd, F_GETFL);
    if (flags >= 0 && (flags & O_ACCMODE) != O_RDONLY) return {};
    const std::string number = std::to_string(fd);
    return error(ErrorKind::invalid_argument,
                 "--ready-fd " + number +
                     ": no file is open for writing there; in a shell: camrig serve ... --ready-fd " + number + " " +
                     number + ">FILE");
}

/// Who may command over HTTP and TCP; the owner of the Unix socket always may.
struct NetworkAccess {
    std::string key = {};     ///< asked for with commands; empty: none, or the token's matter
    std::string secret = {};  ///< what TCP asks for: the token, else the key
    control::Authority authority = control::Authority::command;
    std::string how_to_command = {};  ///< told to whom a command was refused
};

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

/// What the HTTP server asks of the rig. The engine's thread has no time for text, and the server's must not wait for
/// it.
http::HttpHooks http_hooks(control::RpcServer& rpc, control::Authority granted, engine::Engine& engine,
                           stream::WorkerPool& truth_text) {
    http::HttpHooks hooks;
    hooks.rpc = [&rpc, granted](std::string body, bool may_command, std::function<void(http::RpcText)> reply) {
        const auto done = [reply = std::move(reply)](control::RpcAnswer answer) {
            auto claims = std::make_shared<std::vector<ByteBudget::Claim>>(std::move(answer.claims));
            reply({std::move(answer.pieces), std::move(claims)});
        };
        rpc.handle(body, done, may_command ? granted : control::Authority::look);
    };
    hooks.stats = [&engine](std::function<void(stream::RigReport)> reply) {
        engine.post(engine::Request<engine::GetStats>{{}, [reply = std::move(reply)](Result<stream::RigReport> report) {
                                                          reply(report ? std::move(*report) : stream::RigReport{});
                                                      }});
    };
    hooks.truth = [&engine, &truth_text](std::string camera, TimeNs min_ns,
                                         std::function<void(Result<std::string>)> reply) {
        engine.post(engine::Request<engine::GetTruth>{
            {std::move(camera), min_ns}, [&truth_text, reply = std::move(reply)](Result<truth::TruthRef> truth) {
                if (!truth) return reply(std::unexpected(truth.error()));
                std::function<void()> job = [reply, truth = std::move(*truth)] {
                    reply(truth_to_json(*truth).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
                };
                if (!truth_text.post(std::move(job))) job();
            }});
    };
    hooks.files = [](std::string_view path) -> std::optional<http::StaticFile> {
        const auto file = control::page_file(path);
        if (!file) return std::nullopt;
        return http::StaticFile{std::string(file->content_type), std::make_shared<const std::string>(file->text)};
    };
    return hooks;
}

/// Null: it is not wanted.
Result<std::unique_ptr<unrealcv::UnrealCvServer>> open_unrealcv(const ServeOptions& options, const std::string& scene,
                                                                engine::Engine& engine) {
    if (!options.unrealcv_port) return nullptr;
    if (options.read_only)
        return error(ErrorKind::invalid_argument,
                     "--unrealcv: its clients command, and this rig was started with --read-only");
    return unrealcv::UnrealCvServer::create(
        engine, engine,
        {.host = is_loopback_address(options.host) ? options.host : "127.0.0.1",
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

/// What a person wants to know who has started the rig by hand.
void print_addresses(const ServeOptions& options, const std::string& renderer, const std::string& command_key,
                     const http::HttpServer& http, const rtsp::RtspServer& rtsp, const control::ControlServer& control,
                     std::uint16_t onvif_port, const unrealcv::UnrealCvServer* unrealcv,
                     const std::vector<stream::CameraStream>& cameras) {
    std::printf("camrig %s  %s\n  control  %s\n", version, renderer.c_str(), options.control.c_str());
    // As it stands in a URL: an address of IPv6 goes into brackets.
    const std::string address = options.host.contains(':') ? "[" + options.host + "]" : options.host;
    const char* const host = address.c_str();
    if (options.tcp_port) std::printf("  control  %s:%u\n", host, control.tcp_port());
    // As a fragment the key stays in the browser: it is neither sent nor logged when the page is asked for.
    const std::string key = command_key.empty() ? "" : "#key=" + command_key;
    std::printf("  http     http://%s:%u/%s\n", host, http.port(), key.c_str());
    for (const auto& camera : cameras) {
        const char* const name = camera.name.c_str();
        std::printf("  camera   http://%s:%u/cameras/%s/stream.mjpg\n", host, http.port(), name);
        std::printf("  camera   %s://%s:%u/%s\n", rtsp.scheme(), host, rtsp.port(), name);
        for (const OutputSpec& output : camera.outputs)
            if (output.kind == "onvif")
                std::printf("  camera   http://%s:%d/onvif/device_service\n", host,
                            options_of<onvif::OnvifOutput>(output).port);
    }
    if (onvif_port != 0) std::printf("  onvif    http://%s:%u/onvif/device_service\n", host, onvif_port);
    if (unrealcv) std::printf("  unrealcv 127.0.0.1:%u\n", unrealcv->port());
    std::fflush(stdout);
}

/// What is made of the rig, in the order of its making. When it goes, however far the start came, those who ask go
/// first, then the engine, and last those whom it answers: until then it may have something in work for them.
struct Parts {
    Parts() = default;
    Parts(const Parts&) = delete;
    Parts& operator=(const Parts&) = delete;
    ~Parts() {
        if (unrealcv) unrealcv->stop();
        keys.clear();  // before their ports are free for another rig
        if (control) control->stop();
        if (rtsp) rtsp->stop();
        onvif_ports.reset();
        if (http) http->stop();
        if (discovery) discovery->stop();
        if (onvif) onvif->stop();
        if (rpc) rpc->stop();
        truth_text.stop();
        outputs.clear();
        engine.reset();
    }

    std::unique_ptr<engine::Engine> engine;
    std::vector<std::unique_ptr<stream::CameraObserver>> outputs;
    stream::WorkerPool truth_text{1, max_truths_waiting};
    ServerFacts facts;
    std::optional<control::RpcServer> rpc;
    std::unique_ptr<rtsp::RtspServer> rtsp;
    std::optional<onvif::OnvifService> onvif;
    std::unique_ptr<onvif::DiscoveryServer> discovery;  // the HTTP server tells it of ports
    std::unique_ptr<http::HttpServer> http;
    std::optional<onvif::OnvifPorts> onvif_ports;
    std::unique_ptr<control::ControlServer> control;
    std::unique_ptr<unrealcv::UnrealCvServer> unrealcv;
    std::vector<CommandKeyFile> keys;
};

/// Puts what was made where it belongs.
template <typename T>
Result<void> place(Result<std::unique_ptr<T>> made, std::unique_ptr<T>& where) {
    if (!made) return std::unexpected(made.error());
    where = std::move(*made);
    return {};
}

}  // namespace

int run_serve(const ServeOptions& options) {
    if (auto open = check_ready_fd(options.ready_fd); !open) return fail(open.error());
    std::signal(SIGPIPE, SIG_IGN);
    const EndWithoutMemory at_start;
    if (const std::string problem = raise_descriptor_limit(); !problem.empty()) spdlog::warn(problem);
    // glibc gives new threads heaps of their own, which streams that come and go would leave behind half empty.
    mallopt(M_ARENA_MAX, max_heaps);
    // Without a fixed bound it keeps up to 64 MB of what was freed last: pictures and textures of scenes that are gone.
    mallopt(M_MMAP_THRESHOLD, mapped_bytes);
    mallopt(M_TRIM_THRESHOLD, 32 * mapped_bytes);
    StopSignal stop;

    auto token = options.token_file.empty() ? Result<std::string>(std::string()) : read_token_file(options.token_file);
    if (!token) return fail(at("--token-file", token.error()).error());
    auto users =
        options.onvif_users.empty() ? Result<std::vector<onvif::User>>() : onvif::read_users_file(options.onvif_users);
    if (!users) return fail(at("--onvif-users", users.error()).error());
    auto access = network_access(options, *token);
    if (!access) return fail(access.error());
    auto folder = RigFolder::claim(options.control);
    if (!folder) return fail(folder.error());
    auto address = resolve_address("http", options.host);
    if (!address) return fail(address.error());
    const auto device_ports = std::make_shared<onvif::DevicePorts>(std::move(*address));
    register_outputs(device_ports);
    auto scene = load_scene(options.scene, options.scene_options);
    if (!scene) return fail(scene.error());
    const auto scenes = std::filesystem::absolute((*scene)->file).parent_path();
    const std::string scene_name = (*scene)->name;

    auto pool = std::make_shared<frame::FramePool>();
    stream::LocalFrameBus bus({static_cast<int>(std::max(1u, std::thread::hardware_concurrency())), pool});
    engine::EngineOptions engine_options = options.engine;
    engine_options.renderer.pool = pool;
    Parts parts;
    if (auto made = place(engine::Engine::start(std::move(*scene), engine_options, bus), parts.engine); !made)
        return fail(made.error());
    engine::Engine& engine = *parts.engine;

    auto outputs = open_outputs({.bus = bus,
                                 .fetcher = engine,
                                 .commands = engine,
                                 .device_socket = device_socket_of(options.control),
                                 .is_lockstep = options.engine.mode == engine::RunMode::lockstep});
    if (!outputs) return fail(outputs.error());
    parts.outputs = std::move(*outputs);

    ServerFacts& facts = parts.facts;
    facts.add("version", version);
    facts.add("pid", ::getpid());
    facts.add("renderer", engine.renderer_description());
    facts.add("control", options.control);
    facts.add("host", options.host);
    facts.add("devices", device_socket_of(options.control));
    control::RpcServer& rpc = parts.rpc.emplace(control::RpcContext{.commands = engine,
                                                                    .frames = engine,
                                                                    .info = [&facts] { return facts.get(); },
                                                                    .shutdown = [] { StopSignal::raise(); },
                                                                    .token = access->secret,
                                                                    .how_to_command = access->how_to_command,
                                                                    .scenes = scenes});

    if (auto made = place(rtsp::RtspServer::create(rtsp_options(options, *token, bus, engine)), parts.rtsp); !made)
        return fail(made.error());
    facts.add("rtsp", parts.rtsp->port());

    onvif::OnvifService& onvif = parts.onvif.emplace(
        engine, engine,
        onvif::OnvifService::Options{.site = onvif_site(*parts.rtsp, !options.onvif_discovery.empty()),
                                     .token = *token,
                                     .users = std::move(*users),
                                     .may_command = !options.read_only});
    if (!options.onvif_discovery.empty()) {
        auto made = onvif::DiscoveryServer::create(options.onvif_discovery, options.host, engine);
        if (auto done = place(std::move(made), parts.discovery); !done) return fail(done.error());
    }
    auto hooks = http_hooks(rpc, access->authority, engine, parts.truth_text);
    hooks.device = device_hooks(onvif);
    auto http = http::HttpServer::create(http_options(options, *token, access->key, bus, engine, std::move(hooks)));
    if (auto made = place(std::move(http), parts.http); !made) return fail(made.error());
    facts.add("http", parts.http->port());
    const auto onvif_port = open_onvif(options.onvif_port, *parts.http);
    if (!onvif_port) return fail(onvif_port.error());
    if (options.onvif_port) facts.add("onvif", *onvif_port);
    if (parts.discovery && options.onvif_port) parts.discovery->add("", *onvif_port);
    parts.onvif_ports.emplace(bus, device_ports, onvif_doors(*parts.http, parts.discovery.get()));

    auto control = control::ControlServer::create({.unix_path = options.control,
                                                   .host = options.host,
                                                   .tcp_port = options.tcp_port,
                                                   .token = access->secret,
                                                   .tcp_authority = access->authority,
                                                   .rpc = &rpc});
    if (auto made = place(std::move(control), parts.control); !made) return fail(made.error());
    facts.add("tcp", parts.control->tcp_port());
    facts.add_connections("control", [server = parts.control.get()] { return server->counts(); });
    facts.add_connections("http", [server = parts.http.get()] { return server->counts().connections; });
    facts.add_connections("rtsp", [server = parts.rtsp.get()] { return server->counts(); });
    if (auto made = place(open_unrealcv(options, scene_name, engine), parts.unrealcv); !made) return fail(made.error());
    if (parts.unrealcv) {
        facts.add("unrealcv", parts.unrealcv->port());
        facts.add_connections("unrealcv", [server = parts.unrealcv.get()] { return server->counts(); });
    }
    parts.keys = write_key_files(access->key, *parts.http, *parts.control, facts);

    print_addresses(options, engine.renderer_description(), access->key, *parts.http, *parts.rtsp, *parts.control,
                    *onvif_port, parts.unrealcv.get(), bus.cameras());
    at_start.is_over();
    tell_ready(options.ready_fd, facts.get());

    stop.wait();
    return 0;
}

}  // namespace camrig::cli

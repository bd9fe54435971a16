#include <limits>
#include <map>
#include <memory>

#include <CLI/CLI.hpp>

#include "control/client/endpoint.h"
#include "rtsp_out/http/asking_page.h"
#include "rtsp_out/rtsp/video_encoder.h"
#include "tools/camrig/cli_commands.h"

namespace camrig::cli {
namespace {

/// An option by the name of its value. CLI11 would print the enumeration with our to_string(), whose string_view it
/// cannot take.
template <HasNames E>
void add_named_option(CLI::App& command, const std::string& option, std::function<void(E)> set,
                      const std::string& help) {
    std::vector<std::string> names;
    for (const Named<E>& each : names_of(std::type_identity<E>{})) names.emplace_back(each.name);
    command
        .add_option_function<std::string>(
            option, [set = std::move(set)](const std::string& name) { set(*parse_name<E>(name)); }, help)
        ->check(CLI::IsMember(names));
}

}  // namespace

void add_serve_command(CLI::App& app, CliContext& context, const CliHooks& hooks) {
    static const std::map<std::string, render::Conversion> conversions{{"auto", render::Conversion::automatic},
                                                                       {"host", render::Conversion::host},
                                                                       {"device", render::Conversion::device}};
    const auto is_port = CLI::Range(0, 65535);

    auto options = std::make_shared<ServeOptions>();
    CLI::App* serve = app.add_subcommand("serve", "serves a scene until it is told to end");
    serve->add_option("SCENE", options->scene, scene_option_help)->required();
    serve->add_flag_callback("--no-ground", [options] { options->scene_options.bare_ground = false; }, no_ground_help);
    serve->add_option("--host", options->host, "address to listen on; beyond loopback a --token-file is needed")
        ->capture_default_str();
    serve->add_option("--http", options->http_port, "port of HTTP; 0: any free one")
        ->check(is_port)
        ->capture_default_str();
    serve->add_option("--rtsp", options->rtsp_port, "port of RTSP; 0: any free one")
        ->check(is_port)
        ->capture_default_str();
    serve->add_option("--rtsp-cert", options->rtsp_cert, "certificate (PEM): RTSP becomes RTSPS")
        ->check(CLI::ExistingFile);
    serve->add_option("--rtsp-key", options->rtsp_key, "its key (PEM); default: in the certificate's file")
        ->check(CLI::ExistingFile);
    serve
        ->add_option("--rtsp-encoder", options->rtsp_encoder, "of H.264; default: the first of these that is installed")
        ->check(CLI::IsMember(rtsp::h264_elements));
    serve
        ->add_option(
            "--embed", options->embed_origins,
            "origin of web pages that may show pictures, as http://dashboard.example:3000; may be given several "
            "times. Without it only the rig's own page can")
        ->check([](const std::string& text) -> std::string {
            const auto good = http::check_page_origin(text);
            return good ? "" : good.error().message;
        })
        ->allow_extra_args(false);
    serve->add_option("--tcp", options->tcp_port, "port of control over TCP (off by default); 0: any free one")
        ->check(is_port);
    serve
        ->add_option("--onvif", options->onvif_port,
                     "port of an ONVIF device with every camera (off by default); 0: any free one. Cameras with an "
                     "output onvif are devices of their own")
        ->check(is_port);
    serve->add_option("--onvif-discovery", options->onvif_discovery,
                      "interface, as eth0, on which clients find the ONVIF devices by WS-Discovery (off by default)");
    serve->add_option("--onvif-users", options->onvif_users,
                      "file of mode 0600 with a line NAME ROLE PASSWORD for each user of ONVIF devices; roles are "
                      "administrator, operator and user");
    serve
        ->add_option("--unrealcv", options->unrealcv_port,
                     "port of UnrealCV's protocol for its clients, on loopback (off by default); 0: any free one. "
                     "Clients of UnrealCV expect 9000")
        ->check(is_port);
    serve->add_option("--unrealcv-dir", options->unrealcv_folder,
                      "folder in which UnrealCV's clients may have pictures written; without it nowhere");
    serve->add_flag("--unrealcv-ray-depth", options->unrealcv_ray_depth,
                    "depth for UnrealCV's clients is along each ray in metres, as before 1.0; else along the axis in "
                    "centimetres");
    auto* open_loopback =
        serve->add_flag("--open-loopback", options->open_loopback,
                        "commands over loopback HTTP and TCP need no key: for containers and machines of "
                        "one user");
    serve->add_flag("--read-only", options->read_only, "HTTP and TCP only look: commands on the Unix socket alone")
        ->excludes(open_loopback);
    add_named_option<engine::RunMode>(
        *serve, "--mode", [options](engine::RunMode mode) { options->engine.mode = mode; },
        "realtime (default) or lockstep: moved by world.step only");
    add_named_option<engine::OverloadPolicy>(
        *serve, "--overload", [options](engine::OverloadPolicy policy) { options->engine.overload = policy; },
        "drop whole instants (default) or slow the world down");
    serve->add_option("--seed", options->engine.seed, "of all chance in the world; default: the scene's")
        ->check([](const std::string& text) -> std::string {
            // CLI11 would take -1 as 2^64 - 1.
            return text.find_first_not_of("0123456789") == std::string::npos ? "" : "must be a number from 0 on";
        });
    auto* held = serve->add_flag(
        "--held", options->is_held,
        "for one world on many machines: commands need a world time at_ns, and in real time the world runs "
        "as far as world.limit lets it, from 0 on");
    serve->add_option("--log", options->log,
                      "file into which each command goes that changes something, with its world time");
    serve
        ->add_option("--replay", options->replay,
                     "such a file: all of it is done again at the start, as fast as the machine can. The same file as "
                     "--log is gone on with")
        ->check(CLI::ExistingFile)
        ->excludes(held);
    add_named_option<world::Quality>(
        *serve, "--quality", [options](world::Quality quality) { options->engine.quality = quality; },
        "fast, simple (default) or beautiful");
    serve->add_option("--device", options->engine.renderer.device,
                      "EGL device N, cpu, or llvmpipe (Mesa's rasteriser); default: the first with hardware, else cpu");
    serve
        ->add_option_function<int>(
            "--static-layer-mb",
            [options](const int& mb) { options->engine.renderer.static_layer_bytes = std::int64_t{mb} << 20; },
            "memory for pictures of what does not move, MB (256); 0: everything is drawn each time, the same bytes")
        ->check(CLI::Range(0, 1 << 20));
    serve
        ->add_option("--detail-error-px", options->engine.renderer.max_detail_error_px,
                     "people far away are drawn with fewer triangles where that shows less than this; 0: never")
        ->check(CLI::Range(0.0, 16.0))
        ->capture_default_str();
    serve
        ->add_option_function<std::string>(
            "--convert-on",
            [options](const std::string& where) { options->engine.renderer.conversion = conversions.at(where); },
            "where colours become YUV or BGR for readers: device (by a shader, before they are read back; a GPU or "
            "llvmpipe), host, or auto (default): on the device if it is a GPU; the same YUV and BGR")
        ->check(CLI::IsMember({"auto", "host", "device"}));
    serve
        ->add_option("--ready-fd", options->ready_fd,
                     "writes one JSON line with control, http and rtsp here when ready")
        ->check(CLI::Range(0, std::numeric_limits<int>::max()));
    serve->callback([options, &context, &hooks] {
        context.action = [options, &context, &hooks] {
            options->control = context.control.empty() ? client::default_control() : context.control;
            if (const auto at = client::Endpoint::parse(options->control); !at || !at->host.empty())
                return context.usage("--control: a rig's own socket is a path, and " + options->control +
                                     " is an address; control over TCP is --tcp PORT");
            options->token_file = context.token_file;
            return hooks.serve(*options);
        };
    });
}

}  // namespace camrig::cli

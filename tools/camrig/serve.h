#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/engine/engine.h"

namespace camrig::cli {

/// The options of `camrig serve`, as in the contract.
struct ServeOptions {
    std::filesystem::path scene;  ///< as load_scene() takes it
    world::SceneOptions scene_options;
    std::string control;  ///< path of the Unix socket; never empty
    std::string host = "127.0.0.1";
    std::uint16_t http_port = 8080;
    std::uint16_t rtsp_port = 8554;
    std::optional<std::uint16_t> tcp_port;
    std::optional<std::uint16_t> onvif_port;     ///< of an ONVIF device with every camera
    std::string onvif_discovery;                 ///< interface on which devices are found; empty: none
    std::filesystem::path onvif_users;           ///< file of users with roles; empty: none
    std::optional<std::uint16_t> unrealcv_port;  ///< of UnrealCV's protocol, on loopback
    std::filesystem::path unrealcv_folder;       ///< where its clients may have files written; empty: nowhere
    bool unrealcv_ray_depth = false;  ///< its `depth` is along rays, metres; else along the axis, centimetres
    std::filesystem::path token_file;
    bool open_loopback = false;                 ///< commands over loopback need no key
    bool read_only = false;                     ///< no commands over HTTP and TCP at all
    std::filesystem::path rtsp_cert, rtsp_key;  ///< PEM; with a certificate RTSP is RTSPS
    std::string rtsp_encoder;                   ///< GStreamer's name of the H.264 encoder; empty: the first installed
    std::vector<std::string> embed_origins;     ///< of pages that may show pictures: "http://name:port"
    bool is_held = false;                       ///< changes need a world time, and the world a limit
    std::filesystem::path log, replay;          ///< of commands; empty: none
    engine::EngineOptions engine;
    int ready_fd = -1;
};

/// Serves until SIGINT, SIGTERM or server.shutdown. Returns the exit code; errors are one line on stderr.
int run_serve(const ServeOptions& options);

}  // namespace camrig::cli

#pragma once

#include "tools/camrig/cli.h"
#include "tools/camrig/cli_context.h"

namespace CLI {
class App;
}

namespace camrig::cli {

/// Of the options that several commands share.
inline constexpr const char* scene_option_help =
    "name of a shipped scene (hall, street, ...), scene file (.json) or a bare .gltf/.glb";
inline constexpr const char* no_ground_help = "a bare .gltf/.glb stands on no ground and under no sky";

}  // namespace camrig::cli

/// The families of commands. Each adds its subcommands and sets context.action when one of them is given.
namespace camrig::cli {

void add_serve_command(CLI::App& app, CliContext& context, const CliHooks& hooks);
void add_camera_commands(CLI::App& app, CliContext& context);
void add_ptz_commands(CLI::App& app, CliContext& context);
void add_fault_commands(CLI::App& app, CliContext& context, const CliHooks& hooks);
void add_check_command(CLI::App& app, CliContext& context);
void add_world_commands(CLI::App& app, CliContext& context);
void add_actor_commands(CLI::App& app, CliContext& context);
void add_object_commands(CLI::App& app, CliContext& context);
void add_event_commands(CLI::App& app, CliContext& context);
void add_snapshot_command(CLI::App& app, CliContext& context);
void add_truth_command(CLI::App& app, CliContext& context);
void add_record_command(CLI::App& app, CliContext& context);
void add_manual_commands(CLI::App& app, CliContext& context);
void add_stats_command(CLI::App& app, CliContext& context);
void add_protocol_commands(CLI::App& app, CliContext& context);
void add_probe_command(CLI::App& app, CliContext& context);
void add_sensor_command(CLI::App& app, CliContext& context);
void add_plate_commands(CLI::App& app, CliContext& context);
void add_exec_command(CLI::App& app, CliContext& context, const CliHooks& hooks);
void add_bake_command(CLI::App& app, CliContext& context);
void add_view_command(CLI::App& app, CliContext& context, const CliHooks& hooks);
/// `NAME ...` is a module of the Python package.
void add_python_command(CLI::App& app, CliContext& context, const CliHooks& hooks, const std::string& name,
                        const std::string& module, const std::string& help);

}  // namespace camrig::cli

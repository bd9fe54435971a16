#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>

#include <CLI/CLI.hpp>

#include "tools/camrig/cli_commands.h"

namespace camrig::cli {
namespace {

using nlohmann::json;

/// The rig names the reader that holds a step up; it needs to be heard.
constexpr std::chrono::seconds answer_margin{20};
constexpr std::chrono::seconds load_timeout{600};

std::string world_words(const json& world) {
    std::string places;
    for (const json& place : world.at("places")) places += (places.empty() ? "" : ", ") + plain_text(place);
    const bool is_lockstep = world.at("mode") == "lockstep";
    return table(
        {{"scene", plain_text(world.at("scene")) + " (" + plain_text(world.at("scene_file")) + ")"},
         {"world time", seconds_text(world.at("world_ns")) + (world.at("paused") == true ? ", paused" : "")},
         {"mode", plain_text(world.at("mode")) + (is_lockstep ? "" : ", overload " + plain_text(world.at("overload")))},
         {"quality", plain_text(world.at("quality"))},
         {"seed", plain_text(world.at("seed"))},
         {"objects", plain_text(world.at("objects"))},
         {"actors", plain_text(world.at("actors"))},
         {"cameras", plain_text(world.at("cameras"))},
         {"places", places}},
        2);
}

int show(const CliContext& context, const Result<json>& world) {
    return world ? context.print(*world, world_words(*world)) : context.fail(world.error());
}

void add_step(CLI::App& group, CliContext& context) {
    struct Options {
        std::optional<double> seconds;
        std::optional<std::int64_t> nanoseconds;
        double timeout_s = 10.0;
    };
    auto options = std::make_shared<Options>();
    CLI::App* step =
        group.add_subcommand("step", "moves the world (lockstep, or paused); ends when all frames are sent");
    auto* seconds = step->add_option("SECONDS,--seconds", options->seconds, "how far");
    step->add_option("--nanoseconds", options->nanoseconds, "how far, exactly")->excludes(seconds);
    step->add_option("--timeout", options->timeout_s, "longest wait for a reader, in seconds")
        ->check(CLI::Range(0.001, 3600.0))
        ->capture_default_str();
    step->callback([options, &context] {
        context.action = [options, &context] {
            json params{{"timeout_s", options->timeout_s}};
            if (options->seconds) params["seconds"] = *options->seconds;
            if (options->nanoseconds) params["nanoseconds"] = *options->nanoseconds;
            if (params.size() != 2) return context.usage("world step: give SECONDS or --nanoseconds N");
            // The limit holds for one instant, so a long step may take many of them: an hour at least.
            const auto patience = std::chrono::seconds(3600) + answer_margin;
            return show(context, context.call("world.step", params, patience));
        };
    });
}

void add_load(CLI::App& group, CliContext& context) {
    struct Options {
        std::filesystem::path scene;
        bool no_ground = false;
    };
    auto options = std::make_shared<Options>();
    CLI::App* load = group.add_subcommand("load", "loads another scene; cameras stay");
    load->add_option("SCENE", options->scene, scene_option_help)->required();
    load->add_flag("--no-ground", options->no_ground, no_ground_help);
    load->callback([options, &context] {
        context.action = [options, &context] {
            // The rig has a working directory of its own; a file here is named so that it finds it too.
            std::error_code ignored;
            const auto& scene = options->scene;
            const auto path =
                std::filesystem::is_regular_file(scene, ignored) ? std::filesystem::absolute(scene) : scene;
            json params{{"scene", path.string()}};
            if (options->no_ground) params["ground"] = false;
            return show(context, context.call("world.load", params, load_timeout));
        };
    });
}

void add_save(CLI::App& group, CliContext& context) {
    auto name = std::make_shared<std::string>();
    CLI::App* save =
        group.add_subcommand("save", "saves the world of a rig with --log beside that log, for serve --replay");
    save->add_option("NAME", *name, "of the file: LOG.NAME.save; 1 to 24 of a-z, 0-9 and _")->required();
    save->callback([name, &context] {
        context.action = [name, &context] {
            const auto saved = context.call("world.save", {{"name", *name}}, load_timeout);
            if (!saved) return context.fail(saved.error());
            return context.print(*saved, plain_text(saved->at("file")) + ": the world at " +
                                             seconds_text(saved->at("world_ns")) + ", hash " +
                                             plain_text(saved->at("hash")) + "\n");
        };
    });
}

}  // namespace

void add_world_commands(CLI::App& app, CliContext& context) {
    CLI::App* group = app.add_subcommand("world", "shows, moves and loads the world");
    group->require_subcommand(1);
    for (const auto& [name, text] :
         {std::pair("status", "what the world is doing"), std::pair("pause", "holds world time"),
          std::pair("resume", "lets world time run again")}) {
        group->add_subcommand(name, text)->callback([method = std::string("world.") + name, &context] {
            context.action = [method, &context] { return show(context, context.call(method)); };
        });
    }
    add_step(*group, context);
    add_load(*group, context);
    add_save(*group, context);
}

}  // namespace camrig::cli

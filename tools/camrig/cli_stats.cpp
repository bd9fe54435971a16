#include <memory>
#include <optional>
#include <ostream>
#include <thread>

#include <CLI/CLI.hpp>
#include <unistd.h>

#include "tools/camrig/cli_commands.h"

namespace camrig::cli {
namespace {

using nlohmann::json;
using Rows = std::vector<std::vector<std::string>>;

std::vector<std::string> cells(const json& object, std::initializer_list<const char*> keys) {
    std::vector<std::string> row;
    for (const char* key : keys) row.push_back(plain_text(object[key]));
    return row;
}

std::string words_of(const json& stats) {
    Rows cameras{{"CAMERA", "DUE", "RENDERED", "DROPPED", "IDLE"}};
    Rows readers{{"READER", "CAMERA", "FORMAT", "OFFERED", "DELIVERED", "DROPPED", "LATENCY MS"}};
    for (const json& camera : stats.at("cameras")) {
        cameras.push_back(cells(camera, {"name", "due", "rendered", "dropped", "idle"}));
        for (const json& output : camera.at("outputs")) {
            for (const json& reader : output.at("readers")) {
                readers.push_back({plain_text(reader.at("kind")) + " " + plain_text(reader.at("peer")),
                                   plain_text(camera.at("name")), plain_text(output.at("format")),
                                   plain_text(reader.at("offered")), plain_text(reader.at("delivered")),
                                   plain_text(reader.at("dropped")), plain_text(reader.at("latency_ms"))});
            }
        }
    }
    Rows stages{{"STAGE", "COUNT", "MEAN MS", "P50", "P99", "P99.9", "MAX"}};
    for (const json& stage : stats.at("stages"))
        stages.push_back(cells(stage, {"name", "count", "mean_ms", "p50_ms", "p99_ms", "p999_ms", "max_ms"}));
    std::string text = "world time " + seconds_text(stats.at("world_ns")) + ", " + plain_text(stats.at("instants")) +
                       " instants, " + plain_text(stats.at("dropped_instants")) + " with dropped pictures\n";
    text += "\n" + table(cameras);
    if (readers.size() > 1) text += "\n" + table(readers, 3);
    Rows renderer{{"RENDERER", "COUNT"}};
    for (const auto& [name, value] : stats.at("renderer").items()) renderer.push_back({name, plain_text(value)});
    return text + "\n" + table(stages) + "\n" + table(renderer);
}

int watch(const CliContext& context, double interval_s) {
    auto client = context.connect();
    if (!client) return context.fail(client.error());
    const bool clears = !context.json && ::isatty(STDOUT_FILENO);
    for (;;) {
        auto stats = client->call("stats.get");
        if (!stats) return context.fail(stats.error());
        if (clears) context.out << "\x1b[H\x1b[2J";
        if (const int failed = context.print(*stats, words_of(*stats)); failed) return failed;
        std::this_thread::sleep_for(std::chrono::duration<double>(interval_s));
    }
}

}  // namespace

void add_stats_command(CLI::App& app, CliContext& context) {
    auto interval_s = std::make_shared<double>(1.0);
    CLI::App* stats = app.add_subcommand("stats", "counts and stage times of the rig");
    auto* watching = stats->add_option("--watch", *interval_s, "again every so many seconds (1), until it is ended")
                         ->expected(0, 1)
                         ->check(CLI::Range(0.05, 3600.0));
    stats->callback([interval_s, watching, &context] {
        context.action = [interval_s, is_watching = watching->count() > 0, &context] {
            if (is_watching) return watch(context, *interval_s);
            auto now = context.call("stats.get");
            return now ? context.print(*now, words_of(*now)) : context.fail(now.error());
        };
    });
}

}  // namespace camrig::cli

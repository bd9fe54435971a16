#include <cstdio>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>

#include "tools/camrig/cli_commands.h"

namespace camrig::cli {
namespace {

using nlohmann::json;

std::string box_text(const json& box) {
    if (!box.is_array()) return "hidden";
    return plain_text(box[2]) + "x" + plain_text(box[3]) + " at " + plain_text(box[0]) + "," + plain_text(box[1]);
}

std::string percent_text(const json& share) {
    char text[32];
    std::snprintf(text, sizeof text, "%.0f %%", 100.0 * share.get<double>());
    return text;
}

std::string place_text(const json& position) {
    char text[96];
    std::snprintf(text, sizeof text, "%.2f,%.2f,%.2f", position[0].get<double>(), position[1].get<double>(),
                  position[2].get<double>());
    return text;
}

std::string truth_words(const json& truth) {
    std::vector<std::vector<std::string>> rows{{"ID", "NAME", "CLASS", "BOX", "POSITION", "VISIBLE", "OCCLUDED BY"}};
    for (const json& object : truth.at("objects")) {
        rows.push_back({plain_text(object.at("id")), plain_text(object.at("name")), plain_text(object.at("class")),
                        box_text(object.at("box")), place_text(object.at("position")),
                        percent_text(object.at("visible_fraction")),
                        object.at("occluded_by").is_null() ? "-" : plain_text(object.at("occluded_by"))});
    }
    return "frame " + plain_text(truth.at("sequence")) + " of " + plain_text(truth.at("camera")) + ", world time " +
           seconds_text(truth.at("time_ns")) + "\n" + table(rows, 5);
}

}  // namespace

void add_truth_command(CLI::App& app, CliContext& context) {
    struct Options {
        std::string camera;
        std::optional<std::int64_t> min_ns;
    };
    auto options = std::make_shared<Options>();
    CLI::App* truth = app.add_subcommand("truth", "what a camera's latest picture shows; --json for all of it");
    truth->add_option("NAME", options->camera, "the camera")->required();
    truth->add_option("--min-ns", options->min_ns, "world time that the picture must at least show");
    truth->callback([options, &context] {
        context.action = [options, &context] {
            json params{{"camera", options->camera}};
            if (options->min_ns) params["min_ns"] = *options->min_ns;
            const auto reply = context.call("truth.get", params);
            if (!reply) return context.fail(reply.error());
            return context.print(*reply, truth_words(*reply));
        };
    });
}

}  // namespace camrig::cli

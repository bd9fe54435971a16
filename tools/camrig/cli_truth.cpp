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

std::string number_text(const json& value, int places) {
    char text[32];
    std::snprintf(text, sizeof text, "%.*f", places, value.get<double>());
    return text;
}

std::string network_words(const json& network) {
    std::vector<std::vector<std::string>> seen{
        {"ID", "NAME", "CLASS", "CAMERA", "VISIBLE", "PIXELS", "SEEN FROM, DEG", "DISTANCE, M"}};
    for (const json& object : network.at("objects")) {
        for (const json& one : object.at("seen_by"))
            seen.push_back({plain_text(object.at("id")), plain_text(object.at("name")), plain_text(object.at("class")),
                            plain_text(one.at("camera")), percent_text(one.at("visible_fraction")),
                            plain_text(one.at("pixels")), number_text(one.at("azimuth_deg"), 0),
                            number_text(one.at("distance_m"), 2)});
    }
    std::vector<std::vector<std::string>> shared{
        {"CAMERAS", "", "OBJECTS OF BOTH", "SHARE", "GROUND OF BOTH, M2", "SHARE"}};
    for (const json& one : network.at("overlaps"))
        shared.push_back({plain_text(one.at("cameras")[0]), plain_text(one.at("cameras")[1]),
                          plain_text(one.at("objects")), percent_text(one.at("object_share")),
                          number_text(one.at("ground_m2"), 1), percent_text(one.at("ground_share"))});
    return "world time " + seconds_text(network.at("time_ns")) + "\n" + table(seen, 4) + "\n" + table(shared, 2);
}

struct TruthOptions {
    std::vector<std::string> cameras;
    std::optional<std::int64_t> min_ns;
    bool is_network = false;
    std::vector<std::string> classes;
};

int show_network(CliContext& context, const TruthOptions& options) {
    json params = json::object();
    if (!options.cameras.empty()) params["cameras"] = options.cameras;
    if (!options.classes.empty()) params["classes"] = options.classes;
    const auto reply = context.call("truth.network", params);
    if (!reply) return context.fail(reply.error());
    return context.print(*reply, network_words(*reply));
}

int show_truth(CliContext& context, const TruthOptions& options) {
    json params{{"camera", options.cameras.front()}};
    if (options.min_ns) params["min_ns"] = *options.min_ns;
    const auto reply = context.call("truth.get", params);
    if (!reply) return context.fail(reply.error());
    return context.print(*reply, truth_words(*reply));
}

}  // namespace

void add_truth_command(CLI::App& app, CliContext& context) {
    auto options = std::make_shared<TruthOptions>();
    CLI::App* truth = app.add_subcommand("truth", "what a camera's latest picture shows; --json for all of it");
    truth->add_option("NAME", options->cameras, "the camera; with --network several, or all");
    CLI::Option* network =
        truth->add_flag("--network", options->is_network, "who sees whom, and what cameras share, at this instant");
    truth->add_option("--min-ns", options->min_ns, "world time that the picture must at least show")->excludes(network);
    truth->add_option("--classes", options->classes, "NAME,NAME,...: only objects of these classes")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->needs(network);
    truth->callback([options, &context] {
        if (!options->is_network && options->cameras.empty()) throw CLI::RequiredError("NAME");
        if (!options->is_network && options->cameras.size() > 1)
            throw CLI::ExtrasError("truth", {options->cameras.begin() + 1, options->cameras.end()});
        context.action = [options, &context] {
            return options->is_network ? show_network(context, *options) : show_truth(context, *options);
        };
    });
}

}  // namespace camrig::cli

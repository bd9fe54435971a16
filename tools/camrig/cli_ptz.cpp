#include <memory>
#include <optional>
#include <string>
#include <tuple>

#include <CLI/CLI.hpp>

#include "tools/camrig/cli_commands.h"

namespace camrig::cli {
namespace {

using nlohmann::json;

std::string position_text(const json& position) {
    return "pan " + plain_text(position.at("pan_deg")) + " deg, tilt " + plain_text(position.at("tilt_deg")) +
           " deg, zoom " + plain_text(position.at("zoom"));
}

std::string stops_text(const json& stops) {
    std::string text;
    for (const json& stop : stops)
        text += (text.empty() ? "" : ", ") + stop.at("preset").get<std::string>() + " for " +
                plain_text(stop.at("dwell_s")) + " s";
    return text;
}

std::string words_of(const json& status) {
    const bool turns = status.at("turning") == true, zooms = status.at("zooming") == true;
    std::vector<std::vector<std::string>> rows{{"believes", position_text(status)},
                                               {"true", position_text(status.at("true"))},
                                               {"moves", turns && zooms ? "turns and zooms"
                                                         : turns        ? "turns"
                                                         : zooms        ? "zooms"
                                                                        : "stands"}};
    if (!status.at("tour").is_null()) rows.push_back({"tour", status.at("tour")});
    for (const auto& [name, position] : status.at("presets").items())
        rows.push_back({"preset " + name, position_text(position)});
    for (const auto& [name, stops] : status.at("tours").items()) rows.push_back({"tour " + name, stops_text(stops)});
    return table(rows, 2);
}

/// A command about the camera NAME that is one call of a method.
struct PtzCommand {
    CLI::App* app = nullptr;
    std::shared_ptr<json> params = std::make_shared<json>(json::object());

    PtzCommand(CLI::App& group, CliContext& context, const std::string& name, const std::string& method,
               const std::string& help) {
        app = group.add_subcommand(name, help);
        text("NAME", "camera", "the camera")->required();
        app->callback([params = params, method, &context] {
            context.action = [params, method, &context] {
                auto status = context.call(method, *params);
                return status ? context.print(*status, words_of(*status)) : context.fail(status.error());
            };
        });
    }
    CLI::Option* text(const std::string& option, const std::string& key, const std::string& help) {
        return app->add_option_function<std::string>(
            option, [params = params, key](const std::string& value) { (*params)[key] = value; }, help);
    }
    CLI::Option* number(const std::string& option, const std::string& key, const std::string& help) {
        return app->add_option_function<double>(
            option, [params = params, key](double value) { (*params)[key] = value; }, help);
    }
};

}  // namespace

void add_ptz_commands(CLI::App& app, CliContext& context) {
    CLI::App* ptz =
        app.add_subcommand("ptz", "turns and zooms cameras that have a head (camera create --ptz preset=dome)");
    ptz->require_subcommand(1);
    PtzCommand(*ptz, context, "status", "ptz.status", "where the head is, what it believes, its presets");
    PtzCommand move(*ptz, context, "move", "ptz.move", "to angles and a zoom, or by them, or on and on");
    move.number("--pan-deg", "pan_deg", "degrees to the left of where `pose` looks; continuous: a second");
    move.number("--tilt-deg", "tilt_deg", "degrees upwards; continuous: a second");
    move.number("--zoom", "zoom", "of the focal length; continuous: -1 to 1, of the zoom's speed");
    move.text("--mode", "mode", "absolute (default), relative or continuous")
        ->check(CLI::IsMember({"absolute", "relative", "continuous"}));
    move.number("--speed", "speed", "share of the head's speed, up to 1");
    move.number("--timeout", "timeout_s", "seconds after which a continuous move stops by itself");
    PtzCommand aim(*ptz, context, "aim", "ptz.aim", "at what the picture shows at a place");
    aim.number("X", "x", "to the right, from -1 to 1 in the picture")->required();
    aim.number("Y", "y", "upwards, from -1 to 1 in the picture")->required();
    aim.number("--speed", "speed", "share of the head's speed, up to 1");
    PtzCommand(*ptz, context, "stop", "ptz.stop", "brakes");
    for (const auto& [name, method, help] : {std::tuple("preset-set", "ptz.preset_set", "remembers where the head is"),
                                             std::tuple("preset-goto", "ptz.preset_goto", "goes to a preset"),
                                             std::tuple("preset-remove", "ptz.preset_remove", "forgets a preset")})
        PtzCommand(*ptz, context, name, method, help).text("PRESET", "preset", "its name")->required();
    PtzCommand tour(*ptz, context, "tour-set", "ptz.tour_set", "makes a guard tour of presets");
    tour.text("TOUR", "tour", "its name")->required();
    const auto stops = std::make_shared<std::vector<std::string>>();
    const auto all = std::make_shared<json>(json::object());
    tour.app->add_option("PRESET", *stops, "where it goes, over and over, in this order")->required();
    const auto of_all_stops = [&](const std::string& option, const std::string& key, const std::string& help) {
        tour.app->add_option_function<double>(option, [all, key](double value) { (*all)[key] = value; }, help);
    };
    of_all_stops("--dwell", "dwell_s", "seconds at each (5)");
    of_all_stops("--speed", "speed", "share of the head's speed, up to 1");
    tour.app->parse_complete_callback([stops, all, params = tour.params] {
        for (const std::string& preset : *stops)
            (*params)["stops"].push_back(*all), (*params)["stops"].back()["preset"] = preset;
    });
    PtzCommand(*ptz, context, "tour-start", "ptz.tour_start", "goes from stop to stop until another command")
        .text("TOUR", "tour", "its name")
        ->required();
    PtzCommand(*ptz, context, "tour-remove", "ptz.tour_remove", "forgets a tour")
        .text("TOUR", "tour", "its name")
        ->required();
    PtzCommand(*ptz, context, "home-set", "ptz.home_set", "makes where the head is its home");
    PtzCommand(*ptz, context, "home-goto", "ptz.home_goto", "goes home");
}

}  // namespace camrig::cli

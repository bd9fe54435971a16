#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "tools/camrig/cli_commands.h"
#include "tools/camrig/cli_field_options.h"

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

/// How an option of a head's command is called: what names a thing is a word, the rest has dashes.
FieldOption option_of(const Field& field) {
    for (const auto& [name, word] :
         {std::pair("camera", "NAME"), std::pair("preset", "PRESET"), std::pair("tour", "TOUR")})
        if (field.name == name) return {.name = word};
    return {};
}

/// A command that is one call of a method: preset-set of ptz.preset_set.
CLI::App* add_command(CLI::App& group, CliContext& context, const std::string& method, const std::string& help,
                      const MethodParams& params = make_params()) {
    std::string name = method.substr(method.find('.') + 1);
    std::ranges::replace(name, '_', '-');
    CLI::App* const command = group.add_subcommand(name, help);
    for (const Field& field : params_of(method))
        if (field.parts.empty()) add_field_option(*command, params, field, option_of(field))->required(field.required);
    command->callback([params, method, &context] {
        context.action = [params, method, &context] {
            auto status = context.call(method, *params);
            return status ? context.print(*status, words_of(*status)) : context.fail(status.error());
        };
    });
    return command;
}

/// The presets of a tour in their order; what each stop has is said once for all.
void add_tour_set(CLI::App& group, CliContext& context) {
    const MethodParams params = make_params(), stop = make_params();
    CLI::App* const command = add_command(group, context, "ptz.tour_set", "makes a guard tour of presets", params);
    const auto presets = std::make_shared<std::vector<std::string>>();
    command->add_option("PRESET", *presets, "where it goes, over and over, in this order")->required();
    for (const Field& field : std::ranges::find(params_of("ptz.tour_set"), "stops", &Field::name)->parts)
        if (field.name != "preset") add_field_option(*command, stop, field);
    command->parse_complete_callback([params, stop, presets] {
        for (const std::string& preset : *presets)
            (*params)["stops"].push_back(*stop), (*params)["stops"].back()["preset"] = preset;
    });
}

}  // namespace

void add_ptz_commands(CLI::App& app, CliContext& context) {
    CLI::App* ptz =
        app.add_subcommand("ptz", "turns and zooms cameras that have a head (camera create --ptz preset=dome)");
    ptz->require_subcommand(1);
    for (const auto& [method, help] :
         {std::pair("ptz.status", "where the head is, what it believes, its presets"),
          std::pair("ptz.move", "to angles and a zoom, by them, on and on, or by the picture"),
          std::pair("ptz.stop", "brakes"), std::pair("ptz.preset_set", "remembers where the head is"),
          std::pair("ptz.preset_goto", "goes to a preset"), std::pair("ptz.preset_remove", "forgets a preset"),
          std::pair("ptz.tour_start", "goes from stop to stop until another command"),
          std::pair("ptz.tour_remove", "forgets a tour"), std::pair("ptz.home_set", "makes where the head is its home"),
          std::pair("ptz.home_goto", "goes home")})
        add_command(*ptz, context, method, help);
    add_tour_set(*ptz, context);
}

}  // namespace camrig::cli

#include <memory>
#include <set>
#include <string>

#include <CLI/CLI.hpp>

#include "core/world/read/fault_json.h"
#include "tools/camrig/cli_commands.h"
#include "tools/camrig/cli_field_options.h"

namespace camrig::cli {
namespace {

using nlohmann::json;

std::string world_seconds(const json& ns) {
    return ns.is_null() ? "cleared" : plain_text(json(ns.get<double>() * 1e-9)) + " s";
}

std::string faults_text(const json& faults) {
    std::vector<std::vector<std::string>> rows{{"id", "camera", "kind", "severity", "from", "until", "params"}};
    for (const json& one : faults)
        rows.push_back({plain_text(one.at("id")), one.at("camera"), one.at("kind"), plain_text(one.at("severity")),
                        world_seconds(one.at("start_ns")), world_seconds(one.at("end_ns")), one.at("params").dump()});
    return rows.size() == 1 ? "no camera fails" : table(rows);
}

void add_set_fault(CLI::App& group, CliContext& context) {
    CLI::App* const app = group.add_subcommand("set", "lets a camera fail");
    const MethodParams params = make_params();
    const auto text = [&](const char* name, const char* key, const char* help) {
        return app->add_option_function<std::string>(
            name, [params, key](const std::string& value) { (*params)[key] = value; }, help);
    };
    text("NAME", "camera", "the camera")->required();
    text("KIND", "kind", "what goes wrong; camrig fault kinds")->required()->check(CLI::IsMember(world::fault_names()));
    for (const Field& field : descriptions_of(world::timed_fault_fields()))
        if (field.name != "kind" && field.name != "params") add_field_option(*app, params, field);
    // What several kinds have is one option.
    std::vector<Field> shown;
    for (const auto& kind : fault::fault_kinds()) {
        for (const Field& field : kind.description.fields) {
            if (std::ranges::find(shown, field.name, &Field::name) != shown.end()) continue;
            shown.push_back(field);
            std::string of;
            for (const auto& other : fault::fault_kinds())
                if (std::ranges::find(other.description.fields, field.name, &Field::name) !=
                    other.description.fields.end())
                    of += (of.empty() ? "of " : ", ") + other.description.name;
            add_field_option(*app, params, field, {.group = "params", .help = of, .takes_word = true});
        }
    }
    app->callback([params, &context] {
        context.action = [params, &context] {
            auto set = context.call("fault.set", *params);
            return set ? context.print(*set, faults_text(json::array({*set}))) : context.fail(set.error());
        };
    });
}

void add_clear(CLI::App& group, CliContext& context) {
    CLI::App* const app = group.add_subcommand("clear", "ends faults");
    const MethodParams params = make_params();
    app->add_option_function<std::string>(
        "NAME", [params](const std::string& name) { (*params)["camera"] = name; }, "of this camera");
    app->add_option_function<std::int64_t>("--id", [params](std::int64_t id) { (*params)["id"] = id; }, "this fault");
    app->add_option_function<std::string>(
           "--kind", [params](const std::string& kind) { (*params)["kind"] = kind; }, "of this kind")
        ->check(CLI::IsMember(world::fault_names()));
    app->callback([params, &context] {
        context.action = [params, &context] {
            auto done = context.call("fault.clear", *params);
            if (!done) return context.fail(done.error());
            return context.print(*done, plain_text(done->at("cleared")) + " cleared");
        };
    });
}

void add_wipe(CLI::App& group, CliContext& context) {
    CLI::App* const app = group.add_subcommand("wipe", "wipes the glass before a lens: ends dirt, drops, condensation");
    const MethodParams params = make_params();
    app->add_option_function<std::string>(
           "NAME", [params](const std::string& name) { (*params)["camera"] = name; }, "the camera")
        ->required();
    app->callback([params, &context] {
        context.action = [params, &context] {
            auto done = context.call("fault.wipe", *params);
            if (!done) return context.fail(done.error());
            return context.print(*done, plain_text(done->at("cleared")) + " wiped away");
        };
    });
}

void add_list(CLI::App& group, CliContext& context) {
    CLI::App* const app = group.add_subcommand("list", "the faults that are not over");
    const MethodParams params = make_params();
    app->add_option_function<std::string>(
        "NAME", [params](const std::string& name) { (*params)["camera"] = name; }, "of this camera");
    app->callback([params, &context] {
        context.action = [params, &context] {
            auto listed = context.call("fault.list", *params);
            return listed ? context.print(*listed, faults_text(listed->at("faults"))) : context.fail(listed.error());
        };
    });
}

void add_log(CLI::App& group, CliContext& context) {
    CLI::App* const app = group.add_subcommand("log", "who was refused or thrown out, and when readers came back");
    const MethodParams params = make_params();
    app->add_option_function<std::string>(
        "NAME", [params](const std::string& name) { (*params)["camera"] = name; }, "of this camera");
    app->add_option_function<std::uint64_t>(
        "--since", [params](std::uint64_t since) { (*params)["since"] = since; }, "behind the event of this number");
    app->callback([params, &context] {
        context.action = [params, &context] {
            auto log = context.call("fault.log", *params);
            if (!log) return context.fail(log.error());
            std::vector<std::vector<std::string>> rows{{"number", "world", "camera", "output", "", "who"}};
            for (const json& one : log->at("events"))
                rows.push_back({plain_text(one.at("number")), seconds_text(one.at("world_ns")), one.at("camera"),
                                one.at("output"), one.at("kind"), one.at("peer")});
            return context.print(*log, rows.size() == 1 ? "no reader has met a fault" : table(rows));
        };
    });
}

void add_kinds(CLI::App& group, CliContext& context) {
    CLI::App* const app = group.add_subcommand("kinds", "what can go wrong, and what it can be told");
    app->callback([&context] {
        context.action = [&context] {
            json kinds = json::array();
            std::vector<std::vector<std::string>> rows;
            for (const auto& kind : fault::fault_kinds()) {
                const KindDescription& is = kind.description;
                kinds.push_back({{"name", is.name}, {"doc", is.doc}, {"params", to_json(is.fields)}});
                rows.push_back({is.name, is.doc});
                for (const Field& field : is.fields)
                    rows.push_back(
                        {"  --" + field.option_text(),
                         field.doc_text() + (field.unit.empty() ? "" : ", " + field.unit) + "; " + field.fallback});
            }
            return context.print(kinds, table(rows, 2));
        };
    });
}

}  // namespace

void add_fault_commands(CLI::App& app, CliContext& context, const CliHooks& hooks) {
    CLI::App* fault = app.add_subcommand("fault", "lets cameras fail: frozen, black, frames lost, ..");
    fault->require_subcommand(1);
    add_set_fault(*fault, context);
    add_clear(*fault, context);
    add_wipe(*fault, context);
    add_list(*fault, context);
    add_log(*fault, context);
    add_kinds(*fault, context);
    add_python_command(*fault, context, hooks, "run", "camrig.campaign",
                       "a campaign: how a program takes faults, with a report (docs/faults.md)");
}

}  // namespace camrig::cli

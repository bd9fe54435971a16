#include <memory>
#include <ostream>

#include <CLI/CLI.hpp>

#include "control/rpc/rpc_server.h"
#include "core/base/json_reader.h"
#include "tools/camrig/cli_commands.h"

namespace camrig {
namespace {

using nlohmann::json;

json fields_json(const std::vector<Field>& fields, bool are_params) {
    json list = json::array();
    for (const Field& field : fields) {
        json one{{"name", field.name}, {"type", field.type}, {"doc", field.doc}};
        if (are_params) one["required"] = field.required;
        if (!field.unit.empty()) one["unit"] = field.unit;
        if (!field.fallback.empty()) one["default"] = field.fallback;
        list.push_back(std::move(one));
    }
    return list;
}

int methods(const CliContext& context) {
    json list = json::array();
    std::string words;
    for (const Method& method : documented_methods()) {
        json errors = json::array();
        for (const ErrorKind kind : method.errors) errors.push_back(std::string(to_string(kind)));
        list.push_back({{"name", method.name},
                        {"summary", method.summary},
                        {"params", fields_json(method.params, true)},
                        {"result", fields_json(method.result, false)},
                        {"errors", std::move(errors)}});
        std::string params;
        for (const Field& field : method.params) {
            const std::string shown = field.required ? field.name : "[" + field.name + "]";
            params += (params.empty() ? "" : ", ") + shown;
        }
        words += method.name + " {" + params + "}\n    " + method.summary + "\n";
    }
    return context.print({{"methods", std::move(list)}}, words);
}

int call(const CliContext& context, const std::string& method, const std::string& text, double timeout_s) {
    auto params = parse_json(text, std::size_t{1} << 20);
    if (!params) return context.usage("call: JSON: " + params.error().message);
    if (!params->is_object()) return context.usage("call: JSON must be an object like {\"name\":\"lobby\"}");
    const auto timeout =
        std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::duration<double>(timeout_s));
    auto result = context.call(method, *params, timeout);
    if (!result) return context.fail(result.error());
    return context.print(*result, result->dump(2, ' ', false, json::error_handler_t::replace));
}

}  // namespace

void add_protocol_commands(CLI::App& app, CliContext& context) {
    struct Options {
        std::string method;
        std::string params = "{}";
        double timeout_s = 600.0;
        bool markdown = false;
    };
    auto options = std::make_shared<Options>();
    CLI::App* call_command = app.add_subcommand("call", "calls a method of the control protocol");
    call_command->add_option("METHOD", options->method, "see: camrig methods")->required();
    call_command->add_option("JSON", options->params, "its parameters, e.g. '{\"name\":\"lobby\"}'");
    call_command->add_option("--timeout", options->timeout_s, "seconds to wait for the answer")
        ->check(CLI::Range(0.001, 86'400.0))
        ->capture_default_str();
    call_command->callback([options, &context] {
        context.action = [options, &context] {
            return call(context, options->method, options->params, options->timeout_s);
        };
    });

    CLI::App* methods_command = app.add_subcommand("methods", "lists the methods of the control protocol");
    methods_command->add_flag("--markdown", options->markdown, "the whole of docs/control-protocol.md");
    methods_command->callback([options, &context] {
        context.action = [options, &context] {
            if (!options->markdown) return methods(context);
            context.out << control_protocol_markdown(documented_methods()) << std::flush;
            return 0;
        };
    });
}

}  // namespace camrig

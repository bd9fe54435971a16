#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <ostream>
#include <span>

#include <CLI/CLI.hpp>

#include "control/rpc/generated_files.h"
#include "control/rpc/rpc_server.h"
#include "core/base/json_reader.h"
#include "core/base/write_file.h"
#include "tools/camrig/cli_commands.h"

namespace camrig::cli {
namespace {

using nlohmann::json;

int methods(const CliContext& context) {
    std::string words;
    for (const control::Method& method : control::documented_methods()) {
        std::string params;
        for (const Field& field : method.params) {
            const std::string shown = field.required ? field.name : "[" + field.name + "]";
            params += (params.empty() ? "" : ", ") + shown;
        }
        words += method.name + " {" + params + "}\n    " + method.summary + "\n";
    }
    return context.print(control::protocol_description(), words);
}

Result<std::string> text_of(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::string text{std::istreambuf_iterator<char>(stream), {}};
    if (!stream && text.empty()) return error(ErrorKind::not_found, file.string() + ": cannot be read");
    return text;
}

int write_generated(const CliContext& context, const std::filesystem::path& repository) {
    std::string words;
    for (const control::GeneratedFile& generated : control::generated_files()) {
        const auto file = repository / generated.path;
        const auto present = text_of(file);
        if (!present) return context.fail(present.error());
        const auto text = generated.make(*present);
        if (!text) return context.fail({text.error().kind, file.string() + ": " + text.error().message});
        if (*text == *present) continue;
        if (auto written = write_atomically(file, std::as_bytes(std::span(*text))); !written)
            return context.fail(written.error());
        words += file.string() + ": made anew\n";
    }
    return context.print(nlohmann::json::object(), words);
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
        std::filesystem::path repository = {};
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
    methods_command->add_option("--write", options->repository,
                                "DIR: camrig's sources; makes the files anew that come from the tables of methods and "
                                "parameters");
    methods_command->callback([options, &context] {
        context.action = [options, &context] {
            if (!options->repository.empty()) return write_generated(context, options->repository);
            if (!options->markdown) return methods(context);
            context.out << control_protocol_markdown(control::documented_methods()) << std::flush;
            return 0;
        };
    });
}

}  // namespace camrig::cli

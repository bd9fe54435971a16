#include "tools/camrig/cli_field_options.h"

#include <algorithm>

#include <CLI/CLI.hpp>

#include "control/rpc/rpc_server.h"
#include "core/base/json_reader.h"
#include "tools/camrig/cli_context.h"

namespace camrig::cli {
namespace {

using nlohmann::json;

constexpr std::size_t max_option_bytes = std::size_t{1} << 20;

/// How many numbers the value has with commas between: "[x, y, z]" has three. 0: it is no such list.
std::size_t count_numbers(const std::string& type) {
    if (!type.starts_with('[') || type.contains("string")) return 0;
    return static_cast<std::size_t>(std::ranges::count(type, ',')) + 1;
}

/// "[x, y, z]" as "X,Y,Z".
std::string list_name(const std::string& type) {
    std::string name;
    for (const char c : type)
        if (c == ',' || (c >= 'a' && c <= 'z')) name += c == ',' ? c : static_cast<char>(c - 'a' + 'A');
    return name;
}

json value_or_throw(Result<json> value) {
    if (!value) throw CLI::ValidationError(value.error().message);
    return std::move(*value);
}

Result<json> parse_option(const std::string& option, const std::string& text) {
    auto value = parse_json(text, max_option_bytes);
    return value ? std::move(value) : at(option, value.error());
}

}  // namespace

const std::vector<Field>& params_of(std::string_view method) {
    return control::documented_method(method).params;
}

std::string words_of(const Field& field) {
    std::string text = field.doc_text();
    std::erase(text, '`');
    if (const auto null = text.find("null: "); null != std::string::npos) text.replace(null, 4, "none");
    return field.unit.empty() ? text : field.unit + (text.empty() ? "" : "; ") + text;
}

CLI::Option* add_field_option(CLI::App& app, const MethodParams& params, const Field& field, const FieldOption& style) {
    const auto set = [params, group = style.group, key = field.name](json value) {
        (group.empty() ? *params : (*params)[group])[key] = std::move(value);
    };
    const std::string option = style.name.empty() ? "--" + field.option_text() : style.name;
    const std::string help = style.help.empty() ? words_of(field) : style.help;
    const std::string type = field.plain_type();
    if (type == "number") return app.add_option_function<double>(option, set, help);
    if (type == "integer") return app.add_option_function<std::int64_t>(option, set, help);
    if (type == "boolean" && style.takes_word) return app.add_option_function<bool>(option, set, help);
    if (type == "boolean") {
        const std::string names = option + ",!--no-" + field.option_text();
        return app.add_flag_function(names, [set](std::int64_t count) { set(count > 0); }, help);
    }
    if (type == "string") return app.add_option_function<std::string>(option, set, help);
    if (const std::size_t count = count_numbers(type)) {
        const auto read = [set, option, count](const std::string& text) {
            set(value_or_throw(parse_numbers(option, text, count)));
        };
        return app.add_option_function<std::string>(option, read, help)->type_name(list_name(type));
    }
    const auto read = [set, option](const std::string& text) { set(value_or_throw(parse_option(option, text))); };
    return app.add_option_function<std::string>(option, read, help + " (docs/scene-format.md)")->type_name("JSON");
}

void add_field_options(CLI::App& app, const MethodParams& params, const std::vector<Field>& fields) {
    for (const Field& field : fields)
        add_field_option(app, params, field, {.name = field.name == "name" ? "NAME" : ""})->required(field.required);
}

}  // namespace camrig::cli

#include <string>

#include "control/rpc/rpc_server.h"

namespace camrig {
namespace {

std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text) {
        if (c == '|') out += '\\';
        out += c;
    }
    return out;
}

void table(std::string& out, const char* first, const std::vector<Field>& fields, bool with_required) {
    out += std::string("| ") + first + " | type | |\n|---|---|---|\n";
    for (const auto& field : fields) {
        out += "| `" + field.name + "`" + (with_required && field.required ? " (required)" : "") + " | " +
               escaped(field.type) + " | " + escaped(field.doc) + " |\n";
    }
    out += "\n";
}

}  // namespace

std::string methods_as_markdown(const std::vector<Method>& methods) {
    std::string out;
    for (const auto& method : methods) {
        out += "### `" + method.name + "`\n\n" + method.summary + "\n\n";
        if (method.params.empty()) {
            out += "No parameters.\n\n";
        } else {
            table(out, "parameter", method.params, true);
        }
        table(out, "result", method.result, false);
        if (method.errors.empty()) continue;
        out += "Errors: ";
        for (std::size_t i = 0; i < method.errors.size(); ++i)
            out += std::string(i ? ", " : "") + "`" + std::string(to_string(method.errors[i])) + "`";
        out += ".\n\n";
    }
    return out;
}

}  // namespace camrig

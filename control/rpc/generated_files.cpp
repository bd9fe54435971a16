#include "control/rpc/generated_files.h"

#include <algorithm>

#include "control/rpc/method_shapes.h"
#include "control/rpc/rpc_server.h"
#include "core/world/camera_fields.h"

namespace camrig {
namespace {

constexpr std::string_view table_begins = "<!-- camera fields, made by: camrig methods --write . -->\n";
constexpr std::string_view table_ends = "<!-- camera fields end here -->";

}  // namespace

std::vector<Field> camera_descriptions() {
    return descriptions_of(camera_fields());
}

std::vector<Field> shapes_in(const std::vector<Field>& fields) {
    std::vector<Field> shapes;
    for (const Field& field : fields) {
        if (field.shape.empty()) continue;
        for (Field& inner : shapes_in(field.parts)) shapes.push_back(std::move(inner));
        if (std::ranges::find(shapes, field.shape, &Field::shape) == shapes.end()) shapes.push_back(field);
    }
    return shapes;
}

Result<std::string> scene_format_tables(const std::string& present) {
    const auto begins = present.find(table_begins), ends = present.find(table_ends);
    if (begins == std::string::npos || ends == std::string::npos || ends < begins)
        return error(ErrorKind::invalid_argument, "has not the marks around its table of camera fields");
    std::string table;
    auto fields = camera_descriptions();
    std::erase_if(fields, [](const Field& field) { return field.by == Field::By::rig; });
    params_table(table, fields);
    return present.substr(0, begins + table_begins.size()) + "\n" + table + present.substr(ends);
}

std::vector<GeneratedFile> generated_files() {
    return {{"docs/control-protocol.md",
             [](const std::string&) { return control_protocol_markdown(documented_methods()); }},
            {"docs/scene-format.md", scene_format_tables},
            {"scenes/schema.json", scene_schema},
            {"control/python/camrig/parameters.py", [](const std::string&) { return python_parameters(); }},
            {"control/client/camrig/parameters.h", [](const std::string&) { return client_parameters(); }}};
}

}  // namespace camrig

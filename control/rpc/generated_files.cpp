#include "control/rpc/generated_files.h"

#include <algorithm>

#include "control/rpc/method_shapes.h"
#include "control/rpc/rpc_server.h"
#include "core/base/output_family.h"
#include "core/fault/fault_kind.h"
#include "core/world/camera_fields.h"
#include "core/world/read/actor_json.h"
#include "core/world/read/behaviour_json.h"
#include "core/world/read/daylight_json.h"
#include "core/world/read/event_json.h"
#include "core/world/read/ground_json.h"
#include "core/world/read/light_json.h"
#include "core/world/scene_reader.h"

namespace camrig::control {
namespace {

/// What stands between the marks of this name in a page.
Result<void> replace_part(std::string& page, const std::string& name, const std::string& text) {
    const std::string begin = "<!-- " + name + ", made by: camrig methods --write . -->\n";
    const std::string end = "<!-- " + name + " end here -->";
    const auto begins = page.find(begin), ends = page.find(end);
    if (begins == std::string::npos || ends == std::string::npos || ends < begins)
        return error(ErrorKind::invalid_argument, "has not the marks around its table of " + name);
    page.replace(begins + begin.size(), ends - begins - begin.size(), "\n" + text);
    return {};
}

/// What each kind does, then the keys of all; kinds that have the same key share a row.
std::string kinds_tables(const KindsDescription& described) {
    const std::string head = described.key.empty() ? described.name : "`" + described.key + "`";
    std::string out = "| " + head + " | |\n|---|---|\n";
    for (const KindDescription& kind : described.kinds) out += "| `" + kind.name + "` | " + kind.doc + " |\n";
    std::vector<std::pair<std::string, Field>> rows;
    for (const KindDescription& kind : described.kinds) {
        for (const Field& field : kind.fields) {
            const auto same = std::ranges::find_if(
                rows, [text = to_json(field)](const auto& row) { return to_json(row.second) == text; });
            if (same == rows.end())
                rows.emplace_back("`" + kind.name + "`", field);
            else
                same->first += ", `" + kind.name + "`";
        }
    }
    out += "\n| of | key | type | default | |\n|---|---|---|---|---|\n";
    for (const auto& [kinds, field] : rows) out += "| " + kinds + " " + param_row(field);
    return out + "\n";
}

Result<std::string> fault_tables(const std::string& present) {
    KindsDescription described{"fault", "kind", {}};
    const nlohmann::json nothing = nlohmann::json::object();
    for (const auto& kind : fault::fault_kinds()) {
        KindDescription one = kind.description;
        JsonReader reader(nothing, "");
        one.doc = std::string(to_string(fault::layer_of(kind.read(reader)))) + ": " + one.doc;
        described.kinds.push_back(std::move(one));
    }
    std::string page = present;
    if (auto done = replace_part(page, "faults", kinds_tables(described)); !done) return std::unexpected(done.error());
    return page;
}

}  // namespace

std::vector<ObjectDescription> objects_of_methods() {
    return {{"actor", descriptions_of<world::ActorSpec>()},
            {"attachment", descriptions_of<world::Attachment>()},
            {"event", descriptions_of<world::EventSpec>()},
            {"daylight", descriptions_of<world::DaylightSpec>()},
            {"fog", descriptions_of<world::FogSpec>()}};
}

std::vector<ObjectDescription> objects_of_scenes() {
    auto objects = objects_of_methods();
    objects.insert(objects.end(), {{"scene", descriptions_of<world::Scene>()},
                                   {"environment", descriptions_of<world::Environment>()},
                                   {"model_file", descriptions_of<world::ModelFile>()},
                                   {"object", descriptions_of<world::ObjectSpec>()},
                                   {"route", descriptions_of<world::Route>()},
                                   {"area", descriptions_of<world::Area>()},
                                   {"place", descriptions_of<world::Place>()}});
    return objects;
}

std::vector<KindsDescription> kinds_of_methods() {
    std::vector<KindDescription> outputs;
    for (const OutputFamily& family : output_families()) outputs.push_back(family.kind.description);
    return {{"behaviour", "type", descriptions_of(world::behaviour_kinds())},
            {"trigger", "", descriptions_of(world::trigger_kinds())},
            {"action", "action", descriptions_of(world::action_kinds())},
            {"output", "kind", std::move(outputs)}};
}

std::vector<KindsDescription> kinds_of_scenes() {
    auto kinds = kinds_of_methods();
    kinds.push_back({"light", "type", descriptions_of(world::light_kinds())});
    kinds.push_back({"shape", "shape", descriptions_of(world::shape_kinds())});
    return kinds;
}

std::vector<Field> camera_descriptions() {
    return descriptions_of(world::camera_fields());
}

std::vector<Field> shapes_in(const std::vector<Field>& fields) {
    std::vector<Field> shapes;
    const auto add = [&](const Field& shape) {
        if (std::ranges::find(shapes, shape.shape, &Field::shape) == shapes.end()) shapes.push_back(shape);
    };
    for (const Field& field : fields) {
        if (field.shape.empty()) continue;
        for (const Field& inner : shapes_in(field.parts)) add(inner);
        add(field);
    }
    return shapes;
}

Result<std::string> scene_format_tables(const std::string& present) {
    std::string page = present;
    auto objects = objects_of_scenes();
    auto camera = camera_descriptions();
    std::erase_if(camera, [](const Field& field) { return field.by == Field::By::rig; });
    objects.emplace_back("camera", std::move(camera));
    for (const auto& [name, fields] : objects) {
        std::string table;
        params_table(table, fields);
        if (auto done = replace_part(page, name + " fields", table); !done) return std::unexpected(done.error());
    }
    for (const KindsDescription& described : kinds_of_scenes()) {
        auto done = replace_part(page, described.name + "s", kinds_tables(described));
        if (!done) return std::unexpected(done.error());
    }
    return page;
}

std::vector<GeneratedFile> generated_files() {
    return {{"docs/control-protocol.md",
             [](const std::string&) { return control_protocol_markdown(documented_methods()); }},
            {"docs/scene-format.md", scene_format_tables},
            {"docs/faults.md", fault_tables},
            {"scenes/schema.json", scene_schema},
            {"control/python/camrig/parameters.py", [](const std::string&) { return python_parameters(); }},
            {"control/client/camrig/parameters.h", [](const std::string&) { return client_parameters(); }}};
}

}  // namespace camrig::control

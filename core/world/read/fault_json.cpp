#include "core/world/read/fault_json.h"

#include <algorithm>

#include "core/world/world_fields.h"

namespace camrig::world {
namespace {

using fault::FaultSpec;

/// The key `kind`, and `params`, whose keys are those of its table.
void read_kind_and_params(JsonReader& reader, Changes<FaultSpec>& changes) {
    std::string name;
    if (!reader.find("kind")) return reader.fail("kind", "is missing");
    read_fault_name(reader, "kind", name);
    static const nlohmann::json none = nlohmann::json::object();
    const nlohmann::json* const given = reader.find("params");
    if (!reader.ok("kind")) return;
    const auto& kinds = fault::fault_kinds();
    const auto kind = std::ranges::find(kinds, name, [](const auto& one) { return one.description.name; });
    JsonReader params(given ? *given : none, reader.path_of("params"));
    fault::FaultKind made = kind->read(params);
    if (auto done = params.finish(); !done) return reader.fail(done.error());
    changes.change([made = std::move(made)](FaultSpec& spec) { spec.kind = made; });
}

std::vector<FieldOf<FaultSpec>> make_fields() {
    return {{.field = {.name = "kind",
                       .type = "string",
                       .doc = "what goes wrong (docs/faults.md)",
                       .required = true,
                       .choices = fault_names()},
             .read = read_kind_and_params},
            {.field = {.name = "params",
                       .type = "object",
                       .doc = "of that kind (docs/faults.md)",
                       .fallback = "{}",
                       .schema = R"({"type": "object"})"}},
            field_at<&FaultSpec::severity>({.name = "severity",
                                            .doc = "1: as params say; less is milder, 0 is as if there were no fault",
                                            .range = {0, 1}}),
            field_at<&FaultSpec::seed>(
                {.name = "seed", .doc = "of what is random in it", .fallback = "the rig's", .range = {.low = 0}})};
}

}  // namespace

std::vector<std::string> fault_names() {
    std::vector<std::string> names;
    for (const auto& kind : fault::fault_kinds()) names.push_back(kind.description.name);
    return names;
}

void read_fault_name(JsonReader& reader, std::string_view key, std::string& out) {
    reader.required(key, out);
    if (!reader.ok(key)) return;
    std::string known;
    for (const std::string& name : fault_names()) {
        if (name == out) return;
        known += (known.empty() ? "" : ", ") + name;
    }
    reader.fail(key, "'" + out.substr(0, 40) + "' is none of " + known);
}

FieldTable<FaultSpec> fault_fields() {
    static const std::vector<FieldOf<FaultSpec>> table = make_fields();
    return table;
}

FieldTable<FaultSpec> timed_fault_fields() {
    static const std::vector<FieldOf<FaultSpec>> table = [] {
        auto all = make_fields();
        all.push_back(seconds_at<&FaultSpec::begin_ns>(
            {.name = "start_s", .doc = "world time from which on it is there", .fallback = "now"}));
        all.push_back(seconds_at<&FaultSpec::end_ns>(
            {.name = "end_s", .doc = "world time at which it is over", .fallback = "until it is cleared"}));
        return all;
    }();
    return table;
}

}  // namespace camrig::world

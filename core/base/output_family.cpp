#include "core/base/output_family.h"

#include <algorithm>
#include <map>

namespace camrig {
namespace {

using nlohmann::json;

std::vector<OutputFamily>& registered() {
    static std::vector<OutputFamily> families;
    return families;
}

/// "v4l2 and device", "a, b and c".
std::string listed(const std::vector<std::string>& words) {
    std::string text;
    for (std::size_t i = 0; i < words.size(); ++i)
        text += (i == 0 ? "" : i + 1 == words.size() ? " and " : ", ") + words[i];
    return text;
}

}  // namespace

void set_output_families(std::vector<OutputFamily> families) {
    registered() = std::move(families);
}

const std::vector<OutputFamily>& output_families() {
    return registered();
}

const OutputFamily& family_of(const OutputSpec& output) {
    const auto found = std::ranges::find(registered(), output.kind,
                                         [](const OutputFamily& family) { return family.kind.description.name; });
    CHECK(found != registered().end());
    return *found;
}

json all_options_of(const OutputSpec& output) {
    json options = output.options;
    for (const Field& field : family_of(output).kind.description.fields)
        if (!options.contains(field.name)) options[field.name] = field.fallback;
    return options;
}

json key_of(const OutputSpec& output) {
    const OutputFamily& family = family_of(output);
    if (family.identity) return family.identity(output);
    if (family.key.empty()) return nullptr;
    return all_options_of(output).at(family.key);
}

bool is_same_output(const OutputSpec& a, const OutputSpec& b) {
    return a.kind == b.kind && key_of(a) == key_of(b);
}

OutputSpec read_output(JsonReader& reader) {
    std::vector<Kind<json>> kinds;
    for (const OutputFamily& family : registered()) kinds.push_back(family.kind);
    OutputSpec output;
    output.options = read_kind(kinds, reader, "kind");
    reader.optional("kind", output.kind);
    return output;
}

json output_to_json(const OutputSpec& output) {
    json all = output.options;
    all["kind"] = output.kind;
    return all;
}

std::vector<Field> output_fields() {
    std::vector<Field> fields{{.name = "kind", .type = "string", .required = true}};
    std::map<std::string, std::vector<std::string>> kinds_with;
    for (const OutputFamily& family : registered()) {
        const std::string& kind = family.kind.description.name;
        fields.front().choices.push_back(kind);
        for (const Field& field : family.kind.description.fields) {
            const auto known = std::ranges::find(fields, field.name, &Field::name);
            if (known == fields.end())
                fields.push_back(field);
            else  // one key means one thing, whatever the family
                CHECK(to_json(*known) == to_json(field));
            kinds_with[field.name].push_back(kind);
        }
    }
    for (Field& field : fields) {
        if (field.name == "kind") continue;
        field.doc = "of " + listed(kinds_with[field.name]) + (field.doc.empty() ? "" : ": " + field.doc);
        field.required = false;
    }
    return fields;
}

Result<void> check_outputs(const std::vector<OutputSpec>& outputs, ImageSize size) {
    if (outputs.size() > max_outputs_per_camera)
        return error(ErrorKind::resource_exhausted, "outputs: " + std::to_string(outputs.size()) +
                                                        " of them; a camera has at most " +
                                                        std::to_string(max_outputs_per_camera));
    for (std::size_t i = 0; i < outputs.size(); ++i) {
        const std::string place = "outputs[" + std::to_string(i) + "]";
        const auto& fits = family_of(outputs[i]).fits;
        if (const auto good = fits ? fits(outputs[i], size) : Result<void>(); !good) return at(place, good.error());
        for (std::size_t earlier = 0; earlier < i; ++earlier)
            if (is_same_output(outputs[earlier], outputs[i]))
                return error(ErrorKind::invalid_argument,
                             place + ": is the same output as outputs[" + std::to_string(earlier) + "]");
    }
    return {};
}

}  // namespace camrig

#include "tools/camrig/cli_camera_options.h"

#include <algorithm>
#include <tuple>

#include <CLI/CLI.hpp>

#include "core/base/output_family.h"
#include "core/world/camera_fields.h"
#include "tools/camrig/cli_context.h"
#include "tools/camrig/cli_field_options.h"

namespace camrig::cli {
namespace {

using nlohmann::json;

/// Collects parameters and keeps the first error.
class Params {
public:
    void put(const std::string& key, Result<json> value) {
        if (!value) {
            if (!error_) error_ = value.error();
        } else {
            values_[key] = std::move(*value);
        }
    }
    Result<json> take() {
        if (error_) return std::unexpected(*error_);
        return std::move(values_);
    }

private:
    json values_ = json::object();
    std::optional<Error> error_;
};

Result<json> pose_of(const CameraOptions& options, const json& present) {
    Params pose;
    if (!options.position.empty()) {
        pose.put("position", parse_numbers("--position", options.position, 3));
    } else if (present.is_object()) {
        pose.put("position", present.at("position"));
    } else {
        return error(ErrorKind::invalid_argument, "--position: is missing; give X,Y,Z in metres (or --place NAME)");
    }
    if (!options.look_at.empty()) {
        pose.put("look_at", parse_numbers("--look-at", options.look_at, 3));
    } else if (!options.orientation.empty()) {
        pose.put("orientation", parse_numbers("--orientation", options.orientation, 4));
    } else if (options.has_angles()) {
        const auto angle = [&](const char* key, const std::optional<double>& given) {
            pose.put(key, given ? json(*given) : present.is_object() ? present.at(key) : json(0));
        };
        angle("pan_deg", options.pan_deg);
        angle("tilt_deg", options.tilt_deg);
        angle("roll_deg", options.roll_deg);
    } else if (present.is_object()) {
        pose.put("orientation", present.at("orientation"));
    }
    return pose.take();
}

Result<json> intrinsics_of(const std::string& text) {
    auto numbers = parse_numbers("--intrinsics", text, 4);
    if (!numbers) return numbers;
    return json{{"fx", (*numbers)[0]}, {"fy", (*numbers)[1]}, {"cx", (*numbers)[2]}, {"cy", (*numbers)[3]}};
}

json mount_of(const std::string& text) {
    if (text.empty()) return nullptr;
    const std::size_t slash = text.find('/');
    return {{"actor", text.substr(0, slash)}, {"node", slash == std::string::npos ? "" : text.substr(slash + 1)}};
}

Result<json> lens_of(const std::string& text) {
    const std::size_t colon = text.find(':');
    json lens{{"model", text.substr(0, colon)}};
    if (colon == std::string::npos) return lens;
    const std::string list = text.substr(colon + 1);
    auto numbers = parse_numbers("--lens", list, static_cast<std::size_t>(std::ranges::count(list, ',')) + 1);
    if (!numbers) return numbers;
    lens["coefficients"] = std::move(*numbers);
    return lens;
}

/// A number, a text, a truth value, a size; of parameters that may be null, "none" is null.
json scalar_of(const Field& field, const std::string& text) {
    const bool is_none = field.is_nullable() && text == "none";
    if (is_none) return nullptr;
    if (field.type == "[width, height]") {
        const auto size = parse_size(text);
        return size ? *size : json(text);  // which the rig refuses, with the option's name
    }
    return field.type.starts_with("string") ? json(text) : number_or_text(text);
}

/// NAME=VALUE; the rig knows the names.
Result<json> object_of(const Field& field, const std::vector<std::string>& given) {
    if (given == std::vector<std::string>{"none"} && field.is_nullable()) return nullptr;
    json object = json::object();
    for (const std::string& text : given) {
        const std::size_t sign = text.find('=');
        const std::string name = text.substr(0, sign);
        const auto part = std::ranges::find(field.parts, name, &Field::name);
        const std::string of_part = sign == std::string::npos ? "" : text.substr(sign + 1);
        const bool is_known = part != field.parts.end() && !of_part.empty();
        const bool is_text = is_known && (part->type.starts_with("string") || of_part == part->word);
        const bool is_none = is_known && part->is_nullable() && of_part == "none";
        const json value = is_none ? json() : is_text ? json(of_part) : json::parse(of_part, nullptr, false);
        if (sign == 0 || (!is_none && !is_text && !value.is_number() && !value.is_boolean() && !value.is_array()))
            return error(
                ErrorKind::invalid_argument,
                "--" + field.option_text() + ": \"" + text + "\" must be NAME=VALUE with a number, true or false, " +
                    (is_known && !part->word.empty() ? "or \"" + part->word + "\", " : "") + "e.g. " +
                    field.parts.back().name + "=1" + (field.is_nullable() ? ", or none, to take it away" : ""));
        object[name] = value;
    }
    return object;
}

bool is_from_table(const Field& field) {
    if (field.by != Field::By::both || field.name == "name") return false;
    const std::string type = field.plain_type();
    return type == "boolean" || type == "number" || type == "integer" || type == "string" ||
           (type == "object" && !field.is_whole && !field.parts.empty());
}

void add_from_table(CLI::App& command, CameraOptions::FromTable& given) {
    const Field& field = given.field;
    const std::string name = "--" + field.option_text();
    if (field.type == "boolean") {
        auto* on = command.add_flag(name, given.is_on, words_of(field));
        command.add_flag("--no-" + field.option_text(), given.is_off, "does not")->excludes(on);
        return;
    }
    auto* option = command.add_option(name, given.values);
    if (!field.parts.empty()) {
        std::string names;
        for (const Field& part : field.parts) names += (names.empty() ? "" : ", ") + part.name;
        if (field.is_nullable()) names += "; none: " + field.null;
        option->description("NAME=VALUE, more than once for more: " + names)->allow_extra_args(false);
        return;
    }
    option->description(words_of(field))->expected(1)->type_name(field.type.starts_with("string") ? "TEXT" : "FLOAT");
    if (field.type == "number" || field.type == "integer") option->check(CLI::Number);
}

/// Returns the option that wishes the output.
CLI::Option* add_output(CLI::App& command, const OutputFamily& family, CameraOptions::GivenOutput& given) {
    const KindDescription& kind = family.kind.description;
    given.kind = kind.name;
    CLI::Option* wish = family.key.empty() ? command.add_flag("--" + kind.name, given.is_on, kind.doc) : nullptr;
    for (const Field& field : kind.fields) {
        auto& option = given.options.emplace_back(field);
        const bool is_key = field.name == family.key;
        const std::string name = is_key                 ? kind.name
                                 : field.option.empty() ? kind.name + "-" + field.option_text()
                                                        : field.option;
        auto* added = command.add_option("--" + name, option.values, words_of(field))->expected(1);
        if (field.type == "number" || field.type == "integer") added->check(CLI::Number);
        if (is_key) wish = added->description(kind.doc + "; " + words_of(field));
        if (wish && !is_key) added->needs(wish);
    }
    return wish;
}

json outputs_of(const CameraOptions& options) {
    json outputs = json::array();
    for (const auto& [kind, is_on, given] : options.outputs) {
        json output = json::object();
        for (const auto& [field, values, on, off] : given)
            if (!values.empty()) output[field.name] = scalar_of(field, values.front());
        if (output.empty() && !is_on) continue;
        output["kind"] = kind;
        outputs.push_back(std::move(output));
    }
    return outputs;
}

}  // namespace

void CameraOptions::add_to(CLI::App& command) {
    command.add_option("--size", size, "WxH in pixels, 16x16 to 8192x8192");
    command.add_option("--fps", fps, "frames per second: 25, 29.97 or 30000/1001");
    for (const auto& entry : world::camera_fields())
        if (is_from_table(entry.field)) add_from_table(command, from_table.emplace_back(entry.field));
    auto *vertical = command.get_option("--vfov-deg"), *horizontal = command.get_option("--hfov-deg");
    auto* pixels = command.add_option("--intrinsics", intrinsics, "FX,FY,CX,CY in pixels");
    vertical->excludes(horizontal)->excludes(pixels);
    horizontal->excludes(pixels);
    command.add_option("--position", position, "X,Y,Z in metres");
    auto* target = command.add_option("--look-at", look_at, "X,Y,Z of the point in the middle of the picture");
    auto* quaternion = command.add_option("--orientation", orientation, "X,Y,Z,W of a quaternion");
    target->excludes(quaternion);
    for (auto [name, value, text] : {std::tuple("--pan-deg", &pan_deg, "about world z, 0 looks along +x"),
                                     std::tuple("--tilt-deg", &tilt_deg, "positive looks up"),
                                     std::tuple("--roll-deg", &roll_deg, "about the viewing direction")})
        command.add_option(name, *value, text)->excludes(target)->excludes(quaternion);
    // Beyond that it is another pan and roll, which the next pan or tilt alone would be added to.
    command.get_option("--tilt-deg")->check(CLI::Range(-90.0, 90.0));
    command.add_option("--mount", mount,
                       "ACTOR or ACTOR/NODE that it is fixed to, the pose being in that frame; \"\": none");
    auto* glass =
        command.add_option("--lens", lens, "MODEL or MODEL:K1,K2,... as in ROS, e.g. plumb_bob:-0.2,0.05,0,0,0");
    auto* file = command
                     .add_option("--calibration", calibration,
                                 "FILE: size, intrinsics and lens of a real camera (ROS camera_info YAML, OpenCV "
                                 "FileStorage YAML or JSON, Kalibr camchain)")
                     ->excludes(vertical)
                     ->excludes(horizontal)
                     ->excludes(pixels)
                     ->excludes(glass);
    command.add_option("--calibration-camera", calibration_camera, "which camera of a FILE with several, e.g. cam1")
        ->needs(file);
    auto* none = command.add_flag("--no-outputs", no_outputs, "none of these any more");
    for (const OutputFamily& family : output_families())
        add_output(command, family, outputs.emplace_back())->excludes(none);
}

bool CameraOptions::has_pose() const {
    return !position.empty() || !look_at.empty() || !orientation.empty() || has_angles();
}

Result<json> camera_params(const CameraOptions& options, const json& present_pose) {
    Params params;
    if (!options.size.empty()) params.put("size", parse_size(options.size));
    if (!options.fps.empty()) params.put("fps", number_or_text(options.fps));
    for (const auto& [field, values, is_on, is_off] : options.from_table) {
        if (is_on || is_off)
            params.put(field.name, is_on);
        else if (!values.empty())
            params.put(field.name, field.parts.empty() ? scalar_of(field, values.front()) : object_of(field, values));
    }
    if (!options.intrinsics.empty()) params.put("intrinsics", intrinsics_of(options.intrinsics));
    if (options.has_pose()) params.put("pose", pose_of(options, present_pose));
    if (options.mount) params.put("mount", mount_of(*options.mount));
    if (!options.lens.empty()) params.put("lens", lens_of(options.lens));
    json outputs = outputs_of(options);
    if (!outputs.empty() || options.no_outputs) params.put("outputs", std::move(outputs));
    return params.take();
}

}  // namespace camrig::cli

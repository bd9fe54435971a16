#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/image_size.h"
#include "core/base/kind.h"
#include "core/base/output_spec.h"
#include "core/base/result.h"

namespace camrig {

inline constexpr std::size_t max_outputs_per_camera = 16;

/// One family of outputs, described: the name that `kind` has, its options, and what they demand. How its outputs are
/// opened is said where the program is put together (tools/camrig/outputs.cpp).
struct OutputFamily {
    Kind<nlohmann::json> kind;  ///< reads to the options that are given; see output_kind()
    /// The option that tells two of its outputs apart: a camera has one output for each value. Empty: it has one.
    std::string key = {};
    /// Where several options together tell two outputs apart: a value that is equal for equal ones. Empty: `key` does.
    std::function<nlohmann::json(const OutputSpec&)> identity = {};
    bool is_key_of_rig = false;  ///< the whole rig has one output for each value, as of a device number
    /// Whether a camera of this size can have this one. Empty: any can.
    std::function<Result<void>(const OutputSpec&, ImageSize)> fits = {};
    /// Whether this machine can open this one for the camera of that name; the engine's thread asks before a command
    /// changes a camera's outputs, and must not wait. Empty: it can.
    std::function<Result<void>(const OutputSpec&, const std::string& camera)> can_open = {};
};

/// The kind whose options are a T, with the table of its fields. `check` is asked for what they demand of each other,
/// which `description.rule` tells programs.
template <HasFields T>
Kind<nlohmann::json> output_kind(KindDescription description, std::function<void(const T&, JsonReader&)> check = {}) {
    description.fields = descriptions_of(fields_of(std::type_identity<T>{}));
    return {std::move(description), [check = std::move(check)](JsonReader& reader) {
                const auto& table = fields_of(std::type_identity<T>{});
                Changes<T> changes;
                read_fields(table, reader, changes);
                T value;
                changes.apply_to(value);
                if (check && reader.ok()) check(value, reader);
                nlohmann::json given = nlohmann::json::object();
                for (const auto& each : table)
                    if (reader.has(each.field.name)) given[each.field.name] = each.write(value);
                return given;
            }};
}

/// The options of an output as the T of its own family; what was not given has its default.
template <HasFields T>
T options_of(const OutputSpec& output) {
    JsonReader reader(output.options, output.kind);
    auto options = read_all(fields_of(std::type_identity<T>{}), reader);
    CHECK(options);
    return std::move(*options);
}

/// Registers the families that this program has: before the first camera is read, and before there are other threads.
void set_output_families(std::vector<OutputFamily> families);
const std::vector<OutputFamily>& output_families();
/// Of a valid output.
const OutputFamily& family_of(const OutputSpec& output);
/// Its options, with the defaults of those that were not given.
nlohmann::json all_options_of(const OutputSpec& output);
/// What tells it from others of its family: the value of the key, given or by default; null where there is none.
nlohmann::json key_of(const OutputSpec& output);
/// Are both of one family, with the same key?
bool is_same_output(const OutputSpec& a, const OutputSpec& b);

/// The caller finishes the reader.
OutputSpec read_output(JsonReader& reader);
nlohmann::json output_to_json(const OutputSpec& output);
/// `kind`, and the options of all families in one list; each says of which families it is.
std::vector<Field> output_fields();
/// What is wrong with the outputs of a camera of this size, with the place ("outputs[1]: ...").
Result<void> check_outputs(const std::vector<OutputSpec>& outputs, ImageSize size);

}  // namespace camrig

#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/field.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

/// Options of the command line that are made from tables of fields: what a method takes, its command takes.
namespace camrig::cli {

/// The parameters of a method, filled while the command line is read: `--yaw-deg 90` becomes {"yaw_deg": 90}.
using MethodParams = std::shared_ptr<nlohmann::json>;
inline MethodParams make_params() {
    return std::make_shared<nlohmann::json>(nlohmann::json::object());
}

/// What `method` of the control protocol takes.
const std::vector<Field>& params_of(std::string_view method);

/// Documentation of a field for a terminal.
std::string words_of(const Field& field);

/// Where the value of an option goes, and how the option is called.
struct FieldOption {
    std::string group = {};   ///< the object within the parameters; empty: the parameters themselves
    std::string name = {};    ///< "NAME", a word by its place; empty: "--" and the field's
    std::string help = {};    ///< empty: what the field says
    bool takes_word = false;  ///< of a truth value: `true` or `false` after it, instead of --NAME and --no-NAME
};

/// An option that sets the field in `params`, in its JSON type. Vectors are X,Y,Z; a truth value needs no word after
/// it; what has no shorter form is JSON text. What is of another form is wrong usage; values are for the rig to judge.
CLI::Option* add_field_option(CLI::App& app, const MethodParams& params, const Field& field,
                              const FieldOption& style = {});

/// An option for each of the fields; `name` is the first word, NAME.
void add_field_options(CLI::App& app, const MethodParams& params, const std::vector<Field>& fields);

}  // namespace camrig::cli

#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "control/rpc/method.h"

namespace camrig::control {

/// An object that several methods take, described once.
struct SharedObject {
    std::string name;
    std::string summary;
    std::vector<Field> fields;
};

std::vector<SharedObject> shared_objects();

/// A table of parameters in Markdown.
void params_table(std::string& out, const std::vector<Field>& fields);
/// A row of that table.
std::string param_row(const Field& field);

/// The text of docs/control-protocol.md before its tables.
std::string_view protocol_introduction();

}  // namespace camrig::control

#pragma once

#include "core/base/field_table.h"
#include "core/base/json_reader.h"
#include "core/fault/fault_plan.h"

/// Faults in JSON, of commands and of events.
namespace camrig::world {

/// kind, params, severity and seed.
FieldTable<fault::FaultSpec> fault_fields();
/// The same, with start_s and end_s.
FieldTable<fault::FaultSpec> timed_fault_fields();

/// The names of all kinds.
std::vector<std::string> fault_names();
/// The value of a key that is there: the name of a kind.
void read_fault_name(JsonReader& reader, std::string_view key, std::string& out);

}  // namespace camrig::world

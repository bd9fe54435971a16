#pragma once

#include <nlohmann/json.hpp>

#include "core/base/kind.h"
#include "core/base/result.h"
#include "core/world/event/event_spec.h"

namespace camrig::world {

inline constexpr std::size_t max_event_actions = 64;
inline constexpr std::size_t max_user_data_bytes = 4096;

/// The triggers by the key that names them, and the actions by their `action`.
const std::vector<Kind<Trigger>>& trigger_kinds();
const std::vector<Kind<Action>>& action_kinds();
FieldTable<EventSpec> fields_of(std::type_identity<EventSpec>);
FieldTable<EventReport> fields_of(std::type_identity<EventReport>);

/// The keys of an event, in scene files and in event.add; errors carry the JSON path. Names are not looked up here:
/// check_event() does that. `reader` is finished.
Result<EventSpec> read_event(JsonReader& reader);
/// Its `do` alone.
FieldOf<EventSpec> actions_field();

}  // namespace camrig::world

#include "core/world/behaviour_spec.h"

#include "core/world/event/event_spec.h"

namespace camrig {

std::string_view type_name(const BehaviourSpec& behaviour) {
    constexpr std::string_view names[] = {"stand",  "route", "go_to",   "wander",  "look_at",
                                          "follow", "group", "vehicle", "steered", "sequence"};
    static_assert(std::size(names) == std::variant_size_v<BehaviourSpec>);
    return names[behaviour.index()];
}

bool places_actor(const BehaviourSpec& behaviour) {
    return std::holds_alternative<RouteBehaviour>(behaviour) || std::holds_alternative<VehicleBehaviour>(behaviour);
}

std::string_view type_name(const Trigger& trigger) {
    constexpr std::string_view names[] = {"at_s", "every_s", "border", "meet", "event", "arrived"};
    static_assert(std::size(names) == std::variant_size_v<Trigger>);
    if (const auto* border = std::get_if<AtBorder>(&trigger)) return border->enters ? "enter" : "leave";
    return names[trigger.index()];
}

}  // namespace camrig

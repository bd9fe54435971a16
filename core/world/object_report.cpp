#include "core/world/object_report.h"

#include <algorithm>
#include <string_view>

namespace camrig::world {
namespace {

ObjectReport report_of(const Instance& instance, bool moves, bool hidden) {
    const ObjectInfo& info = *instance.info;
    return {.id = static_cast<std::uint32_t>(info.id),
            .name = info.name,
            .object_class = info.object_class,
            .model = info.model_name,
            .moves = moves,
            .hidden = hidden,
            .scale = instance.scale,
            .position = instance.position,
            .orientation = glm::normalize(instance.orientation * glm::inverse(info.heading_from_model))};
}

/// Calls visit(instances, moves, hidden) for each list until it says true.
template <typename Visit>
void any_list(const Snapshot& snapshot, Visit&& visit) {
    visit(snapshot.statics->objects, false, false) || visit(snapshot.movers, true, false) ||
        visit(snapshot.statics->hidden, false, true) || visit(snapshot.hidden, true, true);
}

}  // namespace

std::vector<ObjectReport> objects_of(const Snapshot& snapshot) {
    std::vector<ObjectReport> all;
    any_list(snapshot, [&](const std::vector<Instance>& instances, bool moves, bool hidden) {
        for (const Instance& one : instances) all.push_back(report_of(one, moves, hidden));
        return false;
    });
    std::ranges::sort(all, {}, &ObjectReport::id);
    return all;
}

const Instance* find_object(const Snapshot& snapshot, std::string_view name, ObjectReport* report) {
    const Instance* found = nullptr;
    any_list(snapshot, [&](const std::vector<Instance>& instances, bool moves, bool hidden) {
        const auto at = std::ranges::find_if(instances, [&](const Instance& one) { return one.info->name == name; });
        if (at == instances.end()) return false;
        found = &*at;
        if (report) *report = report_of(*at, moves, hidden);
        return true;
    });
    return found;
}

}  // namespace camrig::world

#include "core/world/event/event_table.h"

#include <algorithm>

#include "core/world/walk/walk_area.h"

namespace camrig::world {
namespace {

/// Delayed firings of one event that may wait at a time; more are left out.
constexpr std::size_t max_delayed = 1024;

bool is_meant(const AtBorder& border, const Witness& actor) {
    return (border.actor.empty() || border.actor == *actor.name) &&
           (border.object_class.empty() || border.object_class == *actor.object_class);
}

}  // namespace

void EventTable::add(const EventSpec& spec, TimeNs now_ns, const std::vector<Witness>& actors) {
    Entry entry;
    entry.spec = std::make_shared<EventSpec>(spec);
    if (const auto* at = std::get_if<AtTime>(&spec.when)) entry.next_ns = at->at_ns;
    if (const auto* every = std::get_if<EveryTime>(&spec.when)) {
        entry.next_ns = every->first_ns.value_or(every->period_ns);
        if (entry.next_ns < now_ns)
            entry.next_ns += (now_ns - entry.next_ns + every->period_ns - 1) / every->period_ns * every->period_ns;
    }
    if (!actors.empty()) {
        std::vector<Firing> ignored;
        look(entry, now_ns - 1, actors, ignored);
    }
    entries_.push_back(std::move(entry));
}

bool EventTable::remove(const std::string& name) {
    last_.erase(name);
    return std::erase_if(entries_, [&](const Entry& entry) { return entry.spec->name == name; }) > 0;
}

bool EventTable::contains(const std::string& name) const {
    return std::ranges::any_of(entries_, [&](const Entry& entry) { return entry.spec->name == name; });
}

std::vector<EventSpec> EventTable::specs() const {
    std::vector<EventSpec> all;
    for (const Entry& entry : entries_) all.push_back(*entry.spec);
    return all;
}

std::vector<EventReport> EventTable::reports() const {
    std::vector<EventReport> all;
    for (const Entry& entry : entries_)
        all.push_back({entry.spec->name, std::string(type_name(entry.spec->when)), entry.fired, entry.spec->limit});
    return all;
}

std::uint64_t EventTable::last_firing(const std::string& name) const {
    const auto found = last_.find(name);
    return found == last_.end() ? 0 : found->second;
}

void EventTable::look(Entry& entry, TimeNs now_ns, const std::vector<Witness>& actors, std::vector<Firing>& out) const {
    const auto fire = [&](const std::string& actor) { out.push_back({entry.spec->name, actor, entry.spec}); };
    const Trigger& when = entry.spec->when;
    if (std::holds_alternative<AtTime>(when)) {
        if (entry.next_ns > now_ns) return;
        entry.next_ns = max_time_ns;
        fire({});
    } else if (const auto* every = std::get_if<EveryTime>(&when)) {
        if (entry.next_ns > now_ns) return;
        entry.next_ns += ((now_ns - entry.next_ns) / every->period_ns + 1) * every->period_ns;
        fire({});
    } else if (const auto* border = std::get_if<AtBorder>(&when)) {
        const Area& area = scene_->areas.at(border->area);
        std::set<std::uint32_t> inside_now;
        for (const Witness& actor : actors) {
            if (!is_meant(*border, actor)) continue;
            const bool was = entry.inside.contains(actor.id);
            const bool is = actor.is_carried ? was : inside(area.points, actor.position);
            if (is) inside_now.insert(actor.id);
            if (was != is && is == border->enters) fire(*actor.name);
        }
        entry.inside = std::move(inside_now);
    } else if (const auto* meeting = std::get_if<AtMeeting>(&when)) {
        const auto find = [&](const std::string& name) {
            return std::ranges::find_if(actors, [&](const Witness& actor) { return *actor.name == name; });
        };
        const auto a = find(meeting->actors[0]), b = find(meeting->actors[1]);
        const auto is_carried = [&](const auto& actor) { return actor != actors.end() && actor->is_carried; };
        if (is_carried(a) || is_carried(b)) return;
        const bool near =
            a != actors.end() && b != actors.end() && glm::distance(a->position, b->position) <= meeting->distance_m;
        if (near && !entry.is_near) fire(meeting->actors[0]);
        entry.is_near = near;
    } else if (const auto* arrival = std::get_if<AtArrival>(&when)) {
        for (const Witness& actor : actors)
            if (actor.has_arrived && *actor.name == arrival->actor) fire(*actor.name);
    } else if (!entry.later.empty()) {  // after another event
        const auto first_later = std::ranges::find_if(entry.later, [&](TimeNs at_ns) { return at_ns > now_ns; });
        for (auto it = entry.later.begin(); it != first_later; ++it) fire({});
        entry.later.erase(entry.later.begin(), first_later);
    }
}

std::vector<EventTable::Firing> EventTable::due(TimeNs now_ns, const std::vector<Witness>& actors) {
    std::vector<Firing> firings;
    for (Entry& entry : entries_)
        if (!entry.is_spent()) look(entry, now_ns, actors, firings);
    return firings;
}

bool EventTable::claim(const Firing& firing) {
    const auto entry = std::ranges::find(entries_, firing.spec, &Entry::spec);
    if (entry == entries_.end() || entry->is_spent()) return false;
    ++entry->fired;
    last_[firing.event] = ++firings_;
    return true;
}

std::vector<EventTable::Firing> EventTable::after(const Firing& firing, TimeNs now_ns) {
    std::vector<Firing> at_once;
    for (Entry& entry : entries_) {
        const auto* after = std::get_if<AfterEvent>(&entry.spec->when);
        if (!after || after->event != firing.event || entry.is_spent()) continue;
        if (after->delay_ns == 0)
            at_once.push_back({entry.spec->name, firing.actor, entry.spec});
        else if (entry.later.size() < max_delayed)
            entry.later.push_back(now_ns + after->delay_ns);
    }
    return at_once;
}

void EventTable::add_to(Digest& digest) const {
    digest.add(firings_, entries_.size());
    for (const Entry& entry : entries_) {
        digest.add(entry.spec->name, entry.spec->limit, entry.fired, entry.next_ns, entry.is_near,
                   last_firing(entry.spec->name));
        digest.add(entry.later.size(), entry.inside.size());
        for (const TimeNs later_ns : entry.later) digest.add(later_ns);
        for (const std::uint32_t id : entry.inside) digest.add(id);
    }
}

}  // namespace camrig::world

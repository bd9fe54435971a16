#include "core/world/read/follow_graph.h"

namespace camrig::world {

std::size_t FollowGraph::number_of(const std::string& name) {
    const auto [entry, is_new] = numbers_.try_emplace(name, names_.size());
    if (is_new) {
        names_.push_back(name);
        followed_.emplace_back();
        is_clear_.push_back(false);
    }
    return entry->second;
}

void FollowGraph::add(const std::string& actor, const BehaviourSpec& behaviour) {
    if (const auto* follow = std::get_if<FollowBehaviour>(&behaviour)) {
        const std::size_t from = number_of(actor), to = number_of(follow->actor);
        followed_[from].push_back(to);
    }
    if (const auto* sequence = std::get_if<SequenceBehaviour>(&behaviour))
        for (const SequenceStep& step : sequence->steps) add(actor, step.behaviour);
}

std::string FollowGraph::trail(const std::vector<Turn>& way) const {
    std::string told;
    for (const Turn& turn : way) told += "'" + names_[turn.who] + "' follows ";
    return told + "'" + names_[way.front().who] + "'";
}

std::optional<std::string> FollowGraph::circle_of(const std::string& actor) {
    const auto start = numbers_.find(actor);
    if (start == numbers_.end()) return {};
    std::vector<bool> seen(names_.size());
    std::vector<Turn> way{{.who = start->second}};  // depth first
    while (!way.empty()) {
        Turn& turn = way.back();
        if (turn.next == followed_[turn.who].size()) {
            const bool is_clear = turn.is_clear;
            is_clear_[turn.who] = is_clear;
            way.pop_back();
            if (!way.empty() && !is_clear) way.back().is_clear = false;
            continue;
        }
        const std::size_t to = followed_[turn.who][turn.next++];
        if (to == start->second) return trail(way);
        if (is_clear_[to]) continue;
        if (seen[to])
            turn.is_clear = false;  // it is on this way, or leads into a circle
        else
            way.push_back({.who = to});
        seen[to] = true;
    }
    return {};
}

}  // namespace camrig::world

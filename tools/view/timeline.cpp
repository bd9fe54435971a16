#include "tools/view/timeline.h"

namespace camrig::view {

void Timeline::update(const RigModel& model) {
    const std::int64_t now_ns = model.world.world_ns;
    if (now_ns < now_ns_) actors_.clear();
    now_ns_ = now_ns;
    for (const ActorRow& actor : model.actors) {
        auto& doings = actors_[actor.name];
        if (doings.empty() || doings.back().what != actor.doing) {
            doings.push_back({doings.empty() ? now_ns : doings.back().to_ns, now_ns, actor.doing});
        }
        doings.back().to_ns = now_ns;
    }
    for (auto& [name, doings] : actors_)
        while (!doings.empty() && doings.front().to_ns < now_ns - span_ns) doings.pop_front();
    std::erase_if(actors_, [](const auto& item) { return item.second.empty(); });
}

}  // namespace camrig::view

#include "core/world/step_history.h"

#include <algorithm>
#include <map>

#include "core/base/result.h"
#include "core/world/interpolate.h"
#include "core/world/mount.h"
#include "core/world/posed_model.h"

namespace camrig::world {
namespace {

ClipState clip_before(const ClipPlay& play, TimeNs remaining_ns, TimeNs step_ns) {
    ClipState clip{.animation = play.animation, .phase_ns = play.phase_ns, .weight = play.weight};
    if (play.duration_ns <= 0 || remaining_ns == 0) return clip;
    const WideInt back = static_cast<WideInt>(play.advance_ns) * remaining_ns / step_ns;
    const WideInt phase = (play.phase_ns - back) % play.duration_ns;
    clip.phase_ns = static_cast<TimeNs>(phase < 0 ? phase + play.duration_ns : phase);
    return clip;
}

/// On the way from a step to `end`, with so much of it still to come.
Instance instance_between(const MoverRecord& begin, const ActorState& end, TimeNs remaining_ns, TimeNs step_ns) {
    const double share = static_cast<double>(step_ns - remaining_ns) / static_cast<double>(step_ns);
    Instance instance;
    instance.info = begin.info;
    instance.scale = begin.scale;
    const glm::dvec3 moved = end.position - begin.state.position;
    instance.position = begin.state.position + moved * share;
    instance.orientation =
        glm::normalize(slerp_shortest(begin.state.orientation, end.orientation, share) * begin.heading_from_model);
    instance.velocity = moved / (static_cast<double>(step_ns) * 1e-9);
    for (const ClipPlay& play : end.clips) instance.clips.push_back(clip_before(play, remaining_ns, step_ns));
    return instance;
}

/// What hangs on something is brought there. `instances` are those of the movers, in their order; what hangs on what is
/// gone stays where it is. A carrier hangs on nothing itself.
void hang(const std::vector<MoverRecord>& movers, std::vector<Instance>& instances) {
    std::map<std::uint32_t, std::size_t> place;  // by id; made when something hangs
    for (std::size_t i = 0; i < movers.size(); ++i) {
        const auto& held = movers[i].held;
        if (!held) continue;
        for (std::size_t k = place.size(); k < movers.size(); ++k)
            place[static_cast<std::uint32_t>(movers[k].info->id)] = k;
        const auto carrier = place.find(held->carrier);
        if (carrier == place.end()) continue;
        instances[i] =
            hung_on(*held, instances[carrier->second], std::move(instances[i]), movers[i].heading_from_model);
    }
}

/// What nobody sees is kept apart: pictures and ground truth are of the rest.
void take_hidden(std::span<const MoverRecord> movers, Snapshot& snapshot) {
    if (std::ranges::none_of(movers, &MoverRecord::is_hidden)) return;
    std::vector<Instance> seen;
    seen.reserve(movers.size());
    for (std::size_t i = 0; i < movers.size(); ++i)
        (movers[i].is_hidden ? snapshot.hidden : seen).push_back(std::move(snapshot.movers[i]));
    snapshot.movers = std::move(seen);
}

}  // namespace

Instance instance_of(const MoverRecord& mover) {
    Instance instance;
    instance.info = mover.info;
    instance.scale = mover.scale;
    instance.position = mover.state.position;
    instance.orientation = glm::normalize(mover.state.orientation * mover.heading_from_model);
    instance.velocity = mover.velocity;
    for (const ClipPlay& play : mover.state.clips) instance.clips.push_back(clip_before(play, 0, 1));
    return instance;
}

Instance hung_on(const Held& held, const Instance& carrier, Instance own, const glm::dquat& heading_from_model) {
    // At the origin the frame is the actor's; at a node it is the node's with z for its y, as the world is to glTF.
    glm::dquat frame = glm::inverse(held.heading_from_model);
    glm::dvec3 place = frame * held.position;
    if (held.node >= 0) {
        static thread_local PosedModel pose;
        pose_model(*carrier.info->model, carrier.clips, pose);
        const glm::dmat4& node = pose.model_from_node[static_cast<std::size_t>(held.node)];
        const glm::dvec3& z_up = held.position;
        place = glm::dvec3(node * glm::dvec4(z_up.x, z_up.z, -z_up.y, 1.0));
        frame = z_up_turn(node);
    }
    own.position = carrier.position + carrier.orientation * (carrier.scale * place);
    own.orientation = glm::normalize(carrier.orientation * frame * held.orientation * heading_from_model);
    own.velocity = carrier.velocity;
    return own;
}

StepRecord StepHistory::push(StepRecord record) {
    StepRecord used;
    // The step after the oldest record must reach back so far as well.
    while (records_.size() > 1 && records_[1].world_ns + span_ns <= record.world_ns) {
        used = std::move(records_.front());
        records_.pop_front();
    }
    records_.push_back(std::move(record));
    return used;
}

SnapshotRef StepHistory::at(TimeNs world_ns, const StepRecord& present) const {
    CHECK(world_ns <= present.world_ns && world_ns >= oldest_ns(present));
    const auto next = std::ranges::lower_bound(records_, world_ns, {}, &StepRecord::world_ns);
    const StepRecord& end = next == records_.end() ? present : *next;
    const bool is_on_step = end.world_ns == world_ns;
    const StepRecord& begin = is_on_step ? end : *std::prev(next);
    auto snapshot = std::make_shared<Snapshot>();
    snapshot->world_ns = world_ns;
    snapshot->statics = begin.statics;
    snapshot->movers.reserve(begin.movers.size());
    for (std::size_t i = 0; i < begin.movers.size(); ++i)
        snapshot->movers.push_back(is_on_step
                                       ? instance_of(begin.movers[i])
                                       : instance_between(begin.movers[i], end.arrived[i], end.world_ns - world_ns,
                                                          end.world_ns - begin.world_ns));
    hang(begin.movers, snapshot->movers);
    take_hidden(begin.movers, *snapshot);
    return snapshot;
}

StepHistory StepHistory::since(TimeNs world_ns) const {
    StepHistory made;
    auto first = std::ranges::upper_bound(records_, world_ns, {}, &StepRecord::world_ns);
    if (first != records_.begin()) --first;
    made.records_.assign(first, records_.end());
    return made;
}

SnapshotRef WorldPast::at(TimeNs world_ns) const {
    return before_.at(std::clamp(world_ns, before_.oldest_ns(present_), present_.world_ns), present_);
}

}  // namespace camrig::world

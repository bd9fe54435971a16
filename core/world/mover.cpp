#include "core/world/mover.h"

#include <algorithm>

namespace camrig::world {
namespace {

constexpr TimeNs cross_fade_ns = 250 * ns_per_ms;

}  // namespace

void Mover::start(const StepContext& context) {
    behaviour->start(context, now);
    take_clip(now);
    choose_clips(context);
}

void Mover::take_clip(const ActorState& state) {
    own_.reset();
    if (!state.clips.empty()) own_ = state.clips.front();
}

/// Hanging on somebody it goes no way of its own: a clip that follows the ground stands still, another goes on.
void Mover::play_on(TimeNs step_ns) {
    if (!own_) return;
    const Animation& animation = info->model->animations[static_cast<std::size_t>(own_->animation)];
    const TimeNs advance_ns = animation.ground_speed_m_s > 0.0 ? 0 : step_ns;
    own_ = clip_at(*info->model, own_->animation, WideInt{own_->phase_ns} + advance_ns, own_->phase_ns);
}

void Mover::step(const StepContext& context) {
    StepContext own = context;
    own.id = id();
    own.radius_m = radius_m;
    own.scale = scale;
    if (held_at_ns) {
        behind_ns += context.step_ns;
        if (own_) own_->advance_ns = 0;  // the clip stands still too
    } else if (held) {
        play_on(context.step_ns);
    } else {
        own.now_ns = context.world_ns - behind_ns;
        behaviour->step(own, now);
        take_clip(now);
    }
    choose_clips(own);
}

void Mover::choose_clips(const StepContext& context) {
    std::optional<ClipPlay> wanted = own_;
    if (played && played->until_ns && context.world_ns >= *played->until_ns) played.reset();
    if (played) {
        wanted.reset();
        const auto at = [&](TimeNs ns) {
            return static_cast<WideInt>(ns - played->began_ns) * played->speed_ppm / 1'000'000;
        };
        if (played->animation >= 0)
            wanted =
                clip_at(*info->model, played->animation, at(context.world_ns), at(context.world_ns - context.step_ns));
    }
    // A change of clip is a cross-fade; the old one goes on as fast as it last did. There is no fade from or to the
    // rest pose.
    if (has_clip_ && wanted && wanted->animation != main_.animation) {
        if (!fading_ || main_.weight >= 0.5) fading_ = main_;
        fade_ns_ = 0;
    }
    if (!wanted) fading_.reset();
    has_clip_ = wanted.has_value();
    now.clips.clear();
    if (!wanted) return;
    if (fading_) {
        fade_ns_ += context.step_ns;
        const double share = static_cast<double>(fade_ns_) / static_cast<double>(cross_fade_ns);
        if (share >= 1.0 || fading_->animation == wanted->animation) {
            fading_.reset();
        } else {
            wanted->weight = share;
            fading_->weight = 1.0 - share;
            if (fading_->duration_ns > 0) {
                const WideInt phase = (static_cast<WideInt>(fading_->phase_ns) + fading_->advance_ns);
                const auto wrapped = static_cast<TimeNs>(phase % fading_->duration_ns);
                fading_->phase_ns = wrapped < 0 ? wrapped + fading_->duration_ns : wrapped;
            }
        }
    }
    main_ = *wanted;
    now.clips.push_back(main_);
    if (fading_) now.clips.push_back(*fading_);
}

void Mover::record(TimeNs step_ns, MoverRecord& record) const {
    record.info = info;
    record.scale = scale;
    record.heading_from_model = heading_from_model;
    record.velocity = velocity(step_ns);
    record.state = now;
    record.held = held;
    record.is_hidden = is_hidden;
}

MoverRecord Mover::record(TimeNs step_ns) const {
    MoverRecord made;
    record(step_ns, made);
    return made;
}

MoverRecord Mover::record_before() const {
    return {.info = info,
            .scale = scale,
            .heading_from_model = heading_from_model,
            .velocity = {},
            .state = before,
            .held = {},
            .is_hidden = is_hidden};
}

std::optional<Body> Mover::body(TimeNs step_ns) const {
    if (held || !is_actor) return std::nullopt;
    Body body;
    body.id = id();
    body.position = glm::dvec2(now.position);
    body.velocity = glm::dvec2(velocity(step_ns));
    body.z = now.position.z;
    body.radius = radius_m;
    body.gives_way = behaviour->gives_way() && !held_at_ns;
    if (const auto footprint = behaviour->footprint()) {
        const glm::dvec3 front = now.orientation * glm::dvec3(1.0, 0.0, 0.0);
        body.radius = footprint->width_m / 2.0;
        body.axis = glm::dvec2(front) * std::max(0.0, (footprint->length_m - footprint->width_m) / 2.0);
    }
    if (!(body.radius > 0.0)) return std::nullopt;
    return body;
}

namespace {

void add_clip(Digest& digest, const ClipPlay& clip) {
    digest.add(clip.animation, clip.duration_ns, clip.phase_ns, clip.weight);
}

}  // namespace

void Mover::add_to(Digest& digest) const {
    digest.add(id(), info->name, info->object_class, model, is_actor, scale, variant, radius_m);
    digest.add(now.position, now.orientation, before.position, before.orientation, now.clips.size());
    for (const ClipPlay& clip : now.clips) add_clip(digest, clip);
    digest.add(is_hidden, is_gone, was_arrived, behind_ns, held_at_ns, played.has_value(), held.has_value());
    if (played) digest.add(played->animation, played->speed_ppm, played->began_ns, played->until_ns);
    if (held) digest.add(held->carrier, held->node, held->position, held->orientation);
    digest.add(has_clip_, fade_ns_, fading_.has_value(), own_.has_value());
    if (own_) add_clip(digest, *own_);
    add_clip(digest, main_);
    if (fading_) add_clip(digest, *fading_);
    behaviour->add_to(digest);
}

}  // namespace camrig::world

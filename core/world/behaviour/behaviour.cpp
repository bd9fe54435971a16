#include "core/world/behaviour/behaviour.h"

namespace camrig::world {

ClipPlay clip_at(const Model& model, int animation, WideInt clip_ns, WideInt clip_ns_before) {
    const TimeNs duration = model.animations[static_cast<std::size_t>(animation)].duration_ns;
    ClipPlay play;
    play.animation = animation;
    play.duration_ns = duration;
    if (duration <= 0) return play;
    const auto wrapped = static_cast<TimeNs>(clip_ns % duration);
    play.phase_ns = wrapped < 0 ? wrapped + duration : wrapped;
    play.advance_ns = static_cast<TimeNs>(clip_ns - clip_ns_before);
    return play;
}

}  // namespace camrig::world

#include "core/engine/schedule.h"

#include <algorithm>

namespace camrig::engine {

void Schedule::set(CameraId camera, const camera::ExposureTimes& times, TimeNs after_ns, std::int64_t first_sequence) {
    Entry& entry = entries_[camera];
    entry.times = times;
    entry.next = times.frames_until(after_ns);
    entry.sequence_offset = first_sequence - entry.next;
}

TimeNs Schedule::next_due_ns() const {
    TimeNs next = max_time_ns;
    for (const auto& [camera, entry] : entries_) next = std::min(next, entry.next_ns());
    return next;
}

TimeNs Schedule::next_due_ns(CameraId camera) const {
    return entries_.at(camera).next_ns();
}

std::int64_t Schedule::next_sequence(CameraId camera) const {
    const Entry& entry = entries_.at(camera);
    return entry.next + entry.sequence_offset;
}

std::vector<Schedule::Due> Schedule::take(TimeNs world_ns) {
    std::vector<Due> due;
    for (auto& [camera, entry] : entries_) {
        if (entry.next_ns() != world_ns) continue;
        due.push_back({camera, entry.next + entry.sequence_offset});
        ++entry.next;
    }
    return due;
}

TimeNs Schedule::choose_instant(TimeNs now_ns) const {
    TimeNs chosen = max_time_ns;
    for (const auto& [camera, entry] : entries_) {
        if (entry.next_ns() > now_ns) continue;
        const TimeNs newest = entry.times.time_of_frame(entry.times.frames_until(now_ns) - 1);
        chosen = std::min(chosen, newest);
    }
    return chosen;
}

std::vector<Schedule::Skipped> Schedule::skip_before(TimeNs world_ns) {
    std::vector<Skipped> skipped;
    for (auto& [camera, entry] : entries_) {
        const std::int64_t next = entry.times.first_frame_at_or_after(world_ns);
        if (next <= entry.next) continue;
        skipped.push_back({camera, next - entry.next, entry.next_ns()});
        entry.next = next;
    }
    return skipped;
}

}  // namespace camrig::engine

#include "core/engine/schedule.h"

#include <algorithm>

namespace camrig::engine {

void Schedule::set(CameraId camera, const camera::ExposureTimes& times, TimeNs after_ns, std::int64_t first_sequence) {
    Entry& entry = entries_[camera];
    entry.times = times;
    entry.next = times.frames_until(after_ns);
    entry.sequence = first_sequence;
    entry.stride = 1;
}

void Schedule::set_stride(CameraId camera, std::int64_t grid_points) {
    CHECK(grid_points >= 1);
    Entry& entry = entries_.at(camera);
    entry.next += grid_points - entry.stride;
    entry.stride = grid_points;
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
    return entries_.at(camera).sequence;
}

std::vector<Schedule::Due> Schedule::take(TimeNs world_ns) {
    std::vector<Due> due;
    for (auto& [camera, entry] : entries_) {
        if (entry.next_ns() != world_ns) continue;
        due.push_back({camera, entry.sequence++});
        entry.next += entry.stride;
    }
    return due;
}

TimeNs Schedule::choose_instant(TimeNs now_ns) const {
    TimeNs chosen = max_time_ns;
    for (const auto& [camera, entry] : entries_) {
        if (entry.next_ns() > now_ns) continue;
        const std::int64_t passed = entry.times.frames_until(now_ns) - 1 - entry.next;
        chosen = std::min(chosen, entry.times.time_of_frame(entry.next + passed / entry.stride * entry.stride));
    }
    return chosen;
}

std::vector<Schedule::Skipped> Schedule::skip_before(TimeNs world_ns) {
    std::vector<Skipped> skipped;
    for (auto& [camera, entry] : entries_) {
        const std::int64_t passed = entry.times.first_frame_at_or_after(world_ns) - entry.next;
        if (passed <= 0) continue;
        const std::int64_t frames = (passed + entry.stride - 1) / entry.stride;
        skipped.push_back({camera, frames, entry.next_ns(), entry.stride});
        entry.next += frames * entry.stride;
        entry.sequence += frames;
    }
    return skipped;
}

}  // namespace camrig::engine

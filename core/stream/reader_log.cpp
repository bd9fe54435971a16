#include "core/stream/reader_log.h"

#include <algorithm>
#include <utility>

#include "core/base/clock.h"

namespace camrig::stream {

std::span<const Named<ReaderEventKind>> names_of(std::type_identity<ReaderEventKind>) {
    using enum ReaderEventKind;
    static constexpr Named<ReaderEventKind> names[] = {
        {closed, "closed"}, {open, "open"}, {refused, "refused"}, {thrown_out, "thrown_out"}, {good, "good"}};
    return names;
}

void ReaderLog::add(ReaderEvent event) {
    if (event.world_ns == 0) event.world_ns = newest_ns_.load(std::memory_order_relaxed);
    std::lock_guard lock(mutex_);
    event.monotonic_ns = monotonic_now_ns();
    event.real_ns = realtime_now_ns();
    event.number = ++last_;
    events_.push_back(std::move(event));
    if (events_.size() > max_events) events_.pop_front();
}

ReaderLog::Since ReaderLog::since(std::uint64_t number, std::string_view camera) const {
    std::lock_guard lock(mutex_);
    Since found{{}, last_, 0};
    const std::uint64_t before_kept = last_ - events_.size();
    if (before_kept > number) found.missed = before_kept - number;
    std::ranges::copy_if(events_, std::back_inserter(found.events), [&](const ReaderEvent& event) {
        return event.number > number && (camera.empty() || event.camera == camera);
    });
    return found;
}

}  // namespace camrig::stream

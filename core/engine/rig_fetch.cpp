#include <algorithm>

#include "core/base/clock.h"
#include "core/engine/rig.h"

// Pictures on request: a camera's latest due picture, drawn now if nobody was watching, from the snapshot of its
// instant.
namespace camrig {
namespace {

constexpr std::size_t max_pending_fetches = 256;
constexpr TimeNs fetch_timeout_ns = 10 * ns_per_s;

}  // namespace

void Rig::fetch(FetchRequest request, std::function<void(Result<MediaUnit>)> done) {
    thread_.check();
    auto found = cameras_.find(request.camera);
    if (!found) return done(std::unexpected(found.error()));
    if ((*found)->latest.world_ns >= request.min_ns) return answer(**found, std::move(request), std::move(done));
    if (pending_.size() >= max_pending_fetches)
        return done(error(ErrorKind::resource_exhausted, "too many requests wait for a later frame; ask again"));
    pending_.push_back({std::move(request), std::move(done), monotonic_now_ns() + fetch_timeout_ns});
}

void Rig::answer(CameraEntry& entry, FetchRequest request, std::function<void(Result<MediaUnit>)> done) {
    LatestDue& latest = entry.latest;
    FrameRef frame;
    if (request.kind == FrameKind::color && latest.color) {
        frame = latest.color;
    } else {
        View view = view_of(entry, latest);
        std::ranges::fill(view.kinds, false);
        view.kinds[static_cast<std::size_t>(request.kind)] = true;
        const FrameSet set = draw(latest.snapshot, latest.monotonic_ns, {view});
        if (set.frames.empty()) {
            return done(
                error(ErrorKind::unavailable,
                      "camera " + *entry.name + ": this picture could not be drawn; the log of the rig says why"));
        }
        frame = set.frames.front();
        if (request.kind == FrameKind::color) latest.color = frame;
    }
    bus_.transcode_once(std::move(frame), request.format, std::move(done));
}

bool Rig::has_pending_fetch(const CameraEntry& entry, TimeNs world_ns) const {
    return std::ranges::any_of(pending_, [&](const PendingFetch& fetch) {
        return fetch.request.kind == FrameKind::color && fetch.request.min_ns <= world_ns &&
               fetch.request.camera == *entry.name;
    });
}

void Rig::answer_pending(TimeNs monotonic_ns) {
    for (auto it = pending_.begin(); it != pending_.end();) {
        auto found = cameras_.find(it->request.camera);
        const bool is_there = found && (*found)->latest.world_ns >= it->request.min_ns;
        if (found && !is_there && monotonic_ns < it->deadline_ns) {
            ++it;
            continue;
        }
        PendingFetch fetch = std::move(*it);
        it = pending_.erase(it);
        if (is_there) {
            answer(**found, std::move(fetch.request), std::move(fetch.done));
        } else if (!found) {
            fetch.done(std::unexpected(found.error()));
        } else {
            fetch.done(error(ErrorKind::unavailable,
                             "camera " + fetch.request.camera + " has no frame at or after min_ns " +
                                 std::to_string(fetch.request.min_ns) + " yet; its latest shows world time " +
                                 std::to_string((*found)->latest.world_ns) +
                                 (clock_.running() ? " ns" : " ns and the world stands still: step or resume it")));
        }
    }
}

}  // namespace camrig

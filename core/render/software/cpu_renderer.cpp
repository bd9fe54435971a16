#include "core/render/software/cpu_renderer.h"

#include <algorithm>

#include "core/render/view_frames.h"

namespace camrig {

Result<void> CpuRenderer::submit(SnapshotRef snapshot, TimeNs monotonic_ns, std::span<const View> views) {
    thread_.check();
    CHECK(in_flight() < max_in_flight);
    if (snapshot != snapshot_) {
        snapshot_ = snapshot;
        drawer_.begin_instant(snapshot);
    }
    Instant instant;
    instant.world_ns = snapshot->world_ns;
    instant.monotonic_ns = monotonic_ns;
    instant.order.reserve(views.size());
    instant.frames.reserve(views.size());
    drawn_here_.clear();
    for (const View& view : views) {
        instant.order.push_back(view.camera);
        const bool is_here = wants(view, FrameKind::color) && drawer_.can_draw(view);
        if (is_here) drawn_here_.push_back(&view);
        const auto wanted = std::ranges::count(view.kinds, true);
        if (wanted == (is_here ? 1 : 0)) continue;
        instant.rest.push_back(view);
        if (is_here) instant.rest.back().kinds[static_cast<int>(FrameKind::color)] = false;
    }
    if (!instant.rest.empty()) {
        if (auto asked = ask_other(snapshot, monotonic_ns, instant.rest); asked) {
            instant.asks_other = true;
        } else {
            for (const View& view : instant.rest)
                instant.failures.push_back({view.camera, at(*view.name, asked.error()).error()});
        }
    }
    drawer_.draw(drawn_here_, monotonic_ns, instant.frames);
    submitted_.push_back(std::move(instant));
    return {};
}

Result<void> CpuRenderer::ask_other(SnapshotRef snapshot, TimeNs monotonic_ns, std::span<const View> views) {
    if (other_ == nullptr && !other_failed_) {
        auto made = make_other_();
        if (made) {
            other_ = std::move(*made);
        } else {
            other_failed_ = made.error();
        }
    }
    if (other_ == nullptr) return std::unexpected(*other_failed_);
    return other_->submit(std::move(snapshot), monotonic_ns, views);
}

Result<Renderer::Finished> CpuRenderer::collect() {
    thread_.check();
    CHECK(!submitted_.empty());
    Instant instant = std::move(submitted_.front());
    submitted_.pop_front();
    Finished finished;
    finished.set.world_ns = instant.world_ns;
    finished.set.monotonic_ns = instant.monotonic_ns;
    finished.set.frames = std::move(instant.frames);
    finished.failures = std::move(instant.failures);
    if (!instant.asks_other) return finished;
    auto others = other_->collect();
    if (!others) return std::unexpected(others.error());
    finished.failures.insert(finished.failures.end(), others->failures.begin(), others->failures.end());
    auto& frames = finished.set.frames;
    frames.insert(frames.end(), others->set.frames.begin(), others->set.frames.end());
    const auto place = [&](const FrameRef& frame) {
        return std::pair(std::ranges::find(instant.order, frame->info().camera_id), frame->info().kind);
    };
    std::ranges::sort(frames, [&](const FrameRef& a, const FrameRef& b) { return place(a) < place(b); });
    return finished;
}

void CpuRenderer::forget(CameraId camera) {
    thread_.check();
    drawer_.forget(camera);
    if (other_ != nullptr) other_->forget(camera);
}

RenderCounters CpuRenderer::counters() const {
    RenderCounters sum = drawer_.counters();
    if (other_ != nullptr) sum += other_->counters();
    return sum;
}

bool CpuRenderer::is_plain(const View& view) const {
    return SoftwareDrawer::is_plain(view);
}

std::string CpuRenderer::description() const {
    const std::string own = "camrig's rasteriser (" + std::string(has_wide_lanes() ? "AVX2" : "SSE2") + ")";
    return other_ == nullptr ? own : own + "; " + other_->description();
}

}  // namespace camrig

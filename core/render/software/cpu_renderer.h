#pragma once

#include <deque>
#include <functional>
#include <optional>

#include "core/base/thread_check.h"
#include "core/render/software/software_drawer.h"

namespace camrig {

/// The Renderer of a machine without a GPU: colour pictures by camrig's own rasteriser where it can draw them, all else
/// (ground truth, lenses, several samples a pixel, quality beautiful) by another one, made when it is first needed.
class CpuRenderer final : public Renderer {
public:
    using MakeRenderer = std::function<Result<std::unique_ptr<Renderer>>()>;
    CpuRenderer(const SoftwareDrawer::Options& options, MakeRenderer make_other)
        : drawer_(options), make_other_(std::move(make_other)) {}

    Result<void> submit(SnapshotRef snapshot, TimeNs monotonic_ns, std::span<const View> views) override;
    Result<Finished> collect() override;
    int in_flight() const override { return static_cast<int>(submitted_.size()); }
    bool is_plain(const View& view) const override;
    bool is_on_cpu() const override { return true; }
    void forget(CameraId camera) override;
    RenderCounters counters() const override;
    std::string description() const override;

private:
    struct Instant {
        TimeNs world_ns = 0;
        TimeNs monotonic_ns = 0;
        std::vector<View> rest;  ///< what the other renderer draws
        std::vector<FrameRef> frames;
        std::vector<CameraId> order;
        std::vector<Finished::Failure> failures;
        bool asks_other = false;
    };

    Result<void> ask_other(SnapshotRef snapshot, TimeNs monotonic_ns, std::span<const View> views);

    SoftwareDrawer drawer_;
    MakeRenderer make_other_;
    std::unique_ptr<Renderer> other_;
    std::optional<Error> other_failed_;  ///< why it could not be made
    SnapshotRef snapshot_;
    std::vector<const View*> drawn_here_;
    std::deque<Instant> submitted_;
    ThreadCheck thread_;
};

}  // namespace camrig

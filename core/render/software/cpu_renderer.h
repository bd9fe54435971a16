#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <vector>

#include "core/base/thread_check.h"
#include "core/render/software/software_drawer.h"

namespace camrig::render::software {

/// The Renderer of a machine without a GPU: pictures by camrig's own rasteriser where it can draw them, all else
/// (colour with several samples a pixel; points and lines through a lens) by another one, made when it is first needed.
class CpuRenderer final : public Renderer {
public:
    using MakeRenderer = std::function<Result<std::unique_ptr<Renderer>>()>;
    CpuRenderer(const SoftwareDrawer::Options& options, MakeRenderer make_other)
        : drawer_(options), make_other_(std::move(make_other)) {}

    Result<Finished> draw(const world::SnapshotRef& snapshot, TimeNs monotonic_ns,
                          std::span<const View> views) override;
    std::optional<std::vector<frame::Silhouette>> silhouettes(const world::SnapshotRef& snapshot, const View& view,
                                                              std::span<const ObjectId> objects) override;
    bool is_plain(const View& view) const override;
    TimeNs expected_cost_ns(const View& view) const override;
    bool is_on_cpu() const override { return true; }
    void forget(CameraId camera) override;
    void hand_over(CameraId camera) override;
    RenderCounters counters() const override;
    std::string description() const override;

private:
    void begin_instant(const world::SnapshotRef& snapshot);
    Result<Finished> draw_all(const world::SnapshotRef& snapshot, TimeNs monotonic_ns, std::span<const View> views);
    Result<Finished> draw_rest(const world::SnapshotRef& snapshot, TimeNs monotonic_ns);

    SoftwareDrawer drawer_;
    MakeRenderer make_other_;
    std::unique_ptr<Renderer> other_;
    std::atomic<bool> has_only_triangles_ = true;  ///< the last instant; others ask is_plain()
    std::optional<Error> other_failed_;            ///< why it could not be made
    // Of one call of draw(), kept for their memory.
    std::vector<const View*> here_;
    std::vector<View> rest_;                                 ///< what the other renderer draws
    std::vector<std::size_t> places_here_, places_of_rest_;  ///< among all views
    ThreadCheck thread_;
};

}  // namespace camrig::render::software

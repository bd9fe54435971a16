#pragma once

#include <deque>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "core/frame/frame_pool.h"
#include "core/render/layer_table.h"
#include "core/render/renderer.h"
#include "core/render/software/lens_views.h"
#include "core/render/software/thread_team.h"
#include "core/render/software/view_work.h"

namespace camrig {

/// Colour pictures by camrig's own rasteriser: no GL, several views at once. Qualities fast and simple, triangles, any
/// lens, one sample a pixel: what most cameras of a rig are. Whoever asks draws other views elsewhere.
///
/// Standing cameras keep what does not move (LayerTable): the opaque surfaces with their depth, and the finished
/// picture with what is blended over them. Each instant only the rectangles that movers touch are put back and drawn.
/// The bytes are those of a full draw, because a pixel follows from its triangle alone (rasterizer.h).
class SoftwareDrawer {
public:
    struct Options {
        std::shared_ptr<FramePool> pool;
        SharedModels models{};  ///< empty: its own
        std::int64_t static_layer_bytes = 0;
        double max_detail_error_px = 0.0;
        int threads = 1;
        bool wide_lanes = has_wide_lanes();  ///< false: as on a CPU without them, for tests
    };
    explicit SoftwareDrawer(const Options& options);

    void begin_instant(const SnapshotRef& snapshot);
    /// Whether the colour picture of such a view can be drawn here, if the world has nothing but triangles.
    static bool is_plain(const View& view);
    const SnapshotRef& snapshot() const { return scene_.snapshot(); }
    /// Whether the colour picture of a view of the present instant can be drawn here.
    bool can_draw(const View& view) {
        return is_plain(view) && scene_.has_only_triangles() && lenses_.of(view).has_value();
    }
    /// Appends the colour frames of the views, in their order.
    void draw(std::span<const View* const> views, TimeNs monotonic_ns, std::vector<FrameRef>& frames);
    /// CPU time that each view of the last draw() took by itself.
    std::span<const TimeNs> cost_ns() const { return cost_ns_; }
    void forget(CameraId camera);
    RenderCounters counters() const;

private:
    /// A deformed surface of which a view needs these levels.
    struct Unmade {
        const PlacedSurface* surface = nullptr;
        LevelSet levels = 0;
    };
    void find_primitives(const PlacedSurfaces& placed, std::vector<const SoftwarePrimitive*>& to);
    void prepare(const View& view, ViewWork& work);
    void deform_seen(std::span<ViewWork* const> works);
    /// All but the pixels, which draw_rows makes in that many bands.
    void begin_view(ViewWork& work, ViewScratch& scratch, int bands, TimeNs monotonic_ns);
    /// The view has a layer: where its picture differs from the last one, and where from what the frame's memory holds,
    /// which may be an earlier picture of the camera.
    static void find_changes(ViewWork& work);
    void add_triangles(ViewWork& work, ViewScratch& scratch);
    /// Room to keep what does not move; the view goes on without a layer where there is none.
    void make_layer(ViewWork& work, bool has_blended);
    /// A band is drawn: with the last one the frame is finished, and noted for the frames that follow.
    static void end_band(ViewWork& work);

    Options options_;
    ThreadTeam team_;
    SharedModels models_;
    PlacedScene scene_;
    std::vector<const SoftwarePrimitive*> static_primitives_, mover_primitives_;  ///< of what is placed
    std::uint64_t layer_number_ = 0;
    LayerTable<StaticLayer> layers_;
    std::mutex layers_mutex_;  ///< of layers_ and layer_number_ while views are drawn
    std::map<CameraId, FrameHistory> histories_;
    LensViews lenses_;
    std::deque<ViewWork> works_;
    std::vector<ViewWork*> in_work_;
    std::vector<TimeNs> cost_ns_;
    std::deque<ViewScratch> scratch_;  ///< by thread, or by view where they are few
    std::vector<Unmade> unmade_;
    std::uint64_t views_ = 0, views_in_parts_ = 0, draws_ = 0, draws_coarse_ = 0;
};

}  // namespace camrig

#pragma once

#include <array>
#include <atomic>
#include <deque>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "core/frame/frame_pool.h"
#include "core/render/layer_table.h"
#include "core/render/renderer.h"
#include "core/render/software/rasterizer.h"
#include "core/render/software/thread_team.h"

namespace camrig {

/// Colour pictures by camrig's own rasteriser: no GL, several views at once. Qualities fast and simple, triangles, no
/// lens but the pinhole, one sample a pixel: what most cameras of a rig are. Whoever asks draws other views elsewhere.
///
/// Standing cameras keep what does not move (LayerTable): the opaque surfaces with their depth, and the finished
/// picture with what is blended over them. Each instant only the rectangles that movers touch are put back and drawn.
/// The bytes are those of a full draw, because a pixel follows from its triangle alone (rasterizer.h).
class SoftwareDrawer {
public:
    struct Options {
        std::shared_ptr<FramePool> pool;
        std::int64_t static_layer_bytes = 0;
        double max_detail_error_px = 0.0;
        int threads = 1;
        bool wide_lanes = has_wide_lanes();  ///< false: as on a CPU without them, for tests
    };
    explicit SoftwareDrawer(const Options& options);

    void begin_instant(const SnapshotRef& snapshot);
    /// Whether the colour picture of a view of the present instant can be drawn here.
    bool can_draw(const View& view) const;
    /// The colour frames of the views, in their order.
    void draw(std::span<const View* const> views, TimeNs monotonic_ns, std::vector<FrameRef>& frames);
    void forget(CameraId camera);
    RenderCounters counters() const;

private:
    /// What is kept of a camera that stands still.
    struct Layer {
        Plane<std::uint32_t> color;
        Plane<float> depth;
        Plane<std::uint32_t> finished;  ///< empty: nothing is blended, it is `color`
        std::uint64_t number = 0;       ///< no two that were ever kept have the same; 0: nothing is kept yet
    };
    /// What a frame showed: a layer, and other things in some rectangles.
    struct Shown {
        std::uint64_t mark = 0;   ///< Frame::content_mark; 0: none
        std::uint64_t layer = 0;  ///< 0: none that is kept
        std::vector<PixelRect> rects;
    };
    /// The last frames of a camera, in a ring.
    struct History {
        std::array<Shown, 8> frames;
        std::size_t last = 0;
        std::int64_t sequence = -1;  ///< of the last
    };
    struct ViewWork {
        const View* view = nullptr;
        ViewScope scope;
        Layer* layer = nullptr;
        History* history = nullptr;
        std::vector<ViewDraw> movers, blended;
        PixelRect whole;
        std::vector<PixelRect> rects;      ///< what is drawn: where movers are, if a layer is kept
        std::span<const PixelRect> stale;  ///< if a layer is kept: where the frame's memory holds something else
        std::atomic<int> bands_left = 0;
        std::shared_ptr<Frame> frame;
        Canvas canvas;
        bool is_in_frame = false;  ///< the canvas' colour is the frame's; false: it is copied there
        bool is_in_parts = false;
        std::uint64_t draws = 0, draws_coarse = 0;
    };
    /// A deformed item of which a view needs these levels.
    struct Unmade {
        const SoftwareItem* item = nullptr;
        LevelSet levels = 0;
    };
    struct TriangleRange {
        std::uint32_t first = 0, count = 0;
    };
    /// What it takes to draw a view.
    struct Scratch {
        ViewGeometry geometry;
        TriangleRange statics, movers;                   ///< opaque
        std::vector<ViewDraw> blended_statics, blended;  ///< from far to near; the second with the first
        TriangleNumbers numbers;
        Plane<float> depth;
        Plane<std::uint32_t> color;  ///< of pictures whose rows are no whole groups of lanes
    };

    void prepare(const View& view, ViewWork& work);
    void deform_seen(std::span<ViewWork* const> works);
    /// Rows of a picture of which each band has about as much work.
    static PixelRect band_of(const ViewWork& work, int band, int bands);
    /// All but the pixels, which draw_rows makes for that many bands of rows that cover the picture.
    void begin_view(ViewWork& work, Scratch& scratch, int bands, TimeNs monotonic_ns);
    /// The view has a layer: where its picture differs from the last one, and where from what the frame's memory holds,
    /// which may be an earlier picture of the camera.
    static void find_changes(ViewWork& work);
    void add_triangles(ViewWork& work, Scratch& scratch);
    /// Room to keep what does not move; the view goes on without a layer where there is none.
    void make_layer(ViewWork& work, bool has_blended);
    /// Different bands from different threads. The last one finishes the frame.
    static void draw_rows(ViewWork& work, Scratch& scratch, const PixelRect& band);
    /// What was kept, where it is not.
    static void put_back(ViewWork& work, const PixelRect& band);
    /// The background, and with room for a layer what does not move, kept there.
    static void draw_ground(ViewWork& work, Scratch& scratch, const PixelRect& band);
    static void draw_opaque(Scratch& scratch, const TriangleRange& triangles, const ViewWork& work,
                            const PixelRect& band);
    static void draw_blended(const Scratch& scratch, std::span<const ViewDraw> draws, const ViewWork& work,
                             const PixelRect& band);
    /// Notes what the frame shows, for the frames that follow.
    static void remember(ViewWork& work);

    Options options_;
    ThreadTeam team_;
    SoftwareModels models_;
    SoftwareItems statics_, movers_;
    std::vector<const SoftwareItem*> blended_statics_;
    SnapshotRef snapshot_;
    std::shared_ptr<const StaticSet> static_set_;
    std::uint64_t statics_number_ = 0, layer_number_ = 0;
    LayerTable<Layer> layers_;
    std::mutex layers_mutex_;  ///< of layers_ and layer_number_ while views are drawn
    std::map<CameraId, History> histories_;
    std::deque<ViewWork> works_;
    std::vector<ViewWork*> in_work_;
    std::deque<Scratch> scratch_;  ///< by thread, or by view where they are few
    std::vector<Unmade> unmade_;
    std::uint64_t views_ = 0, views_in_parts_ = 0, draws_ = 0, draws_coarse_ = 0;
    std::uint64_t meshes_skinned_ = 0, meshes_unseen_ = 0;  ///< in the instants before this one
};

}  // namespace camrig

#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "core/frame/frame_pool.h"
#include "core/render/renderer.h"
#include "core/render/shared_caches.h"
#include "core/render/software/lens_views.h"
#include "core/render/software/software_shadows.h"
#include "core/render/software/static_layers.h"
#include "core/render/software/thread_team.h"
#include "core/render/software/view_work.h"

namespace camrig::render::software {

/// Pictures by camrig's own rasteriser: no GL, several views at once, and of each view all kinds that are wanted in one
/// go: through any lens, at all qualities, with one sample a pixel or by areas. Whoever asks draws others elsewhere.
///
/// Standing cameras keep what does not move (StaticLayers): the opaque surfaces with their depth, and the finished
/// picture with what is blended over them; ids, classes and normals once they were asked for. Each instant only the
/// rectangles that movers touch are put back and drawn. The bytes are those of a full draw, because a pixel follows
/// from its triangle alone (rasterizer.h).
class SoftwareDrawer {
public:
    struct Options {
        std::shared_ptr<frame::FramePool> pool;
        SharedCaches caches{};  ///< empty: its own
        std::int64_t static_layer_bytes = 0;
        double max_detail_error_px = 0.0;
        int threads = 1;
        bool wide_lanes = has_wide_lanes();  ///< false: as on a CPU without them, for tests
    };
    explicit SoftwareDrawer(const Options& options);

    void begin_instant(const world::SnapshotRef& snapshot);
    /// Whether such a picture of the view can be drawn here, if its lens can be.
    static bool may_draw(const View& view, frame::FrameKind kind = frame::FrameKind::color);
    /// Whether pixels of its colour picture show the areas of surfaces, if it is drawn here; else what is at their
    /// centres.
    static bool has_areas(const View& view);
    const world::SnapshotRef& snapshot() const { return scene_.snapshot(); }
    /// Whether such a picture of a view of the present instant can be drawn here.
    bool can_draw(const View& view, frame::FrameKind kind = frame::FrameKind::color);
    /// Appends the frames of the views that are wanted and can be drawn here, in the order of views and kinds.
    void draw(std::span<const View* const> views, TimeNs monotonic_ns, std::vector<frame::FrameRef>& frames);
    /// Which pixels each of these objects would show in the instance picture of the view if nothing else were there.
    std::vector<frame::Silhouette> silhouettes(const View& view, std::span<const ObjectId> objects);
    /// Whether something moves while the view's picture is taken, so that its rows show different moments.
    bool is_exposed(const View& view) const;
    /// CPU time that each view of the last draw() took by itself.
    std::span<const TimeNs> cost_ns() const { return cost_ns_; }
    void forget(CameraId camera);
    /// Another drawer with the same SharedCaches draws the camera from now on: its layer is left for that one.
    void hand_over(CameraId camera);
    /// Memory ran out on the way: nothing is kept, of any camera, nor placed.
    void clear();
    RenderCounters counters() const;

private:
    Result<ViewLens> lens_of(const View& view) { return caches_.lenses->of(view, options_.wide_lanes); }
    void forget_here(CameraId camera);
    void place(const world::SnapshotRef& snapshot);
    void find_primitives(const scene::PlacedSurfaces& placed, std::vector<const SoftwarePrimitive*>& to);
    void deform_seen(std::span<ViewWork* const> works);
    /// Those that were asked for; what was drawn beside them is kept.
    static void give_frames(ViewWork& work, const View& view, std::vector<frame::FrameRef>& frames);
    /// The shadow maps of this instant, made with the first views that look at them, at their cost.
    void make_shadows(std::span<ViewWork* const> works);
    void find_bodies(ViewWork& work) const;
    /// view_setup.cpp: what a view needs before its rows are drawn. First which kinds of pictures: notes what is asked
    /// for, and says what is to be drawn for it.
    KindSet kinds_to_draw(const View& view, ViewWork& work);
    scene::SceneView scene_view_of(const View& view, world::Quality quality);
    void prepare(const View& view, ViewWork& work);
    /// What its backdrop shows now; waits for a film.
    void take_picture_of_backdrop(ViewWork& work);
    void acquire_frames(ViewWork& work, TimeNs monotonic_ns);
    /// All but the pixels, which draw_rows makes in that many bands.
    void begin_view(ViewWork& work, ViewScratch& scratch, int bands, TimeNs monotonic_ns);
    /// Its last step, when the rectangles are known.
    void begin_drawing(ViewWork& work, ViewScratch& scratch, int bands);
    /// view_triangles.cpp: what the view sees, as triangles on its screen; and what the picture of a backdrop shows,
    /// before all that is drawn.
    void add_triangles(ViewWork& work, ViewScratch& scratch);
    void add_proxies(ViewWork& work, ViewScratch& scratch);
    /// exposed_views.cpp: views of cameras with a sensor before which something moves, one after the other; the scene
    /// is placed as it was afterwards.
    void draw_exposed(TimeNs monotonic_ns);
    void draw_exposed(ViewWork& work, TimeNs monotonic_ns);
    /// The flow of a view before which nothing moves while it is taken.
    void draw_flow(ViewWork& work, TimeNs monotonic_ns);
    /// The moment, whose flow is wanted, as it will be a frame later.
    void look_ahead(const ViewWork& work, TimeNs moment_ns);
    /// How far anything is moved, and how large the disc is that anything is seen as, in pixels.
    struct Spread {
        MovedPixels moved;
        double disc_px = 0.0;
    };
    Spread spread_of(ViewWork& work, TimeNs monotonic_ns);
    void sum_light(ViewWork& work, const Spread& spread);
    void draw_moment_channels(ViewWork& work, double moved_px);
    /// Makes moment_ the view's at that time, as that point of its opening has it; its rectangles, and what of it is
    /// drawn, come next.
    void begin_moment(const ViewWork& work, const world::CameraPast::Moment& at, double lamps_hz,
                      glm::dvec2 point = glm::dvec2(0.0));
    /// The light of the moment, by all threads, of its rectangles; a picture in parts if the view has a layer.
    void draw_moment_light(const LightRows& to);
    /// The light of all that stands still while the picture is taken or, with what moves, of the moment: in full or in
    /// parts over the view's layer, which is made if there is none yet.
    void draw_standing_light(ViewWork& work, bool with_moving, const LightRows& to);
    /// What draw_standing_light() drew, until the next time; the moments' sum may go where it was drawn.
    LightRows keep_standing_light(ViewWork& work);
    /// Adds to the view's light, of lamps as RowShares has them: what a standing camera sees, of that what moves, and
    /// what any other camera sees.
    void add_standing(ViewWork& work, std::span<const MovingGroup> groups, std::size_t lamps);
    void add_movers(ViewWork& work, const MovingGroup& group, std::size_t lamps, const LightRows& standing);
    void add_moments(ViewWork& work, const Spread& spread, std::size_t lamps);
    /// Adds weight of each row * (the moment's light - minus), in rectangles.
    void add_moment(ViewWork& work, std::span<const PixelRect> rects, const LightRows& minus,
                    std::span<const float> weights);
    void draw_moment_rows_of_channels(const PixelRect& rows);
    void copy_in_bands(ViewWork& work, const LightRows& from, std::span<const PixelRect> rects, const LightRows& to);
    std::vector<PixelRect> moving_rects(const ViewWork& work, int first_row, int end_row) const;
    /// In bands of these rows, numbered, by all threads.
    void in_bands(ViewWork& work, const PixelRect& rows, const std::function<void(int, const PixelRect&)>& draw);
    /// A band is drawn: with the last one the frames are finished, and noted for those that follow.
    void end_band(ViewWork& work, ViewScratch& scratch);

    Options options_;
    ThreadTeam team_;
    SharedCaches caches_;
    scene::PlacedScene scene_;
    SceneAhead ahead_;
    std::vector<const SoftwarePrimitive*> static_primitives_, mover_primitives_;  ///< of what is placed
    StaticLayers layers_;
    std::map<CameraId, FrameHistory> histories_;
    std::uint64_t instant_ = 0;
    TimeNs instant_ns_ = 0;  ///< of the pictures, whatever moment of theirs is placed
    AskedPictures asked_;
    SoftwareShadows shadows_;
    std::uint64_t shadows_instant_ = 0;  ///< for which they are made
    scene::PlacedBodies moving_bodies_;  ///< of the instant
    std::uint64_t bodies_instant_ = 0;
    std::deque<ViewWork> works_;
    std::vector<ViewWork*> in_work_, exposed_, flows_;
    View moment_view_;
    ViewWork moment_;
    ExposureScratch exposure_scratch_;
    std::vector<TimeNs> cost_ns_;
    std::deque<ViewScratch> scratch_;                  ///< by thread, or by view where they are few
    std::vector<const scene::PlacedSurface*> unmade_;  ///< deformed ones of which views need levels
    std::vector<scene::LevelSet> unmade_levels_;       ///< those, by PlacedSurface::index of the movers
    std::uint64_t views_ = 0, views_in_parts_ = 0, draws_ = 0, draws_coarse_ = 0;
};

}  // namespace camrig::render::software

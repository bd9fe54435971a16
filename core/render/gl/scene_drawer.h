#pragma once

#include <span>
#include <vector>

#include "core/render/gl/draw_pass.h"
#include "core/render/gl/light_map.h"
#include "core/render/gl/shadow_maps.h"
#include "core/render/gl/static_layers.h"
#include "core/render/gl/view_plan.h"

namespace camrig::render::gl {

struct SceneDrawerOptions {
    std::int64_t static_layer_bytes = 0;
    double max_detail_error_px = 0.0;
    bool batch_draws = false;
};

/// What is known of one view before anything is drawn into it.
struct SceneChanges {
    StaticLayers::Layer* layer = nullptr;  ///< null: nothing is kept, or may be
    /// Per tile, where the shadows of movers fall: there the kept picture is wrong.
    std::vector<std::vector<PixelRect>> shadowed;
    bool is_mostly_shadowed = false;  ///< more than half of it: a full draw is cheaper
    bool is_in_parts = false;         ///< the kept picture is put back, and drawn in `rects` only
    bool is_put_back = false;         ///< already
    std::uint64_t shown_layer = 0;    ///< StaticLayers::Layer::number of the kept picture, once it is put back
    std::vector<PixelRect> rects;     ///< pixels; no two intersect
    std::vector<scene::SeenSurface> shadowed_statics, static_blended;
    scene::SeenMovers movers;
};

/// Draws the scene of a view into its source pictures: static opaque geometry first, then movers, then all that is
/// blended. That order is what static layers live on.
class SceneDrawer {
public:
    SceneDrawer(const GlFunctions& gl, ShaderCache& shaders, const SceneDrawerOptions& options)
        : gl_(gl),
          max_detail_error_px_(options.max_detail_error_px),
          pass_(gl, shaders, options.batch_draws),
          layers_(gl, options.static_layer_bytes),
          shadows_(gl),
          light_map_(gl) {}

    void begin_instant();
    /// What the pictures of several views share; once before their restore().
    void prepare(std::span<const View> views, GpuScene& scene);
    /// Looks up what is kept of the view and, where that is the colours of a picture of its own, puts it back, but for
    /// what movers touch. For all views of an instant before the first draw(): a copy waits for all that is being drawn
    /// on a CPU rasteriser, and between views that would leave one of two cores idle.
    /// `color`: the view's finished picture, if the scene is drawn straight into it; else null.
    void restore(const View& view, const ViewPlan& plan, GpuScene& scene, const ColorTarget* color,
                 ViewTargets& targets, SceneChanges& changes);
    void draw(const View& view, const ViewPlan& plan, GpuScene& scene, ViewSources sources, ViewTargets& targets,
              SceneChanges& changes);
    /// Somebody else has set GL state.
    void lose_state() { state_is_ours_ = false; }
    void forget(CameraId camera) { layers_.forget(camera); }
    RenderCounters counters() const;

private:
    /// Where movers and blended surfaces are drawn over a layer that is kept. False, if that is not worth while.
    bool find_changes(const View& view, const ViewPlan& plan, GpuScene& scene, SceneChanges& changes);
    /// `targets`: those whose finished picture `color` is; null for a picture that others use too.
    void put_back(const ViewPlan& plan, const ColorTarget& color, ViewTargets* targets, SceneChanges& changes);
    void draw_changes(const View& view, const ViewPlan& plan, GpuScene& scene, const ColorTarget& color,
                      const SceneChanges& changes);
    /// Opaque ones of `draws` that reach into `rect`.
    void draw_touching(std::span<const scene::SeenSurface> draws, const PixelRect& rect);
    /// What the layer needs besides its opaque part, where anything static is blended; leaves `color` as it was.
    void keep_finished(const View& view, const ViewPlan& plan, GpuScene& scene, const ColorTarget& color,
                       StaticLayers::Layer& layer);
    enum class Shadows : std::uint8_t { still, now };
    void begin_tile(const View& view, const ViewPlan& plan, const SourceTile& tile, GpuScene& scene, Shadows shadows);
    ViewTransform transform_of(const View& view, const ViewPlan& plan, const SourceTile& tile) const;
    /// Per tile the rectangles in which movers darken what stands still, by their shadows or by being near.
    std::vector<std::vector<PixelRect>> shadow_rects(const View& view, const ViewPlan& plan, const GpuScene& scene);
    /// Static opaque geometry again, in those rectangles.
    void draw_shadowed(const View& view, const ViewPlan& plan, GpuScene& scene, const ColorTarget& color,
                       std::span<const std::vector<PixelRect>> rects);
    void draw_into(GLuint framebuffer, const SourceTile& tile, int factor);
    void use_scissor(const SourceTile& tile, const PixelRect& rect, int factor);
    /// One after the other into every tile: `statics` are opaque static geometry, `rest` movers and what is blended.
    void draw_tiles(const View& view, const ViewPlan& plan, GpuScene& scene, const ViewSources& statics,
                    const ViewSources& rest, Shadows shadows = Shadows::now);
    /// Of what is about to be drawn, these objects only; all of it when there are none.
    void keep_only(std::span<const ObjectId> objects);
    void clear(const ColorTarget& target, const glm::vec3& background);
    void clear(const TruthTarget& target);

    const GlFunctions& gl_;
    double max_detail_error_px_;
    DrawPass pass_;
    StaticLayers layers_;
    std::uint64_t views_ = 0, views_in_parts_ = 0;
    ShadowMaps shadows_;
    LightMap light_map_;
    bool lights_are_made_ = false;  ///< both, for this instant
    bool state_is_ours_ = false;    ///< nothing but pass_ has set GL state since its begin_instant()
    std::vector<scene::SeenSurface> static_opaque_;
    std::vector<scene::SeenSurface> moving_opaque_;
    std::vector<scene::SeenSurface> blended_;
    std::vector<scene::SeenSurface> touching_;
    std::vector<PixelRect> samples_;
    scene::BodiesInView bodies_;  ///< of the tile
};

}  // namespace camrig::render::gl

#pragma once

#include <map>
#include <optional>
#include <span>
#include <vector>

#include "core/render/gl/draw_pass.h"
#include "core/render/gl/image_pass.h"
#include "core/render/gl/paint_scene.h"
#include "core/render/gl/readback.h"
#include "core/render/gl/scratch_targets.h"
#include "core/render/gl/shadow_maps.h"
#include "core/render/gl/static_layers.h"
#include "core/render/pixel_rect.h"
#include "core/render/renderer.h"

namespace camrig {

/// The finished pictures of one camera in one instant; they live until the instant was read.
struct ViewTargets {
    std::optional<ColorTarget> color;
    std::optional<TruthTarget> truth;
    /// The kept picture that `color` shows outside of `changed` (StaticLayers::Layer::number); 0: none.
    std::uint64_t shown_layer = 0;
    std::vector<PixelRect> changed;
};

/// Where the finished pictures of a view are and what their depths mean.
struct PaintedView {
    PictureSource color;
    PictureSource depth;
    PictureSource truth;  ///< ids and normals
    ViewTransform transform;
    std::shared_ptr<const LensOnDevice> lens;  ///< null: none
};

struct PainterOptions {
    int max_side = 0;              ///< of any picture
    bool has_float_units = false;  ///< see ImagePass
    std::int64_t static_layer_bytes = 0;
    double max_detail_error_px = 0.0;
};

/// Draws one view: the scene into its source (that is the finished picture itself for a pinhole camera with one sample
/// per pixel), then samples are resolved and the lens is looked through.
class ViewPainter {
public:
    ViewPainter(const GlFunctions& gl, ShaderCache& shaders, const PainterOptions& options)
        : gl_(gl),
          max_side_(options.max_side),
          max_detail_error_px_(options.max_detail_error_px),
          pass_(gl, shaders),
          images_(gl, options.has_float_units),
          lenses_(gl, options.max_side),
          scratch_(gl),
          layers_(gl, options.static_layer_bytes),
          shadows_(gl) {}

    void begin_instant();
    /// What the pictures of several views share; once before their paint().
    void prepare(std::span<const View> views, PaintScene& scene);
    Result<PaintedView> paint(const View& view, PaintScene& scene, ViewTargets& targets);
    void forget(CameraId camera) {
        lenses_.forget(camera);
        layers_.forget(camera);
    }
    RenderCounters counters() const;

private:
    /// How one view is drawn.
    struct Plan {
        const CameraSpec& spec;
        std::shared_ptr<const LensOnDevice> lens{};
        std::span<const SourceTile> tiles{};
        ImageSize source{};  ///< at one texel per pixel
        int supersampling = 1;
        int multisampling = 1;
        bool is_bicubic = false;
        bool wants_color = false;
        bool wants_truth = false;             ///< the scene is drawn again, for ids, normals and depth
        bool takes_depth_from_color = false;  ///< instead
        bool is_resampled() const { return lens != nullptr || supersampling * multisampling > 1; }
    };
    /// The source pictures of one view, and what is drawn into them now; null: nothing.
    struct Sources {
        const ColorTarget* color = nullptr;
        const TruthTarget* truth = nullptr;
    };
    Result<Plan> plan_of(const View& view, SourceTile& whole);
    Result<const ColorTarget*> color_source(const Plan& plan, ViewTargets& targets);
    Result<const TruthTarget*> truth_source(const Plan& plan, ViewTargets& targets);
    /// Static opaque geometry first, then movers, then all that is blended: the order that static layers live on.
    void draw_scene(const View& view, const Plan& plan, PaintScene& scene, Sources sources, ViewTargets& targets);
    /// The colours of a view of one tile whose layer is kept, drawn only where movers may be. False, and nothing is
    /// done, if that is not worth while.
    bool draw_changes(const View& view, const Plan& plan, PaintScene& scene, const ColorTarget& color,
                      const StaticLayers::Layer& layer, std::span<const std::vector<PixelRect>> shadowed,
                      ViewTargets& targets);
    void draw_touching(std::span<const VisibleDraw> draws, const PixelRect& rect);
    /// What the layer needs besides its opaque part, where anything static is blended; leaves `color` as it was.
    void keep_finished(const View& view, const Plan& plan, PaintScene& scene, const ColorTarget& color,
                       StaticLayers::Layer& layer);
    enum class Shadows : std::uint8_t { still, now };
    void begin_tile(const View& view, const Plan& plan, const SourceTile& tile, PaintScene& scene, Shadows shadows);
    ViewTransform transform_of(const View& view, const Plan& plan, const SourceTile& tile) const;
    /// Per tile the rectangles in which movers cast shadows on what stands still.
    std::vector<std::vector<PixelRect>> shadow_rects(const View& view, const Plan& plan) const;
    /// Static opaque geometry again, in those rectangles.
    void draw_shadowed(const View& view, const Plan& plan, PaintScene& scene, const ColorTarget& color,
                       std::span<const std::vector<PixelRect>> rects);
    void draw_into(GLuint framebuffer, const SourceTile& tile, int factor);
    std::optional<PixelRect> bounds_of(const SceneItem& item) const;
    /// One after the other into every tile: `statics` are opaque static geometry, `rest` movers and what is blended.
    void draw_tiles(const View& view, const Plan& plan, PaintScene& scene, const Sources& statics, const Sources& rest,
                    Shadows shadows = Shadows::now);
    /// Of what is about to be drawn, these objects only; all of it when there are none.
    void keep_only(std::span<const ObjectId> objects);
    Result<void> finish_color(const Plan& plan, const ColorTarget& source, const ViewTargets& targets);
    void clear(const ColorTarget& target, const Environment& environment);
    void clear(const TruthTarget& target);

    const GlFunctions& gl_;
    int max_side_;
    double max_detail_error_px_;
    DrawPass pass_;
    ImagePass images_;
    LensCache lenses_;
    ScratchTargets scratch_;
    StaticLayers layers_;
    std::uint64_t views_ = 0, views_in_parts_ = 0;
    ShadowMaps shadows_;
    bool state_is_ours_ = false;  ///< nothing but pass_ has set GL state since its begin_instant()
    std::vector<VisibleDraw> static_opaque_;
    std::vector<VisibleDraw> moving_opaque_;
    std::vector<VisibleDraw> blended_;
    std::vector<VisibleDraw> static_blended_;
};

}  // namespace camrig

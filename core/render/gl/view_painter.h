#pragma once

#include <map>
#include <optional>
#include <span>
#include <vector>

#include "core/render/gl/image_pass.h"
#include "core/render/gl/lens_cache.h"
#include "core/render/gl/readback.h"
#include "core/render/gl/scene_drawer.h"
#include "core/render/gl/scratch_targets.h"
#include "core/render/gl/view_plan.h"

namespace camrig::render::gl {

/// Where the finished pictures of a view are and what their depths mean.
struct PaintedView {
    PictureSource color;
    PictureSource depth;
    PictureSource truth;  ///< ids and normals
    ViewTransform transform;
    std::shared_ptr<const LensOnDevice> lens;  ///< null: none
    frame::Damage damage;                      ///< of `color` since a kept picture (StaticLayers::Layer::number)
};

struct PainterOptions {
    int max_side = 0;              ///< of any picture
    bool has_float_units = false;  ///< see ImagePass
    bool has_codes = false;        ///< finished pictures can be converted (ColorTarget::codes)
    SceneDrawerOptions scene;
};

/// Draws one view: the scene into its source (that is the finished picture itself for a pinhole camera with one sample
/// per pixel), then samples are resolved and the lens is looked through.
class ViewPainter {
public:
    ViewPainter(const GlFunctions& gl, ShaderCache& shaders, const PainterOptions& options)
        : gl_(gl),
          max_side_(options.max_side),
          has_codes_(options.has_codes),
          images_(gl, options.has_float_units),
          lenses_(gl, options.max_side),
          scratch_(gl),
          drawer_(gl, shaders, options.scene) {}

    void begin_instant();
    /// Plans views of an instant, and what their pictures share; before their paint().
    void prepare(std::span<const View> views, GpuScene& scene, std::map<CameraId, ViewTargets>& targets);
    /// `index`: of the view in prepare(), which had the same targets.
    Result<PaintedView> paint(const View& view, std::size_t index, GpuScene& scene, ViewTargets& targets);
    void forget(CameraId camera) {
        lenses_.forget(camera);
        drawer_.forget(camera);
    }
    RenderCounters counters() const { return drawer_.counters(); }

private:
    struct Prepared {
        Result<void> is_planned;
        ViewPlan plan;
        SourceTile whole;  ///< plan.tiles of a view without a lens
        SceneChanges changes;
    };
    Result<ViewPlan> plan_of(const View& view, SourceTile& whole);
    Result<void> prepare(const View& view, GpuScene& scene, ViewTargets& targets, Prepared& prepared);
    Result<const ColorTarget*> color_source(const ViewPlan& plan, ViewTargets& targets);
    Result<const TruthTarget*> truth_source(const ViewPlan& plan, ViewTargets& targets);
    Result<void> finish_color(const ViewPlan& plan, const ColorTarget& source, const ViewTargets& targets);

    const GlFunctions& gl_;
    int max_side_;
    bool has_codes_;
    ImagePass images_;
    LensCache lenses_;
    ScratchTargets scratch_;
    SceneDrawer drawer_;
    std::vector<Prepared> prepared_;  ///< per view of the instant; kept for their memory
};

}  // namespace camrig::render::gl

#pragma once

#include <map>
#include <optional>
#include <span>
#include <vector>

#include "core/render/gl/draw_pass.h"
#include "core/render/gl/image_pass.h"
#include "core/render/gl/readback.h"
#include "core/render/gl/scratch_targets.h"
#include "core/render/renderer.h"

namespace camrig {

/// The finished pictures of one camera in one instant; they live until the instant was read.
struct ViewTargets {
    std::optional<ColorTarget> color;
    std::optional<TruthTarget> truth;
};

/// The world of one instant as the device has it.
struct PaintScene {
    SceneItems& statics;
    SceneItems& movers;
    const Environment& environment;
    std::span<const Light> lights;
    const LightTable& light_sets;
    StreamBuffer& stream;
};

/// Where the finished pictures of a view are and what their depths mean.
struct PaintedView {
    PictureSource color;
    PictureSource depth;
    PictureSource truth;  ///< ids and normals
    ViewTransform transform;
    std::shared_ptr<const LensOnDevice> lens;  ///< null: none
};

/// Draws one view: the scene into its source (that is the finished picture itself for a pinhole camera with one sample
/// per pixel), then samples are resolved and the lens is looked through.
class ViewPainter {
public:
    ViewPainter(const GlFunctions& gl, ShaderCache& shaders, int max_side)
        : gl_(gl), max_side_(max_side), pass_(gl, shaders), images_(gl), lenses_(gl, max_side), scratch_(gl) {}

    void begin_instant();
    Result<PaintedView> paint(const View& view, PaintScene& scene, ViewTargets& targets);
    void forget(CameraId camera) { lenses_.forget(camera); }

private:
    /// How one view is drawn.
    struct Plan {
        const CameraSpec& spec;
        std::shared_ptr<const LensOnDevice> lens{};
        std::span<const SourceTile> tiles{};
        ImageSize source{};  ///< at one texel per pixel
        int supersampling = 1;
        int multisampling = 1;
        bool wants_color = false;
        bool wants_truth = false;             ///< the scene is drawn again, for ids, normals and depth
        bool takes_depth_from_color = false;  ///< instead
        bool is_resampled() const { return lens != nullptr || supersampling * multisampling > 1; }
    };
    Result<Plan> plan_of(const View& view, SourceTile& whole);
    Result<const ColorTarget*> color_source(const Plan& plan, ViewTargets& targets);
    Result<const TruthTarget*> truth_source(const Plan& plan, ViewTargets& targets);
    void draw_tile(const View& view, const Plan& plan, const SourceTile& tile, PaintScene& scene,
                   const ColorTarget* color, const TruthTarget* truth);
    Result<void> finish_color(const Plan& plan, const ColorTarget& source, const ViewTargets& targets);
    void clear(const ColorTarget& target, const Environment& environment);
    void clear(const TruthTarget& target);

    const GlFunctions& gl_;
    int max_side_;
    DrawPass pass_;
    ImagePass images_;
    LensCache lenses_;
    ScratchTargets scratch_;
    bool state_is_ours_ = false;  ///< nothing but pass_ has set GL state since its begin_instant()
    std::vector<VisibleDraw> opaque_;
    std::vector<VisibleDraw> blended_;
};

}  // namespace camrig

#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "core/camera/camera_model.h"
#include "core/render/pixel_rect.h"
#include "core/render/view_transform.h"
#include "core/world/model.h"

namespace camrig {

/// A camera with a lens as something to draw with: where points of the optical frame lie in its picture, also those
/// that it does not show, and what of a scene it may show.
///
/// A triangle that is partly seen must be somewhere as a whole. So the lens ends at `end_radius` of the ideal plane
/// (LensMap), where its picture or its valid disc ends, and from there on goes on slowly and straight outwards: what
/// lies beyond lands beside the picture, or on pixels that see nothing (`blind`), and never before what is seen.
///
/// Depth is z along the optical axis and the near plane is one, as in a pinhole picture; but a wide fisheye (`is_wide`)
/// knows directions that have no such z, and takes the distance to the eye for it: its near plane is a sphere.
///
/// Made once for the optics of a camera, in about 0.2 microseconds a pixel of the picture's border. Immutable; any
/// thread.
class LensView {
public:
    /// Refuses what CameraModel refuses, and fisheyes that see further than 2.8 rad from the axis.
    static Result<std::shared_ptr<const LensView>> create(ImageSize size, const Intrinsics& intrinsics,
                                                          const Lens& lens);

    const CameraModel& model() const { return model_; }
    bool is_wide() const { return is_wide_; }
    double end_radius() const { return end_; }
    /// What has nothing before this radius shows nothing. A little beyond the end: between two points there a straight
    /// edge runs nearer to the axis, by max_sag_px, and what lies behind it must not be missing.
    double seen_radius() const { return end_ + 2.0 * max_sag_px / (rise_ * shortest_focal()); }
    /// How far it goes on beyond, in focal lengths for each unit of the ideal plane.
    double rise() const { return rise_; }
    /// Of a lens that is not wide: what is seen has x / z and y / z between these, and is cut where they are beyond
    /// +-guard().
    glm::dvec2 slope_low() const { return slope_low_; }
    glm::dvec2 slope_high() const { return slope_high_; }
    double guard() const { return guard_; }

    /// The ideal point of a direction; of a wide lens of any but none at all, of others of those ahead.
    glm::dvec2 ideal_of(const glm::dvec3& p) const;
    glm::dvec2 pixel_of_ideal(glm::dvec2 ideal) const;

    /// How far the middle of an edge may lie beside the straight line between its ends, along that line, and of its
    /// depth in front of it. What is bent more is drawn in pieces.
    static constexpr double max_sag_px = 0.02, max_slide_px = 0.1, max_depth_share = 1.0 / 4096.0;
    /// Nothing that is seen and is at most so long on the ideal plane is bent more.
    double straight_length() const { return straight_length_; }
    /// An edge whose ends are at least r from the axis of the ideal plane, and that is at most this share of 1 + r and
    /// of the end long, is bent to one side only: its middle tells how much.
    double simple_share() const { return simple_share_; }

    /// Pixels x0 <= x < x1 of row y whose ray() is none; by rows.
    struct BlindRun {
        int y = 0, x0 = 0, x1 = 0;
    };
    const std::vector<BlindRun>& blind() const { return blind_; }

    /// Holds all that a lens that is not wide can see.
    Frustum frustum(double near_m, double far_m) const;
    /// False only if the box certainly touches no pixel of a wide lens.
    bool may_see(const glm::dmat4& optical_from_local, const Box& box, double far_m) const;
    /// screen_bounds() through the lens.
    std::optional<PixelRect> pixels_of(const glm::dmat4& optical_from_local, const Box& box, double near_m) const;
    /// detail_error_px() through the lens.
    double error_px(const ViewTransform& view, const glm::dmat4& optical_from_local, const Box& box,
                    double error_m) const;

private:
    explicit LensView(const CameraModel& model) : model_(model) {}
    void find_blind();
    void find_seen();
    void find_straight();

    CameraModel model_;
    bool is_wide_ = false;
    double shortest_focal() const { return std::min(model_.intrinsics().fx, model_.intrinsics().fy); }

    double end_ = 0.0, rise_ = 0.0, guard_ = 0.0, straight_length_ = 0.0, simple_share_ = 0.0;
    glm::dvec2 slope_low_{0.0}, slope_high_{0.0};
    std::vector<BlindRun> blind_;
};

}  // namespace camrig

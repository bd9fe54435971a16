#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "core/camera/camera_model.h"
#include "core/render/pixel_rect.h"
#include "core/render/view_transform.h"
#include "core/world/model.h"

namespace camrig::render::scene {

/// A camera with a lens as something to draw with: where points of the optical frame lie in its picture, also those
/// that it does not show, and what of a scene it may show.
///
/// What is partly seen must have bounds as a whole. So the lens ends at `end_radius` of the ideal plane (LensMap),
/// where its picture or its valid disc ends, and from there on goes on slowly and straight outwards: what lies beyond
/// lands beside the picture, or on pixels that see nothing (`blind`), and never before what is seen.
///
/// Depth is z along the optical axis and the near plane is one, as in a pinhole picture; but a wide fisheye (`is_wide`)
/// knows directions that have no such z, and takes the distance to the eye for it: its near plane is a sphere.
///
/// Made once for the optics of a camera, in about 0.2 microseconds a pixel of the picture's border. Immutable; any
/// thread.
class LensView {
public:
    /// Refuses what CameraModel refuses.
    static Result<std::shared_ptr<const LensView>> create(ImageSize size, const camera::Intrinsics& intrinsics,
                                                          const camera::Lens& lens);

    const camera::CameraModel& model() const { return model_; }
    bool is_wide() const { return is_wide_; }
    double end_radius() const { return end_; }
    /// How far it goes on beyond, in focal lengths for each unit of the ideal plane.
    double rise() const { return rise_; }
    /// Of a lens that is not wide: beyond +-guard() of x / z and y / z nothing has a place.
    double guard() const { return guard_; }

    /// The ideal point of a direction; of a wide lens of any but none at all, of others of those ahead.
    glm::dvec2 ideal_of(const glm::dvec3& p) const;
    glm::dvec2 pixel_of_ideal(glm::dvec2 ideal) const;

    /// How many pixels the middle of an edge lies beside the straight line between its ends at most, for its squared
    /// length on the ideal plane; wherever the lens sees it, if it is no longer than short_length().
    double bend() const { return bend_; }
    double short_length() const { return short_length_; }
    static constexpr double most_bend_px = 1.0;  ///< of an edge of that length

    /// Pixels x0 <= x < x1 of row y whose ray() is none; by rows.
    struct BlindRun {
        int y = 0, x0 = 0, x1 = 0;
    };
    const std::vector<BlindRun>& blind() const { return blind_; }

    /// Holds all that a lens that is not wide can see.
    Frustum frustum(double near_m, double far_m) const;
    /// False only if the box certainly touches no pixel of a wide lens.
    bool may_see(const glm::dmat4& optical_from_local, const world::Box& box, double far_m) const;
    /// screen_bounds() through the lens.
    std::optional<PixelRect> pixels_of(const glm::dmat4& optical_from_local, const world::Box& box,
                                       double near_m) const;
    /// detail_error_px() through the lens.
    double error_px(const ViewTransform& view, const glm::dmat4& optical_from_local, const world::Box& box,
                    double error_m) const;

private:
    explicit LensView(const camera::CameraModel& model) : model_(model) {}
    void find_blind();
    std::vector<std::pair<int, int>> pixels_near_rim() const;
    void find_seen();
    void find_bend();

    camera::CameraModel model_;
    bool is_wide_ = false;
    double end_ = 0.0, rise_ = 0.0, guard_ = 0.0, bend_ = 0.0, short_length_ = 0.0;
    glm::dvec2 slope_low_{0.0}, slope_high_{0.0};  ///< of x / z and y / z of all that is seen, if it is not wide
    std::vector<BlindRun> blind_;
};

}  // namespace camrig::render::scene

#pragma once

#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "core/frame/frame.h"
#include "core/render/renderer.h"

namespace camrig::render {

/// The opening of a camera's lens, where a picture is focused: what lies nearer or farther is seen by each point of it
/// elsewhere, and the picture is the mean over all points (a thin lens).
///
/// With i = fx pixel_pitch the distance from lens to sensor, the focal length is f = 1 / (1/i + 1/focus), the opening
/// f / f_number wide, and a point at distance d a disc of |1/focus - 1/d| fx f / f_number pixels (the circle of
/// confusion).
struct Aperture {
    double radius_m = 0.0;
    double focus_m = 1.0;
};

/// nullopt: all of its picture is sharp.
std::optional<Aperture> aperture_of(const world::CameraSpec& spec);

/// The largest disc of all that the picture shows, in pixels across. depth: of the picture, in metres.
double largest_disc_px(const Aperture& aperture, const world::CameraSpec& spec, const frame::Frame& depth);

/// How many points of the opening it takes that the mean over them has the contrast of a disc within 0.02 at all
/// frequencies of the picture, up to discs of 18 pixels; of larger ones no more. 1: as sharp as a pixel can tell.
int count_of_points(double disc_px);
constexpr int most_points = 256;

/// Points of the opening in units of its radius, x to the right and y down: spread evenly (on the spiral of Vogel,
/// 1979), and their mean is the middle. Of one, the middle.
std::vector<glm::dvec2> points_of_opening(int count);

/// The view as that point of the opening has it: what is at the focus is where it was. Through a lens, whose picture
/// shifts otherwise than it is bent, the view turns instead, about the middle of the picture: it is sharp at
/// focus_m cos(angle) at an angle off it.
View seen_from(const View& view, const Aperture& aperture, glm::dvec2 point);

}  // namespace camrig::render

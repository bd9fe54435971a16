#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/frame/frame.h"
#include "core/render/moving_groups.h"
#include "core/render/renderer.h"
#include "core/sensor/row_times.h"
#include "core/world/camera_past.h"

namespace camrig::render {

/// What moves, or flickers, while a picture of a camera with a sensor is taken; nothing, where it has a focus alone.
struct ViewMotion {
    sensor::RowTimes times;                            ///< as far back as the world's past is kept
    std::array<world::CameraPast::Moment, 3> moments;  ///< begin, middle and end
    bool camera_moves = false;
    bool statics_change = false;     ///< a command or an event put others in their place
    std::vector<ObjectId> moving;    ///< of the movers, by rising id
    std::vector<double> flicker_hz;  ///< of lamps, each once
};

/// nullopt: everything stands still.
std::optional<ViewMotion> motion_of(const View& view, const sensor::RowTimes& times);
/// Nothing moves before the view: all is as at that instant.
ViewMotion standing_still(const View& view, const sensor::RowTimes& times, const world::SnapshotRef& instant);

/// The view at a moment. Of a camera with a lens the focal length stays what it is.
View view_at(const View& view, const camera::CameraState& state);

/// How many pixels what is in the picture is moved from begin to end, about.
struct MovedPixels {
    double most = 0.0;             ///< of all
    std::vector<MoverWay> movers;  ///< of those that move, by rising id
};
/// depth: of the middle moment, where the camera moves by more than turning.
MovedPixels moved_pixels(const ViewMotion& motion, const View& view, const frame::Frame* depth);
bool needs_depth(const ViewMotion& motion);

}  // namespace camrig::render

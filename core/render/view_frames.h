#pragma once

#include <memory>
#include <span>

#include "core/base/result.h"
#include "core/frame/frame_pool.h"
#include "core/frame/kind_format.h"
#include "core/render/renderer.h"

namespace camrig::render {

/// What flow is refused with by who does not draw it.
inline constexpr const char* no_flow =
    "flow: drawn by camrig's own rasteriser only, not by device null: with the principal point no farther than 8192 "
    "pixels from any edge of the picture";

/// Of a camera without a sensor there is nothing to draw of one, and nothing of what is on a lens.
inline bool wants(const View& view, frame::FrameKind kind) {
    return view.kinds[static_cast<int>(kind)] && kind != frame::FrameKind::soiling &&
           (kind != frame::FrameKind::sensor || view.spec->sensor);
}

/// Adds to `cost_ns` of each view its share of the time, by the samples of its pictures.
void share_cost(TimeNs spent_ns, std::span<const View> views, std::span<TimeNs> cost_ns);

/// An empty frame of the view's size that carries everything about the instant.
std::shared_ptr<frame::Frame> acquire_frame(frame::FramePool& pool, const View& view, frame::FrameKind kind,
                                            frame::PixelFormat format, TimeNs world_ns, TimeNs monotonic_ns,
                                            const std::optional<sensor::Exposure>& exposure = {});

/// How a view of a camera with a sensor is taken at that instant of a world; nullopt: it has none. Errors:
/// CameraSensor::exposure_of.
Result<std::optional<sensor::Exposure>> exposure_of(const View& view, const world::Snapshot& snapshot);
/// What the camera's clock says of a picture: where there is a sensor, when its first row's exposure begins.
std::optional<ClockReading> clock_of(const View& view, const std::optional<SensorReading>& sensor);
/// In which layout the numbers of a sensor are given.
frame::PixelFormat raw_format(sensor::ColorFilter filter);

/// Turns the object numbers of an instance picture into the numbers of their classes: a semantic picture.
void ids_to_classes(const world::Snapshot& snapshot, frame::Frame& frame);

/// What comes after drawing: the camera's image controls, then the code strip if it wants one.
void finish_color(const View& view, frame::Frame& frame);
/// Which pixels that changes. Rows: the same in all pictures of the view, which it draws anew each time.
enum class FinishedPixels { none, rows, all };
FinishedPixels finished_pixels(const View& view);

}  // namespace camrig::render

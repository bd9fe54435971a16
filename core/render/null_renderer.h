#pragma once

#include <memory>

#include "core/base/thread_check.h"
#include "core/frame/frame_pool.h"
#include "core/render/renderer.h"

namespace camrig::render {

/// A renderer without GL for tests of everything else: each pixel is a pure function of camera number, sequence, world
/// time, place in the image and kind. All kinds are there; code strips are drawn; nothing ever fails.
///
/// colour: red rises to the right, green downwards, blue is `null_pattern_blue`, alpha 255
/// depth: 1 m + 1 cm per pixel of x + y; the last row sees nothing (+inf)
/// instance, semantic: 8x8-pixel blocks numbered from 0 in reading order, modulo 16
/// normal: towards the camera (0, 0, -1) everywhere
class NullRenderer final : public Renderer {
public:
    explicit NullRenderer(std::shared_ptr<frame::FramePool> pool);

    Result<Finished> draw(const world::SnapshotRef& snapshot, TimeNs monotonic_ns,
                          std::span<const View> views) override;
    void forget(CameraId) override {}
    std::string description() const override { return "null (deterministic pattern, no GL)"; }

private:
    std::shared_ptr<frame::FramePool> pool_;
    ThreadCheck thread_;
};

/// The blue value of a null renderer's picture: tells apart cameras, frames and instants.
std::uint8_t null_pattern_blue(std::uint32_t camera_number, std::int64_t sequence, TimeNs world_ns);

}  // namespace camrig::render

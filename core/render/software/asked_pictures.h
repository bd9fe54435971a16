#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <functional>
#include <map>

#include "core/frame/frame.h"
#include "core/render/renderer.h"

namespace camrig::render::software {

/// Some FrameKinds, by number.
using KindSet = std::bitset<frame::frame_kind_count>;

/// What was asked for of each camera in one instant, call after call. Who took several kinds of the last picture will
/// take them of this one: they are drawn with the first of them, and kept until the next instant.
class AskedPictures {
public:
    struct OfCamera {
        std::uint64_t instant = 0;
        std::uint64_t spec_revision = 0;  ///< this, pose, quality and sequence: of what `frames` show
        camera::Pose pose;
        world::Quality quality = world::Quality::simple;
        std::int64_t sequence = -1;
        KindSet before, now;
        std::array<frame::FrameRef, frame::frame_kind_count> frames;
    };

    void next_instant();
    /// Notes that these kinds of the view are asked for; those of them that are to be drawn, and what is drawn beside
    /// them as far as it can be. `kept`: where the frames are to be kept and are to be taken from; null: nowhere.
    KindSet to_draw(const View& view, KindSet wanted, const std::function<bool(frame::FrameKind)>& can_draw,
                    OfCamera*& kept);
    void forget(CameraId camera) { cameras_.erase(camera); }
    void clear() { cameras_.clear(); }

private:
    std::uint64_t instant_ = 0;
    std::map<CameraId, OfCamera> cameras_;
};

}  // namespace camrig::render::software

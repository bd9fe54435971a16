#pragma once

#include <vector>

#include "core/base/ids.h"
#include "core/render/pixel_rect.h"

namespace camrig::render {

/// What one mover does in a picture while it is taken.
struct MoverWay {
    ObjectId id{};
    double px = 0.0;  ///< how far it is moved from begin to end, about; 0: beside the picture
    PixelRect rect;   ///< where it is meanwhile, about
};

/// Movers that are drawn together, at the same moments.
struct MovingGroup {
    std::vector<ObjectId> movers;  ///< by rising id
    double moved_px = 0.0;         ///< of the one that is moved furthest
};

/// Those that are before each other are together, and so are those that are moved about as far: few groups, of which
/// each is drawn as often as it needs. The same for ways in any order.
std::vector<MovingGroup> moving_groups(const std::vector<MoverWay>& ways);

}  // namespace camrig::render

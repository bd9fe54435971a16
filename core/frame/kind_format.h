#pragma once

#include "core/frame/frame.h"

namespace camrig::frame {

/// In which layout raw pictures of a kind are drawn and given; of a sensor the largest, its filter says which.
PixelFormat format_of(FrameKind kind);

}  // namespace camrig::frame

#pragma once

#include "core/frame/frame.h"

namespace camrig::frame {

/// In which layout raw pictures of a kind are drawn and given.
PixelFormat format_of(FrameKind kind);

}  // namespace camrig::frame

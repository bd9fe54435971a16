#include "core/frame/kind_format.h"

#include "core/base/result.h"

namespace camrig {

PixelFormat format_of(FrameKind kind) {
    switch (kind) {
        case FrameKind::color:
            return PixelFormat::rgba8;
        case FrameKind::depth:
            return PixelFormat::depth32f;
        case FrameKind::instance:
        case FrameKind::semantic:
            return PixelFormat::id32;
        case FrameKind::normal:
            return PixelFormat::normal32f;
    }
    CHECK(false);
    return PixelFormat::rgba8;
}

}  // namespace camrig

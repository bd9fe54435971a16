#include "core/frame/kind_format.h"

#include "core/base/result.h"

namespace camrig::frame {

std::span<const Named<FrameKind>> names_of(std::type_identity<FrameKind>) {
    static constexpr Named<FrameKind> names[] = {{FrameKind::color, "color"},       {FrameKind::depth, "depth"},
                                                 {FrameKind::instance, "instance"}, {FrameKind::semantic, "semantic"},
                                                 {FrameKind::normal, "normal"},     {FrameKind::sensor, "sensor"},
                                                 {FrameKind::flow, "flow"},         {FrameKind::soiling, "soiling"}};
    return names;
}

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
        case FrameKind::sensor:
            return PixelFormat::rgb16_planes;
        case FrameKind::flow:
            return PixelFormat::flow32f;
        case FrameKind::soiling:
            return PixelFormat::gray8;
    }
    CHECK(false);
    return PixelFormat::rgba8;
}

}  // namespace camrig::frame

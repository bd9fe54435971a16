#include "core/codec/encoder.h"

namespace camrig {

std::string_view to_string(Codec codec) {
    switch (codec) {
        case Codec::raw:
            return "raw";
        case Codec::jpeg:
            return "jpeg";
        case Codec::png:
            return "png";
    }
    return "unknown";
}

std::string_view to_string(ChromaSampling sampling) {
    return sampling == ChromaSampling::yuv422 ? "4:2:2" : "4:2:0";
}

}  // namespace camrig

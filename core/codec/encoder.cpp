#include "core/codec/encoder.h"

namespace camrig {

std::span<const Named<Codec>> names_of(std::type_identity<Codec>) {
    static constexpr Named<Codec> names[] = {{Codec::jpeg, "jpeg"}, {Codec::png, "png"}, {Codec::raw, "raw"}};
    return names;
}

std::string_view to_string(ChromaSampling sampling) {
    return sampling == ChromaSampling::yuv422 ? "4:2:2" : "4:2:0";
}

}  // namespace camrig

#include "core/codec/encoder.h"

namespace camrig::codec {

std::span<const Named<Codec>> names_of(std::type_identity<Codec>) {
    static constexpr Named<Codec> names[] = {{Codec::jpeg, "jpeg"}, {Codec::png, "png"}, {Codec::raw, "raw"}};
    return names;
}

std::span<const Named<ChromaSampling>> names_of(std::type_identity<ChromaSampling>) {
    static constexpr Named<ChromaSampling> names[] = {{ChromaSampling::yuv422, "4:2:2"},
                                                      {ChromaSampling::yuv420, "4:2:0"}};
    return names;
}

}  // namespace camrig::codec

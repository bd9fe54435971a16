#include "core/camera/lens.h"

namespace camrig::camera {

std::span<const Named<LensModel>> names_of(std::type_identity<LensModel>) {
    static constexpr Named<LensModel> names[] = {{LensModel::pinhole, "pinhole"},
                                                 {LensModel::plumb_bob, "plumb_bob"},
                                                 {LensModel::rational_polynomial, "rational_polynomial"},
                                                 {LensModel::equidistant, "equidistant"}};
    return names;
}

int coefficient_count(LensModel model) {
    switch (model) {
        case LensModel::pinhole:
            return 0;
        case LensModel::plumb_bob:
            return 5;
        case LensModel::rational_polynomial:
            return 8;
        case LensModel::equidistant:
            return 4;
    }
    CHECK(false);
    return 0;
}

}  // namespace camrig::camera

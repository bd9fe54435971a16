#pragma once

#include "core/camera/lens.h"

/// What others than its mathematics ask of a lens model, told from what it is, so that nobody else asks for a model by
/// name.
namespace camrig::camera {

/// A fisheye: its pictures can show what is beside and behind the camera. So it has intrinsics instead of a field of
/// view, and it bends lines also where all its coefficients are 0.
constexpr bool sees_behind(LensModel model) {
    return model == LensModel::equidistant;
}

/// Whether it draws pictures as a pinhole does.
constexpr bool is_plain(const Lens& lens) {
    if (sees_behind(lens.model)) return false;
    for (const double k : lens.coefficients)
        if (k != 0.0) return false;
    return true;
}

}  // namespace camrig::camera

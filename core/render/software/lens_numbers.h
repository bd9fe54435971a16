#pragma once

#include <algorithm>
#include <array>

#include "core/render/scene/lens_view.h"
#include "core/render/software/screen_triangles.h"

namespace camrig::render::software {

/// All numbers that where a point is seen follows from.
struct LensNumbers {
    camera::Intrinsics k;
    double near_m = 0.0, depth_scale = 0.0, depth_shift = 0.0;
    double guard = 0.0;
    std::array<float, 5> numerator{};
    std::array<float, 4> denominator{};
    float p1 = 0.0f, p2 = 0.0f;
    float end = 0.0f, seen = 0.0f, rise = 0.0f, short_length2 = 0.0f;
    float bend_subpixels = 0.0f;  ///< of an edge, at most, for each squared length on the ideal plane
    bool is_angular = false, is_wide = false, is_rational = false, has_tangential = false;

    LensNumbers() = default;
    LensNumbers(const scene::LensView& lens, const ViewTransform& view)
        : k(view.intrinsics),
          near_m(view.near_m),
          depth_scale(view.depth_scale),
          depth_shift(view.depth_shift),
          guard(lens.guard()),
          end(static_cast<float>(lens.end_radius())),
          seen(static_cast<float>(lens.end_radius() + lens.short_length())),
          rise(static_cast<float>(lens.rise())),
          short_length2(static_cast<float>(lens.short_length() * lens.short_length())),
          bend_subpixels(static_cast<float>(lens.bend() * subpixels)),
          is_wide(lens.is_wide()) {
        const camera::LensMap::Formula formula = lens.model().lens().formula();
        const auto narrow = [](double value) { return static_cast<float>(value); };
        std::ranges::transform(formula.numerator, numerator.begin(), narrow);
        std::ranges::transform(formula.denominator, denominator.begin(), narrow);
        p1 = narrow(formula.p1);
        p2 = narrow(formula.p2);
        is_angular = formula.is_angular;
        is_rational = std::ranges::any_of(formula.denominator.begin() + 1, formula.denominator.end(),
                                          [](double c) { return c != 0.0; });
        has_tangential = p1 != 0.0f || p2 != 0.0f;
    }
};

}  // namespace camrig::render::software

#pragma once

#include <array>
#include <numbers>

#include "core/render/software/lanes.h"
#include "core/render/software/lens_numbers.h"

/// LensView for eight points at once. What is as large as the picture is counted in double, what the lens does to it in
/// float: off by 2e-7 of the distance to the principal point.
namespace camrig::render::software {

/// The point (x, y, z) of a direction is seen at k.c + k.f * ((x, y) * factor + (aside_x, aside_y)).
struct ThroughLens {
    Lanes factor, aside_x, aside_y;
    Lanes ideal_x, ideal_y, radius;  ///< on the ideal plane
};

/// Any direction: z is 1 (not of a wide lens) or the direction's length is.
CAMRIG_LANES ThroughLens through_lens(const LensNumbers& lens, Lanes x, Lanes y, Lanes z) {
    const Lanes zero{}, one = zero + 1.0f;
    ThroughLens made{};
    Lanes turn = one;
    if (lens.is_angular) {
        // atan on [0, 1]: at most 2.4e-9 off (Lawson's iteration on Chebyshev polynomials of the square).
        constexpr std::array<float, 10> arc{1.0f,
                                            -0.3333328366279602f,
                                            0.1999826580286026f,
                                            -0.142619326710701f,
                                            0.10942026227712631f,
                                            -0.08377301692962646f,
                                            0.057551853358745575f,
                                            -0.030804336071014404f,
                                            0.01072679553180933f,
                                            -0.001753894961439073f};
        constexpr float half_pi = std::numbers::pi_v<float> / 2.0f, pi = std::numbers::pi_v<float>;
        const Lanes across = sqrt(x * x + y * y + 1e-30f), along = z < zero ? -z : z;
        const auto is_steep = across > along;
        const Lanes t = (is_steep ? along : across) / (is_steep ? across : along), t2 = t * t;
        Lanes sum = zero + arc.back();
        for (std::size_t i = arc.size() - 1; i-- > 0;) sum = sum * t2 + arc[i];
        const Lanes angle = is_steep ? half_pi - t * sum : t * sum;
        made.radius = z < zero ? pi - angle : angle;
        turn = made.radius / across;
    } else {
        made.radius = sqrt(x * x + y * y);
    }
    made.ideal_x = x * turn;
    made.ideal_y = y * turn;
    const auto is_beyond = made.radius > lens.end;
    const Lanes inner = is_beyond ? zero + lens.end : made.radius;
    const Lanes share = is_beyond ? lens.end / made.radius : one;
    const Lanes s = inner * inner;
    Lanes scale = zero + lens.numerator[4];
    for (std::size_t i = 4; i-- > 0;) scale = scale * s + lens.numerator[i];
    if (lens.is_rational) {
        Lanes below = zero + lens.denominator[3];
        for (std::size_t i = 3; i-- > 0;) below = below * s + lens.denominator[i];
        scale = scale / below;
    }
    made.factor = turn * (share * scale + (1.0f - share) * lens.rise);
    if (lens.has_tangential) {
        const Lanes ix = made.ideal_x * share, iy = made.ideal_y * share;
        const Lanes xx = ix * ix, yy = iy * iy, xy = ix * iy;
        made.aside_x = 2.0f * lens.p1 * xy + lens.p2 * (3.0f * xx + yy);
        made.aside_y = lens.p1 * (xx + 3.0f * yy) + 2.0f * lens.p2 * xy;
    }
    return made;
}

}  // namespace camrig::render::software

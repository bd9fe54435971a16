#pragma once

#include <cmath>
#include <numbers>

#include "core/render/scene/body_capsules.h"
#include "core/render/software/lambert.h"
#include "core/render/software/lanes.h"

/// shaders/contact.glsl for CPUs: what bodies keep of the light from all around.
namespace camrig::render::software {

/// The angle from the x axis of a point with y >= 0, to 1e-5. Abramowitz and Stegun, 4.4.49.
CAMRIG_LANES Lanes angle_of(Lanes y, Lanes x) {
    const Lanes across = max(x, -x);
    const Lanes more = max(across, y), less = min(across, y);
    const Lanes q = less / max(more, lanes(1e-30f)), q2 = q * q;
    const Lanes small =
        q * (0.9998660f + q2 * (-0.3302995f + q2 * (0.1801410f + q2 * (-0.0851330f + q2 * 0.0208351f))));
    constexpr auto pi = std::numbers::pi_v<float>;
    const Lanes acute = y > across ? 0.5f * pi - small : small;
    return x < 0.0f ? pi - acute : acute;
}

/// How far points are from the line in a capsule, and where on it they are nearest.
struct CapsulePlace {
    Lanes3 towards;  ///< from a point to the line
    Lanes distance2;
};
CAMRIG_LANES CapsulePlace place_at(const scene::CapsuleInView& capsule, const Lanes3& position) {
    const Lanes3 along = PointGroup::vector(capsule.along);
    const Lanes3 from = PointGroup::vector(capsule.from) - position;
    const float inverse_length2 = 1.0f / std::max(capsule.length * capsule.length, 1e-12f);
    const Lanes3 towards = from + along * clamp01(-dot(from, along) * inverse_length2);
    return {towards, dot(towards, towards)};
}
CAMRIG_LANES float reach_of(const scene::CapsuleInView& capsule) {
    return capsule.radius + static_cast<float>(scene::contact_reach_m);
}

/// Share of the light of an even hemisphere over a surface with normal n that a capsule hides. The ball that is
/// nearest hides (Oat and Sander, Ambient Aperture Lighting, 2007) or, if that is more, the line, as wide as it is
/// (Heitz and Hill, Real-Time Line- and Disk-Light Shading, SIGGRAPH 2017 courses), and half of the ball for its ends.
/// Fades away towards its reach.
CAMRIG_LANES Lanes hidden_share(const scene::CapsuleInView& capsule, const Lanes3& position, const Lanes3& n) {
    const CapsulePlace at = place_at(capsule, position);
    const float radius2 = capsule.radius * capsule.radius, reach = reach_of(capsule);
    const Lanes fade = clamp01(1.0f - at.distance2 * (1.0f / (reach * reach)));
    const Lanes distance2 = max(at.distance2, lanes(radius2));
    const Lanes cosine = max(dot(at.towards, n), Lanes{}) / sqrt(distance2);
    const Lanes ball = cosine * (radius2 / distance2);

    // The line in a frame about the point, cut at the horizon: along `unit` from first to last, beside it by d.
    const Lanes3 unit = PointGroup::vector(capsule.along * (1.0f / std::max(capsule.length, 1e-6f)));
    const Lanes3 from = PointGroup::vector(capsule.from) - position;
    const Lanes start = dot(from, unit), end = start + capsule.length;
    const Lanes3 beside = from - unit * start;
    const Lanes d = max(sqrt(dot(beside, beside)), lanes(capsule.radius));
    const Lanes height = dot(beside, n), slope = dot(unit, n);
    const Lanes horizon = -height / (slope > 0.0f ? max(slope, lanes(1e-6f)) : min(slope, lanes(-1e-6f)));
    const Lanes first = slope > 0.0f ? min(max(start, horizon), end) : start;
    const Lanes last = slope > 0.0f ? end : max(min(end, horizon), start);
    const Lanes first2 = d * d + first * first, last2 = d * d + last * last;
    const Lanes angle = angle_of(d * (last - first), d * d + first * last);
    const Lanes line = height * (last / last2 - first / first2 + angle / d) / d + slope * (d / first2 - d / last2);
    constexpr float inverse_pi = std::numbers::inv_pi_v<float>;
    return clamp01(max(ball, 0.5f * ball + line * (capsule.radius * inverse_pi))) * (fade * fade);
}

/// Whether any of the points is so near that it may be darkened.
template <typename Isa>
CAMRIG_LANES bool is_near(const scene::BodyInView& body, const Lanes3& position) {
    const Lanes3 away = PointGroup::vector(body.middle) - position;
    return Isa::bits(dot(away, away) < body.radius2) != 0;
}
template <typename Isa>
CAMRIG_LANES bool is_near(const scene::CapsuleInView& capsule, const Lanes3& position) {
    const float reach = reach_of(capsule);
    return Isa::bits(place_at(capsule, position).distance2 < reach * reach) != 0;
}

/// Share of the light from all around that bodies leave to the points of something; without movers: those that stand.
template <typename Isa>
CAMRIG_LANES Lanes open_share(const scene::BodiesInView& bodies, ObjectId own, bool has_movers, const Lanes3& position,
                              const Lanes3& n) {
    Lanes open = lanes(1.0f);
    for (const scene::BodyInView& body : bodies.bodies) {
        if ((body.is_moving != 0 && !has_movers) || body.object == own || !is_near<Isa>(body, position)) continue;
        for (std::uint32_t i = body.first; i < body.first + body.count; ++i) {
            if (is_near<Isa>(bodies.capsules[i], position))
                open = open * (1.0f - hidden_share(bodies.capsules[i], position, n));
        }
    }
    return open;
}

/// Where bodies that move may darken something, whatever its normal.
template <typename Isa>
CAMRIG_LANES IntLanes may_be_darkened(const scene::BodiesInView& bodies, const Lanes3& position) {
    /// Places of pixels are found again, from depth, with other roundings.
    constexpr float margin = 1.01f;
    IntLanes found{};
    for (const scene::BodyInView& body : bodies.bodies) {
        if (body.is_moving == 0 || !is_near<Isa>(body, position)) continue;
        for (std::uint32_t i = body.first; i < body.first + body.count; ++i) {
            const float reach = margin * reach_of(bodies.capsules[i]);
            found |= place_at(bodies.capsules[i], position).distance2 < reach * reach;
        }
    }
    return found;
}

}  // namespace camrig::render::software

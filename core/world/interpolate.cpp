#include "core/world/interpolate.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/portable_math.h"

namespace camrig::world {
namespace {

struct KeyPlace {
    std::size_t key = 0;  ///< the one at or before
    double u = 0.0;       ///< 0 at it, towards 1 at the next; 0 outside the keys
    double span_s = 0.0;
};

KeyPlace find_keys(const Channel& channel, TimeNs t) {
    const auto& times = channel.times_ns;
    const auto after = std::upper_bound(times.begin(), times.end(), t);
    if (after == times.begin()) return {};
    const auto key = static_cast<std::size_t>(after - times.begin()) - 1;
    if (after == times.end() || channel.interpolation == Interpolation::step) return {.key = key};
    const auto span = static_cast<double>(*after - times[key]);
    return {.key = key, .u = static_cast<double>(t - times[key]) / span, .span_s = span * 1e-9};
}

/// Component `c` by the rule of the channel; for rotations this is right for step and cubic splines only.
double component(const Channel& channel, const KeyPlace& at, std::size_t c) {
    const auto width = static_cast<std::size_t>(channel.width);
    const auto& values = channel.values;
    if (channel.interpolation != Interpolation::cubic_spline) {
        const double a = values[at.key * width + c];
        return at.u == 0.0 ? a : a + at.u * (values[(at.key + 1) * width + c] - a);
    }
    // Per key: in-tangent, value, out-tangent. Hermite spline with tangents scaled by the span in seconds.
    const double p0 = values[(at.key * 3 + 1) * width + c];
    if (at.u == 0.0) return p0;
    const double m0 = at.span_s * values[(at.key * 3 + 2) * width + c];
    const double m1 = at.span_s * values[(at.key + 1) * 3 * width + c];
    const double p1 = values[((at.key + 1) * 3 + 1) * width + c];
    const double u = at.u, u2 = u * u, u3 = u2 * u;
    return (2 * u3 - 3 * u2 + 1) * p0 + (u3 - 2 * u2 + u) * m0 + (3 * u2 - 2 * u3) * p1 + (u3 - u2) * m1;
}

glm::dquat key_rotation(const Channel& channel, std::size_t key) {
    const float* q = channel.values.data() + key * 4;
    return glm::normalize(glm::dquat(q[3], q[0], q[1], q[2]));
}

double norm(const glm::dquat& q) {
    return std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
}

}  // namespace

glm::dquat slerp_shortest(const glm::dquat& a, const glm::dquat& to, double t) {
    const glm::dquat b = glm::dot(a, to) < 0.0 ? -to : to;
    const double angle = 2.0 * portable::atan2(norm(a - b), norm(a + b));  // 0 .. pi/2
    const double sine = portable::sin(angle);
    // Below this the difference of sine and straight line is under 1e-17.
    const bool straight = angle < 1e-8;
    const double wa = straight ? 1.0 - t : portable::sin((1.0 - t) * angle) / sine;
    const double wb = straight ? t : portable::sin(t * angle) / sine;
    return glm::normalize(a * wa + b * wb);
}

glm::dvec3 sample_vector(const Channel& channel, TimeNs phase_ns) {
    const KeyPlace at = find_keys(channel, phase_ns);
    return {component(channel, at, 0), component(channel, at, 1), component(channel, at, 2)};
}

glm::dquat sample_rotation(const Channel& channel, TimeNs phase_ns) {
    const KeyPlace at = find_keys(channel, phase_ns);
    if (channel.interpolation == Interpolation::cubic_spline) {
        const glm::dquat q(component(channel, at, 3), component(channel, at, 0), component(channel, at, 1),
                           component(channel, at, 2));
        const double length = norm(q);
        // A spline may pass through zero between opposite keys; then the key before stands.
        if (length > 1e-9) return q * (1.0 / length);
        const float* v = channel.values.data() + (at.key * 3 + 1) * 4;
        return glm::normalize(glm::dquat(v[3], v[0], v[1], v[2]));
    }
    const glm::dquat a = key_rotation(channel, at.key);
    return at.u == 0.0 ? a : slerp_shortest(a, key_rotation(channel, at.key + 1), at.u);
}

void sample_weights(const Channel& channel, TimeNs phase_ns, std::vector<float>& out) {
    const KeyPlace at = find_keys(channel, phase_ns);
    out.resize(static_cast<std::size_t>(channel.width));
    for (std::size_t c = 0; c < out.size(); ++c) out[c] = static_cast<float>(component(channel, at, c));
}

}  // namespace camrig::world

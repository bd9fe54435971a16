#include "core/render/surface_tables.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "core/base/portable_math.h"

namespace camrig::render {
namespace {

constexpr int directions = 256;
constexpr double pi = std::numbers::pi;
/// Between these heights of a direction the ground becomes sky.
constexpr double horizon = 0.2;

/// The second coordinate of a Hammersley point: the bits of i behind the point, in reverse.
double radical_inverse(std::uint32_t i) {
    double result = 0.0;
    for (double digit = 0.5; i != 0; i >>= 1, digit *= 0.5) result += (i & 1) != 0 ? digit : 0.0;
    return result;
}

/// Half vectors of a GGX surface that faces z, distributed as D(h) (n.h).
glm::dvec3 half_vector(int i, double alpha) {
    const double u = (i + 0.5) / directions, phi = 2.0 * pi * radical_inverse(static_cast<std::uint32_t>(i));
    const double cosine = std::sqrt((1.0 - u) / (1.0 + (alpha * alpha - 1.0) * u));
    const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
    return {sine * portable::cos(phi), sine * portable::sin(phi), cosine};
}

/// Roughness of a row, squared, as the shader does.
double alpha_of(int row) {
    const double roughness = static_cast<double>(row) / (table_side - 1);
    return std::max(roughness * roughness, 0.002);
}

/// Share of the sky in the radiance from a direction of this height.
double sky_share(double height) {
    // Irradiance from above of clamp(height / horizon), which is below that of a step.
    constexpr double contrast = 1.0 / (1.0 - horizon * horizon / 3.0);
    return 0.5 + 0.5 * contrast * std::clamp(height / horizon, -1.0, 1.0);
}

}  // namespace

std::vector<glm::vec2> make_reflectance_table() {
    std::vector<glm::vec2> table;
    for (int row = 0; row < table_side; ++row) {
        const double alpha = alpha_of(row);
        const auto passed = [a2 = alpha * alpha](double cosine) {
            return 2.0 * cosine / (cosine + std::sqrt(a2 + (1.0 - a2) * cosine * cosine));
        };
        for (int column = 0; column < table_side; ++column) {
            const double nv = std::max(static_cast<double>(column) / (table_side - 1), 1e-3);
            const glm::dvec3 v(std::sqrt(1.0 - nv * nv), 0.0, nv);
            double scale = 0.0, bias = 0.0;
            for (int i = 0; i < directions; ++i) {
                const glm::dvec3 h = half_vector(i, alpha);
                const double vh = glm::dot(v, h);
                const double nl = 2.0 * vh * h.z - v.z;
                if (!(nl > 0.0)) continue;
                const double weight = passed(nl) * passed(nv) * vh / (h.z * nv);
                const double away = 1.0 - vh, fresnel = away * away * (away * away) * away;
                scale += (1.0 - fresnel) * weight;
                bias += fresnel * weight;
            }
            table.emplace_back(scale / directions, bias / directions);
        }
    }
    return table;
}

std::vector<float> make_sky_table() {
    std::vector<float> table;
    for (int row = 0; row < table_side; ++row) {
        const double alpha = alpha_of(row);
        for (int column = 0; column < table_side; ++column) {
            const double height = 2.0 * column / (table_side - 1) - 1.0;
            const glm::dvec3 up(std::sqrt(std::max(0.0, 1.0 - height * height)), 0.0, height);
            double sum = 0.0, weights = 0.0;
            for (int i = 0; i < directions; ++i) {
                // The lobe around z with the eye on its axis, as the split sum has it.
                const glm::dvec3 h = half_vector(i, alpha);
                const glm::dvec3 l = 2.0 * h.z * h - glm::dvec3(0.0, 0.0, 1.0);
                if (!(l.z > 0.0)) continue;
                sum += l.z * sky_share(glm::dot(l, up));
                weights += l.z;
            }
            table.push_back(static_cast<float>(sum / weights));
        }
    }
    return table;
}

}  // namespace camrig::render

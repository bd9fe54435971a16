#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include <Eigen/Dense>

#include "core/photo/plate_light.h"

// low + contrast * Phi((s - shift) / sigma), s the distance from a line at `angle`: five numbers by Gauss and Newton.
namespace camrig::photo {
namespace {

constexpr double reach_px = 8.0;
constexpr double least_contrast = 0.02;
constexpr int most_steps = 40;
constexpr int least_pixels = 32;
constexpr double most_wrong_share = 0.12;  ///< of the contrast

struct Sample {
    Eigen::Vector2d at;  ///< from the middle of the edge
    double light;
};

using Numbers = Eigen::Matrix<double, 5, 1>;
enum : int { low, contrast, shift, sigma, angle };

double luminance(const Picture& picture, int x, int y) {
    return 0.2126 * linear_of(picture.code(x, y, 0)) + 0.7152 * linear_of(picture.code(x, y, 1)) +
           0.0722 * linear_of(picture.code(x, y, 2));
}

std::vector<Sample> samples_of(const Picture& picture, const Region& region) {
    std::vector<Sample> samples;
    for (int y = region.y; y < region.y + region.height; ++y)
        for (int x = region.x; x < region.x + region.width; ++x) samples.push_back({{x, y}, luminance(picture, x, y)});
    return samples;
}

/// Where the slopes of the region are, and which way most of them run; the samples are then told from there. None where
/// they run all ways.
std::optional<Numbers> first_guess(std::vector<Sample>& samples, const Region& region) {
    Eigen::Matrix2d tensor = Eigen::Matrix2d::Zero();
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    double weight = 0.0;
    const auto light = [&](int x, int y) { return samples[std::size_t(y * region.width + x)].light; };
    for (int y = 1; y < region.height - 1; ++y)
        for (int x = 1; x < region.width - 1; ++x) {
            const Eigen::Vector2d slope(light(x + 1, y) - light(x - 1, y), light(x, y + 1) - light(x, y - 1));
            tensor += slope * slope.transpose();
            middle += slope.squaredNorm() * samples[std::size_t(y * region.width + x)].at;
            weight += slope.squaredNorm();
        }
    const auto [least, most] = std::ranges::minmax(samples, {}, &Sample::light);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(tensor);
    if (most.light - least.light < least_contrast || axes.eigenvalues()[0] > 0.1 * axes.eigenvalues()[1])
        return std::nullopt;
    const Eigen::Vector2d across = axes.eigenvectors().col(1);
    double rise = 0.0;
    for (Sample& each : samples) {
        each.at -= middle / weight;
        rise += (each.light - 0.5 * (least.light + most.light)) * each.at.dot(across);
    }
    Numbers guess;
    guess << least.light, most.light - least.light, 0.0, 0.8, std::atan2(across[1], across[0]);
    if (rise < 0.0) guess[low] = most.light, guess[contrast] = -guess[contrast];
    return guess;
}

/// One step of Gauss and Newton; `wrong`: root of the mean square of what was left before it.
Numbers step_from(const Numbers& fit, const std::vector<Sample>& samples, double& wrong) {
    Eigen::Matrix<double, 5, 5> normal = Eigen::Matrix<double, 5, 5>::Identity() * 1e-9;
    Numbers right = Numbers::Zero();
    const Eigen::Vector2d across(std::cos(fit[angle]), std::sin(fit[angle])), along(-across[1], across[0]);
    double squares = 0.0;
    int count = 0;
    for (const Sample& each : samples) {
        const double s = each.at.dot(across);
        if (std::abs(s) > reach_px) continue;
        const double u = (s - fit[shift]) / fit[sigma], phi = 0.5 * std::erfc(-u / std::numbers::sqrt2);
        const double slope = fit[contrast] * std::exp(-0.5 * u * u) / std::sqrt(2.0 * std::numbers::pi) / fit[sigma];
        const double off = each.light - (fit[low] + fit[contrast] * phi);
        Numbers row;
        row << 1.0, phi, -slope, -slope * u, slope * each.at.dot(along);
        normal += row * row.transpose();
        right += row * off;
        squares += off * off;
        ++count;
    }
    wrong = count < least_pixels ? INFINITY : std::sqrt(squares / count);
    Numbers step = normal.ldlt().solve(right);
    step[sigma] = std::clamp(step[sigma], -0.4 * fit[sigma], 0.5 * fit[sigma]);
    step[shift] = std::clamp(step[shift], -1.0, 1.0);
    step[angle] = std::clamp(step[angle], -0.05, 0.05);
    return step;
}

}  // namespace

Result<double> fit_edge(const Picture& picture, const Region& region) {
    if (auto good = check_region(picture, region); !good) return std::unexpected(good.error());
    if (region.width < 8 || region.height < 8) return error(ErrorKind::invalid_argument, "must be 8x8 pixels or more");
    const auto no_edge = error(ErrorKind::invalid_argument, "shows not one straight edge between two plain surfaces");
    std::vector<Sample> samples = samples_of(picture, region);
    const auto guess = first_guess(samples, region);
    if (!guess) return no_edge;
    Numbers fit = *guess;
    double wrong = 0.0;
    for (int turn = 0; turn < most_steps; ++turn) {
        const Numbers step = step_from(fit, samples, wrong);
        if (!step.allFinite()) return no_edge;
        fit += step;
        if (step.norm() < 1e-9) break;
    }
    if (wrong > most_wrong_share * std::abs(fit[contrast]) || fit[sigma] > 0.5 * reach_px) return no_edge;
    return std::sqrt(std::max(0.0, fit[sigma] * fit[sigma] - 1.0 / 12.0));
}

}  // namespace camrig::photo

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Dense>
#include <boost/math/distributions/chi_squared.hpp>

#include "core/photo/plate_light.h"

namespace camrig::photo {
namespace {

constexpr int block = 8;
constexpr int block_freedom = block * block - 3;
constexpr int levels = 16;
constexpr std::size_t least_blocks = 12;

struct Flat {
    double level, variance;
};

/// Mean, and variance less a plane; clipped blocks have none.
std::optional<Flat> flatness(const Picture& picture, int x0, int y0, int channel) {
    double sum = 0, sum_x = 0, sum_y = 0, squares = 0;
    const double middle = 0.5 * (block - 1);
    for (int y = 0; y < block; ++y)
        for (int x = 0; x < block; ++x) {
            const int code = picture.code(x0 + x, y0 + y, channel);
            if (code < 3 || code > 252) return std::nullopt;
            sum += code;
            sum_x += code * (x - middle);
            sum_y += code * (y - middle);
            squares += double(code) * code;
        }
    constexpr double count = block * block, moment = count * (block * block - 1) / 12.0;
    return Flat{sum / count, std::max(0.0, (squares - sum * sum / count - (sum_x * sum_x + sum_y * sum_y) / moment) /
                                               block_freedom)};
}

/// Variance of the flat ones among blocks of one level. What has texture has more: the least tenth begins, then all
/// count that noise alone would make as rough.
Flat flat_variance(std::vector<Flat>& blocks, int& used) {
    const boost::math::chi_squared spread(block_freedom);
    std::ranges::sort(blocks, {}, &Flat::variance);
    double variance = blocks[blocks.size() / 10].variance / (quantile(spread, 0.1) / block_freedom);
    Flat mean{};
    for (int turn = 0; turn < 6; ++turn) {
        const double most = std::max(variance * quantile(spread, 0.99) / block_freedom, 1.0 / 12.0);
        mean = {};
        used = 0;
        for (const Flat& each : blocks) {
            if (each.variance > most) break;
            mean.level += each.level;
            mean.variance += each.variance;
            ++used;
        }
        mean.level /= std::max(used, 1);
        mean.variance /= std::max(used, 1);
        variance = mean.variance;
    }
    return mean;
}

}  // namespace

Result<PlateNoise> fit_noise(const Picture& picture) {
    std::array<std::vector<Flat>, levels> found;
    for (int y = 0; y + block <= picture.size.height; y += block)
        for (int x = 0; x + block <= picture.size.width; x += block)
            for (int channel = 0; channel < 3; ++channel)
                if (const auto each = flatness(picture, x, y, channel))
                    found[std::size_t(each->level * levels / 256.0)].push_back(*each);
    // variance = k level + read^2, each level with the weight of its relative error.
    PlateNoise noise;
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    int rows = 0;
    for (std::vector<Flat>& blocks : found) {
        if (blocks.size() < least_blocks) continue;
        int used = 0;
        const Flat mean = flat_variance(blocks, used);
        if (used < int(least_blocks) / 2) continue;
        const double variance = std::max(0.0, mean.variance - 1.0 / 12.0);
        const double weight = used / std::pow(mean.variance + 0.01, 2);
        const Eigen::Vector2d row(mean.level, 1.0);
        normal += weight * row * row.transpose();
        right += weight * variance * row;
        noise.blocks += used;
        ++rows;
    }
    if (rows == 0)
        return error(ErrorKind::invalid_argument, "noise: hardly anything in the photo is flat; give noise by hand");
    Eigen::Vector2d line =
        rows > 1 ? Eigen::Vector2d(normal.ldlt().solve(right)) : Eigen::Vector2d(0.0, right[1] / normal(1, 1));
    if (line[0] < 0.0) line = {0.0, right[1] / normal(1, 1)};
    if (line[1] < 0.0) line = {right[0] / normal(0, 0), 0.0};
    noise.k = std::max(0.0, line[0]);
    noise.read = std::sqrt(std::max(0.0, line[1]));
    return noise;
}

}  // namespace camrig::photo

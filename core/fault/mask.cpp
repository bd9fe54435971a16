#include "core/fault/mask.h"

#include <algorithm>
#include <cmath>

#include "core/fault/light.h"

namespace camrig::fault {
namespace {

constexpr int grid_columns = 192;
/// How far above and below the height the edge of a spot goes, as a share of the noise.
constexpr double edge = 0.12;

double smooth(double share) {
    const double s = std::clamp(share, 0.0, 1.0);
    return s * s * (3.0 - 2.0 * s);
}

/// Even noise at whole numbers, smooth between; twice, the second time half as large and finer.
double noise(std::uint64_t key, double x, double y) {
    double sum = 0.0, weight = 2.0 / 3.0;
    for (int octave = 0; octave < 2; ++octave, x *= 2.0, y *= 2.0, weight /= 2.0) {
        const double column = std::floor(x), row = std::floor(y);
        const auto at = [&](int dx, int dy) {
            const auto cx = static_cast<std::uint64_t>(static_cast<std::int64_t>(column) + dx);
            const auto cy = static_cast<std::uint64_t>(static_cast<std::int64_t>(row) + dy);
            return static_cast<double>(mixed(key + mixed(cx + mixed(cy + static_cast<std::uint64_t>(octave)))) >> 11) *
                   0x1.0p-53;
        };
        const double sx = smooth(x - column), sy = smooth(y - row);
        sum += weight * ((at(0, 0) * (1 - sx) + at(1, 0) * sx) * (1 - sy) + (at(0, 1) * (1 - sx) + at(1, 1) * sx) * sy);
    }
    return sum;
}

}  // namespace

Mask::Mask(ImageSize size, int columns, int rows)
    : size_(size),
      columns_(columns),
      rows_(rows),
      values_(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows)) {}

Mask Mask::dirt(const Fault& fault, ImageSize size, double coverage, double spot) {
    const int rows = std::max(2, grid_columns * size.height / size.width);
    Mask mask(size, grid_columns, rows);
    const std::uint64_t key = mixed(fault.seed + mixed(fault.id));
    const double scale = 1.0 / (spot * grid_columns);
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < grid_columns; ++column)
            mask.at(column, row) = static_cast<float>(noise(key, column * scale, row * scale));
    std::vector<float> sorted = mask.values_;
    const auto under = static_cast<std::ptrdiff_t>((1.0 - coverage) * static_cast<double>(sorted.size()));
    // At coverage 0 all is below the height and its edge, at 1 all is above.
    float height = 1.0f + static_cast<float>(edge);
    if (coverage >= 1.0) {
        height = -static_cast<float>(edge);
    } else if (coverage > 0.0) {
        std::ranges::nth_element(sorted, sorted.begin() + std::min<std::ptrdiff_t>(under, std::ssize(sorted) - 1));
        height = sorted[static_cast<std::size_t>(std::min<std::ptrdiff_t>(under, std::ssize(sorted) - 1))];
    }
    for (float& value : mask.values_)
        value = static_cast<float>(smooth((static_cast<double>(value - height) + edge) / (2.0 * edge)));
    return mask;
}

Mask Mask::from_above(ImageSize size, double share, double softness) {
    const int rows = std::clamp(size.height, 2, grid_columns);
    Mask mask(size, 2, rows);
    const double blurred = std::max(softness, 1e-3), down = share * (1.0 + blurred);
    for (int row = 0; row < rows; ++row) {
        const double at = static_cast<double>(row) / (rows - 1);
        mask.at(0, row) = mask.at(1, row) = static_cast<float>(smooth((down - at) / blurred));
    }
    return mask;
}

std::optional<Mask> Mask::of(const Fault& fault, ImageSize size) {
    if (const auto* const soiled = std::get_if<Dirt>(&fault.kind))
        return dirt(fault, size, soiled->coverage * fault.severity, soiled->spot);
    if (const auto* const covered = std::get_if<Covered>(&fault.kind))
        return from_above(size, fault.severity, covered->softness);
    return std::nullopt;
}

void Mask::row(int y, std::span<float> alpha) const {
    const double at = static_cast<double>(y) * (rows_ - 1) / std::max(1, size_.height - 1);
    const int above = std::min(static_cast<int>(at), rows_ - 2);
    const auto down = static_cast<float>(at - above);
    const float* const first = &values_[static_cast<std::size_t>(above) * static_cast<std::size_t>(columns_)];
    const float* const second = first + columns_;
    for (std::size_t x = 0; x < alpha.size(); ++x) {
        const double across = static_cast<double>(x) * (columns_ - 1) / std::max(1, size_.width - 1);
        const int left = std::min(static_cast<int>(across), columns_ - 2);
        const auto right = static_cast<float>(across - left);
        const float top = first[left] + (first[left + 1] - first[left]) * right;
        const float bottom = second[left] + (second[left + 1] - second[left]) * right;
        alpha[x] = top + (bottom - top) * down;
    }
}

double Mask::covered() const {
    const auto over = std::ranges::count_if(values_, [](float value) { return value > 0.5f; });
    return static_cast<double>(over) / static_cast<double>(values_.size());
}

std::vector<WaterDrop> drops_of(const Fault& fault, ImageSize size) {
    const auto& kind = std::get<WaterDrops>(fault.kind);
    std::vector<WaterDrop> drops(static_cast<std::size_t>(std::ceil(fault.severity * static_cast<double>(kind.count))));
    for (std::size_t i = 0; i < drops.size(); ++i)
        drops[i] = {chance(fault, i, 0) * size.width, chance(fault, i, 1) * size.height,
                    0.5 * kind.size * size.width * (0.5 + 0.5 * chance(fault, i, 2))};
    return drops;
}

namespace {

/// The share of each pixel's light that passes.
std::vector<float> passing(const FrameFaults& faults, ImageSize size) {
    std::vector<float> passes(static_cast<std::size_t>(size.pixels()), 1.0f);
    const auto width = static_cast<std::size_t>(size.width);
    std::vector<float> alpha(width);
    for (const FaultRef& one : faults.active) {
        if (const auto mask = Mask::of(*one, size))
            for (int y = 0; y < size.height; ++y) {
                mask->row(y, alpha);
                float* const row = &passes[static_cast<std::size_t>(y) * width];
                for (std::size_t x = 0; x < width; ++x) row[x] *= 1.0f - alpha[x];
            }
        if (const auto* const fog = std::get_if<Condensation>(&one->kind))
            for (float& share : passes) share *= static_cast<float>(1.0 - fog->veil * one->severity);
        if (!std::holds_alternative<WaterDrops>(one->kind)) continue;
        for (const WaterDrop& drop : drops_of(*one, size))
            for (int y = std::max(0, static_cast<int>(drop.y - drop.radius));
                 y < std::min(size.height, static_cast<int>(drop.y + drop.radius) + 2); ++y)
                for (int x = std::max(0, static_cast<int>(drop.x - drop.radius));
                     x < std::min(size.width, static_cast<int>(drop.x + drop.radius) + 2); ++x)
                    if (std::hypot(x - drop.x, y - drop.y) < drop.radius)
                        passes[static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)] = 0.0f;
    }
    return passes;
}

bool hides(const FaultRef& fault) {
    return layer_of(fault->kind) == Layer::optics && !std::holds_alternative<Defocus>(fault->kind);
}

}  // namespace

bool hides_scene(const FrameFaults& faults) {
    return std::ranges::any_of(faults.active, hides);
}

std::vector<std::uint8_t> hidden_mask(const FrameFaults* faults, ImageSize size) {
    std::vector<std::uint8_t> mask(static_cast<std::size_t>(size.pixels()));
    if (faults == nullptr || !hides_scene(*faults)) return mask;
    std::ranges::transform(passing(*faults, size), mask.begin(), [](float passes) {
        return static_cast<std::uint8_t>(std::clamp(255.0f * (1.0f - passes) + 0.5f, 0.0f, 255.0f));
    });
    return mask;
}

double covered_fraction(const FrameFaults& faults, ImageSize size) {
    if (!hides_scene(faults)) return 0.0;
    const auto covered = std::ranges::count_if(passing(faults, size), [](float share) { return share < 0.5f; });
    return static_cast<double>(covered) / static_cast<double>(size.pixels());
}

double blur_radius_px(const FrameFaults& faults, ImageSize size) {
    double squares = 0.0;  // variances of blurs add up
    const auto add = [&](const Fault& one, const auto* blurred) {
        if (blurred == nullptr) return;
        const double radius = blurred->radius * one.severity * size.width;
        squares += radius * radius;
    };
    for (const FaultRef& one : faults.active) {
        add(*one, std::get_if<Defocus>(&one->kind));
        add(*one, std::get_if<Condensation>(&one->kind));
    }
    return std::sqrt(squares);
}

}  // namespace camrig::fault

#include "core/fault/light.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/portable_math.h"

namespace camrig::fault {
namespace {

constexpr int steps = 4096;

struct Curves {
    std::array<double, 256> light{};
    std::array<std::uint8_t, steps + 1> code{};
    Curves() {
        for (int i = 0; i < 256; ++i) {
            const double s = i / 255.0;
            light[static_cast<std::size_t>(i)] =
                s <= 0.04045 ? s / 12.92 : portable::exp(2.4 * portable::log((s + 0.055) / 1.055));
        }
        // The code whose light is nearest; codes come back from their own light as they were.
        std::size_t next = 0;
        for (int i = 0; i <= steps; ++i) {
            const double at = light_at(i);
            while (next < 255 && light[next + 1] - at < at - light[next]) ++next;
            code[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(next);
        }
    }
    /// Steps are even in the square root of the light, as codes nearly are.
    static double light_at(int step) { return static_cast<double>(step) / steps * step / steps; }
};

const Curves& curves() {
    static const Curves made;
    return made;
}

/// A mean over 2 * reach + 1 neighbours in a line, and the next one on either side with this weight.
struct Box {
    int reach = 0;
    double weight = 0.0;

    /// That of this variance, in pixels^2.
    static Box of_variance(double variance) {
        const int reach = static_cast<int>((std::sqrt(12.0 * variance + 1.0) - 1.0) / 2.0);
        const double side = reach + 1.0, squares = reach * side * (2.0 * reach + 1.0) / 3.0;
        return {reach, (variance * (2.0 * reach + 1.0) - squares) / (2.0 * (side * side - variance))};
    }
};

/// Of `count` values that are `stride` apart.
void mean(std::vector<float>& values, std::size_t first, std::size_t count, std::size_t stride, const Box& box,
          std::vector<float>& line) {
    line.resize(count);
    for (std::size_t i = 0; i < count; ++i) line[i] = values[first + i * stride];
    const auto at = [&](std::ptrdiff_t i) -> double {
        return line[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i, 0, static_cast<std::ptrdiff_t>(count) - 1))];
    };
    double sum = 0.0;
    for (int i = -box.reach; i <= box.reach; ++i) sum += at(i);
    const double share = 1.0 / (2.0 * box.reach + 1.0 + 2.0 * box.weight);
    for (std::size_t i = 0; i < count; ++i) {
        const auto here = static_cast<std::ptrdiff_t>(i);
        const double before = at(here - box.reach - 1), after = at(here + box.reach + 1);
        values[first + i * stride] = static_cast<float>(share * (sum + box.weight * (before + after)));
        sum += after - at(here - box.reach);
    }
}

}  // namespace

double light_of(int code) {
    return curves().light[static_cast<std::size_t>(code)];
}

int coded(double light) {
    const double root = std::sqrt(std::clamp(light, 0.0, 1.0));
    return curves().code[static_cast<std::size_t>(root * steps + 0.5)];
}

void blur(std::span<std::byte> rgba, ImageSize size, double radius) {
    const auto width = static_cast<std::size_t>(size.width), height = static_cast<std::size_t>(size.height);
    // A disc has the variance radius^2 / 4 along each axis.
    const Box box = Box::of_variance(radius * radius / 4.0 / 3.0);
    std::vector<float> values(width * height), line;
    for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t i = 0; i < values.size(); ++i)
            values[i] = static_cast<float>(light_of(std::to_integer<int>(rgba[4 * i + c])));
        for (int pass = 0; pass < 3; ++pass) {
            for (std::size_t y = 0; y < height; ++y) mean(values, y * width, width, 1, box, line);
            for (std::size_t x = 0; x < width; ++x) mean(values, x, height, width, box, line);
        }
        for (std::size_t i = 0; i < values.size(); ++i)
            rgba[4 * i + c] = static_cast<std::byte>(coded(static_cast<double>(values[i])));
    }
}

}  // namespace camrig::fault

#include "core/sensor/frame_statistics.h"

#include <algorithm>
#include <vector>

#include "core/base/result.h"
#include "core/sensor/bayer.h"

namespace camrig::sensor {
namespace {

constexpr int green = 1;

/// Blocks of 2x2 from one that is looked at to the next, in both directions.
int step_of(ImageSize size) {
    constexpr std::int64_t most_sites = 65536;
    int step = 1;
    while (size.pixels() / (std::int64_t{step} * step) > 2 * most_sites) ++step;
    return step;
}

struct Sum {
    std::uint64_t numbers = 0, count = 0;
};

/// Numbers of green photosites, by how many had them.
struct Histogram {
    std::vector<std::uint32_t> counts;
    std::uint64_t total = 0;

    double mean_of_brightest(double share) const {
        const auto wanted = std::max(share * static_cast<double>(total), 1.0);
        double sum = 0.0, left = wanted;
        for (std::size_t number = counts.size(); number-- > 0 && left > 0.0;) {
            const double taken = std::min(left, static_cast<double>(counts[number]));
            sum += taken * static_cast<double>(number);
            left -= taken;
        }
        return sum / wanted;
    }
};

}  // namespace

std::array<double, 3> FrameStatistics::mean() const {
    std::array<double, 3> sum{};
    for (const auto& zone : zones)
        for (std::size_t c = 0; c < 3; ++c) sum[c] += zone[c] / static_cast<double>(zones.size());
    return sum;
}

FrameStatistics measure(const SensorSpec& spec, ImageSize size, std::span<const std::uint16_t> numbers) {
    CHECK(numbers.size() == static_cast<std::size_t>(size.pixels() * spec.planes()));
    using Zones = std::array<std::array<Sum, 3>, FrameStatistics::columns * FrameStatistics::rows>;
    Zones sums{};
    Histogram histogram{std::vector<std::uint32_t>(static_cast<std::size_t>(spec.max_number()) + 1)};
    const int step = 2 * step_of(size);
    std::vector<int> zone_of_column;
    for (int x = 0; x < size.width; ++x) zone_of_column.push_back(x * FrameStatistics::columns / size.width);
    for (int plane = 0; plane < spec.planes(); ++plane) {
        for (int y = 0; y < size.height; y += (y & 1) != 0 ? step - 1 : 1) {
            const std::uint16_t* const row = numbers.data() + (std::ptrdiff_t{plane} * size.height + y) * size.width;
            auto* const zones =
                &sums[static_cast<std::size_t>(y * FrameStatistics::rows / size.height * FrameStatistics::columns)];
            for (int first = 0; first < std::min(2, size.width); ++first) {
                const int color = spec.filter == ColorFilter::mono  ? green
                                  : spec.filter == ColorFilter::rgb ? plane
                                                                    : color_at(spec.filter, first, y);
                for (int x = first; x < size.width; x += step) {
                    Sum& sum = zones[zone_of_column[static_cast<std::size_t>(x)]][static_cast<std::size_t>(color)];
                    sum.numbers += row[x];
                    ++sum.count;
                    if (color == green) ++histogram.counts[row[x]];
                }
            }
        }
    }
    for (const std::uint32_t count : histogram.counts) histogram.total += count;
    const double range = spec.max_number() - spec.black();
    const auto light_of = [&](double number) { return std::max((number - spec.black()) / range, 0.0); };
    FrameStatistics made;
    for (std::size_t z = 0; z < made.zones.size(); ++z) {
        for (std::size_t c = 0; c < 3; ++c) {
            const Sum& sum = sums[z][spec.filter == ColorFilter::mono ? green : c];
            if (sum.count > 0)
                made.zones[z][c] = light_of(static_cast<double>(sum.numbers) / static_cast<double>(sum.count));
        }
    }
    if (histogram.total > 0) made.highlights = light_of(histogram.mean_of_brightest(0.02));
    return made;
}

}  // namespace camrig::sensor

#include "core/render/moments.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/portable_math.h"

namespace camrig::render {

Moments::Moments(const sensor::RowTimes& times, double moved_px) : times_(times) {
    const TimeNs whole_ns = times.end_ns() - times.begin_ns;
    if (whole_ns <= 0) return;
    double most = most_of_picture;
    if (times.exposure_ns > 0)
        most = std::min(most, most_of_row * static_cast<double>(whole_ns) / static_cast<double>(times.exposure_ns));
    most = std::min(most, static_cast<double>(whole_ns));
    count_ = static_cast<int>(std::clamp(std::ceil(moved_px), 1.0, std::max(1.0, most)));
}

TimeNs Moments::edge_ns(int cell) const {
    return times_.begin_ns + (times_.end_ns() - times_.begin_ns) * cell / count_;
}

TimeNs Moments::time(int cell) const {
    return edge_ns(cell) + (edge_ns(cell + 1) - edge_ns(cell)) / 2;
}

int Moments::cells_of_row() const {
    const TimeNs whole_ns = times_.end_ns() - times_.begin_ns;
    if (whole_ns <= 0) return 1;
    return static_cast<int>(std::max<TimeNs>(1, count_ * times_.exposure_ns / whole_ns));
}

std::pair<TimeNs, TimeNs> Moments::shared(int cell, int row) const {
    const TimeNs begin_ns = times_.begin_ns + row * times_.row_ns;
    return {std::max(begin_ns, edge_ns(cell)), std::min(begin_ns + times_.exposure_ns, edge_ns(cell + 1))};
}

float Moments::weight(int cell, int row) const {
    if (count_ == 1) return 1.0f;
    if (times_.exposure_ns == 0) {
        const TimeNs at_ns = times_.begin_ns + row * times_.row_ns;
        return at_ns >= edge_ns(cell) && (at_ns < edge_ns(cell + 1) || cell + 1 == count_) ? 1.0f : 0.0f;
    }
    const auto [begin_ns, end_ns] = shared(cell, row);
    return static_cast<float>(static_cast<double>(std::max(TimeNs{0}, end_ns - begin_ns)) /
                              static_cast<double>(times_.exposure_ns));
}

std::pair<int, int> Moments::rows(int cell) const {
    if (times_.row_ns == 0 || count_ == 1) return {0, times_.rows};
    int first = 0, end = times_.rows;
    while (first < end && weight(cell, first) == 0.0f) ++first;
    while (end > first && weight(cell, end - 1) == 0.0f) --end;
    return {first, end};
}

double mean_sine(double hz, TimeNs begin_ns, TimeNs end_ns) {
    const double turn = 2.0 * std::numbers::pi * hz * 1e-9;
    const auto phase = [&](TimeNs at_ns) {
        const double turns = hz * 1e-9 * static_cast<double>(at_ns);
        return 2.0 * std::numbers::pi * (turns - std::floor(turns));
    };
    const double length = turn * static_cast<double>(end_ns - begin_ns);
    if (length <= 1e-9) return portable::sin(phase(begin_ns));
    // (cos a - cos b) / (b - a) = sin((a + b) / 2) sinc((b - a) / 2)
    return portable::sin(phase(begin_ns) + 0.5 * length) * portable::sin(0.5 * length) / (0.5 * length);
}

}  // namespace camrig::render

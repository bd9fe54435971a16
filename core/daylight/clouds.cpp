#include "core/daylight/clouds.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numbers>

#include "core/base/portable_math.h"
#include "core/daylight/cloud_noise.h"

// Rays of a column of the sky all go over the same line on the ground. It is walked once, outwards, in steps that
// become longer with the distance: each step has a height of cloud over it, and hides what the rays' ways through it
// are worth. That costs one look at the noise for a step, where a march along each ray would take one for each of its
// own steps.
namespace camrig::daylight {
namespace {

constexpr int all_columns = Clouds::columns, all_rows = Clouds::rows;
constexpr double earth_m = 6371e3;
constexpr double farthest_m = 45e3, shortest_step_m = 20.0, step_share = 0.012;
/// Tops are up to so high over the base; as clouds close they become flatter.
constexpr float highest_m = 500.0f;
/// How far the noise rises from a cloud's edge to its highest top.
constexpr float rise = 0.3f;
/// Of a way so long, 1/e of the light behind is left.
constexpr float way_m = 45.0f;
/// One in so many columns tells how much is hidden.
constexpr int told_columns = 32;

/// The lines over the ground, and what is in each step of them.
struct Lines {
    CloudNoise noise;
    std::vector<float> ends;     ///< of steps, from 0 on
    std::vector<float> drops;    ///< by so much the ground, and all over it, is lower there
    std::vector<int> first_row;  ///< of a step: the lowest whose ray leaves it over the clouds' base
    std::vector<float> wants;    ///< noise: of each column's steps
    std::array<float, all_rows> tangent{}, per_sine{}, weight{};  ///< of rows; weight: solid angle

    std::size_t steps() const { return ends.size() - 1; }
    float height(int row, std::size_t end) const {
        return tangent[static_cast<std::size_t>(row)] * ends[end] + drops[end];
    }
    std::span<const float> of(int column) const {
        const int wrapped = (column + all_columns) % all_columns;
        return std::span(wants).subspan(static_cast<std::size_t>(wrapped) * steps(), steps());
    }
};

Lines make_lines() {
    Lines lines;
    for (int row = 0; row < all_rows; ++row) {
        const double up = Clouds::elevation_of(row);
        const auto at = static_cast<std::size_t>(row);
        lines.tangent[at] = static_cast<float>(portable::tan(up));
        lines.per_sine[at] = static_cast<float>(1.0 / portable::sin(up));
        // Elevation is a square: its step grows with its root.
        lines.weight[at] = static_cast<float>(portable::cos(up) * (row + 0.5) / all_rows);
    }
    for (double end = 0.0; end < farthest_m; end += std::max(shortest_step_m, step_share * end)) {
        lines.ends.push_back(static_cast<float>(end));
        lines.drops.push_back(static_cast<float>(end * end / (2.0 * earth_m) - cloud_base_m));
    }
    for (std::size_t step = 0; step < lines.steps(); ++step) {
        int row = 0;
        while (row < all_rows && lines.height(row, step + 1) <= 0.0f) ++row;
        lines.first_row.push_back(row);
    }
    lines.wants.reserve(static_cast<std::size_t>(all_columns) * lines.steps());
    for (int column = 0; column < all_columns; ++column) {
        const auto x = static_cast<float>(portable::cos(Clouds::pan_of(column)));
        const auto y = static_cast<float>(portable::sin(Clouds::pan_of(column)));
        for (std::size_t step = 0; step < lines.steps(); ++step) {
            const float along = 0.5f * (lines.ends[step] + lines.ends[step + 1]);
            lines.wants.push_back(lines.noise.detailed_at(along * x, along * y));
        }
    }
    return lines;
}

/// Made once in a process, when clouds are first asked for.
const Lines& lines() {
    static const Lines made = make_lines();
    return made;
}

/// Where there are clouds, and how high.
struct Tops {
    float edge;     ///< there are clouds where noise is over it
    float highest;  ///< m

    float of(float want) const {
        const float part = std::clamp((want - edge) * (1.0f / rise), 0.0f, 1.0f);
        return highest * part * (2.0f - part);
    }
};

/// What of the light from behind is left to each ray of a column.
using Left = std::array<float, all_rows>;

/// Calls meet(step, row, seen, middle) from near to far: what of the ray's light comes from the step, and the height
/// over the base in the middle of the ray's way through it. Returns what is left.
template <typename Meet>
Left walk(const Lines& lines, std::span<const float> tops, Meet meet) {
    /// What is behind this is not looked for.
    constexpr float least_left = 1.0f / 256.0f;
    Left left;
    left.fill(1.0f);
    for (std::size_t step = 0; step < tops.size(); ++step) {
        const float top = tops[step];
        if (top <= 0.0f) continue;
        for (int row = lines.first_row[step]; row < all_rows; ++row) {
            const float enters = std::max(lines.height(row, step), 0.0f);
            if (enters >= top) break;
            float& behind = left[static_cast<std::size_t>(row)];
            if (behind < least_left) continue;
            const float leaves = std::min(lines.height(row, step + 1), top);
            const float way = (leaves - enters) * lines.per_sine[static_cast<std::size_t>(row)] * (1.0f / way_m);
            // Near exp(-way).
            const float after = behind / (1.0f + way + 0.5f * way * way);
            meet(step, row, behind - after, 0.5f * (enters + leaves));
            behind = after;
        }
    }
    return left;
}

double hidden_share(const Lines& lines, const Tops& tops) {
    double hidden = 0.0, whole = 0.0;
    std::vector<float> line(lines.steps());
    for (int column = 0; column < all_columns; column += told_columns) {
        std::ranges::transform(lines.of(column), line.begin(), [&](float want) { return tops.of(want); });
        const Left left = walk(lines, line, [](std::size_t, int, float, float) {});
        for (auto row = static_cast<std::size_t>(Clouds::lowest_row()); row < all_rows; ++row) {
            hidden += double{lines.weight[row]} * double{1.0f - left[row]};
            whole += double{lines.weight[row]};
        }
    }
    return hidden / whole;
}

Tops tops_for(const Lines& lines, double share) {
    Tops tops{.edge = 0.0f, .highest = highest_m * static_cast<float>(1.0 - 0.4 * share)};
    // Noise is within 0 and 1, and its details within 0.1 of that.
    float low = -0.1f - rise, high = 1.1f;
    for (int i = 0; i < 11; ++i) {
        tops.edge = 0.5f * (low + high);
        (hidden_share(lines, tops) > share ? low : high) = tops.edge;
    }
    return tops;
}

/// What a ray has met, each part by what of it is seen.
struct Met {
    float away = 0.0f, across = 0.0f;  ///< normal: away from who looks, and towards the next column
    float height = 0.0f, depth = 0.0f, distance = 0.0f;
};

std::uint8_t byte_of(float part) {
    return static_cast<std::uint8_t>(std::clamp(part, 0.0f, 1.0f) * 255.0f + 0.5f);
}

/// A unit vector on the ground.
struct Pan {
    float x, y;
};

CloudSight sight_of(const Met& met, float left, const CloudNoise& noise, const Tops& tops, const Pan& pan) {
    const float opacity = 1.0f - left;
    if (opacity < 1.0f / 255.0f) return {};
    const float inverse = 1.0f / opacity;
    const float over_base = met.height * inverse, distance = met.distance * inverse;
    // Lumps that vary with the height, too, which the field of heights knows nothing of; far away they would only be
    // rough.
    const float fade = std::clamp(1.5f - distance * (1.0f / 15e3f), 0.0f, 1.0f);
    const float lumps = fade * (noise.at(5.37f * (distance * pan.x + 1.3f * over_base) + 3000.0f,
                                         5.37f * (distance * pan.y - 1.1f * over_base)) -
                                0.5f);
    const float height = std::clamp(over_base / tops.highest + 0.25f * lumps, 0.0f, 1.0f);
    // The base looks down, and what is over it more and more up.
    const float away = met.away * inverse, across = met.across * inverse;
    const std::array<float, 3> outward{away * pan.x + across * pan.y, away * pan.y - across * pan.x,
                                       -0.5f + 3.0f * height + 1.5f * lumps};
    const float length = std::sqrt(outward[0] * outward[0] + outward[1] * outward[1] + outward[2] * outward[2] + 0.05f);
    CloudSight sight{.opacity = byte_of(opacity),
                     .outward = {},
                     .height = byte_of(height),
                     .depth = byte_of(met.depth * inverse / tops.highest)};
    for (std::size_t i = 0; i < 3; ++i) sight.outward[i] = static_cast<std::int8_t>(127.0f * outward[i] / length);
    return sight;
}

}  // namespace

Clouds::Clouds(double share) : sights_(static_cast<std::size_t>(columns) * rows) {
    const Lines& all = lines();
    const Tops tops = tops_for(all, share);
    const std::size_t steps = all.steps();
    // The heights over three lines beside each other.
    std::array<std::vector<float>, 3> heights;
    const auto fill = [&](int column) {
        auto& line = heights[static_cast<std::size_t>((column + 3) % 3)];
        line.resize(steps);
        std::ranges::transform(all.of(column), line.begin(), [&](float want) { return tops.of(want); });
    };
    fill(-1);
    fill(0);
    for (int column = 0; column < columns; ++column) {
        fill(column + 1);
        const auto& before = heights[static_cast<std::size_t>((column + 2) % 3)];
        const auto& here = heights[static_cast<std::size_t>(column % 3)];
        const auto& after = heights[static_cast<std::size_t>((column + 1) % 3)];
        std::array<Met, rows> met{};
        const Left left = walk(all, here, [&](std::size_t step, int row, float seen, float middle) {
            Met& of = met[static_cast<std::size_t>(row)];
            const float along = 0.5f * (all.ends[step] + all.ends[step + 1]);
            const std::size_t nearer = step > 0 ? step - 1 : step, farther = std::min(step + 1, steps - 1);
            constexpr auto column_rad = static_cast<float>(2.0 * std::numbers::pi / columns);
            of.away -= seen * (here[farther] - here[nearer]) / (2.0f * (all.ends[step + 1] - all.ends[step]));
            of.across -= seen * (after[step] - before[step]) / (2.0f * column_rad * along);
            of.height += seen * middle;
            of.depth += seen * (here[step] - middle);
            of.distance += seen * along;
        });
        const Pan pan{static_cast<float>(portable::cos(pan_of(column))),
                      static_cast<float>(portable::sin(pan_of(column)))};
        for (int row = 0; row < rows; ++row)
            sights_[static_cast<std::size_t>(row * columns + column)] =
                sight_of(met[static_cast<std::size_t>(row)], left[static_cast<std::size_t>(row)], all.noise, tops, pan);
    }
}

std::span<const CloudSight> Clouds::row(int number) const {
    return std::span(sights_).subspan(static_cast<std::size_t>(number) * columns, columns);
}
int Clouds::lowest_row() {
    return lines().first_row.back();
}
double Clouds::elevation_of(int row) {
    const double part = (row + 0.5) / rows;
    return 0.5 * std::numbers::pi * part * part;
}
double Clouds::pan_of(int column) {
    return -2.0 * std::numbers::pi * (column + 0.5) / columns;
}

std::shared_ptr<const Clouds> clouds_of(double share) {
    struct Kept {
        std::mutex mutex;
        double share = 0.0;
        std::shared_ptr<const Clouds> clouds;
    };
    static Kept kept;
    const std::scoped_lock lock(kept.mutex);
    if (!kept.clouds || kept.share != share) {
        kept.clouds = std::make_shared<const Clouds>(share);
        kept.share = share;
    }
    return kept.clouds;
}

}  // namespace camrig::daylight

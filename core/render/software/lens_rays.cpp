#include "core/render/software/lens_rays.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <vector>

#include "core/render/software/lanes.h"
#include "core/render/software/rows.h"

namespace camrig::render::software {
namespace {

int cells_of(int length, int side) {
    return (length + side - 1) / side;
}

/// Points of the ideal plane.
struct IdealPoints {
    Doubles x, y;
};

/// LensMap::undistort() from a guess that is almost right; of those that are not found, `at` lies anywhere.
CAMRIG_LANES IntLanes undistort_near(const camera::LensMap::Formula& f, double valid_radius,
                                     const IdealPoints& distorted, IdealPoints& at) {
    constexpr int steps = 2;
    constexpr double tolerance = 1e-9;
    for (int step = 0;; ++step) {
        const Doubles &x = at.x, &y = at.y;
        const Doubles xx = x * x, yy = y * y, xy = x * y, s = xx + yy;
        Doubles n = Doubles{} + f.numerator[4], dn{}, d = Doubles{} + f.denominator[3], dd{};
        for (std::size_t i = 4; i-- > 0;) {
            dn = dn * s + n;
            n = n * s + f.numerator[i];
        }
        for (std::size_t i = 3; i-- > 0;) {
            dd = dd * s + d;
            d = d * s + f.denominator[i];
        }
        const Doubles inverse = 1.0 / d, scale = n * inverse;
        const Doubles miss_x = distorted.x - (x * scale + xy * (2.0 * f.p1) + (xx * 3.0 + yy) * f.p2);
        const Doubles miss_y = distorted.y - (y * scale + (xx + yy * 3.0) * f.p1 + xy * (2.0 * f.p2));
        if (step == steps) {
            return (magnitude(miss_x) <= Doubles{} + tolerance) & (magnitude(miss_y) <= Doubles{} + tolerance) &
                   (s < Doubles{} + valid_radius * valid_radius);
        }
        const Doubles along = (dn - scale * dd) * inverse * 2.0;
        const Doubles a = scale + along * xx + y * (2.0 * f.p1) + x * (6.0 * f.p2);
        const Doubles b = along * xy + x * (2.0 * f.p1) + y * (2.0 * f.p2);
        const Doubles c = scale + along * yy + y * (6.0 * f.p1) + x * (2.0 * f.p2);
        const Doubles divisor = 1.0 / (a * c - b * b);
        at = {x + (c * miss_x - b * miss_y) * divisor, y + (a * miss_y - b * miss_x) * divisor};
    }
}

/// sin(t) / t and cos(t) up to t = pi, of s = t^2: their series, to 1e-13.
constexpr int series_terms = 13;
template <int first>
CAMRIG_LANES Doubles series(const Doubles& s) {
    constexpr auto terms = [] {
        std::array<double, series_terms> made{};
        double factorial = 1.0;
        for (int i = 1; i <= first; ++i) factorial *= i;
        for (int k = 0; k < series_terms; ++k) {
            made[static_cast<std::size_t>(k)] = (k % 2 == 0 ? 1.0 : -1.0) / factorial;
            factorial *= (2 * k + first + 1) * (2 * k + first + 2);
        }
        return made;
    }();
    Doubles sum = Doubles{} + terms.back();
    for (std::size_t k = terms.size() - 1; k-- > 0;) sum = sum * s + terms[k];
    return sum;
}

CAMRIG_LANES Doubles doubles_at(const double* from) {
    Doubles made;
    std::memcpy(&made, from, sizeof made);
    return made;
}

/// The ideal points of a row of pixels, and which of them the lens shows at all; with those of the rows above.
class IdealRows {
public:
    IdealRows(const camera::CameraModel& model, int width)
        : model_(model), k_(model.intrinsics()), formula_(model.lens().formula()), width_(width) {
        for (auto& row : rows_) row = {std::vector<double>(size()), std::vector<double>(size()), {}};
        for (auto& row : rows_) row.sees.assign(size(), 0);
    }

    /// False if none sees anything. Rows are asked for from the top.
    template <typename Isa>
    CAMRIG_LANES bool next(int y) {
        std::rotate(rows_.begin(), rows_.end() - 1, rows_.end());
        Row& row = rows_[0];
        const Row &above = rows_[1], &second = rows_[2];
        bool sees = false;
        for (int x = 0; x < width_; x += lane_count) {
            const auto from = static_cast<std::size_t>(x);
            unsigned found = 0;
            if (y >= 2 && above.is_seen(from) && second.is_seen(from)) {
                const auto guess = [&](const std::vector<double>& first, const std::vector<double>& second_one)
                                       __attribute__((always_inline)) {
                                           const Doubles near = doubles_at(first.data() + from);
                                           return near + (near - doubles_at(second_one.data() + from));
                                       };
                IdealPoints at{guess(above.x, second.x), guess(above.y, second.y)};
                const IdealPoints distorted{(widened(int_lane_numbers() + x) + -k_.cx) * (1.0 / k_.fx),
                                            Doubles{} + (y - k_.cy) / k_.fy};
                found = Isa::bits(undistort_near(formula_, model_.lens().valid_radius(), distorted, at));
                std::memcpy(row.x.data() + from, &at.x, sizeof at.x);
                std::memcpy(row.y.data() + from, &at.y, sizeof at.y);
            }
            for (std::size_t k = 0; k < lane_count; ++k) {
                row.sees[from + k] = 1;
                if ((found >> k & 1) == 0) look(row, from + k, y);
                sees |= row.sees[from + k] != 0;
            }
        }
        return sees;
    }
    bool sees(int x) const { return rows_[0].sees[static_cast<std::size_t>(x)] != 0; }
    CAMRIG_LANES IdealPoints at(int x) const {
        return {doubles_at(rows_[0].x.data() + x), doubles_at(rows_[0].y.data() + x)};
    }

private:
    struct Row {
        std::vector<double> x, y;
        std::vector<std::uint8_t> sees;

        bool is_seen(std::size_t from) const {
            return std::all_of(sees.begin() + static_cast<std::ptrdiff_t>(from),
                               sees.begin() + static_cast<std::ptrdiff_t>(from) + lane_count,
                               [](std::uint8_t seen) { return seen != 0; });
        }
    };
    std::size_t size() const { return static_cast<std::size_t>(cells_of(width_, lane_count) * lane_count); }
    void look(Row& row, std::size_t x, int y) const {
        const auto ideal = model_.lens().undistort({(static_cast<double>(x) - k_.cx) / k_.fx, (y - k_.cy) / k_.fy});
        row.sees[x] = ideal.has_value();
        row.x[x] = ideal ? ideal->x : 0.0;
        row.y[x] = ideal ? ideal->y : 0.0;
    }

    const camera::CameraModel& model_;
    camera::Intrinsics k_;
    camera::LensMap::Formula formula_;
    int width_;
    std::array<Row, 3> rows_;
};

template <typename Isa>
CAMRIG_LANES bool fill_row(IdealRows& rows, bool is_angular, bool is_wide, int width, int y, float* to_x, float* to_y,
                           float* to_z) {
    if (!rows.next<Isa>(y)) return false;
    for (int x = 0; x < width; x += lane_count) {
        IdealPoints at = rows.at(x);
        if (is_angular) {
            const Doubles s = at.x * at.x + at.y * at.y, ahead = series<0>(s);
            Doubles across = series<1>(s);
            if (is_wide) {
                store_lanes(to_z + x, narrowed(ahead));
            } else {
                across = across * (1.0 / ahead);
            }
            at = {at.x * across, at.y * across};
        }
        store_lanes(to_x + x, narrowed(at.x));
        store_lanes(to_y + x, narrowed(at.y));
    }
    // What sees nothing looks the way of the one before it, or of the first that sees.
    int first = 0;
    while (!rows.sees(first)) ++first;
    const auto copy = [&](int from, int to) {
        to_x[to] = to_x[from];
        to_y[to] = to_y[from];
        if (is_wide) to_z[to] = to_z[from];
    };
    for (int x = 0; x < width; ++x)
        if (!rows.sees(x)) copy(x < first ? first : x - 1, x);
    return true;
}
CAMRIG_WIDE bool fill_row_wide(IdealRows& rows, bool is_angular, bool is_wide, int width, int y, float* to_x,
                               float* to_y, float* to_z) {
    return fill_row<Avx2Isa>(rows, is_angular, is_wide, width, y, to_x, to_y, to_z);
}

}  // namespace

LensRays::Grid::Grid(ImageSize cells)
    : low_x(cells), low_y(cells), low_z(cells), high_x(cells), high_y(cells), high_z(cells) {
    constexpr float none = std::numeric_limits<float>::infinity();
    const PixelRect all{0, 0, cells.width, cells.height};
    for (const Plane<float>* plane : {&low_x, &low_y, &low_z}) fill(plane->rows(), all, none);
    for (const Plane<float>* plane : {&high_x, &high_y, &high_z}) fill(plane->rows(), all, -none);
}

void LensRays::Grid::add(int column, int row, const glm::vec3& ray) {
    const auto widen = [&](const Plane<float>& lowest, const Plane<float>& highest, glm::length_t i) {
        float &from = lowest.rows()(row)[column], &to = highest.rows()(row)[column];
        from = std::min(from, ray[i]);
        to = std::max(to, ray[i]);
    };
    widen(low_x, high_x, 0);
    widen(low_y, high_y, 1);
    widen(low_z, high_z, 2);
}

LensRays::LensRays(const scene::LensView& lens, bool wide) : size_(lens.model().size()), is_wide_(lens.is_wide()) {
    // A group of lanes more and a row more.
    const ImageSize more{(cells_of(size_.width, lane_count) + 1) * lane_count, size_.height + 1};
    x_ = Plane<float>(more);
    y_ = Plane<float>(more);
    z_ = Plane<float>(is_wide_ ? more : ImageSize{more.width, 1});
    if (!is_wide_) fill(z_.rows(), {0, 0, more.width, 1}, 1.0f);
    const bool is_angular = lens.model().lens().formula().is_angular;
    IdealRows rows(lens.model(), more.width);
    int first = more.height;  // that sees anything
    for (int y = 0; y < more.height; ++y) {
        float *const x = x_.rows()(y), *const down = y_.rows()(y), *const ahead = z_.rows()(is_wide_ ? y : 0);
        const bool sees = wide ? fill_row_wide(rows, is_angular, is_wide_, more.width, y, x, down, ahead)
                               : fill_row<PlainIsa>(rows, is_angular, is_wide_, more.width, y, x, down, ahead);
        if (sees) {
            first = std::min(first, y);
        } else if (first < y) {
            copy_row(y - 1, y);
        }
    }
    for (int y = 0; y < first && first < more.height; ++y) copy_row(first, y);
    find_bounds();
}

void LensRays::copy_row(int from, int to) {
    const auto copied = [&](const Plane<float>& plane) {
        std::copy_n(plane.rows()(from), plane.rows().stride, plane.rows()(to));
    };
    copied(x_);
    copied(y_);
    if (is_wide_) copied(z_);
}

void LensRays::find_bounds() {
    // Rows of bounds are read in groups of lanes.
    const int blocks = cells_of(size_.width, block_side);
    tiles_ = Grid({blocks * lane_count, cells_of(size_.height, tile_side)});
    blocks_ = Grid({cells_of(blocks, lane_count) * lane_count, cells_of(size_.height, block_side)});
    const Coordinates of = rays();
    const auto ray_at = [&](int x, int y) { return glm::vec3(of.x(y)[x], of.y(y)[x], of.z(y)[x]); };
    for (int y = 0; y < size_.height; ++y) {
        for (int x = 0; x < size_.width; ++x) {
            const glm::vec3 ray = ray_at(x, y);
            tiles_.add(x / tile_side, y / tile_side, ray);
            blocks_.add(x / block_side, y / block_side, ray);
            const glm::vec3 steps = glm::abs(ray_at(x + 1, y) - ray) + glm::abs(ray_at(x, y + 1) - ray);
            pixel_reach_ = glm::max(pixel_reach_, steps * 0.5f);
        }
    }
}

}  // namespace camrig::render::software

#include "core/sensor/sensor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "core/base/portable_math.h"
#include "core/base/random.h"
#include "core/sensor/bayer.h"

namespace camrig::sensor {
namespace {

/// More than any well holds, and finite when multiplied by an exposure.
constexpr float most_light = 1e12f;

float clean(float light) {
    return light > 0.0f ? std::min(light, most_light) : 0.0f;
}

std::vector<Sensor::HotPixel> hot_pixels_of(const SensorSpec& spec, ImageSize size) {
    constexpr std::uint64_t place_stream = 0x686f7400, current_stream = 0x686f7401;  // "hot"
    std::vector<Sensor::HotPixel> hot;
    const auto sites = static_cast<std::uint64_t>(size.pixels() * spec.planes());
    const auto count =
        static_cast<std::uint64_t>(std::llround(spec.hot_pixels_ppm * 1e-6 * static_cast<double>(sites)));
    for (std::uint64_t i = 0; i < count; ++i) {
        const auto at = static_cast<std::int64_t>((random_bits(spec.seed, place_stream, i) >> 32) * sites >> 32);
        const double u = random_unit(spec.seed, current_stream, i);
        const auto in_plane = at % size.pixels();
        hot.push_back({static_cast<int>(at / size.pixels()), static_cast<int>(in_plane / size.width),
                       static_cast<int>(in_plane % size.width), -portable::log(1.0 - u) * spec.hot_e_per_s});
    }
    std::ranges::sort(hot, {}, [](const Sensor::HotPixel& h) { return std::tuple(h.plane, h.y, h.x, h.e_per_s); });
    return hot;
}

double factor_of_db(double db) {
    return portable::exp(db * 0.11512925464970229);  // ln(10) / 20
}

}  // namespace

Result<Sensor> Sensor::create(const SensorSpec& spec, ImageSize size, const camera::Intrinsics& intrinsics) {
    if (auto valid = check_sensor(spec); !valid) return std::unexpected(valid.error());
    if (size.width < 1 || size.height < 1 || size.width > max_row || size.height > max_row)
        return error(ErrorKind::invalid_argument, "size: must be 1x1 to 8192x8192");
    return Sensor(spec, size, intrinsics);
}

Sensor::Sensor(const SensorSpec& spec, ImageSize size, const camera::Intrinsics& intrinsics)
    : spec_(spec), size_(size), intrinsics_(intrinsics), hot_(hot_pixels_of(spec, size)) {}

double Sensor::numbers_per_e(double gain_db) const {
    return spec_.numbers_per_e() * factor_of_db(gain_db);
}

RowExposure Sensor::row_of(const Shot& shot, int plane, int y) const {
    const double root = std::sqrt(spec_.vignetting);
    const double v = root * (y - intrinsics_.cy) / intrinsics_.fy;
    const auto number = [](double value) { return static_cast<float>(value); };
    RowExposure row;
    row.padded_width = SiteLight::stride_for(size_.width);
    row.electrons = number(std::min(spec_.electrons_per_s() * shot.exposure_s, 1e20));
    row.u0 = number(-root * intrinsics_.cx / intrinsics_.fx);
    row.u_step = number(root / intrinsics_.fx);
    row.v2 = number(v * v);
    row.prnu = number(spec_.prnu);
    row.dark_e = number(spec_.dark_e_per_s * shot.exposure_s);
    row.limit_e = number(spec_.full_well_e + 10.0 * std::sqrt(spec_.full_well_e) + 100.0);
    row.full_well_e = number(spec_.full_well_e);
    row.read_noise_e = number(spec_.read_noise_e);
    row.dsnu_e = number(spec_.dsnu_e);
    row.row_e = number(spec_.row_noise_e) * RowNoise::of_row(spec_.seed, plane, shot.frame, y);
    row.numbers_per_e = number(numbers_per_e(shot.gain_db));
    row.black = number(spec_.black());
    row.max_number = number(spec_.max_number());
    row.noise = RowNoise::of(spec_.seed, RowNoise::Purpose::picture, plane, shot.frame, y);
    row.fixed = RowNoise::of(spec_.seed, RowNoise::Purpose::fixed_pattern, plane, 0, y);
    return row;
}

void Sensor::gather_row(const Light& light, int plane, int y, int x0, int x1, float* to) const {
    const std::ptrdiff_t at = y * light.stride;
    if (spec_.filter == ColorFilter::rgb) {
        const float* const from = light.planes[plane] + at;
        for (int x = x0; x < x1; ++x) to[x] = clean(from[x]);
    } else if (spec_.filter == ColorFilter::mono) {
        const float *const r = light.planes[0] + at, *const g = light.planes[1] + at, *const b = light.planes[2] + at;
        // Luminance of Rec. 709 primaries.
        for (int x = x0; x < x1; ++x) to[x] = clean(0.2126f * r[x] + 0.7152f * g[x] + 0.0722f * b[x]);
    } else {
        const auto responses = spec_.responses();
        for (int first = x0; first < std::min(x0 + 2, x1); ++first) {
            const auto color = static_cast<std::size_t>(color_at(spec_.filter, first, y));
            const float* const from = light.planes[color] + at;
            const auto response = static_cast<float>(responses[color]);
            for (int x = first; x < x1; x += 2) to[x] = clean(from[x]) * response;
        }
    }
}

void Sensor::gather(const Light& light, int first_row, int end_row, SiteLight& to) const {
    CHECK(to.is_for(spec_, size_));
    for (int plane = 0; plane < spec_.planes(); ++plane)
        for (int y = first_row; y < end_row; ++y) gather_row(light, plane, y, 0, size_.width, to.row(plane, y));
}

/// Where a row's light is, `row` or that which is kept.
const float* Sensor::row_of_light(const StandingLight& standing, const Light& light, int plane, int y,
                                  float* row) const {
    if (standing.sites == nullptr) {
        std::fill(row + size_.width, row + SiteLight::stride_for(size_.width), 0.0f);
        gather_row(light, plane, y, 0, size_.width, row);
        return row;
    }
    const float* lit = standing.sites->row(plane, y);
    standing.but_in->each_run(y, [&](int x0, int x1) {
        if (lit != row) std::copy_n(lit, SiteLight::stride_for(size_.width), row);
        lit = row;
        gather_row(light, plane, y, x0, x1, row);
    });
    return lit;
}

void Sensor::expose(const Light& light, const Shot& shot, int first_row, int end_row, std::span<std::uint16_t> numbers,
                    bool wide) const {
    expose(StandingLight{}, light, shot, first_row, end_row, numbers, wide);
}

void Sensor::expose(const StandingLight& standing, const Light& light, const Shot& shot, int first_row, int end_row,
                    std::span<std::uint16_t> numbers, bool wide) const {
    CHECK(numbers.size() == count() && 0 <= first_row && first_row <= end_row && end_row <= size_.height);
    CHECK(standing.sites == nullptr || standing.sites->is_for(spec_, size_));
    thread_local std::array<float, max_row> lit, mean_e;
    thread_local std::array<std::uint16_t, max_row> made;
    for (int plane = 0; plane < spec_.planes(); ++plane) {
        for (int y = first_row; y < end_row; ++y) {
            const RowExposure row = row_of(shot, plane, y);
            expect_electrons(row, row_of_light(standing, light, plane, y, lit.data()), mean_e.data(), wide);
            const auto [hot, end] = std::ranges::equal_range(hot_, std::pair(plane, y), {},
                                                             [](const HotPixel& h) { return std::pair(h.plane, h.y); });
            for (const HotPixel& pixel : std::ranges::subrange(hot, end)) {
                float& mean = mean_e[static_cast<std::size_t>(pixel.x)];
                mean = std::min(mean + static_cast<float>(pixel.e_per_s * shot.exposure_s), row.limit_e);
            }
            std::uint16_t* const to = numbers.data() + (std::ptrdiff_t{plane} * size_.height + y) * size_.width;
            const bool is_whole = row.padded_width == size_.width;
            count_electrons(row, mean_e.data(), is_whole ? to : made.data(), wide);
            if (!is_whole) std::copy_n(made.data(), size_.width, to);
        }
    }
}

}  // namespace camrig::sensor

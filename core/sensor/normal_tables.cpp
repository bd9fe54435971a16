#include "core/sensor/normal_tables.h"

#include <cmath>
#include <utility>
#include <vector>

#include "core/base/portable_math.h"
#include "core/base/random.h"

namespace camrig::sensor {
namespace {

/// Orders whose correlation between entries at distances 1 to 4 is below 0.001 (NormalTables tests hold them to it).
constexpr std::uint64_t order_seeds[2] = {1806, 5210};

/// The normal value below which a share p of all are, 0 < p < 1, to 1.2e-9 of it (P. J. Acklam's rational
/// approximations, 2003).
double normal_quantile(double p) {
    constexpr double a[] = {-3.969683028665376e+01, 2.209460984245205e+02,  -2.759285104469687e+02,
                            1.383577518672690e+02,  -3.066479806614716e+01, 2.506628277459239e+00};
    constexpr double b[] = {-5.447609879822406e+01, 1.615858368580409e+02, -1.556989798598866e+02,
                            6.680131188771972e+01, -1.328068155288572e+01};
    constexpr double c[] = {-7.784894002430293e-03, -3.223964580411365e-01, -2.400758277161838e+00,
                            -2.549732539343734e+00, 4.374664141464968e+00,  2.938163982698783e+00};
    constexpr double d[] = {7.784695709041462e-03, 3.224671290700398e-01, 2.445134137142996e+00, 3.754408661907416e+00};
    if (p > 0.5) return -normal_quantile(1.0 - p);
    if (p < 0.02425) {
        const double q = std::sqrt(-2.0 * portable::log(p));
        return (((((c[0] * q + c[1]) * q + c[2]) * q + c[3]) * q + c[4]) * q + c[5]) /
               ((((d[0] * q + d[1]) * q + d[2]) * q + d[3]) * q + 1.0);
    }
    const double q = p - 0.5, r = q * q;
    return (((((a[0] * r + a[1]) * r + a[2]) * r + a[3]) * r + a[4]) * r + a[5]) * q /
           (((((b[0] * r + b[1]) * r + b[2]) * r + b[3]) * r + b[4]) * r + 1.0);
}

void shuffle(std::vector<float>& values, std::uint64_t seed) {
    constexpr std::uint64_t stream = 0x73656e736f72;  // "sensor"
    for (std::size_t i = values.size() - 1; i > 0; --i) {
        const std::uint64_t at = (random_bits(seed, stream, i) >> 32) * (i + 1) >> 32;
        std::swap(values[i], values[static_cast<std::size_t>(at)]);
    }
}

std::unique_ptr<const NormalTables> make_tables() {
    constexpr int n = NormalTables::size;
    std::vector<double> exact;
    double squares = 0.0;
    for (int i = 0; i < n; ++i) {
        exact.push_back(normal_quantile((i + 0.5) / n));
        squares += exact.back() * exact.back();
    }
    const double scale = std::sqrt(n / squares / 2.0);
    auto tables = std::make_unique<NormalTables>();
    for (int t = 0; t < 2; ++t) {
        std::vector<float> values;
        for (const double value : exact) values.push_back(static_cast<float>(value * scale));
        shuffle(values, order_seeds[t]);
        auto& table = t == 0 ? tables->a : tables->b;
        for (std::size_t i = 0; i < table.size(); ++i) table[i] = values[i % n];
    }
    return tables;
}

/// The stream of the random numbers of one purpose and plane.
std::uint64_t stream_of(int purpose, int plane, int row) {
    return std::uint64_t{0x53} << 56 | static_cast<std::uint64_t>(purpose) << 48 |
           static_cast<std::uint64_t>(plane) << 40 | static_cast<std::uint32_t>(row);
}

}  // namespace

const NormalTables& normal_tables() {
    static const std::unique_ptr<const NormalTables> tables = make_tables();
    return *tables;
}

RowNoise RowNoise::of(std::uint64_t seed, Purpose purpose, int plane, std::int64_t frame, int row) {
    const NormalTables& tables = normal_tables();
    const std::uint64_t bits =
        random_bits(seed, stream_of(static_cast<int>(purpose), plane, row), static_cast<std::uint64_t>(frame));
    return {tables.a.data() + (bits & 0xffff), tables.b.data() + (bits >> 16 & 0xffff),
            static_cast<std::uint32_t>(bits >> 32)};
}

float RowNoise::of_row(std::uint64_t seed, int plane, std::int64_t frame, int row) {
    constexpr int purpose = 2;
    const std::uint64_t bits = random_bits(seed, stream_of(purpose, plane, row), static_cast<std::uint64_t>(frame));
    const NormalTables& tables = normal_tables();
    return tables.a[bits & 0xffff] + tables.b[bits >> 16 & 0xffff];
}

}  // namespace camrig::sensor

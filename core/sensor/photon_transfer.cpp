#include "core/sensor/photon_transfer.h"

#include <algorithm>
#include <cmath>

namespace camrig::sensor {
namespace {

/// Of numbers that a converter rounded, beside the variance that they had before.
constexpr double rounding_variance = 1.0 / 12.0;
/// Places of a lit picture that may be at the end of the range: hot ones.
constexpr double most_saturated = 0.001;
/// Means of a pair that are further apart are no pair.
constexpr double most_apart = 0.02;
constexpr std::size_t least_pictures = 6, most_pictures = 256;

struct Point {
    double mean = 0.0, variance = 0.0;
};

/// Of every second place in a row and every second row: one colour of a mosaic.
Point point_of(const RawPicture& a, const RawPicture& b, int phase) {
    double sum = 0.0, difference = 0.0, squares = 0.0;
    std::int64_t count = 0;
    for (int y = phase / 2; y < a.size.height; y += 2) {
        for (int x = phase % 2; x < a.size.width; x += 2) {
            const auto i = static_cast<std::size_t>(std::int64_t{y} * a.size.width + x);
            const double one = a.numbers[i], other = b.numbers[i];
            sum += one + other;
            difference += one - other;
            squares += (one - other) * (one - other);
            ++count;
        }
    }
    const auto n = static_cast<double>(count);
    return {sum / (2.0 * n), (squares / n - (difference / n) * (difference / n)) / 2.0};
}

Point mean_point(const RawPicture& a, const RawPicture& b) {
    Point mean;
    for (int phase = 0; phase < 4; ++phase) {
        const Point one = point_of(a, b, phase);
        mean.mean += one.mean / 4.0;
        mean.variance += one.variance / 4.0;
    }
    return mean;
}

std::unexpected<Error> refused(const RawPicture& picture, const std::string& why) {
    return error(ErrorKind::invalid_argument, picture.name + ": " + why);
}

Result<void> check(std::span<const RawPicture> pictures, int bits) {
    if (bits < 8 || bits > 16) return error(ErrorKind::invalid_argument, "bits: must be 8 to 16");
    if (pictures.size() < least_pictures || pictures.size() > most_pictures || pictures.size() % 2 != 0)
        return error(
            ErrorKind::invalid_argument,
            std::to_string(pictures.size()) + " pictures: give two dark ones, then two of each of 2 to 127 lights");
    const int top = (1 << bits) - 1;
    const ImageSize size = pictures.front().size;
    for (const RawPicture& picture : pictures) {
        if (picture.size != size || size.width < 2 || size.height < 2)
            return refused(picture, "is of " + picture.size.to_string() + "; all must be of " + size.to_string() +
                                        ", 2x2 at least");
        const int largest = *std::ranges::max_element(picture.numbers);
        if (largest > top)
            return refused(picture, "has a number of " + std::to_string(largest) + ", more than " +
                                        std::to_string(bits) + " bits hold; give the right number with --bits");
    }
    for (const RawPicture& picture : pictures.subspan(2)) {
        const auto saturated = std::ranges::count(picture.numbers, top);
        if (static_cast<double>(saturated) > most_saturated * static_cast<double>(picture.numbers.size()))
            return refused(picture, "is saturated: " + std::to_string(saturated) + " places have " +
                                        std::to_string(top) + "; take it with less light or exposure");
    }
    return {};
}

}  // namespace

Result<PhotonTransfer> fit_photon_transfer(std::span<const RawPicture> pictures, int bits) {
    if (auto good = check(pictures, bits); !good) return std::unexpected(good.error());
    const Point dark = mean_point(pictures[0], pictures[1]);
    // Least squares through the dark point, each point by what it is worth: a variance is known to a share of itself.
    double products = 0.0, squares = 0.0, brightest = 0.0;
    for (std::size_t i = 2; i < pictures.size(); i += 2) {
        const RawPicture &a = pictures[i], &b = pictures[i + 1];
        const double first = mean_point(a, a).mean - dark.mean, second = mean_point(b, b).mean - dark.mean;
        if (std::abs(first - second) > most_apart * std::max(first, second) + 1.0)
            return refused(b, "is no pair with " + a.name + ": their means are " + std::to_string(first) + " and " +
                                  std::to_string(second) + " above black");
        for (int phase = 0; phase < 4; ++phase) {
            const Point lit = point_of(a, b, phase), black = point_of(pictures[0], pictures[1], phase);
            const double signal = lit.mean - black.mean, noise = lit.variance - black.variance;
            const double weight = 1.0 / (lit.variance * lit.variance + black.variance * black.variance + 1e-12);
            products += weight * signal * noise;
            squares += weight * signal * signal;
            brightest = std::max(brightest, noise);
        }
    }
    const double gain = products / squares;
    if (!(gain > 0.0) || brightest < dark.variance)
        return error(
            ErrorKind::invalid_argument,
            pictures.back().name + ": the lit pictures have hardly more noise than the dark ones; give more light");
    const double read_variance = dark.variance - rounding_variance;
    return PhotonTransfer{.numbers_per_e = gain,
                          .read_noise_e = std::sqrt(std::max(0.0, read_variance)) / gain,
                          .full_well_e = ((1 << bits) - 1 - dark.mean) / gain,
                          .black_level = dark.mean,
                          .pairs = static_cast<int>(pictures.size()) / 2 - 1};
}

}  // namespace camrig::sensor

#include "core/world/backdrop/depth_pieces.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

namespace camrig::world {
namespace {

constexpr std::size_t most_planes = 65536;
constexpr double least_error = 0.002;
constexpr int most_doublings = 4;

/// The sums of a least-squares plane over pixels of a rectangle, from its middle: there its parts do not mix.
struct Fit {
    double q = 0.0, xq = 0.0, yq = 0.0, x2 = 0.0, y2 = 0.0;
};

/// The plane through the rectangle's pixels, all of which are known, where it is near enough to each of them.
std::optional<DepthPiece> plane_of(const DepthImage& image, const PixelRect& rect, double error) {
    const auto value = [&](int x, int y) {
        return static_cast<double>(
            image.values[static_cast<std::size_t>(y) * static_cast<std::size_t>(image.size.width) +
                         static_cast<std::size_t>(x)]);
    };
    const double middle_x = 0.5 * (rect.x0 + rect.x1 - 1), middle_y = 0.5 * (rect.y0 + rect.y1 - 1);
    Fit sums;
    for (int y = rect.y0; y < rect.y1; ++y) {
        for (int x = rect.x0; x < rect.x1; ++x) {
            const double q = 1.0 / value(x, y), dx = x - middle_x, dy = y - middle_y;
            sums.q += q;
            sums.xq += dx * q;
            sums.yq += dy * q;
            sums.x2 += dx * dx;
            sums.y2 += dy * dy;
        }
    }
    DepthPiece piece{.rect = rect};
    piece.right = sums.x2 > 0.0 ? sums.xq / sums.x2 : 0.0;
    piece.down = sums.y2 > 0.0 ? sums.yq / sums.y2 : 0.0;
    piece.inverse = sums.q / static_cast<double>(rect.area()) - piece.right * (middle_x - rect.x0) -
                    piece.down * (middle_y - rect.y0);
    double least = 1e300, most = 0.0;
    for (int y = rect.y0; y < rect.y1; ++y) {
        for (int x = rect.x0; x < rect.x1; ++x) {
            const double wanted = value(x, y), q = piece.inverse_at(x, y);
            if (!(q > 0.0) || std::abs(1.0 / q - wanted) > std::max(0.5, error * wanted)) return std::nullopt;
            least = std::min(least, 1.0 / wanted);
            most = std::max(most, 1.0 / wanted);
        }
    }
    // Half a pixel further out are its corners, which are to be no spikes.
    for (const auto& [x, y] : {std::pair(rect.x0, rect.y0), {rect.x1, rect.y0}, {rect.x0, rect.y1}, {rect.x1, rect.y1}})
        if (const double q = piece.inverse_at(x - 0.5, y - 0.5); !(q > 0.5 * least) || q > 2.0 * most)
            return std::nullopt;
    return piece;
}

/// Cuts the rectangle into quarters until each shows a plane or nothing. False: too many.
bool cut(const DepthImage& image, const PixelRect& rect, double error, std::vector<DepthPiece>& to) {
    if (rect.width() <= 0 || rect.height() <= 0) return true;
    std::int64_t known = 0;
    for (int y = rect.y0; y < rect.y1; ++y) {
        const auto row = image.values.begin() + static_cast<std::ptrdiff_t>(y) * image.size.width;
        known += (rect.width()) - std::count(row + rect.x0, row + rect.x1, 0);
    }
    if (known == 0) return true;
    if (known == rect.area()) {
        if (const auto piece = plane_of(image, rect, error)) {
            if (to.size() == most_planes) return false;
            to.push_back(*piece);
            return true;
        }
    }
    const int x = (rect.x0 + rect.x1 + 1) / 2, y = (rect.y0 + rect.y1 + 1) / 2;
    return cut(image, {rect.x0, rect.y0, x, y}, error, to) && cut(image, {x, rect.y0, rect.x1, y}, error, to) &&
           cut(image, {rect.x0, y, x, rect.y1}, error, to) && cut(image, {x, y, rect.x1, rect.y1}, error, to);
}

}  // namespace

Result<std::vector<DepthPiece>> depth_pieces(const DepthImage& image, int most_px) {
    const auto [width, height] = image.size;
    for (int doubled = 0; doubled <= most_doublings; ++doubled) {
        std::vector<DepthPiece> pieces;
        bool fits = true;
        for (int y = 0; y < height && fits; y += most_px)
            for (int x = 0; x < width && fits; x += most_px)
                fits = cut(image, {x, y, std::min(x + most_px, width), std::min(y + most_px, height)},
                           std::ldexp(least_error, doubled), pieces);
        if (!fits) continue;
        if (pieces.empty()) return error(ErrorKind::invalid_argument, "has no depth anywhere: all of it is 0");
        return pieces;
    }
    return error(ErrorKind::resource_exhausted,
                 "is too rough: within 3.2 % it takes more than " + std::to_string(most_planes) +
                     " planes; smooth it (a median of 5 x 5), or set to 0 what hides nobody");
}

}  // namespace camrig::world

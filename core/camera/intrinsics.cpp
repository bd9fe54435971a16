#include "core/camera/intrinsics.h"

#include <cmath>
#include <numbers>
#include <string>

namespace camrig {
namespace {

constexpr double deg = std::numbers::pi / 180.0;
constexpr double min_fov_rad = 0.01 * deg;
constexpr double max_fov_rad = 179.9 * deg;

Result<double> focal_length(const char* what, int pixels, double fov_rad) {
    if (!(fov_rad > min_fov_rad && fov_rad < max_fov_rad)) {
        return error(ErrorKind::invalid_argument, std::string(what) + ": " + std::to_string(fov_rad / deg) +
                                                      " deg is no field of view of a pinhole camera; use 0.01 to 179.9 deg");
    }
    return 0.5 * pixels / std::tan(0.5 * fov_rad);
}

Intrinsics centred(ImageSize size, double focal) {
    return {focal, focal, 0.5 * (size.width - 1), 0.5 * (size.height - 1)};
}

/// Angle between the rays through both edges of the image, which lie half a pixel outside the outermost pixel centres.
double full_angle(int pixels, double focal, double centre) {
    return std::atan((centre + 0.5) / focal) + std::atan((pixels - 0.5 - centre) / focal);
}

}  // namespace

Result<Intrinsics> intrinsics_from_vfov(ImageSize size, double vfov) {
    const auto focal = focal_length("vfov_deg", size.height, vfov);
    if (!focal) return std::unexpected(focal.error());
    return centred(size, *focal);
}

Result<Intrinsics> intrinsics_from_hfov(ImageSize size, double hfov) {
    const auto focal = focal_length("hfov_deg", size.width, hfov);
    if (!focal) return std::unexpected(focal.error());
    return centred(size, *focal);
}

Result<void> check_intrinsics(ImageSize size, const Intrinsics& k) {
    const bool finite = std::isfinite(k.fx) && std::isfinite(k.fy) && std::isfinite(k.cx) && std::isfinite(k.cy);
    if (!finite || k.fx <= 0.0 || k.fy <= 0.0)
        return error(ErrorKind::invalid_argument, "intrinsics: fx and fy must be positive and all four finite");
    // The principal point may lie outside the image (a crop of a larger sensor), but not absurdly far.
    if (std::abs(k.cx) > 1e6 || std::abs(k.cy) > 1e6)
        return error(ErrorKind::invalid_argument, "intrinsics: cx and cy must be within 1e6 pixels of the image");
    for (const double fov : {hfov_rad(size, k), vfov_rad(size, k)}) {
        if (!(fov > 1e-3 * min_fov_rad && fov < max_fov_rad)) {
            return error(ErrorKind::invalid_argument,
                         "intrinsics: they mean a field of view of " + std::to_string(fov / deg) +
                             " deg for size " + size.to_string() + "; a pinhole camera has 0.01 to 179.9 deg");
        }
    }
    return {};
}

double vfov_rad(ImageSize size, const Intrinsics& k) { return full_angle(size.height, k.fy, k.cy); }
double hfov_rad(ImageSize size, const Intrinsics& k) { return full_angle(size.width, k.fx, k.cx); }

}  // namespace camrig

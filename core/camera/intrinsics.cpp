#include "core/camera/intrinsics.h"

#include <cmath>
#include <numbers>
#include <string>

#include "core/base/field_of.h"
#include "core/base/number_text.h"
#include "core/base/portable_math.h"

namespace camrig::camera {
namespace {

constexpr double deg = std::numbers::pi / 180.0;
constexpr double min_fov_rad = 0.01 * deg;
constexpr double max_fov_rad = 179.9 * deg;
/// The other side of a very long and narrow picture may be this much narrower than the smallest angle one can ask for.
constexpr double narrow_side = 1e-3;
/// A principal point may lie outside the image (a crop of a larger sensor), but not absurdly far.
constexpr double max_principal_point_px = 1e6;

Result<void> check_size(ImageSize size) {
    if (size.width >= 1 && size.height >= 1) return {};
    return error(ErrorKind::invalid_argument, "size: " + size.to_string() + " has no pixels");
}

Result<double> focal_length(const char* what, int pixels, double fov_rad) {
    if (!(fov_rad > min_fov_rad && fov_rad < max_fov_rad)) {
        return error(ErrorKind::invalid_argument,
                     std::string(what) + ": " + number_text(fov_rad / deg) +
                         " deg is no field of view of a pinhole camera; use 0.01 to 179.9 deg");
    }
    return 0.5 * pixels / portable::tan(0.5 * fov_rad);
}

Intrinsics centred(ImageSize size, double focal) {
    return {focal, focal, 0.5 * (size.width - 1), 0.5 * (size.height - 1)};
}

/// Angle between the rays through both edges of the image, which lie half a pixel outside the outermost pixel centres.
double full_angle(int pixels, double focal, double centre) {
    return portable::atan((centre + 0.5) / focal) + portable::atan((pixels - 0.5 - centre) / focal);
}

}  // namespace

FieldTable<Intrinsics> fields_of(std::type_identity<Intrinsics>) {
    const Range focal{.low = 0, .is_low_out = true}, centre{-1e6, 1e6};
    static const std::vector<FieldOf<Intrinsics>> table{
        field_at<&Intrinsics::fx>(
            {.name = "fx", .doc = "focal length", .required = true, .unit = "px", .range = focal}),
        field_at<&Intrinsics::fy>(
            {.name = "fy", .doc = "focal length", .required = true, .unit = "px", .range = focal}),
        field_at<&Intrinsics::cx>(
            {.name = "cx", .doc = "principal point", .required = true, .unit = "px", .range = centre}),
        field_at<&Intrinsics::cy>(
            {.name = "cy", .doc = "principal point", .required = true, .unit = "px", .range = centre}),
    };
    return table;
}

Result<Intrinsics> intrinsics_from_vfov(ImageSize size, double vfov) {
    if (auto good = check_size(size); !good) return std::unexpected(good.error());
    const auto focal = focal_length("vfov_deg", size.height, vfov);
    if (!focal) return std::unexpected(focal.error());
    return centred(size, *focal);
}

Result<Intrinsics> intrinsics_from_hfov(ImageSize size, double hfov) {
    if (auto good = check_size(size); !good) return std::unexpected(good.error());
    const auto focal = focal_length("hfov_deg", size.width, hfov);
    if (!focal) return std::unexpected(focal.error());
    return centred(size, *focal);
}

Result<void> check_intrinsics(ImageSize size, const Intrinsics& k) {
    if (auto good = check_size(size); !good) return good;
    const bool finite = std::isfinite(k.fx) && std::isfinite(k.fy) && std::isfinite(k.cx) && std::isfinite(k.cy);
    if (!finite || k.fx <= 0.0 || k.fy <= 0.0)
        return error(ErrorKind::invalid_argument, "intrinsics: fx and fy must be positive and all four finite");
    if (std::abs(k.cx) > max_principal_point_px || std::abs(k.cy) > max_principal_point_px)
        return error(ErrorKind::invalid_argument, "intrinsics: cx and cy must be within 1e6 pixels of the image");
    for (const double fov : {hfov_rad(size, k), vfov_rad(size, k)}) {
        if (!(fov > narrow_side * min_fov_rad && fov < max_fov_rad)) {
            return error(ErrorKind::invalid_argument, "intrinsics: they mean a field of view of " +
                                                          number_text(fov / deg) + " deg for size " + size.to_string() +
                                                          "; a pinhole camera has 0.01 to 179.9 deg");
        }
    }
    return {};
}

Intrinsics between(const Intrinsics& from, const Intrinsics& to, double share) {
    const auto scaled = [share](double begin, double end) {
        return begin * portable::exp(portable::log(end / begin) * share);
    };
    const auto moved = [share](double begin, double end) { return begin + (end - begin) * share; };
    return {scaled(from.fx, to.fx), scaled(from.fy, to.fy), moved(from.cx, to.cx), moved(from.cy, to.cy)};
}

double vfov_rad(ImageSize size, const Intrinsics& k) {
    return full_angle(size.height, k.fy, k.cy);
}
double hfov_rad(ImageSize size, const Intrinsics& k) {
    return full_angle(size.width, k.fx, k.cx);
}

}  // namespace camrig::camera

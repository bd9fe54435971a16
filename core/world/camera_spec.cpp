#include "core/world/camera_spec.h"

#include <algorithm>
#include <cmath>

#include "core/base/output_family.h"
#include "core/camera/camera_model.h"
#include "core/world/backdrop/backdrop.h"
#include "core/world/camera_fields.h"

namespace camrig::world {
namespace {

/// The code strip's cells need this much room (core/frame/code_strip), and so does the clock's text.
constexpr ImageSize min_code_strip_size{128, 32};

Result<camera::Intrinsics> derive_intrinsics(ImageSize size, const Optics& optics) {
    if (const auto* vertical = std::get_if<VerticalFov>(&optics))
        return camera::intrinsics_from_vfov(size, vertical->rad);
    if (const auto* horizontal = std::get_if<HorizontalFov>(&optics))
        return camera::intrinsics_from_hfov(size, horizontal->rad);
    return std::get<camera::Intrinsics>(optics);
}

Result<void> check_size(const CameraSpec& spec) {
    const auto [width, height] = spec.size;
    if (width < min_image_size.width || height < min_image_size.height || width > max_image_size.width ||
        height > max_image_size.height) {
        return invalid("size: " + spec.size.to_string() + "; cameras have " + min_image_size.to_string() + " to " +
                       max_image_size.to_string() + " pixels");
    }
    if (spec.code_strip && (width < min_code_strip_size.width || height < min_code_strip_size.height)) {
        return invalid("code_strip: a picture of " + spec.size.to_string() + " has no room for it; it needs " +
                       min_code_strip_size.to_string());
    }
    if (spec.clock_text && (width < min_code_strip_size.width || height < min_code_strip_size.height)) {
        return invalid("clock_text: a picture of " + spec.size.to_string() + " has no room for it; it needs " +
                       min_code_strip_size.to_string());
    }
    return {};
}

Result<void> check_range(const CameraSpec& spec) {
    if (auto good = check_fields(camera_fields(), spec); !good) return good;
    if (auto good = check_fields(fields_of(std::type_identity<LensSampling>{}), spec.lens_sampling); !good)
        return invalid("lens." + good.error().message);
    if (!(spec.far_m == 0.0 || (std::isfinite(spec.far_m) && spec.far_m > spec.near_m)))
        return invalid("far: must be 0 (no limit) or over near");
    return {};
}

/// What a picture of one sample a pixel may have.
bool is_of_areas_or_middles(Antialias antialias) {
    return antialias == Antialias::none || antialias == Antialias::coverage;
}

Result<void> check_sensor(const CameraSpec& spec) {
    if (!spec.sensor) return {};
    if (auto good = sensor::check_sensor(*spec.sensor); !good) return invalid("sensor." + good.error().message);
    // Light is drawn by one rasteriser alone.
    if (spec.antialias != Antialias::automatic && !is_of_areas_or_middles(spec.antialias))
        return error(ErrorKind::unsupported, "antialias: with a sensor it is auto, none or coverage");
    const bool is_pinhole = spec.lens.model == camera::LensModel::pinhole;
    if (is_pinhole ? spec.lens_sampling.method != LensMethod::automatic : spec.lens_sampling != LensSampling{})
        return error(ErrorKind::unsupported,
                     "lens: with a sensor it is drawn through itself (method and filter "
                     "as they are when left out)");
    return {};
}

Result<void> check_pose(const camera::Pose& pose) {
    for (glm::length_t i = 0; i < 3; ++i) {
        if (!(std::abs(pose.position[i]) <= camera::max_coordinate_m))
            return invalid("pose.position: must be finite and within 1e10 m of the origin");
    }
    // Made by core/camera, so a unit quaternion; this is for specs put together in code.
    if (!(std::abs(glm::length(pose.orientation) - 1.0) < 1e-6))
        return invalid("pose.orientation: is not a unit quaternion");
    return {};
}

bool is_soft_or_noisy(const BackdropSpec& backdrop) {
    return backdrop.edge_px > 0.0 || backdrop.noise;
}

Result<void> check_exposure(const CameraSpec& spec) {
    if (spec.exposure_ev == 0.0 || (!spec.sensor && !spec.backdrop)) return {};
    return error(ErrorKind::unsupported, spec.sensor ? "exposure_ev: a camera with a sensor is exposed by "
                                                       "sensor.exposure_s and sensor.gain_db; set it to 0"
                                                     : "exposure_ev: the picture of a backdrop is exposed already; set "
                                                       "it to 0");
}

/// A plate is true from one place, through one lens.
Result<void> check_backdrop(const CameraSpec& spec) {
    if (!spec.backdrop) return {};
    const auto refuse = [](const std::string& why) { return error(ErrorKind::unsupported, why); };
    const bool stands_still = spec.backdrop->stands_still();
    if (spec.mount && !spec.backdrop->is_projected())
        return refuse(
            "mount: a camera with a backdrop stands still, because its picture is true from one place only; leave out "
            "one of both, or give it a projected picture");
    if (spec.ptz && stands_still)
        return refuse(
            "ptz: a camera with a backdrop stands still, because its picture shows what was before it at one pan, tilt "
            "and zoom; leave out one of both, or give it a panorama or a projected picture");
    if (spec.sensor)
        return refuse("sensor: the picture of a backdrop went through a sensor already; leave out one of both");
    if (spec.zoom != spec.optics_zoom && stands_still)
        return refuse("zoom: a camera with a backdrop has the zoom that its picture was taken with");
    if (spec.lens_sampling != LensSampling{})
        return refuse("lens.method: people are drawn into a backdrop through the lens itself (method auto)");
    if (spec.antialias != Antialias::automatic && !is_of_areas_or_middles(spec.antialias))
        return refuse("antialias: with a backdrop it is auto, none or coverage");
    if (spec.antialias == Antialias::coverage && spec.backdrop->is_projected())
        return refuse("antialias: a projected picture is drawn without (auto or none)");
    if (spec.antialias == Antialias::coverage && is_soft_or_noisy(*spec.backdrop))
        return refuse("antialias: coverage has edges of its own; leave out backdrop.edge_px and backdrop.noise, or it");
    return {};
}

/// The pose with its head turned.
Result<camera::Pose> turned(const camera::Pose& pose, std::optional<double> pan_rad, std::optional<double> tilt_rad) {
    if (!pan_rad && !tilt_rad) return pose;
    camera::PanTiltRoll angles = camera::angles_of(pose.orientation);
    angles.pan = pan_rad.value_or(angles.pan);
    angles.tilt = tilt_rad.value_or(angles.tilt);
    return pose_from_angles(pose.position, angles);
}

Result<void> check_lens(const CameraSpec& spec) {
    // A lens sees along its axis: where that is in the picture, its edges need no survey, which takes milliseconds.
    const auto is_within = [](double centre, int pixels) { return centre >= -0.5 && centre < pixels - 0.5; };
    if (is_within(spec.intrinsics.cx, spec.size.width) && is_within(spec.intrinsics.cy, spec.size.height)) {
        const auto map = camera::LensMap::create(spec.lens);
        return map ? Result<void>() : std::unexpected(map.error());
    }
    if (auto camera = camera::CameraModel::create(spec.size, spec.intrinsics, spec.lens); !camera)
        return std::unexpected(camera.error());
    return {};
}

/// What a patch does not say stays.
template <typename From, typename To>
void assign_if(const std::optional<From>& from, To& to) {
    if (from) to = *from;
}

}  // namespace

Antialias antialias_of(const CameraSpec& spec, Quality quality) {
    if (spec.antialias != Antialias::automatic) return spec.antialias;
    // What a film shows changes, so that nothing of areas could be kept; a projected picture is looked up at middles.
    if (spec.backdrop && (spec.backdrop->kind == BackdropKind::film || spec.backdrop->is_projected() ||
                          is_soft_or_noisy(*spec.backdrop)))
        return Antialias::none;
    // Above 4 megapixels pixels are small enough for what several samples of each (lenses, GPUs) would take of memory.
    constexpr std::int64_t most_pixels = std::int64_t{1} << 22;
    return quality == Quality::beautiful && spec.size.pixels() <= most_pixels ? Antialias::coverage : Antialias::none;
}

std::span<const Named<Quality>> names_of(std::type_identity<Quality>) {
    static constexpr Named<Quality> names[] = {
        {Quality::fast, "fast"}, {Quality::simple, "simple"}, {Quality::beautiful, "beautiful"}};
    return names;
}

Result<CameraSpec> patch_camera_spec(const CameraSpec& base, const CameraPatch& patch) {
    CameraSpec spec = base;
    assign_if(patch.size, spec.size);
    assign_if(patch.rate, spec.rate);
    assign_if(patch.optics, spec.optics);
    assign_if(patch.zoom, spec.zoom);
    if (patch.optics) spec.zoom = spec.optics_zoom = patch.zoom.value_or(1.0);
    assign_if(patch.pose, spec.pose);
    assign_if(patch.mount, spec.mount);
    const auto pose = turned(spec.pose, patch.pan_rad, patch.tilt_rad);
    if (!pose) return std::unexpected(pose.error());
    spec.pose = *pose;
    assign_if(patch.lens, spec.lens);
    assign_if(patch.lens_sampling, spec.lens_sampling);
    assign_if(patch.outputs, spec.outputs);
    assign_if(patch.backdrop, spec.backdrop);
    for (const auto& change : patch.others) change(spec);

    for (const auto& good : {check_size(spec), check_range(spec), check_sensor(spec), check_pose(spec.pose),
                             check_outputs(spec.outputs, spec.size), check_backdrop(spec), check_exposure(spec)})
        if (!good) return std::unexpected(good.error());
    auto intrinsics = derive_intrinsics(spec.size, spec.optics);
    if (!intrinsics) return std::unexpected(intrinsics.error());
    intrinsics->fx *= spec.zoom / spec.optics_zoom;
    intrinsics->fy *= spec.zoom / spec.optics_zoom;
    if (spec.backdrop && spec.backdrop->intrinsics && spec.backdrop->files && !spec.backdrop->is_projected())
        *intrinsics = scaled(*spec.backdrop->intrinsics, spec.backdrop->files->size(), spec.size);
    if (auto good = check_intrinsics(spec.size, *intrinsics); !good) return std::unexpected(good.error());
    spec.intrinsics = *intrinsics;
    const bool same_optics = spec.lens == base.lens && spec.lens_sampling == base.lens_sampling &&
                             spec.size == base.size && spec.intrinsics == base.intrinsics;
    if (!same_optics)
        if (auto good = check_lens(spec); !good) return std::unexpected(good.error());
    const bool stays =
        spec.backdrop && spec.backdrop->is_projected() ? spec.lens == base.lens : same_optics && spec.pose == base.pose;
    if (!spec.backdrop) {
        spec.backdrop_here = nullptr;
    } else if (!stays || spec.backdrop != base.backdrop) {
        auto made = make_backdrop(spec);
        if (!made) return std::unexpected(made.error());
        spec.backdrop_here = std::move(*made);
    }
    return spec;
}

}  // namespace camrig::world

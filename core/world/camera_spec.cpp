#include "core/world/camera_spec.h"

#include <algorithm>
#include <cmath>

#include "core/camera/camera_model.h"

namespace camrig {
namespace {

/// The code strip's cells need this much room (core/frame/code_strip).
constexpr ImageSize min_code_strip_size{128, 32};
constexpr int max_device_number = 255;
constexpr double max_near_m = 1e6;

Error invalid(std::string message) {
    return {ErrorKind::invalid_argument, std::move(message)};
}

Result<Intrinsics> derive_intrinsics(ImageSize size, const Optics& optics) {
    if (const auto* vertical = std::get_if<VerticalFov>(&optics)) return intrinsics_from_vfov(size, vertical->rad);
    if (const auto* horizontal = std::get_if<HorizontalFov>(&optics))
        return intrinsics_from_hfov(size, horizontal->rad);
    return std::get<Intrinsics>(optics);
}

Result<void> check_size(const CameraSpec& spec) {
    const auto [width, height] = spec.size;
    if (width < min_image_size.width || height < min_image_size.height || width > max_image_size.width ||
        height > max_image_size.height) {
        return std::unexpected(invalid("size: " + spec.size.to_string() + "; cameras have " +
                                       min_image_size.to_string() + " to " + max_image_size.to_string() + " pixels"));
    }
    if (spec.code_strip && (width < min_code_strip_size.width || height < min_code_strip_size.height)) {
        return std::unexpected(invalid("code_strip: a picture of " + spec.size.to_string() +
                                       " has no room for it; it needs " + min_code_strip_size.to_string()));
    }
    return {};
}

Result<void> check_range(const CameraSpec& spec) {
    if (!(spec.near_m > 0.0 && spec.near_m <= max_near_m))
        return std::unexpected(invalid("near: must be over 0 and at most 1e6 m"));
    if (!(spec.far_m == 0.0 || (std::isfinite(spec.far_m) && spec.far_m > spec.near_m)))
        return std::unexpected(invalid("far: must be 0 (no limit) or over near"));
    return {};
}

Result<void> check_pose(const Pose& pose) {
    for (glm::length_t i = 0; i < 3; ++i) {
        if (!(std::abs(pose.position[i]) <= max_coordinate_m))
            return std::unexpected(invalid("pose.position: must be finite and within 1e10 m of the origin"));
    }
    // Made by core/camera, so a unit quaternion; this is for specs put together in code.
    if (!(std::abs(glm::length(pose.orientation) - 1.0) < 1e-6))
        return std::unexpected(invalid("pose.orientation: is not a unit quaternion"));
    return {};
}

Result<void> check_zoom(double zoom) {
    if (zoom >= 1.0 && zoom <= 10.0) return {};
    return std::unexpected(invalid("zoom: must be 1 to 10"));
}

Result<void> check_controls(const ImageControls& controls) {
    struct Limit {
        const char* name;
        double value, low, high;
        const char* words;
    };
    for (const Limit& limit : {Limit{"exposure_ev", controls.exposure_ev, -6, 6, "-6 to 6"},
                               Limit{"gain_db", controls.gain_db, 0, 24, "0 to 24"},
                               Limit{"white_balance_k", controls.white_balance_k, 2800, 10000, "2800 to 10000"},
                               Limit{"brightness", controls.brightness, -1, 1, "-1 to 1"},
                               Limit{"contrast", controls.contrast, 0, 2, "0 to 2"},
                               Limit{"saturation", controls.saturation, 0, 2, "0 to 2"}}) {
        if (!(limit.value >= limit.low && limit.value <= limit.high))
            return std::unexpected(invalid(std::string("controls.") + limit.name + ": must be " + limit.words));
    }
    return {};
}

void apply_controls(const ImageControlsPatch& patch, ImageControls& controls) {
    const auto apply = [](const auto& from, auto& to) {
        if (from) to = *from;
    };
    apply(patch.auto_exposure, controls.auto_exposure);
    apply(patch.exposure_ev, controls.exposure_ev);
    apply(patch.gain_db, controls.gain_db);
    apply(patch.auto_white_balance, controls.auto_white_balance);
    apply(patch.white_balance_k, controls.white_balance_k);
    apply(patch.brightness, controls.brightness);
    apply(patch.contrast, controls.contrast);
    apply(patch.saturation, controls.saturation);
}

/// The pose with its head turned.
Result<Pose> turned(const Pose& pose, std::optional<double> pan_rad, std::optional<double> tilt_rad) {
    if (!pan_rad && !tilt_rad) return pose;
    PanTiltRoll angles = angles_of(pose.orientation);
    angles.pan = pan_rad.value_or(angles.pan);
    angles.tilt = tilt_rad.value_or(angles.tilt);
    return pose_from_angles(pose.position, angles);
}

Result<void> check_lens(const CameraSpec& spec) {
    if (spec.lens_sampling.oversample < 1 || spec.lens_sampling.oversample > max_lens_oversampling)
        return std::unexpected(invalid("lens.oversample: must be 1 to " + std::to_string(max_lens_oversampling)));
    if (auto camera = CameraModel::create(spec.size, spec.intrinsics, spec.lens); !camera)
        return std::unexpected(camera.error());
    return {};
}

/// The options of an RTSP output's H.264 encoder.
Result<void> check_h264(const OutputSpec& output, const std::string& place) {
    if (output.kind != "rtsp" || output.codec == "mjpeg") {
        for (const auto& [is_given, key] : {std::pair{output.bitrate_kbps.has_value(), ".bitrate_kbps"},
                                            {output.key_interval_s.has_value(), ".key_interval_s"},
                                            {!output.preset.empty(), ".preset"},
                                            {!output.profile.empty(), ".profile"}})
            if (is_given) return std::unexpected(invalid(place + key + ": only rtsp outputs with codec h264 have one"));
        return {};
    }
    if (output.bitrate_kbps && (*output.bitrate_kbps < 16 || *output.bitrate_kbps > 200'000))
        return std::unexpected(invalid(place + ".bitrate_kbps: must be 16 to 200000"));
    if (output.key_interval_s && !(*output.key_interval_s >= 0.01 && *output.key_interval_s <= 60.0))
        return std::unexpected(invalid(place + ".key_interval_s: must be 0.01 to 60"));
    constexpr std::array presets = {"", "ultrafast", "superfast", "veryfast", "faster", "fast", "medium", "slow"};
    if (std::ranges::find(presets, output.preset) == presets.end())
        return std::unexpected(invalid(place + ".preset: '" + output.preset.substr(0, 40) +
                                       "' is none of ultrafast, superfast, veryfast, faster, fast, medium, slow"));
    constexpr std::array profiles = {"", "baseline", "main", "high"};
    if (std::ranges::find(profiles, output.profile) == profiles.end())
        return std::unexpected(
            invalid(place + ".profile: '" + output.profile.substr(0, 40) + "' is none of baseline, main, high"));
    return {};
}

Result<void> check_output(const OutputSpec& output, ImageSize size, const std::string& place) {
    const bool numbered = output.kind == "v4l2" || output.kind == "device";
    if (!numbered && output.kind != "rtsp" && output.kind != "mjpeg") {
        return std::unexpected(
            invalid(place + ".kind: '" + output.kind.substr(0, 40) + "' is none of v4l2, device, rtsp, mjpeg"));
    }
    if (numbered && !output.number)
        return std::unexpected(invalid(place + ".number: is missing; it is the N of /dev/videoN"));
    if (!numbered && output.number)
        return std::unexpected(invalid(place + ".number: " + output.kind + " outputs have none"));
    if (output.number && (*output.number < 0 || *output.number > max_device_number))
        return std::unexpected(invalid(place + ".number: must be 0 to 255"));

    // YUYV and YU12 have half as many chroma columns (and rows); Chrome drops every picture of an odd width.
    if (output.kind == "v4l2" && (size.width % 2 != 0 || size.height % 2 != 0))
        return std::unexpected(
            invalid(place + ": a v4l2 device needs an even width and height; the camera has " + size.to_string()));

    constexpr std::array formats = {"", "YUYV", "YU12", "MJPG", "BGR3"};
    if (!output.format.empty() && output.kind != "v4l2")
        return std::unexpected(invalid(place + ".format: only v4l2 outputs have one"));
    if (std::ranges::find(formats, output.format) == formats.end())
        return std::unexpected(
            invalid(place + ".format: '" + output.format.substr(0, 40) + "' is none of YUYV, YU12, MJPG, BGR3"));

    constexpr std::array codecs = {"", "h264", "mjpeg"};
    if (!output.codec.empty() && output.kind != "rtsp")
        return std::unexpected(invalid(place + ".codec: only rtsp outputs have one"));
    if (std::ranges::find(codecs, output.codec) == codecs.end())
        return std::unexpected(invalid(place + ".codec: '" + output.codec.substr(0, 40) + "' is none of h264, mjpeg"));

    const bool mjpeg = output.kind == "mjpeg" || output.codec == "mjpeg";
    if (output.quality && !mjpeg) return std::unexpected(invalid(place + ".quality: only mjpeg outputs have one"));
    if (output.quality && (*output.quality < 1 || *output.quality > 100))
        return std::unexpected(invalid(place + ".quality: must be 1 to 100"));
    return check_h264(output, place);
}

Result<void> check_outputs(const std::vector<OutputSpec>& outputs, ImageSize size) {
    if (outputs.size() > max_outputs_per_camera) {
        return error(ErrorKind::resource_exhausted, "outputs: " + std::to_string(outputs.size()) +
                                                        " of them; a camera has at most " +
                                                        std::to_string(max_outputs_per_camera));
    }
    for (std::size_t i = 0; i < outputs.size(); ++i) {
        const std::string place = "outputs[" + std::to_string(i) + "]";
        if (auto good = check_output(outputs[i], size, place); !good) return good;
        for (std::size_t earlier = 0; earlier < i; ++earlier) {
            const OutputSpec &a = outputs[earlier], &b = outputs[i];
            if (a.kind == b.kind && a.number == b.number && a.codec == b.codec)
                return std::unexpected(
                    invalid(place + ": is the same output as outputs[" + std::to_string(earlier) + "]"));
        }
    }
    return {};
}

}  // namespace

Antialias antialias_of(const CameraSpec& spec, Quality quality) {
    if (spec.antialias != Antialias::automatic) return spec.antialias;
    // Above 4 megapixels four samples of each take more memory than they gain: pixels are small enough.
    constexpr std::int64_t most_pixels = std::int64_t{1} << 22;
    return quality == Quality::beautiful && spec.size.pixels() <= most_pixels ? Antialias::msaa4 : Antialias::none;
}

std::string_view to_string(Quality quality) {
    switch (quality) {
        case Quality::fast:
            return "fast";
        case Quality::simple:
            return "simple";
        case Quality::beautiful:
            return "beautiful";
    }
    return "simple";
}

Result<Quality> parse_quality(std::string_view name) {
    for (const Quality quality : {Quality::fast, Quality::simple, Quality::beautiful})
        if (name == to_string(quality)) return quality;
    return error(ErrorKind::invalid_argument,
                 "'" + std::string(name.substr(0, 40)) + "' is none of fast, simple, beautiful");
}

Result<CameraSpec> patch_camera_spec(const CameraSpec& base, const CameraPatch& patch) {
    CameraSpec spec = base;
    const auto apply = [](const auto& from, auto& to) {
        if (from) to = *from;
    };
    apply(patch.size, spec.size);
    apply(patch.rate, spec.rate);
    apply(patch.optics, spec.optics);
    apply(patch.zoom, spec.zoom);
    if (patch.optics) spec.zoom = spec.optics_zoom = patch.zoom.value_or(1.0);
    apply(patch.pose, spec.pose);
    const auto pose = turned(spec.pose, patch.pan_rad, patch.tilt_rad);
    if (!pose) return std::unexpected(pose.error());
    spec.pose = *pose;
    apply(patch.lens, spec.lens);
    apply(patch.lens_sampling, spec.lens_sampling);
    apply(patch.antialias, spec.antialias);
    apply(patch.near_m, spec.near_m);
    apply(patch.far_m, spec.far_m);
    apply(patch.quality, spec.quality);
    apply_controls(patch.controls, spec.controls);
    apply(patch.code_strip, spec.code_strip);
    apply(patch.outputs, spec.outputs);

    for (const auto& good : {check_size(spec), check_range(spec), check_pose(spec.pose), check_zoom(spec.zoom),
                             check_controls(spec.controls), check_outputs(spec.outputs, spec.size)})
        if (!good) return std::unexpected(good.error());
    auto intrinsics = derive_intrinsics(spec.size, spec.optics);
    if (!intrinsics) return std::unexpected(intrinsics.error());
    intrinsics->fx *= spec.zoom / spec.optics_zoom;
    intrinsics->fy *= spec.zoom / spec.optics_zoom;
    if (auto good = check_intrinsics(spec.size, *intrinsics); !good) return std::unexpected(good.error());
    spec.intrinsics = *intrinsics;
    // Surveying a lens takes a millisecond, and a camera that only turns need not wait for it.
    const bool same_optics = spec.lens == base.lens && spec.lens_sampling == base.lens_sampling &&
                             spec.size == base.size && spec.intrinsics == base.intrinsics;
    if (same_optics) return spec;
    if (auto good = check_lens(spec); !good) return std::unexpected(good.error());
    return spec;
}

}  // namespace camrig

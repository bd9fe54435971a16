#include "core/world/output_check.h"

#include <utility>

#include "core/world/camera_fields.h"

namespace camrig {
namespace {

Error refusal(std::string message) {
    return {ErrorKind::invalid_argument, std::move(message)};
}

/// The options of an RTSP output's H.264 encoder.
Result<void> check_h264(const OutputSpec& output, const std::string& place) {
    if (output.kind != "rtsp" || output.codec == "mjpeg") {
        for (const auto& [is_given, key] : {std::pair{output.bitrate_kbps.has_value(), ".bitrate_kbps"},
                                            {output.key_interval_s.has_value(), ".key_interval_s"},
                                            {!output.preset.empty(), ".preset"},
                                            {!output.profile.empty(), ".profile"}})
            if (is_given) return std::unexpected(refusal(place + key + ": only rtsp outputs with codec h264 have one"));
    }
    return {};
}

Result<void> check_output(const OutputSpec& output, ImageSize size, const std::string& place) {
    const bool numbered = output.kind == "v4l2" || output.kind == "device";
    if (auto good = check_fields(fields_of(std::type_identity<OutputSpec>{}), output); !good)
        return std::unexpected(refusal(place + "." + good.error().message));
    if (numbered && !output.number)
        return std::unexpected(refusal(place + ".number: is missing; it is the N of /dev/videoN"));
    if (!numbered && output.number)
        return std::unexpected(refusal(place + ".number: " + output.kind + " outputs have none"));

    // YUYV and YU12 have half as many chroma columns (and rows); Chrome drops every picture of an odd width.
    if (output.kind == "v4l2" && (size.width % 2 != 0 || size.height % 2 != 0))
        return std::unexpected(
            refusal(place + ": a v4l2 device needs an even width and height; the camera has " + size.to_string()));

    if (!output.format.empty() && output.kind != "v4l2")
        return std::unexpected(refusal(place + ".format: only v4l2 outputs have one"));
    if (!output.subsampling.empty() && output.kind != "device" && output.format != "MJPG")
        return std::unexpected(
            refusal(place + ".subsampling: only device outputs and v4l2 outputs of format MJPG have one"));
    if (!output.codec.empty() && output.kind != "rtsp")
        return std::unexpected(refusal(place + ".codec: only rtsp outputs have one"));

    const bool mjpeg = output.kind == "mjpeg" || output.codec == "mjpeg";
    if (output.quality && !mjpeg) return std::unexpected(refusal(place + ".quality: only mjpeg outputs have one"));
    return check_h264(output, place);
}

}  // namespace

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
                    refusal(place + ": is the same output as outputs[" + std::to_string(earlier) + "]"));
        }
    }
    return {};
}

}  // namespace camrig

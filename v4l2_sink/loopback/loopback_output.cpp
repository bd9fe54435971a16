#include "v4l2_sink/loopback/loopback_output.h"

#include "v4l2_sink/loopback/loopback_server.h"
#include "v4l2_sink/media_format.h"

namespace camrig::device {
namespace {

void check_subsampling(const LoopbackOutput& output, JsonReader& reader) {
    if (reader.has("subsampling") && output.format != "MJPG")
        reader.fail("subsampling", "only device outputs and v4l2 outputs of format MJPG have one");
}

// YUYV and YU12 have half as many chroma columns (and rows); Chrome drops every picture of an odd width.
Result<void> check_loopback_size(ImageSize size) {
    if (size.width % 2 == 0 && size.height % 2 == 0) return {};
    return error(ErrorKind::invalid_argument,
                 "a v4l2 device needs an even width and height; the camera has " + size.to_string());
}

}  // namespace

FieldTable<LoopbackOutput> fields_of(std::type_identity<LoopbackOutput>) {
    using O = LoopbackOutput;
    static const std::vector<FieldOf<O>> table{
        field_at<&O::number>(video_number_field()),
        field_at<&O::format>({.name = "format", .choices = {"YUYV", "YU12", "MJPG", "BGR3"}}),
        field_at<&O::subsampling>(subsampling_field()),
    };
    return table;
}

OutputFamily loopback_family() {
    return {.kind = output_kind<LoopbackOutput>(
                {.name = "v4l2",
                 .doc = "/dev/videoN of the kernel module v4l2loopback, for every program of the machine",
                 .rule = R"({"if": {"required": ["subsampling"]},
                             "then": {"properties": {"format": {"const": "MJPG"}}, "required": ["format"]}})"},
                check_subsampling),
            .key = "number",
            .is_key_of_rig = true,
            .fits = [](const OutputSpec&, ImageSize size) { return check_loopback_size(size); },
            .can_open =
                [](const OutputSpec& output, const std::string& camera) {
                    return check_loopback(options_of<LoopbackOutput>(output).number, camera);
                }};
}

}  // namespace camrig::device

#include "rtsp_out/rtsp/rtsp_output.h"

namespace camrig::rtsp {
namespace {

void check_codec(const RtspOutput& output, JsonReader& reader) {
    if (output.codec == RtspCodec::h264 && reader.has("quality")) reader.fail("quality", "only mjpeg outputs have one");
    if (output.codec == RtspCodec::h264) return;
    for (const char* key : {"bitrate_kbps", "key_interval_s", "preset", "profile"})
        if (reader.has(key)) reader.fail(key, "only rtsp outputs with codec h264 have one");
}

/// What check_codec says, as JSON schema.
constexpr const char* codec_rule = R"({
    "if": {"properties": {"codec": {"const": "mjpeg"}}, "required": ["codec"]},
    "then": {"properties": {"bitrate_kbps": false, "key_interval_s": false, "preset": false, "profile": false}},
    "else": {"properties": {"quality": false}}})";

}  // namespace

std::span<const Named<RtspCodec>> names_of(std::type_identity<RtspCodec>) {
    static constexpr Named<RtspCodec> names[] = {{RtspCodec::h264, "h264"}, {RtspCodec::mjpeg, "mjpeg"}};
    return names;
}

FieldTable<RtspOutput> fields_of(std::type_identity<RtspOutput>) {
    using O = RtspOutput;
    static const std::vector<FieldOf<O>> table{
        field_at<&O::codec>({.name = "codec"}),
        field_at<&O::quality>({.name = "quality", .doc = "JPEG quality", .range = {1, 100}}),
        field_at<&O::bitrate_kbps>({.name = "bitrate_kbps",
                                    .doc = "with h264; by default 0.15 bits per pixel",
                                    .unit = "kbit/s",
                                    .range = {16, 200'000}}),
        field_at<&O::key_interval_s>({.name = "key_interval_s",
                                      .doc = "with h264: a key frame at least so often",
                                      .unit = "s",
                                      .range = {0.01, 60}}),
        field_at<&O::preset>({.name = "preset",
                              .doc = "with h264",
                              .choices = {"ultrafast", "superfast", "veryfast", "faster", "fast", "medium", "slow"}}),
        field_at<&O::profile>({.name = "profile", .doc = "with h264", .choices = {"baseline", "main", "high"}}),
    };
    return table;
}

OutputFamily rtsp_family() {
    return {
        .kind = output_kind<RtspOutput>({.name = "rtsp",
                                         .doc = "how the RTSP stream of this codec, which every camera has, is encoded",
                                         .rule = codec_rule},
                                        check_codec),
        .key = "codec"};
}

}  // namespace camrig::rtsp

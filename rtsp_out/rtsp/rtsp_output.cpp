#include "rtsp_out/rtsp/rtsp_output.h"

#include <algorithm>
#include <cmath>

#include "core/base/picture_fields.h"
#include "core/base/rtp_jpeg.h"

namespace camrig::rtsp {
namespace {

constexpr double bits_per_pixel = 0.15;
constexpr int min_default_kbps = 200;

constexpr const char* size_schema =
    R"({"type": "array", "items": {"type": "integer", "minimum": 16, "maximum": 8192}, "minItems": 2, "maxItems": 2})";
constexpr const char* fps_schema =
    R"({"anyOf": [{"type": "number", "minimum": 0.1, "maximum": 1000},
                  {"type": "string", "pattern": "^[0-9]+(\\.[0-9]+|/[0-9]+)?$"}]})";

void check_options(const RtspOutput& output, JsonReader& reader) {
    const auto refuse = [&](std::initializer_list<const char*> keys, const char* who) {
        for (const char* key : keys)
            if (reader.has(key)) reader.fail(key, std::string("only ") + who);
    };
    if (output.codec != RtspCodec::mjpeg) refuse({"quality"}, "mjpeg outputs have one");
    if (output.codec == RtspCodec::mjpeg)
        refuse({"bitrate_kbps", "key_interval_s", "preset"}, "rtsp outputs with codec h264 or h265 have one");
    if (output.codec != RtspCodec::h264) refuse({"profile"}, "rtsp outputs with codec h264 have one");
    if (output.stream != RtspStream::sub) refuse({"size"}, "the sub stream has one; others have the camera's");
    if (output.size && (std::min(output.size->width, output.size->height) < min_image_size.width ||
                        std::max(output.size->width, output.size->height) > max_image_size.width))
        reader.fail("size", "must be " + min_image_size.to_string() + " to " + max_image_size.to_string());
}

/// What check_options says, as JSON schema.
constexpr const char* options_rule = R"({"allOf": [
    {"if": {"properties": {"codec": {"const": "mjpeg"}}, "required": ["codec"]},
     "then": {"properties": {"bitrate_kbps": false, "key_interval_s": false, "preset": false}},
     "else": {"properties": {"quality": false}}},
    {"if": {"properties": {"codec": {"enum": ["mjpeg", "h265"]}}, "required": ["codec"]},
     "then": {"properties": {"profile": false}}},
    {"if": {"properties": {"stream": {"const": "sub"}}, "required": ["stream"]},
     "else": {"properties": {"size": false}}}]})";

FieldOf<RtspOutput> size_field() {
    return {.field = {.name = "size",
                      .type = "[width, height]",
                      .doc = "with stream sub, at most the camera's; by default half of it",
                      .unit = "px",
                      .schema = size_schema},
            .read =
                [](JsonReader& reader, Changes<RtspOutput>& changes) {
                    if (const auto size = read_size(reader, "size"))
                        changes.change([size](RtspOutput& output) { output.size = size; });
                },
            .write =
                [](const RtspOutput& output) {
                    return output.size ? size_to_json(*output.size) : nlohmann::json(nullptr);
                }};
}

FieldOf<RtspOutput> fps_field() {
    return {
        .field = {.name = "fps",
                  .type = "number or \"num/den\"",
                  .doc = "1/10 to 1000, at most the camera's; by default the camera's, of sub half of it",
                  .unit = "1/s",
                  .schema = fps_schema},
        .read =
            [](JsonReader& reader, Changes<RtspOutput>& changes) {
                if (const auto rate = read_rate(reader, "fps"))
                    changes.change([rate](RtspOutput& output) { output.fps = rate; });
            },
        .write =
            [](const RtspOutput& output) { return output.fps ? rate_to_json(*output.fps) : nlohmann::json(nullptr); }};
}

/// Half, in steps that the codec can have: chroma has half as many columns, and RTP carries JPEG in blocks.
ImageSize half_of(ImageSize camera, RtspCodec codec) {
    const int step = codec == RtspCodec::mjpeg ? rtp_jpeg_step : 2;
    const auto half = [step](int side) { return std::max(min_image_size.width, side / 2 / step * step); };
    return {half(camera.width), half(camera.height)};
}

Result<void> check_size(const OutputSpec& output, ImageSize camera) {
    const auto options = options_of<RtspOutput>(output);
    if (options.stream != RtspStream::sub) return {};
    const ImageSize size = options.size.value_or(half_of(camera, options.codec));
    if (options.size && (size.width > camera.width || size.height > camera.height))
        return error(ErrorKind::invalid_argument, "size: " + size.to_string() + " is more than the camera's " +
                                                      camera.to_string() + "; the sub stream is the smaller one");
    if (!can_be_carried({.options = options, .size = size}))
        return error(ErrorKind::invalid_argument, "size: RTP carries JPEG of sizes in multiples of 8 up to 2040, not " +
                                                      size.to_string() + "; choose such a size, or codec h264");
    return {};
}

bool is_slower(const Rate& a, const Rate& b) {
    return a.num() * b.den() < b.num() * a.den();  // both at most 1e9
}

/// Every second frame; of a camera that is slower than any stream may be, every one.
Rate half_of(const Rate& camera) {
    return Rate::create(camera.num(), 2 * camera.den()).value_or(camera);
}

}  // namespace

std::span<const Named<RtspCodec>> names_of(std::type_identity<RtspCodec>) {
    static constexpr Named<RtspCodec> names[] = {
        {RtspCodec::h264, "h264"}, {RtspCodec::h265, "h265"}, {RtspCodec::mjpeg, "mjpeg"}};
    return names;
}

std::span<const Named<RtspStream>> names_of(std::type_identity<RtspStream>) {
    static constexpr Named<RtspStream> names[] = {{RtspStream::main, "main"}, {RtspStream::sub, "sub"}};
    return names;
}

FieldTable<RtspOutput> fields_of(std::type_identity<RtspOutput>) {
    using O = RtspOutput;
    static const std::vector<FieldOf<O>> table{
        field_at<&O::codec>({.name = "codec", .doc = "main with mjpeg is a stream beside that of h264 or h265"}),
        field_at<&O::stream>({.name = "stream"}),
        size_field(),
        fps_field(),
        field_at<&O::quality>({.name = "quality", .doc = "JPEG quality", .range = {1, 100}}),
        field_at<&O::bitrate_kbps>({.name = "bitrate_kbps",
                                    .doc = "with h264 and h265; by default 0.15 bits per pixel",
                                    .unit = "kbit/s",
                                    .range = {16, 200'000}}),
        field_at<&O::key_interval_s>({.name = "key_interval_s",
                                      .doc = "with h264 and h265: a key frame at least so often",
                                      .unit = "s",
                                      .range = {0.01, 60}}),
        field_at<&O::preset>({.name = "preset",
                              .doc = "with h264 and h265",
                              .choices = {"ultrafast", "superfast", "veryfast", "faster", "fast", "medium", "slow"}}),
        field_at<&O::profile>({.name = "profile", .doc = "with h264", .choices = {"baseline", "main", "high"}}),
    };
    return table;
}

OutputFamily rtsp_family() {
    return {
        .kind = output_kind<RtspOutput>({.name = "rtsp",
                                         .doc = "how one of the RTSP streams, which every camera has, is encoded",
                                         .rule = options_rule},
                                        check_options),
        .key = "codec",
        .identity = [](const OutputSpec& output) { return std::string(path_ending(options_of<RtspOutput>(output))); },
        .fits = check_size};
}

std::string_view path_ending(const RtspOutput& output) {
    if (output.stream == RtspStream::sub) return "/sub";
    return output.codec == RtspCodec::mjpeg ? "/mjpeg" : "";
}

std::vector<StreamSettings> streams_of(const std::vector<OutputSpec>& outputs, ImageSize size, const Rate& rate) {
    std::vector<StreamSettings> streams;
    for (RtspOutput options :
         {RtspOutput{}, RtspOutput{.stream = RtspStream::sub}, RtspOutput{.codec = RtspCodec::mjpeg}}) {
        for (const OutputSpec& output : outputs) {
            if (output.kind != "rtsp") continue;
            if (auto given = options_of<RtspOutput>(output); path_ending(given) == path_ending(options)) {
                options = std::move(given);
                break;
            }
        }
        const bool is_sub = options.stream == RtspStream::sub;
        StreamSettings stream{.size = is_sub ? options.size.value_or(half_of(size, options.codec)) : size,
                              .rate = options.fps.value_or(is_sub ? half_of(rate) : rate)};
        if (is_slower(rate, stream.rate)) stream.rate = rate;
        stream.bitrate_kbps = options.bitrate_kbps.value_or(default_bitrate_kbps(stream.size, stream.rate));
        stream.options = std::move(options);
        streams.push_back(std::move(stream));
    }
    return streams;
}

bool can_be_carried(const StreamSettings& stream) {
    return stream.options.codec != RtspCodec::mjpeg || fits_rtp_jpeg(stream.size);
}

int default_bitrate_kbps(ImageSize size, const Rate& rate) {
    const double bits = static_cast<double>(size.pixels()) * rate.hertz() * bits_per_pixel;
    return std::max(min_default_kbps, static_cast<int>(std::lround(bits / 1000)));
}

}  // namespace camrig::rtsp

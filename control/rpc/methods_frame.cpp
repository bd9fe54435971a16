#include <algorithm>
#include <array>
#include <optional>

#include "control/rpc/method_fields.h"
#include "control/rpc/methods.h"
#include "core/base/base64.h"
#include "core/frame/kind_format.h"

namespace camrig::control {
namespace {

using nlohmann::json;

/// What is asked for.
struct FrameQuestion {
    std::string camera;
    frame::FrameKind kind = frame::FrameKind::color;
    codec::Codec format = codec::Codec::jpeg;
    int quality = codec::default_jpeg_quality;
    std::string pixels = "rgba8";
    std::string encoding = "base64";
    TimeNs min_ns = 0;
    bool now = false;

    bool as_bytes() const { return encoding == "bytes"; }
};

/// What raw pictures of colour are given in.
constexpr std::array raw_color_layouts{frame::PixelFormat::rgba8, frame::PixelFormat::bgr24, frame::PixelFormat::rgb24,
                                       frame::PixelFormat::gray8};

std::vector<std::string> names_of_layouts() {
    std::vector<std::string> names;
    for (const frame::PixelFormat layout : raw_color_layouts) names.emplace_back(to_string(layout));
    return names;
}

const std::vector<FieldOf<FrameQuestion>>& question_fields() {
    using Question = FrameQuestion;
    static const std::vector<FieldOf<Question>> table{
        camera_name_at<&Question::camera>("camera"),
        field_at<&Question::kind>({.name = "kind"}),
        field_at<&Question::format>({.name = "format"}),
        field_at<&Question::quality>({.name = "quality", .doc = "of jpeg", .range = {1, 100}}),
        field_at<&Question::pixels>({.name = "pixels", .doc = "of raw colour", .choices = names_of_layouts()}),
        field_at<&Question::encoding>(
            {.name = "encoding",
             .doc =
                 "bytes, for programs that are in a hurry, follow the line of the answer, as many as its `bytes` says, "
                 "with nothing after them; on the control socket and TCP only, and not in a batch",
             .choices = {"base64", "bytes"}}),
        min_ns_at<&Question::min_ns>(),
        field_at<&Question::now>(
            {.name = "now",
             .doc = "the world as commands find it now, whether the camera is due or not: a picture of the request's "
                    "own, with a `sequence` below 0"})};
    return table;
}

Result<void> check_frame_bytes(const std::string& camera, std::size_t bytes) {
    if (bytes <= max_frame_bytes) return {};
    return error(ErrorKind::resource_exhausted,
                 "camera " + camera + ": this picture has " + std::to_string(bytes) +
                     " bytes; frame.get gives at most " + std::to_string(max_frame_bytes) +
                     ": ask for jpeg or png, or take it from /cameras/" + camera + "/snapshot.png");
}

/// What is claimed for one picture, from before it is drawn until its answer is made.
///
/// The size of a raw picture is known, so its text is claimed at once. How large a JPEG or PNG becomes is not: the
/// picture that it is made of counts among all that is under way, and the text is claimed when its size is known.
class FrameClaims {
public:
    FrameClaims(std::shared_ptr<ByteBudget> answers, std::shared_ptr<ByteBudget> all)
        : answers_(std::move(answers)), all_(std::move(all)) {}

    Result<void> admit(const stream::FetchRequest& request, ImageSize size) {
        const std::size_t bytes =
            bytes_of(request.format.codec == codec::Codec::raw ? request.format.pixels : format_of(request.kind), size);
        if (request.format.codec != codec::Codec::raw) return take(*all_, bytes, picture_);
        if (auto good = check_frame_bytes(request.camera, bytes); !good) return good;
        return take(*answers_, base64_size(bytes), text_);
    }
    Result<ByteBudget::Claim> text(std::size_t bytes) {
        if (text_) return std::move(*text_);
        return answers_->claim(base64_size(bytes));
    }

private:
    static Result<void> take(ByteBudget& budget, std::size_t bytes, std::optional<ByteBudget::Claim>& place) {
        auto claim = budget.claim(bytes);
        if (!claim) return std::unexpected(claim.error());
        place = std::move(*claim);
        return {};
    }

    const std::shared_ptr<ByteBudget> answers_, all_;
    std::optional<ByteBudget::Claim> picture_, text_;
};

Result<RpcResult> frame_result(const stream::MediaUnit& unit, const FrameQuestion& question, FrameClaims& claims) {
    const frame::FrameInfo& info = unit.info;
    const std::span<const std::byte> bytes = unit.bytes ? std::span(*unit.bytes) : unit.frame->bytes();
    if (auto good = check_frame_bytes(question.camera, bytes.size()); !good) return std::unexpected(good.error());
    auto claim = claims.text(bytes.size());
    if (!claim) return std::unexpected(claim.error());
    json fields{{"camera", question.camera},
                {"sequence", info.sequence},
                {"time_ns", info.world_ns},
                {"monotonic_ns", info.monotonic_ns},
                {"size", {info.size.width, info.size.height}},
                {"kind", json_of(question.kind)},
                {"format", json_of(question.format)},
                {"encoding", question.encoding},
                {"bytes", bytes.size()}};
    if (info.clock || info.sensor) {
        fields["stamp_ns"] = info.stamp_ns();
        fields["steady_ns"] = info.steady_ns();
    }
    fields["sensor"] =
        info.sensor ? write_fields(fields_of(std::type_identity<SensorReading>{}), *info.sensor) : json(nullptr);
    if (unit.frame) fields["pixels"] = std::string(to_string(unit.frame->info().format));
    RpcResult result(std::move(fields), question.as_bytes()
                                            ? std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size())
                                            : base64_encode(bytes));
    result.is_bytes = question.as_bytes();
    result.claim = std::move(*claim);
    return result;
}

void get(RpcContext& context, const json& params, RpcReply done) {
    JsonReader reader(params, "");
    auto question =
        read_all<FrameQuestion>(question_fields(), reader, [](const FrameQuestion& asked, JsonReader& keys) {
            if (keys.has("quality") && asked.format != codec::Codec::jpeg) keys.fail("quality", "only jpeg has one");
            if (keys.has("pixels") && (asked.kind != frame::FrameKind::color || asked.format != codec::Codec::raw))
                keys.fail("pixels", "only raw pictures of colour have a choice");
            if (asked.kind == frame::FrameKind::sensor && asked.format != codec::Codec::raw)
                keys.fail("format", "numbers of a sensor come raw only");
            if (asked.kind == frame::FrameKind::flow && asked.format != codec::Codec::raw)
                keys.fail("format", "flow comes raw only");
            if (asked.kind == frame::FrameKind::soiling && asked.format == codec::Codec::jpeg)
                keys.fail("format", "soiling comes raw or as png");
            if (keys.has("min_ns") && asked.now) keys.fail("now", "give either min_ns or now");
        });
    if (!question) return done(std::unexpected(question.error()));
    if (question->as_bytes() && !done.takes_bytes())
        return done(
            error(ErrorKind::invalid_argument,
                  "encoding: bytes come on the control socket and TCP, in answers by themselves; not by HTTP or "
                  "in a batch"));
    stream::FetchRequest request;
    request.camera = question->camera;
    request.kind = question->kind;
    request.min_ns = question->min_ns;
    const bool is_raw = question->format == codec::Codec::raw, is_jpeg = question->format == codec::Codec::jpeg;
    frame::PixelFormat layout = is_raw ? format_of(request.kind) : frame::PixelFormat::rgba8;
    if (is_raw && request.kind == frame::FrameKind::color)
        layout = *std::ranges::find(raw_color_layouts, question->pixels,
                                    [](frame::PixelFormat of) { return to_string(of); });
    request.format = {question->format, layout, is_jpeg ? question->quality : 0, {}};
    const auto claims = std::make_shared<FrameClaims>(done.budget(), context.budget);
    request.admit = [claims, asked = request](ImageSize size) { return claims->admit(asked, size); };
    const bool shows_now = question->now;
    // The answer comes on the worker that encoded the picture: base64 is a small part of that work, so it is done
    // there.
    const auto answer = [question = std::move(*question), claims, done](Result<stream::MediaUnit> unit) {
        if (!unit) return done(std::unexpected(unit.error()));
        done(unless_out_of_memory([&] { return frame_result(*unit, question, *claims); }));
    };
    if (!shows_now) return context.frames.fetch(std::move(request), answer);
    context.commands.post(engine::Request<engine::GetInstant>{
        {}, [&frames = context.frames, request = std::move(request), answer, done](auto instant) mutable {
            if (!instant) return done(std::unexpected(instant.error()));
            request.instant = std::move(*instant);
            frames.fetch(std::move(request), answer);
        }});
}

}  // namespace

std::vector<Method> frame_methods(RpcContext& context) {
    using enum ErrorKind;
    return {
        {.name = "frame.get",
         .summary =
             "The camera's latest due frame; drawn now if nobody was watching. Raw pictures are rows from the top "
             "without padding, in the layout that `pixels` names.",
         .params = descriptions_of(question_fields()),
         .result =
             {{"camera", "string", "its name"},
              {"sequence", "integer", "number of the frame; a gap is a dropped frame"},
              time_field,
              monotonic_field,
              stamp_field,
              steady_field,
              {"size", "[width, height]", "size of the picture", false, "px"},
              {"kind", "string", "as asked"},
              {"format", "string", "as asked"},
              {"pixels", "string",
               "raw only: that of colour as asked, `depth32f`, `id32`, `normal32f` or `flow32f` (two floats: pixels to "
               "the right and down until the camera's next frame), `gray8` of soiling (0: nothing before the scene, "
               "255: all of "
               "its light is taken); of a sensor 16-bit numbers: "
               "`gray16`, of a mosaic `bayer_rggb16`, `bayer_grbg16`, `bayer_gbrg16` or `bayer_bggr16`, of "
               "filter rgb three planes, `rgb16_planes`; little-endian"},
              {"sensor", "object or null",
               "of a camera with a sensor: how it took the picture: exposure_s, gain_db, "
               "electrons_per_number, black_level, bits, red_gain, green_gain, blue_gain, metered, settled"},
              {"encoding", "string", "as asked"},
              {"bytes", "integer", "how many they are; with encoding `bytes` they follow the line"},
              {"data", "string", "with encoding `base64`: the bytes"}},
         .errors = {invalid_argument, not_found, unavailable, unsupported, resource_exhausted},
         .handler = [&context](const json& params, RpcReply done) { get(context, params, std::move(done)); },
         .example = R"({"camera": "lobby", "format": "png"})",
         .only_looks = true}};
}

}  // namespace camrig::control

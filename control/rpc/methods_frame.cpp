#include <algorithm>
#include <array>
#include <optional>

#include "control/rpc/methods.h"
#include "core/base/base64.h"
#include "core/base/json_reader.h"
#include "core/base/names.h"
#include "core/frame/kind_format.h"

namespace camrig {
namespace {

using nlohmann::json;

/// What raw pictures of colour are given in.
constexpr std::array raw_color_layouts{PixelFormat::rgba8, PixelFormat::bgr24, PixelFormat::rgb24, PixelFormat::gray8};

std::optional<FrameKind> parse_kind(std::string_view name) {
    if (name == "color") return FrameKind::color;
    if (name == "depth") return FrameKind::depth;
    if (name == "instance") return FrameKind::instance;
    if (name == "semantic") return FrameKind::semantic;
    if (name == "normal") return FrameKind::normal;
    return std::nullopt;
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

    Result<void> admit(const FetchRequest& request, ImageSize size) {
        const std::size_t bytes =
            bytes_of(request.format.codec == Codec::raw ? request.format.pixels : format_of(request.kind), size);
        if (request.format.codec != Codec::raw) return take(*all_, bytes, picture_);
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

Result<RpcResult> frame_result(const MediaUnit& unit, const std::string& camera, const std::string& kind,
                               const std::string& format, bool as_bytes, FrameClaims& claims) {
    const FrameInfo& info = unit.info;
    const std::span<const std::byte> bytes = unit.bytes ? std::span(*unit.bytes) : unit.frame->bytes();
    if (auto good = check_frame_bytes(camera, bytes.size()); !good) return std::unexpected(good.error());
    auto claim = claims.text(bytes.size());
    if (!claim) return std::unexpected(claim.error());
    json fields{{"camera", camera},
                {"sequence", info.sequence},
                {"time_ns", info.world_ns},
                {"monotonic_ns", info.monotonic_ns},
                {"size", {info.size.width, info.size.height}},
                {"kind", kind},
                {"format", format},
                {"encoding", as_bytes ? "bytes" : "base64"}};
    if (unit.frame) fields["pixels"] = std::string(to_string(unit.frame->info().format));
    fields["bytes"] = bytes.size();
    RpcResult result(std::move(fields), as_bytes
                                            ? std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size())
                                            : base64_encode(bytes));
    result.is_bytes = as_bytes;
    result.claim = std::move(*claim);
    return result;
}

void get(RpcContext& context, const json& params, RpcReply done) {
    JsonReader reader(params, "");
    FetchRequest request;
    std::string kind = "color";
    std::string format = "jpeg";
    std::string encoding = "base64";
    std::optional<int> quality;
    std::optional<std::string> pixels;
    reader.required("camera", request.camera);
    reader.optional("kind", kind);
    reader.optional("format", format);
    reader.optional("quality", quality);
    reader.optional("pixels", pixels);
    reader.optional("encoding", encoding);
    reader.optional("min_ns", request.min_ns);
    if (reader.ok())
        if (auto good = check_name("camera", request.camera); !good) reader.fail(good.error());
    const auto parsed_kind = parse_kind(kind);
    if (!parsed_kind) reader.fail("kind", "must be color, depth, instance, semantic or normal");
    if (format != "jpeg" && format != "png" && format != "raw") reader.fail("format", "must be jpeg, png or raw");
    if (quality && (*quality < 1 || *quality > 100)) reader.fail("quality", "must be 1 to 100");
    if (quality && format != "jpeg") reader.fail("quality", "only jpeg has one");
    const auto layout =
        std::ranges::find(raw_color_layouts, pixels.value_or("rgba8"), [](PixelFormat of) { return to_string(of); });
    if (layout == raw_color_layouts.end()) reader.fail("pixels", "must be rgba8, bgr24, rgb24 or gray8");
    if (pixels && (kind != "color" || format != "raw"))
        reader.fail("pixels", "only raw pictures of colour have a choice");
    if (encoding != "base64" && encoding != "bytes") reader.fail("encoding", "must be base64 or bytes");
    const bool as_bytes = encoding == "bytes";
    if (as_bytes && !done.takes_bytes())
        reader.fail("encoding",
                    "bytes come on the control socket and TCP, in answers by themselves; not by HTTP or in a batch");
    if (auto finished = reader.finish(); !finished) return done(std::unexpected(finished.error()));
    request.kind = *parsed_kind;
    if (format == "jpeg")
        request.format = {Codec::jpeg, PixelFormat::rgba8, quality.value_or(default_jpeg_quality), {}};
    if (format == "png") request.format = {Codec::png, PixelFormat::rgba8, 0, {}};
    if (format == "raw")
        request.format = {Codec::raw, request.kind == FrameKind::color ? *layout : format_of(request.kind), 0, {}};
    const auto claims = std::make_shared<FrameClaims>(done.budget(), context.budget);
    request.admit = [claims, asked = request](ImageSize size) { return claims->admit(asked, size); };
    std::string camera = request.camera;
    // The answer comes on the worker that encoded the picture: base64 is a small part of that work, so it is done
    // there.
    context.frames.fetch(std::move(request), [camera = std::move(camera), kind, format, as_bytes, claims,
                                              done = std::move(done)](Result<MediaUnit> unit) {
        if (!unit) return done(std::unexpected(unit.error()));
        done(unless_out_of_memory([&] { return frame_result(*unit, camera, kind, format, as_bytes, *claims); }));
    });
}

}  // namespace

std::vector<Method> frame_methods(RpcContext& context) {
    using enum ErrorKind;
    return {{.name = "frame.get",
             .summary =
                 "The camera's latest due frame; drawn now if nobody was watching. Raw pictures are rows from the top "
                 "without padding, in the layout that `pixels` names.",
             .params = {{"camera", "string", "name of the camera", true},
                        {"kind", "string", "`color`, `depth`, `instance`, `semantic` or `normal`", false, "", "color"},
                        {"format", "string", "`jpeg`, `png` or `raw`", false, "", "jpeg"},
                        {"quality", "integer", "of jpeg, 1 to 100", false, "", std::to_string(default_jpeg_quality)},
                        {"pixels", "string", "of raw colour: `rgba8`, `bgr24`, `rgb24` or `gray8`", false, "", "rgba8"},
                        {"encoding", "string",
                         "`base64`, or `bytes` for programs that are in a hurry: they follow the line of the answer, "
                         "as many as its `bytes` says, with nothing after them. On the control socket and TCP only, "
                         "and not in a batch",
                         false, "", "base64"},
                        {"min_ns", "integer",
                         "world time the frame must show or be later than; waits up to 10 s for it. 0: from which the "
                         "camera's last "
                         "command shows",
                         false, "ns", "0"}},
             .result = {{"camera", "string", "its name"},
                        {"sequence", "integer", "number of the frame; a gap is a dropped frame"},
                        {"time_ns", "integer", "world time it shows", false, "ns"},
                        {"monotonic_ns", "integer", "CLOCK_MONOTONIC time of that instant", false, "ns"},
                        {"size", "[width, height]", "size of the picture", false, "px"},
                        {"kind", "string", "as asked"},
                        {"format", "string", "as asked"},
                        {"pixels", "string",
                         "raw only: that of colour as asked, `depth32f`, `id32` or `normal32f`, little-endian"},
                        {"encoding", "string", "as asked"},
                        {"bytes", "integer", "how many they are; with encoding `bytes` they follow the line"},
                        {"data", "string", "with encoding `base64`: the bytes"}},
             .errors = {invalid_argument, not_found, unavailable, unsupported, resource_exhausted},
             .handler = [&context](const json& params, RpcReply done) { get(context, params, std::move(done)); },
             .example = R"({"camera": "lobby", "format": "png"})",
             .only_looks = true}};
}

}  // namespace camrig

#include <optional>

#include "control/rpc/methods.h"
#include "core/base/json_reader.h"

namespace camrig {
namespace {

using nlohmann::json;

std::optional<FrameKind> parse_kind(std::string_view name) {
    if (name == "color") return FrameKind::color;
    if (name == "depth") return FrameKind::depth;
    if (name == "instance") return FrameKind::instance;
    if (name == "semantic") return FrameKind::semantic;
    if (name == "normal") return FrameKind::normal;
    return std::nullopt;
}

void get(RpcContext& context, const json& params, RpcReply done) {
    JsonReader reader(params, "");
    FetchRequest request;
    std::string kind = "color";
    std::string format = "jpeg";
    int quality = default_jpeg_quality;
    reader.required("camera", request.camera);
    reader.optional("kind", kind);
    reader.optional("format", format);
    reader.optional("quality", quality);
    reader.optional("min_ns", request.min_ns);
    const auto parsed_kind = parse_kind(kind);
    if (!parsed_kind) reader.fail("kind", "must be color, depth, instance, semantic or normal");
    if (format == "raw") {
        request.format = {Codec::raw, PixelFormat::rgba8, 0, {}};
    } else if (format == "jpeg") {
        request.format = {Codec::jpeg, PixelFormat::rgba8, quality, {}};
    } else if (format == "png") {
        request.format = {Codec::png, PixelFormat::rgba8, 0, {}};
    } else {
        reader.fail("format", "must be jpeg, png or raw");
    }
    if (quality < 1 || quality > 100) reader.fail("quality", "must be 1 to 100");
    if (auto finished = reader.finish(); !finished) return done(std::unexpected(finished.error()));
    request.kind = *parsed_kind;
    context.frames.fetch(std::move(request), [kind, format, done = std::move(done)](Result<MediaUnit> unit) {
        if (!unit) return done(std::unexpected(unit.error()));
        const FrameInfo& info = unit->info;
        const std::span<const std::byte> bytes = unit->bytes ? std::span(*unit->bytes) : unit->frame->bytes();
        json reply{{"camera", *info.camera},
                   {"sequence", info.sequence},
                   {"time_ns", info.world_ns},
                   {"monotonic_ns", info.monotonic_ns},
                   {"size", {info.size.width, info.size.height}},
                   {"kind", kind},
                   {"format", format},
                   {"encoding", "base64"},
                   {"data", base64(bytes)}};
        if (unit->frame) reply["pixels"] = std::string(to_string(unit->frame->info().format));
        done(std::move(reply));
    });
}

}  // namespace

std::vector<Method> frame_methods(RpcContext& context) {
    using enum ErrorKind;
    return {{"frame.get",
             "The camera's latest due frame; drawn now if nobody was watching.",
             {{"camera", "string", "name of the camera", true},
              {"kind", "string", "color (default) | depth | instance | semantic | normal"},
              {"format", "string",
               "jpeg (default) | png | raw (rgba8 rows from the top; depth: 32-bit floats, ids: 32-bit)"},
              {"quality", "integer", "of JPEG, 1 to 100; default 90"},
              {"min_ns", "integer", "world time the frame must show or be later than; waits up to 10 s for it"}},
             {{"camera", "string", "its name"},
              {"sequence", "integer", "number of the frame"},
              {"time_ns", "integer", "world time it shows"},
              {"monotonic_ns", "integer", "CLOCK_MONOTONIC time of that instant"},
              {"size", "[width, height]", "pixels"},
              {"kind", "string", "as asked"},
              {"format", "string", "as asked"},
              {"pixels", "string", "raw only: layout of the bytes"},
              {"encoding", "string", "base64"},
              {"data", "string", "the bytes"}},
             {invalid_argument, not_found, unavailable, unsupported, resource_exhausted},
             [&context](const json& params, RpcReply done) { get(context, params, std::move(done)); }}};
}

}  // namespace camrig

#include <array>
#include <cstdio>

#include <spdlog/spdlog.h>

#include "control/unrealcv/session.h"
#include "core/base/write_file.h"
#include "core/camera/pose.h"
#include "core/world/shipped.h"

// Pictures of cameras, as bytes or as files.
namespace camrig::unrealcv {
namespace asio = boost::asio;
namespace {

using Awaited = asio::awaitable<Answer>;

constexpr std::size_t max_file_name_bytes = 500;

/// What a picture is to become: bytes in the answer, or a file.
struct Target {
    FileType type = FileType::png;
    std::optional<std::string> file;  ///< below the door's folder
};

std::expected<Target, std::string> target_of(std::string_view format) {
    const std::string invalid = "Invalid filename type, filename " + std::string(format.substr(0, max_file_name_bytes));
    const std::size_t dot = format.rfind('.');
    const auto type = file_type(dot == std::string_view::npos ? format : format.substr(dot + 1));
    if (!type || format.size() > max_file_name_bytes) return std::unexpected(invalid);
    if (dot == std::string_view::npos) return Target{*type, std::nullopt};
    return Target{*type, std::string(format)};
}

/// Writes a file below the door's folder; gives its absolute path.
Result<std::string> save(const std::filesystem::path& folder, const std::string& name,
                         std::span<const std::byte> bytes) {
    if (folder.empty())
        return error(ErrorKind::unsupported,
                     "this rig writes no files for UnrealCV; start it with --unrealcv-dir, or ask for png, bmp or npy");
    if (std::filesystem::path(name).is_absolute() || !world::leads_below(name))
        return error(ErrorKind::invalid_argument,
                     "a file lies below the folder of --unrealcv-dir: give a relative name without ..");
    const std::filesystem::path file = folder / name;
    std::error_code failed;
    std::filesystem::create_directories(file.parent_path(), failed);
    if (auto written = write_atomically(file, bytes); !written) return std::unexpected(written.error());
    return file.string();
}

using Make = std::function<Result<codec::BytesRef>(const frame::Frame&)>;

Make maker(Session& session, const Moment& now, const engine::CameraReply& camera, frame::FrameKind kind, FileType type,
           Depth depth) {
    const std::shared_ptr<PictureMemory> memory = session.door().pictures;
    switch (kind) {
        case frame::FrameKind::instance:
            return [memory, type, colors = session.door().colors](const frame::Frame& ids) {
                return encode_picture(*memory, *mask_of(*memory, ids, *colors), type);
            };
        case frame::FrameKind::normal:
            return [memory, type, turn = camera::world_from_optical_rotation(now.state_of(camera).pose)](
                       const frame::Frame& normals) {
                return encode_picture(*memory, *shown_normals(*memory, normals, turn), type);
            };
        case frame::FrameKind::depth:
            return [memory, depth, intrinsics = now.state_of(camera).intrinsics, lens = camera.camera.spec()->lens](
                       const frame::Frame& metres) { return depth_array(*memory, metres, depth, intrinsics, lens); };
        case frame::FrameKind::flow:
            return [memory, type](const frame::Frame& flow) -> Result<codec::BytesRef> {
                return type == FileType::npy ? flow_array(*memory, flow)
                                             : encode_picture(*memory, *shown_flow(*memory, flow), type);
            };
        default:
            return [memory, type](const frame::Frame& rgba) { return encode_picture(*memory, rgba, type); };
    }
}

asio::awaitable<Answer> give(Session& session, std::string_view id, frame::FrameKind kind, Target target, Depth depth) {
    const auto now = co_await session.moment_of_cameras();
    if (!now) co_return refused(now.error());
    const auto camera = camera_at(**now, id);
    if (!camera) co_return refused(camera.error());
    Make make = maker(session, **now, **camera, kind, target.type, depth);
    std::function<Result<Body>(const frame::Frame&)> answer =
        [make = std::move(make), folder = session.door().folder,
         name = target.file](const frame::Frame& frame) -> Result<Body> {
        auto bytes = make(frame);
        if (!bytes) return std::unexpected(bytes.error());
        if (!name) return std::move(*bytes);
        return save(folder, *name, **bytes);
    };
    auto made = co_await session.picture(**camera, kind, std::move(answer));
    if (!made) co_return refused(std::move(made.error().message));
    co_return std::move(*made);
}

asio::awaitable<Answer> picture(Session& session, Arguments arguments, frame::FrameKind kind, Depth depth) {
    const bool is_depth = kind == frame::FrameKind::depth;
    if (arguments.size() == 1) {
        char name[32];
        std::snprintf(name, sizeof name, "%08llu.%s", static_cast<unsigned long long>(session.door().files++),
                      is_depth ? "npy" : "png");
        return give(session, arguments[0], kind, {is_depth ? FileType::npy : FileType::png, name}, depth);
    }
    const auto refuse = [](std::string why) -> asio::awaitable<Answer> { co_return refused(std::move(why)); };
    auto target = target_of(arguments[1]);
    if (!target) return refuse(target.error());
    // Numbers come as arrays alone.
    if (is_depth && target->type != FileType::npy)
        return refuse("Invalid filename type, filename " + std::string(arguments[1]));
    return give(session, arguments[0], kind, std::move(*target), depth);
}

Awaited lit(Session& session, Arguments arguments) {
    return picture(session, arguments, frame::FrameKind::color, {});
}
Awaited mask(Session& session, Arguments arguments) {
    return picture(session, arguments, frame::FrameKind::instance, {});
}
Awaited normal(Session& session, Arguments arguments) {
    return picture(session, arguments, frame::FrameKind::normal, {});
}
Awaited flow(Session& session, Arguments arguments) {
    return picture(session, arguments, frame::FrameKind::flow, {});
}
Awaited depth(Session& session, Arguments arguments) {
    return picture(session, arguments, frame::FrameKind::depth, session.door().depth);
}
Awaited plane_depth(Session& session, Arguments arguments) {
    return picture(session, arguments, frame::FrameKind::depth, Depth::plane_m);
}

}  // namespace

std::span<const Command> picture_commands() {
    static constexpr std::array table{
        Command{"vget /camera/[uint]/lit [str]", "Its picture: png, bmp, npy or a file name", lit},
        Command{"vget /camera/[uint]/lit", "The same as a file with a number; gives its path", lit},
        Command{"vget /camera/[uint]/object_mask [str]", "Objects in the colours of /object/[str]/color", mask},
        Command{"vget /camera/[uint]/object_mask", "The same as a file with a number", mask},
        Command{"vget /camera/[uint]/seg [str]", "The same as object_mask", mask},
        Command{"vget /camera/[uint]/normal [str]", "Normals in the world, (n + 1) / 2", normal},
        Command{"vget /camera/[uint]/normal", "The same as a file with a number", normal},
        Command{"vget /camera/[uint]/optical_flow [str]", "Optical flow: npy, or its way as a colour", flow},
        Command{"vget /camera/[uint]/optical_flow", "The same as a file with a number", flow},
        Command{"vget /camera/[uint]/depth [str]", "Depth: npy or a file name", depth},
        Command{"vget /camera/[uint]/depth", "The same as a file with a number", depth},
        Command{"vget /camera/[uint]/plane_depth [str]", "Depth along the axis, metres", plane_depth}};
    return table;
}

}  // namespace camrig::unrealcv

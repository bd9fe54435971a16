#include <array>
#include <cmath>
#include <numbers>

#include "control/unrealcv/session.h"
#include "control/unrealcv/units.h"

// Cameras: where they are, how they look, and new ones.
namespace camrig::unrealcv {
namespace asio = boost::asio;
namespace {

using Awaited = asio::awaitable<Answer>;

/// A new camera's, as UnrealCV's.
constexpr double new_hfov_rad = 1.5707963267948966;
constexpr int most_names_tried = 300;

glm::dvec3 vector_at(Arguments arguments, std::size_t first) {
    return {*number_of(arguments[first]), *number_of(arguments[first + 1]), *number_of(arguments[first + 2])};
}

Awaited list(Session& session, Arguments) {
    const auto now = co_await session.moment_of_cameras();
    if (!now) co_return refused(now.error());
    std::string names;
    for (const engine::CameraReply& one : (*now)->cameras)
        (names += names.empty() ? "" : " ") += one.camera.spec()->name;
    co_return names;
}

/// What is told of a camera.
using Tell = std::string (*)(const world::CameraSpec&, const camera::CameraState&);

asio::awaitable<Answer> tell(Session& session, std::string_view id, Tell text) {
    const auto now = co_await session.moment_of_cameras();
    if (!now) co_return refused(now.error());
    const auto camera = camera_at(**now, id);
    if (!camera) co_return refused(camera.error());
    co_return text(*(*camera)->camera.spec(), (*now)->state_of(**camera));
}

Awaited location(Session& session, Arguments arguments) {
    return tell(session, arguments[0],
                [](const auto&, const auto& state) { return text_of(location_of(state.pose.position)); });
}
Awaited rotation(Session& session, Arguments arguments) {
    return tell(session, arguments[0],
                [](const auto&, const auto& state) { return text_of(rotation_of(state.pose.orientation)); });
}
Awaited pose(Session& session, Arguments arguments) {
    return tell(session, arguments[0], [](const auto&, const auto& state) {
        return text_of(location_of(state.pose.position)) + " " + text_of(rotation_of(state.pose.orientation));
    });
}
Awaited fov(Session& session, Arguments arguments) {
    return tell(session, arguments[0], [](const auto& spec, const auto& state) {
        return number_text(glm::degrees(camera::hfov_rad(spec.size, state.intrinsics)), 6);
    });
}
Awaited size(Session& session, Arguments arguments) {
    return tell(session, arguments[0], [](const auto& spec, const auto&) {
        return std::to_string(spec.size.width) + " " + std::to_string(spec.size.height);
    });
}
/// The player stands where the first camera is.
Awaited actor_location(Session& session, Arguments) {
    static constexpr std::array<std::string_view, 1> first{"0"};
    return location(session, first);
}
Awaited actor_rotation(Session& session, Arguments) {
    static constexpr std::array<std::string_view, 1> first{"0"};
    return rotation(session, first);
}

/// Puts a camera somewhere in the world; it leaves what it was mounted on.
asio::awaitable<Answer> place(Session& session, std::string_view id, std::optional<glm::dvec3> to,
                              std::optional<glm::dvec3> turned) {
    const auto now = co_await session.moment_of_cameras();
    if (!now) co_return refused(now.error());
    const auto camera = camera_at(**now, id);
    if (!camera) co_return refused(camera.error());
    const world::CameraSpec& spec = *(*camera)->camera.spec();
    if (spec.ptz && turned) co_return refused("camera " + spec.name + " is on a pan/tilt head; turn it by ptz.move");
    camera::Pose pose = (*camera)->camera.base_at((*now)->world());
    if (to) pose.position = metres_of(*to);
    if (turned) pose.orientation = orientation_of(*turned);
    engine::SetCamera command{.name = spec.name, .patch = {}};
    command.patch.pose = pose;
    if (spec.mount) command.patch.mount = std::optional<world::Mount>();
    co_return co_await session.change(std::move(command));
}

Awaited set_location(Session& session, Arguments arguments) {
    return place(session, arguments[0], vector_at(arguments, 1), std::nullopt);
}
Awaited set_rotation(Session& session, Arguments arguments) {
    return place(session, arguments[0], std::nullopt, vector_at(arguments, 1));
}
Awaited set_pose(Session& session, Arguments arguments) {
    return place(session, arguments[0], vector_at(arguments, 1), vector_at(arguments, 4));
}

/// Changes a camera otherwise.
asio::awaitable<Answer> adjust(
    Session& session, std::string_view id,
    std::function<void(const Moment&, const engine::CameraReply&, world::CameraPatch&)> how) {
    const auto now = co_await session.moment_of_cameras();
    if (!now) co_return refused(now.error());
    const auto camera = camera_at(**now, id);
    if (!camera) co_return refused(camera.error());
    engine::SetCamera command{.name = (*camera)->camera.spec()->name, .patch = {}};
    how(**now, **camera, command.patch);
    co_return co_await session.change(std::move(command));
}

/// What the head's zoom multiplies the focal length of the spec by.
double zoom_of(const camera::CameraState& state) {
    return state.head ? state.head->true_position.zoom : 1.0;
}
Awaited set_fov(Session& session, Arguments arguments) {
    return adjust(session, arguments[0],
                  [rad = glm::radians(*number_of(arguments[1]))](const Moment& now, const engine::CameraReply& camera,
                                                                 world::CameraPatch& patch) {
                      const double zoom = zoom_of(now.state_of(camera));
                      // Half a turn and more is refused as it is.
                      const bool is_angle = rad < std::numbers::pi;
                      patch.optics = world::HorizontalFov{is_angle ? 2.0 * std::atan(std::tan(0.5 * rad) * zoom) : rad};
                  });
}
/// The field of view stays what it is from side to side.
Awaited set_size(Session& session, Arguments arguments) {
    const ImageSize wanted{*integer_of(arguments[1]), *integer_of(arguments[2])};
    return adjust(session, arguments[0],
                  [wanted](const Moment& now, const engine::CameraReply& camera, world::CameraPatch& patch) {
                      patch.size = wanted;
                      const camera::CameraState state = now.state_of(camera);
                      camera::Intrinsics wide = state.intrinsics;
                      wide.fx /= zoom_of(state);
                      patch.optics = world::HorizontalFov{camera::hfov_rad(camera.camera.spec()->size, wide)};
                  });
}
Awaited set_exposure_bias(Session& session, Arguments arguments) {
    return adjust(session, arguments[0],
                  [stops = *number_of(arguments[1])](const auto&, const auto&, world::CameraPatch& patch) {
                      patch.change([stops](world::CameraSpec& spec) {
                          spec.controls.auto_exposure = false;
                          spec.controls.exposure_ev = stops;
                      });
                  });
}
Awaited set_projection(Session& session, Arguments arguments) {
    const bool is_perspective = arguments[1] == "perspective";
    const auto now = co_await session.moment_of_cameras();
    if (!now) co_return refused(now.error());
    const auto camera = camera_at(**now, arguments[0]);
    if (!camera) co_return refused(camera.error());
    if (!is_perspective) co_return refused("camrig's cameras are perspective");
    co_return std::string();
}
/// What camrig has no counterpart of changes nothing.
Awaited ignore(Session& session, Arguments arguments) {
    const auto now = co_await session.moment_of_cameras();
    if (!now) co_return refused(now.error());
    const auto camera = camera_at(**now, arguments[0]);
    if (!camera) co_return refused(camera.error());
    co_return std::string();
}

asio::awaitable<Answer> spawn_at(Session& session, glm::dvec3 to) {
    const auto now = co_await session.moment_of_cameras();
    if (!now) co_return refused(now.error());
    std::size_t number = (*now)->cameras.size();
    for (int tried = 0; tried < most_names_tried; ++tried, ++number) {
        engine::CreateCamera command{.name = "camera_" + std::to_string(number), .place = {}, .patch = {}};
        command.patch.optics = world::HorizontalFov{new_hfov_rad};
        command.patch.pose = camera::Pose{.position = metres_of(to)};
        const auto made = co_await session.ask(command);
        if (made) {
            session.changed();
            co_return command.name;
        }
        if (made.error().kind != ErrorKind::already_exists) co_return refused(made.error().message);
    }
    co_return refused("all names for a new camera are taken");
}

Awaited spawn(Session& session, Arguments) {
    return spawn_at(session, {});
}

}  // namespace

asio::awaitable<Answer> spawn_camera(Session& session, glm::dvec3 to) {
    return spawn_at(session, to);
}

std::span<const Command> camera_commands() {
    static constexpr std::array table{
        Command{"vget /cameras", "Names of all cameras; the place in this list is a camera's number", list},
        Command{"vset /cameras/spawn", "Makes a camera at the origin, 640x480 and 90 degrees wide", spawn},
        Command{"vget /camera/[uint]/location", "Where it is: x y z, centimetres", location},
        Command{"vset /camera/[uint]/location [float] [float] [float]", "Puts it to x y z", set_location},
        Command{"vset /camera/[uint]/moveto [float] [float] [float]", "The same: nothing stops it", set_location},
        Command{"vget /camera/[uint]/rotation", "How it is turned: pitch yaw roll, degrees", rotation},
        Command{"vset /camera/[uint]/rotation [float] [float] [float]", "Turns it to pitch yaw roll", set_rotation},
        Command{"vget /camera/[uint]/pose", "Location and rotation", pose},
        Command{"vset /camera/[uint]/pose [float] [float] [float] [float] [float] [float]",
                "Puts it to x y z and turns it to pitch yaw roll", set_pose},
        Command{"vget /camera/[uint]/fov", "Field of view from side to side, degrees", fov},
        Command{"vset /camera/[uint]/fov [float]", "Sets it", set_fov},
        Command{"vget /camera/[uint]/horizontal_fieldofview", "The same as fov", fov},
        Command{"vset /camera/[uint]/horizontal_fieldofview [float]", "The same as fov", set_fov},
        Command{"vget /camera/[uint]/size", "Width and height of its pictures", size},
        Command{"vset /camera/[uint]/size [uint] [uint]", "Sets them", set_size},
        Command{"vget /actor/location", "Location of camera 0", actor_location},
        Command{"vget /actor/rotation", "Rotation of camera 0", actor_rotation},
        Command{"vset /camera/[uint]/exposure_bias [float]", "Exposure in stops", set_exposure_bias},
        Command{"vset /camera/[uint]/projection_type [str]", "perspective; there is no other", set_projection},
        Command{"vset /camera/[uint]/lit_source [str]", "No effect", ignore},
        Command{"vset /camera/[uint]/reflection [str]", "No effect", ignore},
        Command{"vset /camera/[uint]/illumination [str]", "No effect", ignore},
        Command{"vset /camera/[uint]/exposure_method [str]", "No effect", ignore},
        Command{"vset /camera/[uint]/auto_speed [float] [float]", "No effect", ignore},
        Command{"vset /camera/[uint]/auto_brightness [float] [float]", "No effect", ignore},
        Command{"vset /camera/[uint]/motion_blur [float] [float] [float] [uint]", "No effect", ignore},
        Command{"vset /camera/[uint]/focal [float] [float]", "No effect", ignore},
        Command{"vset /camera/[uint]/physical_exposure [uint]", "No effect", ignore}};
    return table;
}

}  // namespace camrig::unrealcv

#include <array>

#include "control/unrealcv/session.h"

// What the door says of itself.
namespace camrig::unrealcv {
namespace asio = boost::asio;
namespace {

/// Clients that know it expect the commands of that plugin; from 2.0.0 on they would expect those of another.
constexpr const char* plugin_version = "1.1.0";
/// [rest] is as many words as this to clients, which know no such placeholder.
constexpr int most_words = 11;
/// Requests that one vbatch may announce.
constexpr int max_vbatch = 10'000;

using Awaited = asio::awaitable<Answer>;

Awaited status(Session& session, Arguments) {
    const auto now = co_await session.moment_of_cameras();
    if (!now) co_return refused(now.error());
    ImageSize size{640, 480};
    double hfov = 90.0;
    if (!(*now)->cameras.empty()) {
        const engine::CameraReply& first = (*now)->cameras.front();
        size = first.camera.spec()->size;
        hfov = glm::degrees(camera::hfov_rad(size, (*now)->state_of(first).intrinsics));
    }
    const DoorState& door = session.door();
    // Clients take the folder of the configuration for that of saved files.
    const std::string config =
        door.folder.empty() ? "none (no --unrealcv-dir)" : (door.folder / "unrealcv.ini").string();
    const std::string port = std::to_string(door.port);
    co_return "Is Listening\nClient Connected\n" + port + "\nConfiguration\nConfig file: " + config +
        "\nPort: " + port + "\nWidth: " + std::to_string(size.width) + "\nHeight: " + std::to_string(size.height) +
        "\nFOV: " + std::to_string(hfov) + "\nEnableInput: false\nEnableRightEye: false\n";
}

Awaited help(Session&, Arguments) {
    std::string text;
    for (const Command& one : commands()) ((((text += one.pattern) += '\n') += one.help) += '\n');
    co_return text;
}

Awaited list_commands(Session&, Arguments) {
    constexpr std::string_view rest = "[rest]";
    std::string text;
    for (const Command& one : commands()) {
        if (!one.pattern.ends_with(rest)) {
            (text += one.pattern) += '\n';
            continue;
        }
        std::string pattern(one.pattern.substr(0, one.pattern.size() - rest.size()));
        for (int words = 1; words <= most_words; ++words) {
            pattern += words == 1 ? "[str]" : " [str]";
            (text += pattern) += '\n';
        }
    }
    co_return text;
}

Awaited version(Session&, Arguments) {
    co_return std::string(plugin_version);
}

Awaited echo(Session&, Arguments arguments) {
    co_return std::string(arguments[0]);
}

Awaited scene_name(Session& session, Arguments) {
    const auto state = co_await session.ask(engine::GetWorld{});
    if (!state) co_return refused(state.error().message);
    co_return state->scene;
}

Awaited vbatch(Session& session, Arguments arguments) {
    const int count = std::atoi(std::string(arguments[0]).c_str());
    if (count < 1 || count > max_vbatch) co_return bad_arguments();
    session.end_batch();
    session.begin_vbatch(count);
    co_return std::string();
}

}  // namespace

std::span<const Command> plugin_commands() {
    static constexpr std::array table{
        Command{"vget /unrealcv/status", "The door's port and folder, and the first camera's size", status},
        Command{"vget /unrealcv/help", "All commands with what they do", help},
        Command{"vget /unrealcv/commands", "The templates of all commands, one a line", list_commands},
        Command{"vget /unrealcv/version", "The version of UnrealCV that these commands are of", version},
        Command{"vget /unrealcv/echo [rest]", "Gives back what it is given", echo},
        Command{"vget /scene/name", "Name of the scene", scene_name},
        Command{"vget /level/name", "Name of the scene", scene_name},
        Command{"vbatch [uint]", "The next so many requests read one moment", vbatch}};
    return table;
}

}  // namespace camrig::unrealcv

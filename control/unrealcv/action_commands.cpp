#include <array>

#include "control/unrealcv/session.h"
#include "control/unrealcv/units.h"
#include "core/world/shipped.h"

// The world: its clock, its scene; and what has no effect here.
namespace camrig::unrealcv {
namespace asio = boost::asio;
namespace {

using Awaited = asio::awaitable<Answer>;

constexpr double max_tick_s = 3600.0;

Awaited no_effect(Session&, Arguments) {
    co_return std::string();
}
Awaited not_implemented(Session&, Arguments) {
    co_return refused("Not Implemented");
}

/// In lockstep the world is always paused: it moves by ticks alone.
asio::awaitable<std::expected<bool, std::string>> is_lockstep(Session& session) {
    const auto now = co_await session.moment();
    if (!now) co_return std::unexpected(now.error());
    co_return (*now)->instant->mode == engine::RunMode::lockstep;
}

Awaited pause(Session& session, Arguments) {
    const auto lockstep = co_await is_lockstep(session);
    if (!lockstep) co_return refused(lockstep.error());
    if (*lockstep) co_return std::string();
    co_return co_await session.change(engine::PauseWorld{});
}
Awaited resume(Session& session, Arguments) {
    const auto lockstep = co_await is_lockstep(session);
    if (!lockstep) co_return refused(lockstep.error());
    if (*lockstep) co_return std::string();
    co_return co_await session.change(engine::ResumeWorld{});
}
Awaited is_paused(Session& session, Arguments) {
    const auto now = co_await session.moment();
    if (!now) co_return refused(now.error());
    co_return std::string((*now)->instant->stands_still ? "true" : "false");
}

Answer set_tick(Session& session, double seconds) {
    if (!(seconds > 0.0 && seconds <= max_tick_s)) return bad_arguments();
    session.door().tick_ns = std::llround(seconds * 1e9);
    return std::string();
}
Awaited set_tick_interval(Session& session, Arguments arguments) {
    co_return set_tick(session, *number_of(arguments[0]));
}
Awaited set_frame_rate(Session& session, Arguments arguments) {
    co_return set_tick(session, 1.0 / *number_of(arguments[0]));
}
Awaited tick(Session& session, Arguments) {
    const auto now = co_await session.moment();
    if (!now) co_return refused(now.error());
    const TimeNs duration_ns = session.door().tick_ns.value_or((*now)->instant->scene->step_ns);
    co_return co_await session.change(engine::StepWorld{.duration_ns = duration_ns});
}

/// Shipped scenes by name alone: who can reach this port need not be the owner of this machine's files.
Awaited level(Session& session, Arguments arguments) {
    const std::string name(arguments[0]);
    if (!world::shipped_scenes().contains(name))
        co_return refused("Can not find a level with name '" + name.substr(0, 100) + "'; there are the shipped scenes");
    const auto scene = std::make_shared<world::SceneRef>();
    std::function<Result<std::string>()> load = [scene, name]() -> Result<std::string> {
        auto loaded = world::load_scene(name);
        if (!loaded) return std::unexpected(loaded.error());
        *scene = std::move(*loaded);
        return std::string();
    };
    const auto read = co_await session.work(std::move(load));
    if (!read) co_return refused(read.error().message);
    engine::LoadWorld command{*scene};
    co_return co_await session.change(std::move(command));
}

Awaited viewmode(Session& session, Arguments) {
    co_return session.viewmode;
}
Awaited set_viewmode(Session& session, Arguments arguments) {
    session.viewmode = arguments[0];
    co_return std::string();
}

}  // namespace

std::span<const Command> action_commands() {
    static constexpr std::array table{
        Command{"vset /action/game/pause", "Holds the world's clock", pause},
        Command{"vset /action/game/resume", "Lets it run", resume},
        Command{"vget /action/game/is_paused", "true or false; in lockstep true", is_paused},
        Command{"vset /action/game/level [str]", "Loads a shipped scene", level},
        Command{"vset /action/tick_intervel [float]", "Seconds of a tick", set_tick_interval},
        Command{"vset /action/tick_interval [float]", "Seconds of a tick", set_tick_interval},
        Command{"vset /action/set_fixed_frame_rate [float]", "Ticks a second", set_frame_rate},
        Command{"vset /action/tick", "Moves a world that stands still by a tick", tick},
        Command{"vget /viewmode", "What vset /viewmode said", viewmode},
        Command{"vset /viewmode [str]", "No effect on pictures", set_viewmode},
        Command{"vset /action/input/enable", "No effect", no_effect},
        Command{"vset /action/input/disable", "No effect", no_effect},
        Command{"vset /action/keyboard [str] [float]", "Not implemented", not_implemented},
        Command{"vset /action/eyes_distance [float]", "Not implemented", not_implemented},
        Command{"vrun [rest]", "No effect", no_effect},
        Command{"vexec [rest]", "No effect", no_effect},
        Command{"DisableAllScreenMessages", "No effect", no_effect}};
    return table;
}

}  // namespace camrig::unrealcv

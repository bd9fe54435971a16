#include "core/engine/rig.h"

#include <algorithm>
#include <numeric>

#include "core/base/clock.h"

namespace camrig::engine {
namespace {

std::vector<stream::CounterReport> reports_of(const render::RenderCounters& counters) {
    const auto now = [](std::string_view name, auto value, std::string_view help) {
        return stream::CounterReport{name, false, static_cast<std::uint64_t>(value), help};
    };
    const auto all = [](std::string_view name, std::uint64_t value, std::string_view help) {
        return stream::CounterReport{name, true, value, help};
    };
    return {
        now("static_layers", counters.layers, "Pictures kept of what does not move."),
        now("static_layer_bytes", counters.layer_bytes, "Device memory of the static layers."),
        now("draw_data_bytes", counters.draw_data_bytes, "Memory of OpenGL for uniforms and deformed vertices."),
        all("static_layers_drawn", counters.layers_drawn, "Static layers made."),
        all("static_layers_reused", counters.layers_reused, "Static layers copied instead of drawing."),
        all("static_layers_stale", counters.layers_stale, "Static layers thrown away because what they show changed."),
        all("static_layers_evicted", counters.layers_evicted, "Static layers thrown away to make room."),
        all("views", counters.views, "Pictures drawn, on demand and for truth too."),
        all("views_in_parts", counters.views_in_parts, "Pictures drawn only where something may move."),
        all("meshes_skinned", counters.meshes_skinned, "Skinned meshes made, once per instant for all cameras."),
        all("meshes_unseen", counters.meshes_unseen, "Skinned meshes that no camera saw and that were not made."),
        all("draws", counters.draws, "Surfaces drawn."),
        all("draw_calls", counters.draw_calls, "Calls of OpenGL for them, of one or more surfaces each."),
        all("draws_coarse", counters.draws_coarse, "Surfaces drawn with a coarser level of detail."),
        all("conversions", counters.conversions, "Pictures that came from the device in the layout readers take.")};
}

/// Then the other desks have their turn.
constexpr int max_commands_a_turn = 64;

}  // namespace

Rig::Rig(const EngineOptions& options, std::vector<std::unique_ptr<DrawLane>> lanes,
         std::shared_ptr<DrawnTasks> finished, stream::LocalFrameBus& bus, std::function<void()> wake)
    : state_(options, bus, std::move(wake)),
      world_(state_),
      cameras_(state_, world_),
      faults_(state_, world_),
      replicas_(state_, world_),
      requests_(state_, cameras_),
      instants_(state_, world_, requests_) {
    state_.drawing = std::make_unique<DrawDesk>(
        std::move(lanes), std::move(finished),
        DrawDesk::Callbacks{.drawn = [this](DrawnViews& drawn) { instants_.drawn(drawn); },
                            .dropped = [this](const DueViews& due, const render::View& view,
                                              stream::DropReason reason) { instants_.dropped(due, view, reason); },
                            .next_request = [this] { return requests_.next(); }});
}

Rig::~Rig() {
    state_.agenda.refuse_all({ErrorKind::unavailable, "the rig shuts down"});
}

Result<std::unique_ptr<Rig>> Rig::create(world::SceneRef scene, const EngineOptions& options,
                                         std::vector<std::unique_ptr<DrawLane>> lanes,
                                         std::shared_ptr<DrawnTasks> finished, stream::LocalFrameBus& bus,
                                         std::function<void()> wake) {
    std::unique_ptr<Rig> rig(new Rig(options, std::move(lanes), std::move(finished), bus, std::move(wake)));
    rig->thread_.check();
    rig->state_.agenda.set_limit(options.limit_ns);
    if (auto loaded = rig->load(std::move(scene)); !loaded) return std::unexpected(loaded.error());
    rig->cameras_.show_all();
    rig->state_.drawing->finish();
    if (options.mode == RunMode::realtime) rig->state_.clock.run(0, monotonic_now_ns());
    return rig;
}

TimeNs Rig::wake_time_ns() const {
    if (state_.drawing->has_finished()) return 0;
    if (!state_.agenda.empty() && instants_.has_reached(state_.agenda.next_ns(), monotonic_now_ns())) return 0;
    return std::min({instants_.wake_time_ns(), requests_.wake_time_ns(), world_.next_deadline_ns()});
}

void Rig::tick(TimeNs monotonic_ns) {
    thread_.check();
    state_.drawing->take_finished();
    instants_.turn(monotonic_ns);
    do_what_has_its_time(monotonic_ns);
    requests_.turn(monotonic_ns);
    state_.drawing->dispatch(monotonic_ns);
    world_.answer_waits(monotonic_ns);
}

template <typename C>
bool Rig::admit(Request<C>& request, Command& command) {
    const auto refuse = [&](ErrorKind kind, std::string message) {
        request.done(error(kind, std::move(message)));
        return false;
    };
    if (state_.options.journal && Logged<C> && !request.text)
        return refuse(ErrorKind::unsupported,
                      "this rig keeps a log of commands, which has those of JSON-RPC only (control socket, TCP, POST "
                      "/rpc); send it there");
    if (!request.at_ns) {
        constexpr bool moves_clock = std::same_as<C, StepWorld>;
        if (state_.options.is_held && Logged<C> && !moves_clock)
            return refuse(ErrorKind::unavailable,
                          "this world is held, so that it is the same on every machine: a command needs a world time "
                          "at_ns; send it to what holds it (camrig farm)");
        return true;
    }
    const TimeNs at_ns = *request.at_ns, now_ns = state_.world_now_ns(monotonic_now_ns());
    if (at_ns < std::max(now_ns, state_.done_ns))
        return refuse(ErrorKind::invalid_argument, "at_ns: " + std::to_string(at_ns) + " is past; world time is " +
                                                       std::to_string(std::max(now_ns, state_.done_ns)) + " ns");
    if (at_ns > now_ns + Agenda::max_ahead_ns)
        return refuse(ErrorKind::invalid_argument,
                      "at_ns: more than an hour ahead; world time is " + std::to_string(now_ns) + " ns");
    const auto done = request.done;
    if (auto added = state_.agenda.add(at_ns, command); !added) done(std::unexpected(added.error()));
    return false;
}

void Rig::apply(Command& command) {
    thread_.check();
    if (std::visit([&](auto& request) { return admit(request, command); }, command)) perform(command);
}

TimeNs Rig::time_of_command() const {
    const TimeNs now_ns = state_.world_now_ns(monotonic_now_ns()), last_ns = state_.world->last_step_ns();
    return now_ns <= last_ns - state_.scene->step_ns ? last_ns - state_.scene->step_ns + 1 : now_ns;
}

void Rig::note(TimeNs at_ns, const std::string& text, bool has_failed) {
    state_.agenda.note(at_ns, text);
    if (state_.options.journal) state_.options.journal->note(at_ns, text, has_failed);
}

void Rig::perform(Command& command) {
    const auto perform_one = [this]<typename C>(Request<C>& request) {
        TimeNs at_ns = 0;
        if constexpr (Logged<C>) {
            at_ns = request.at_ns.value_or(request.text ? time_of_command() : 0);
            if (request.at_ns || request.text) state_.command_ns = at_ns;
        } else if (request.at_ns) {
            state_.command_ns = request.at_ns;
        }
        const auto answer = [&](auto result) {
            state_.command_ns.reset();
            if constexpr (Logged<C>) {
                if constexpr (!std::same_as<C, LoadWorld>) state_.done_ns = std::max(state_.done_ns, at_ns);
                const bool has_failed = !result.has_value();
                if (request.text && (!has_failed || std::same_as<C, Act>)) note(at_ns, *request.text, has_failed);
            }
            request.done(std::move(result));
        };
        if constexpr (std::is_same_v<C, StepWorld>) {
            state_.command_ns.reset();
            if (instants_.start_step(request, [this] { return world_state(); }) && request.text &&
                state_.options.journal)
                state_.options.journal->note(at_ns, *request.text, false);
        } else if constexpr (std::is_same_v<C, WaitEvents>) {
            world_.wait_events(request);
        } else if constexpr (std::is_same_v<C, GetTruth>) {
            requests_.get_truth(request);
        } else if constexpr (requires { cameras_.run(request.command); }) {
            answer(cameras_.run(request.command));
        } else if constexpr (requires { faults_.run(request.command); }) {
            answer(faults_.run(request.command));
        } else if constexpr (requires { replicas_.run(request.command); }) {
            answer(replicas_.run(request.command));
        } else if constexpr (requires { world_.run(request.command); }) {
            answer(world_.run(request.command));
        } else {
            answer(run(request.command));
        }
    };
    std::visit(perform_one, command);
}

void Rig::do_what_has_its_time(TimeNs monotonic_ns) {
    Agenda& agenda = state_.agenda;
    for (int i = 0; i < max_commands_a_turn && !agenda.empty(); ++i) {
        const TimeNs at_ns = agenda.next_ns();
        if (!instants_.has_reached(at_ns, monotonic_ns)) return;
        if (!state_.clock.running()) state_.clock.hold(std::max(at_ns, state_.clock.world_at(0)));
        Command command = agenda.take();
        perform(command);
    }
}

void Rig::fetch(stream::FetchRequest request, std::function<void(Result<stream::MediaUnit>)> done) {
    thread_.check();
    requests_.fetch(std::move(request), std::move(done));
}

Result<WorldState> Rig::run(LoadWorld& command) {
    if (instants_.has_steps()) return error(ErrorKind::unavailable, "a step is in progress; load when it has answered");
    if (auto loaded = load(command.scene); !loaded) return std::unexpected(loaded.error());
    WorldState state = world_state();
    state.applied_ns = 0;
    return state;
}

Result<void> Rig::load(world::SceneRef scene) {
    const std::uint64_t seed = state_.options.seed.value_or(scene->seed);
    auto world = world::World::create(scene, seed);
    if (!world) return std::unexpected(world.error());
    if (auto added = cameras_.add_cameras_of(*scene); !added) return std::unexpected(added.error());

    // From here on nothing can fail. What was due of the old world goes out first.
    state_.drawing->finish();
    const bool runs = state_.clock.running();
    state_.world = std::move(*world);
    state_.scene = std::move(scene);
    state_.seed = seed;
    world_.begin_world();
    instants_.begin_world();
    state_.clock.hold(0);
    state_.command_ns.reset();
    if (state_.agenda.limit_ns() != max_time_ns) state_.agenda.set_limit(0);
    state_.done_ns = 0;
    state_.held_until_ns = -1;
    state_.agenda.refuse_all({ErrorKind::unavailable, "at_ns: another world was loaded before that time"});
    state_.drawing->begin_world(state_.world->snapshot(0));
    cameras_.begin_world();
    state_.drawing->finish();
    if (runs) state_.clock.run(0, monotonic_now_ns());
    return {};
}

Result<WorldState> Rig::run(GetWorld&) {
    return world_state();
}

Result<std::shared_ptr<const HeldInstant>> Rig::run(GetInstant&) {
    const world::World& world = world_.world_of_now();
    auto instant = std::make_shared<HeldInstant>();
    instant->snapshot = world.snapshot(world.last_step_ns());
    instant->stands_still = !state_.clock.running();
    instant->monotonic_ns =
        instant->stands_still ? monotonic_now_ns() : state_.clock.monotonic_at(instant->snapshot->world_ns);
    instant->sequence = --last_held_;
    instant->scene = state_.scene;
    instant->mode = state_.options.mode;
    return instant;
}

Result<WorldState> Rig::run(PauseWorld&) {
    if (state_.options.mode == RunMode::lockstep)
        return error(ErrorKind::unsupported,
                     "in lockstep the world moves by world.step only; there is nothing to pause");
    state_.drawing->finish();  // no picture comes after the answer
    WorldClock& clock = state_.clock;
    // An instant that is due and has not begun is still to come.
    if (clock.running())
        clock.hold(std::min(state_.world_now_ns(monotonic_now_ns()), state_.schedule.next_due_ns() - 1));
    return world_state();
}

Result<WorldState> Rig::run(ResumeWorld&) {
    if (state_.options.mode == RunMode::lockstep)
        return error(ErrorKind::unsupported,
                     "in lockstep the world moves by world.step only; start with --mode realtime to let it run");
    if (instants_.has_steps())
        return error(ErrorKind::unavailable, "a step is in progress; resume when it has answered");
    WorldClock& clock = state_.clock;
    if (!clock.running()) clock.run(clock.world_at(0), monotonic_now_ns());
    return world_state();
}

WorldState Rig::world_state() const {
    const world::Scene& scene = *state_.scene;
    WorldState state;
    state.scene = scene.name;
    state.scene_file = scene.file.string();
    state.mode = state_.options.mode;
    state.overload = state_.options.overload;
    state.quality = state_.options.quality;
    state.paused = state.mode == RunMode::realtime && !state_.clock.running();
    state.world_ns = state_.world_now_ns(monotonic_now_ns());
    state.step_ns = scene.step_ns;
    state.seed = state_.seed;
    state.objects = state_.world->object_count();
    state.actors = state_.world->actor_count();
    state.state = state_.world->state_hash();
    state.cameras = state_.cameras.size();
    for (const auto& [name, place] : scene.places) state.places.push_back(name);
    state.applied_ns = state.world_ns;
    return state;
}

Result<stream::RigReport> Rig::run(GetStats&) {
    stream::RigReport report;
    report.monotonic_ns = monotonic_now_ns();
    report.world_ns = state_.world_now_ns(report.monotonic_ns);
    for (const auto& [id, entry] : state_.cameras.all()) {
        const auto dropped = std::accumulate(entry.dropped.begin(), entry.dropped.end(), std::uint64_t{0});
        report.cameras.push_back({*entry.name, entry.due, entry.rendered, dropped, entry.idle, entry.dropped, {}});
    }
    instants_.fill_report(report);
    report.stages.push_back({"draw", state_.drawing->timer()->summary()});
    report.stages.push_back({"publish", state_.publish_time.summary()});
    report.stages.push_back({"truth", requests_.truth_time().summary()});
    report.renderer = reports_of(state_.drawing->counters());
    state_.bus.fill_report(report);
    return report;
}

}  // namespace camrig::engine

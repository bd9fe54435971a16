#include <algorithm>
#include <array>
#include <tuple>
#include <type_traits>

#include "core/base/clock.h"
#include "core/engine/rig.h"

// What each command does. A command that fails changes nothing.
namespace camrig {
namespace {

constexpr std::size_t max_queued_steps = 64;

CameraStream stream_of(const CameraEntry& entry) {
    return {entry.id, *entry.name, entry.spec->size, entry.spec->rate, entry.spec->outputs};
}

std::vector<CounterReport> reports_of(const RenderCounters& counters) {
    const auto now = [](std::string_view name, auto value, std::string_view help) {
        return CounterReport{name, false, static_cast<std::uint64_t>(value), help};
    };
    const auto all = [](std::string_view name, std::uint64_t value, std::string_view help) {
        return CounterReport{name, true, value, help};
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

}  // namespace

void Rig::apply(Command& command) {
    thread_.check();
    std::visit(
        [this](auto& request) {
            if constexpr (std::is_same_v<std::decay_t<decltype(request)>, Request<StepWorld>>) {
                start_step(request);
            } else if constexpr (std::is_same_v<std::decay_t<decltype(request)>, Request<WaitEvents>>) {
                wait_events(request);
            } else if constexpr (std::is_same_v<std::decay_t<decltype(request)>, Request<GetTruth>>) {
                get_truth(request);
            } else {
                request.done(run(request.command));
            }
        },
        command);
}

Result<CameraState> Rig::run(CreateCamera& command) {
    CameraSpec base;
    base.name = command.name;
    CameraPatch patch = command.patch;
    if (command.place) {
        const auto found = scene_->places.find(*command.place);
        if (found == scene_->places.end()) {
            std::string names;
            for (const auto& [name, place] : scene_->places) names += (names.empty() ? "" : ", ") + name;
            return error(ErrorKind::not_found, "place: the scene has no place '" + command.place->substr(0, 60) +
                                                   "'; " + (names.empty() ? "it has none" : "it has: " + names));
        }
        if (!patch.pose) patch.pose = found->second.pose;
        if (!patch.optics) patch.optics = VerticalFov{found->second.vfov_rad};
    }
    if (auto good = check_mount(patch); !good) return std::unexpected(good.error());
    auto spec = patch_camera_spec(base, patch);
    if (!spec) return std::unexpected(spec.error());
    if (auto good = check_new_outputs(*spec, {}); !good) return std::unexpected(good.error());
    auto entry = add_camera(std::move(*spec));
    if (!entry) return std::unexpected(entry.error());
    CameraState state = state_of(**entry);
    state.applied_ns = (*entry)->latest.world_ns;
    return state;
}

Result<CameraEntry*> Rig::add_camera(CameraSpec spec) {
    if (auto good = check_outputs(spec); !good) return std::unexpected(good.error());
    auto entry = cameras_.add(std::move(spec));
    if (entry) start_camera(**entry);
    return entry;
}

void Rig::start_camera(CameraEntry& entry) {
    // Its first picture shows the moment it was made, with the number just before that of its next grid point: at world
    // time 0 that is frame 0 itself.
    const TimeNs now_ns = world_now_ns(monotonic_now_ns());
    const Rate& rate = entry.spec->rate;
    const std::int64_t next = rate.first_frame_at_or_after(now_ns + 1);
    schedule_.set(entry.id, rate, now_ns, next);
    renew_latest(entry, next - 1);
    bus_.add_camera(stream_of(entry));
}

Result<void> Rig::check_mount(const CameraPatch& patch) {
    if (!patch.mount || !*patch.mount) return {};
    return world_of_now().check_mount(**patch.mount, "mount");
}

Result<void> Rig::check_outputs(const CameraSpec& spec) {
    for (const OutputSpec& output : spec.outputs) {
        if (std::ranges::find(options_.output_kinds, output.kind) == options_.output_kinds.end()) {
            std::string kinds;
            for (const auto& kind : options_.output_kinds) kinds += (kinds.empty() ? "" : ", ") + kind;
            return error(ErrorKind::unsupported, "outputs: this rig has no '" + output.kind + "'; it has: " + kinds);
        }
        if (!output.number) continue;
        for (const auto& [id, entry] : cameras_.all()) {
            if (*entry.name == spec.name) continue;
            for (const OutputSpec& taken : entry.spec->outputs) {
                if (taken.kind != output.kind || taken.number != output.number) continue;
                return error(ErrorKind::already_exists, "outputs: " + output.kind + " number " +
                                                            std::to_string(*output.number) + " belongs to camera " +
                                                            *entry.name + "; choose another");
            }
        }
    }
    return {};
}

Result<void> Rig::check_new_outputs(const CameraSpec& spec, const std::vector<OutputSpec>& present) {
    if (!options_.check_output) return {};
    for (const OutputSpec& output : spec.outputs) {
        const bool is_there = std::ranges::any_of(
            present, [&](const OutputSpec& one) { return one.kind == output.kind && one.number == output.number; });
        if (is_there) continue;
        if (auto good = options_.check_output(spec.name, output); !good) return at("outputs", good.error());
    }
    return {};
}

void Rig::renew_latest(CameraEntry& entry, std::int64_t sequence) {
    TimeNs monotonic_ns = monotonic_now_ns();
    const TimeNs now_ns = world_now_ns(monotonic_ns);
    if (clock_.running()) monotonic_ns = clock_.monotonic_at(now_ns);
    world_->advance_to(now_ns);
    SnapshotRef snapshot = world_->snapshot(now_ns);
    const Pose pose = pose_at(entry, *snapshot);
    entry.latest = {entry.spec, entry.spec_revision, sequence, now_ns, monotonic_ns, std::move(snapshot), pose, {}};
}

void Rig::show_latest(CameraEntry& entry) {
    const PixelFormats wanted = bus_.wanted(entry.id, entry.latest.world_ns);
    View view = view_of(entry, entry.latest);
    if (!wanted.empty()) view.color_formats = made_of(view, wanted);
    const FrameSet set = draw(entry.latest.snapshot, entry.latest.monotonic_ns, std::array{view});
    entry.latest.colors = set.frames;
    publish(set, nullptr);
}

Result<CameraState> Rig::run(SetCamera& command) {
    auto found = cameras_.find(command.name);
    if (!found) return std::unexpected(found.error());
    const std::shared_ptr<const CameraSpec> old = (*found)->spec;
    if (auto good = check_mount(command.patch); !good) return std::unexpected(good.error());
    auto spec = patch_camera_spec(*old, command.patch);
    if (!spec) return std::unexpected(spec.error());
    if (auto good = check_outputs(*spec); !good) return std::unexpected(good.error());
    if (auto good = check_new_outputs(*spec, old->outputs); !good) return std::unexpected(good.error());
    auto replaced = cameras_.replace(command.name, std::move(*spec));
    if (!replaced) return std::unexpected(replaced.error());
    CameraEntry& entry = **replaced;

    const TimeNs now_ns = world_now_ns(monotonic_now_ns());
    if (entry.spec->rate != old->rate)
        schedule_.set(entry.id, entry.spec->rate, now_ns, schedule_.next_sequence(entry.id));
    TimeNs applied_ns = schedule_.next_due_ns(entry.id);
    // Nothing falls due while the world stands still, yet the change must show. In real time it is a frame more. In
    // lockstep readers are sent what is due and nothing else: who asks gets the frame that is there, drawn anew.
    const bool stands_still = !clock_.running() && options_.mode == RunMode::realtime;
    if (!clock_.running()) {
        const std::int64_t next = schedule_.next_sequence(entry.id);
        if (stands_still) schedule_.set(entry.id, entry.spec->rate, now_ns, next + 1);
        renew_latest(entry, stands_still ? next : entry.latest.sequence);
        applied_ns = entry.latest.world_ns;
    }
    if (entry.spec->size != old->size || entry.spec->rate != old->rate || entry.spec->outputs != old->outputs)
        bus_.change_camera(stream_of(entry));
    bus_.adjust_camera(stream_of(entry));
    if (stands_still && !bus_.wanted(entry.id, entry.latest.world_ns).empty()) show_latest(entry);
    CameraState state = state_of(entry);
    state.applied_ns = applied_ns;
    return state;
}

Result<Applied> Rig::run(DeleteCamera& command) {
    auto removed = cameras_.remove(command.name);
    if (!removed) return std::unexpected(removed.error());
    const Applied applied{world_now_ns(monotonic_now_ns())};
    schedule_.remove(removed->id);
    bus_.remove_camera(removed->id);
    renderer_->forget(removed->id);
    return applied;
}

Result<CameraState> Rig::run(GetCamera& command) {
    auto found = cameras_.find(command.name);
    if (!found) return std::unexpected(found.error());
    return state_of(**found);
}

Result<std::vector<CameraState>> Rig::run(ListCameras&) {
    std::vector<CameraState> states;
    for (const auto& [id, entry] : cameras_.all()) states.push_back(state_of(entry));
    return states;
}

CameraState Rig::state_of(const CameraEntry& entry) const {
    CameraState state;
    state.id = entry.id;
    state.spec = *entry.spec;
    state.world_pose = entry.spec->mount ? entry.latest.pose : entry.spec->pose;
    state.sequence = entry.latest.sequence;
    state.readers = bus_.reader_count(entry.id);
    state.applied_ns = entry.latest.world_ns;
    return state;
}

Result<WorldState> Rig::run(LoadWorld& command) {
    finish_turns();
    if (!steps_.empty()) return error(ErrorKind::unavailable, "a step is in progress; load when it has answered");
    if (auto loaded = load(command.scene); !loaded) return std::unexpected(loaded.error());
    WorldState state = world_state();
    state.applied_ns = 0;
    return state;
}

Result<void> Rig::load(SceneRef scene) {
    const std::uint64_t seed = options_.seed.value_or(scene->seed);
    auto world = World::create(scene, seed);
    if (!world) return std::unexpected(world.error());
    std::vector<CameraEntry*> added;
    for (const CameraSpec& spec : scene->cameras) {
        if (cameras_.find(spec.name)) continue;
        const auto good = check_outputs(spec);
        const auto entry = good ? cameras_.add(spec) : Result<CameraEntry*>(std::unexpected(good.error()));
        if (!entry) {
            for (const CameraEntry* camera : added) std::ignore = cameras_.remove(std::string(*camera->name));
            return at(scene->file.string() + ": camera " + spec.name, entry.error());
        }
        added.push_back(*entry);
    }

    // From here on nothing can fail.
    const bool runs = clock_.running();
    world_ = std::move(*world);
    is_world_behind_ = false;
    chosen_late_ns_.reset();
    camera_moves_.clear();
    event_base_ = last_event_;
    collect_world();
    scene_ = std::move(scene);
    seed_ = seed;
    // World time starts again at 0; cameras stay, and their sequence numbers go on. Readers are shown the new world at
    // once: that pays for its textures while the clock does not run yet, so it costs no frames.
    clock_.hold(0);
    std::vector<CameraEntry*> stayed;
    for (auto& [id, entry] : cameras_.all()) {
        if (std::ranges::find(added, &entry) != added.end()) continue;
        schedule_.set(id, entry.spec->rate, 0, schedule_.next_sequence(id) + 1);
        stayed.push_back(&entry);
    }
    for (CameraEntry* entry : stayed) {
        renew_latest(*entry, schedule_.next_sequence(entry->id) - 1);
        if (!bus_.wanted(entry->id, 0).empty()) show_latest(*entry);
    }
    for (CameraEntry* entry : added) start_camera(*entry);
    if (runs) clock_.run(0, monotonic_now_ns());
    return {};
}

Result<WorldState> Rig::run(GetWorld&) {
    return world_state();
}

Result<WorldState> Rig::run(PauseWorld&) {
    if (options_.mode == RunMode::lockstep)
        return error(ErrorKind::unsupported,
                     "in lockstep the world moves by world.step only; there is nothing to pause");
    finish_turns();  // no picture comes after the answer
    // An instant that is due and not drawn yet is still to come.
    if (clock_.running()) clock_.hold(std::min(world_now_ns(monotonic_now_ns()), schedule_.next_due_ns() - 1));
    return world_state();
}

Result<WorldState> Rig::run(ResumeWorld&) {
    if (options_.mode == RunMode::lockstep)
        return error(ErrorKind::unsupported,
                     "in lockstep the world moves by world.step only; start with --mode realtime to let it run");
    if (!steps_.empty()) return error(ErrorKind::unavailable, "a step is in progress; resume when it has answered");
    if (!clock_.running()) clock_.run(clock_.world_at(0), monotonic_now_ns());
    return world_state();
}

void Rig::start_step(Request<StepWorld>& request) {
    if (clock_.running()) {
        return request.done(error(ErrorKind::unavailable,
                                  "the world runs in real time; pause it first, or start with --mode lockstep"));
    }
    if (steps_.size() >= max_queued_steps)
        return request.done(
            error(ErrorKind::resource_exhausted, std::to_string(max_queued_steps) + " steps are waiting; send slower"));
    const StepWorld& step = request.command;
    const TimeNs from_ns = steps_.empty() ? clock_.world_at(0) : steps_.back().target_ns;
    if (step.duration_ns < 0 || step.duration_ns > max_time_ns - from_ns)
        return request.done(error(ErrorKind::invalid_argument, "a step must be from 0 ns and end before 146 years"));
    StepJob job;
    job.target_ns = from_ns + step.duration_ns;
    job.timeout_ns = step.timeout_ns;
    job.done = std::move(request.done);
    steps_.push_back(std::move(job));
    wake_();
}

WorldState Rig::world_state() const {
    WorldState state;
    state.scene = scene_->name;
    state.scene_file = scene_->file.string();
    state.mode = options_.mode;
    state.overload = options_.overload;
    state.quality = options_.quality;
    state.paused = options_.mode == RunMode::realtime && !clock_.running();
    state.world_ns = world_now_ns(monotonic_now_ns());
    state.step_ns = scene_->step_ns;
    state.seed = seed_;
    state.objects = world_->object_count();
    state.actors = world_->actor_count();
    state.state = world_->state_hash();
    state.cameras = cameras_.size();
    for (const auto& [name, place] : scene_->places) state.places.push_back(name);
    state.applied_ns = state.world_ns;
    return state;
}

Result<RigReport> Rig::run(GetStats&) {
    RigReport report;
    report.monotonic_ns = monotonic_now_ns();
    report.world_ns = world_now_ns(report.monotonic_ns);
    report.instants = instants_;
    report.dropped_instants = dropped_instants_;
    for (const auto& [id, entry] : cameras_.all())
        report.cameras.push_back({*entry.name, entry.due, entry.rendered, entry.dropped, entry.idle, {}});
    report.stages = {{"wakeup", wakeup_.summary()},   {"world", world_time_.summary()}, {"submit", submit_.summary()},
                     {"collect", collect_.summary()}, {"publish", publish_.summary()},  {"truth", truth_.summary()}};
    report.renderer = reports_of(renderer_->counters());
    bus_.fill_report(report);
    return report;
}

}  // namespace camrig

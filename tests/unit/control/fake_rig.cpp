#include "tests/unit/control/fake_rig.h"

#include <type_traits>

namespace camrig::control {
namespace {

/// What its cameras' clocks say: replies have all their fields.
constexpr ClockReading clock_that_lies{.stamp_error_ns = -7'000, .steady_error_ns = 500};

}  // namespace

void FakeRig::post(engine::Command command) {
    if (drops_) return;
    std::visit(
        [this](auto& request) {
            using Kind = std::decay_t<decltype(request.command)>;
            {
                std::lock_guard lock(mutex_);
                if (std::is_same_v<Kind, engine::StepWorld> && holds_) {
                    held_.push_back([this, request]() mutable { request.done(run(request.command)); });
                    return;
                }
            }
            request.done(run(request.command));
        },
        command);
}

void FakeRig::hold_steps() {
    std::lock_guard lock(mutex_);
    holds_ = true;
}

void FakeRig::release() {
    std::vector<std::function<void()>> held;
    {
        std::lock_guard lock(mutex_);
        holds_ = false;
        held.swap(held_);
    }
    for (auto& job : held) job();
}

std::size_t FakeRig::held() const {
    std::lock_guard lock(mutex_);
    return held_.size();
}

void FakeRig::set_picture(std::vector<std::byte> picture) {
    std::lock_guard lock(mutex_);
    picture_ = std::move(picture);
}

stream::FetchRequest FakeRig::last_fetch() const {
    std::lock_guard lock(mutex_);
    return last_fetch_;
}

Result<engine::CameraReply> FakeRig::find(const std::string& name) const {
    const auto found = cameras_.find(name);
    if (found == cameras_.end()) return error(ErrorKind::not_found, "there is no camera '" + name + "'");
    return found->second;
}

Result<engine::CameraReply> FakeRig::run(engine::CreateCamera& command) {
    std::lock_guard lock(mutex_);
    if (cameras_.contains(command.name))
        return error(ErrorKind::already_exists, "there is a camera '" + command.name + "'");
    if (command.place && *command.place != "door")
        return error(ErrorKind::not_found, "place: the scene has none of that name");
    world::CameraSpec base;
    base.name = command.name;
    auto camera = world::Camera(base).changed(command.patch, 0, 0);
    if (!camera) return std::unexpected(camera.error());
    engine::CameraReply state;
    state.id = CameraId{static_cast<std::uint32_t>(cameras_.size() + 1)};
    state.camera = std::move(*camera);
    state.now.pose = state.camera.spec()->pose;
    state.sequence = 0;
    state.applied_ns = world_.world_ns;
    return cameras_[command.name] = state;
}

Result<engine::CameraReply> FakeRig::run(engine::SetCamera& command) {
    std::lock_guard lock(mutex_);
    auto state = find(command.name);
    if (!state) return state;
    auto camera = state->camera.changed(command.patch, 0, command.duration_ns);
    if (!camera) return std::unexpected(camera.error());
    state->camera = std::move(*camera);
    state->now.pose = state->camera.spec()->pose;
    return cameras_[command.name] = *state;
}

Result<engine::Applied> FakeRig::run(engine::DeleteCamera& command) {
    std::lock_guard lock(mutex_);
    if (cameras_.erase(command.name) == 0)
        return error(ErrorKind::not_found, "there is no camera '" + command.name + "'");
    return engine::Applied{world_.world_ns};
}

Result<engine::CameraReply> FakeRig::run(engine::GetCamera& command) {
    std::lock_guard lock(mutex_);
    return find(command.name);
}

Result<std::vector<engine::CameraReply>> FakeRig::run(engine::ListCameras&) {
    std::lock_guard lock(mutex_);
    std::vector<engine::CameraReply> all;
    for (const auto& [name, state] : cameras_) all.push_back(state);
    return all;
}

Result<engine::PtzReply> FakeRig::tell_head(const std::string& name,
                                            const std::function<Result<void>(camera::PtzHead&)>& tell) {
    std::lock_guard lock(mutex_);
    auto state = find(name);
    if (!state) return std::unexpected(state.error());
    auto camera = state->camera.with_head(tell);
    if (!camera) return std::unexpected(camera.error());
    cameras_[name].camera = *camera;
    const camera::PtzHead& head = **camera->head();
    return engine::PtzReply{
        head.status(world_.world_ns), 0, head.arrives_ns(), head.presets(), 0, head.tours(), head.tour()};
}

Result<engine::PtzReply> FakeRig::run(engine::MovePtz& command) {
    return tell_head(command.camera, [&](camera::PtzHead& head) {
        camera::PtzMove move = command.move;
        if (move.mode == camera::PtzMode::fov) move.pan_deg = move.x, move.tilt_deg = move.y;  // a lens of its own
        return head.move(move, 0);
    });
}

Result<engine::PtzReply> FakeRig::run(engine::PtzPresets& command) {
    return tell_head(command.camera, [&](camera::PtzHead& head) -> Result<void> {
        using enum engine::PtzPresets::Action;
        switch (command.action) {
            case go_to:
                return head.go_to_preset(command.preset, command.speed, 0);
            case remove:
                return head.remove_preset(command.preset);
            case go_home:
                return head.go_home(command.speed, 0);
            case set_home:
                return head.set_home(0), Result<void>();
            case add:
                if (head.presets().contains(command.preset))
                    return error(ErrorKind::already_exists, "there is a preset '" + command.preset + "'");
                [[fallthrough]];
            case set:
                return head.set_preset(command.preset, 0);
        }
        return {};
    });
}

Result<engine::PtzReply> FakeRig::run(engine::PtzTours& command) {
    return tell_head(command.camera, [&](camera::PtzHead& head) -> Result<void> {
        if (command.action != engine::PtzTours::Action::set) return {};
        for (const camera::PtzTourStop& stop : command.stops)
            if (auto good = head.set_preset(stop.preset, 0); !good) return good;
        return head.set_tour(command.tour, command.stops);
    });
}

Result<engine::PtzReply> FakeRig::run(engine::StopPtz& command) {
    return tell_head(command.camera, [&](camera::PtzHead& head) -> Result<void> {
        return head.stop(command.pan_tilt, command.zoom, 0);
    });
}

Result<engine::FaultReply> FakeRig::run(engine::SetFault& command) {
    const auto found = cameras_.find(command.camera);
    if (found == cameras_.end()) return error(ErrorKind::not_found, "no camera '" + command.camera + "'");
    auto fault = found->second.camera.faults().set(command.fault, ++faults_, 0, 0);
    if (!fault) return std::unexpected(fault.error());
    return engine::FaultReply{command.camera, *fault, 0};
}

Result<engine::ClearFaults::Reply> FakeRig::run(engine::ClearFaults& command) {
    engine::ClearFaults::Reply reply;
    for (auto& [name, camera] : cameras_)
        reply.cleared += camera.camera.faults().clear(
            0, [&](const fault::Fault& one) { return !command.id || *command.id == one.id; });
    return reply;
}

Result<engine::ListFaults::Reply> FakeRig::run(engine::ListFaults&) {
    engine::ListFaults::Reply reply;
    for (const auto& [name, camera] : cameras_)
        for (auto& one : camera.camera.faults().present(0)) reply.faults.push_back({name, one, 0});
    return reply;
}

Result<engine::GetReaderLog::Reply> FakeRig::run(engine::GetReaderLog& command) {
    stream::ReaderLog log;
    log.add({.kind = stream::ReaderEventKind::refused, .camera = "lobby", .output = "rtsp", .peer = "127.0.0.1"});
    return log.since(command.since, command.camera);
}

Result<engine::PtzReply> FakeRig::run(engine::GetPtz& command) {
    return tell_head(command.camera, [](camera::PtzHead&) -> Result<void> { return {}; });
}

Result<engine::WorldState> FakeRig::run(engine::LoadWorld& command) {
    std::lock_guard lock(mutex_);
    world_.scene = command.scene->name;
    world_.scene_file = command.scene->file.string();
    world_.world_ns = 0;
    return world_;
}

Result<engine::WorldState> FakeRig::run(engine::GetWorld&) {
    std::lock_guard lock(mutex_);
    return world_;
}

Result<engine::WorldState> FakeRig::run(engine::PauseWorld&) {
    std::lock_guard lock(mutex_);
    world_.paused = true;
    return world_;
}

Result<engine::WorldState> FakeRig::run(engine::ResumeWorld&) {
    std::lock_guard lock(mutex_);
    world_.paused = false;
    return world_;
}

Result<engine::WorldState> FakeRig::run(engine::StepWorld& command) {
    std::lock_guard lock(mutex_);
    last_step_ns_ = command.duration_ns;
    world_.world_ns += command.duration_ns;
    world_.applied_ns = world_.world_ns;
    return world_;
}

Result<engine::ActorList> FakeRig::run(engine::ListActors&) {
    world::ActorReport anna;
    anna.name = "anna";
    return engine::ActorList{{anna}, {10, 0xab}};
}

Result<engine::ActorChange> FakeRig::run(engine::SpawnActor& command) {
    if (command.actor.name == "anna") return error(ErrorKind::already_exists, "name: 'anna' is taken");
    world::ActorReport report;
    report.name = command.actor.name;
    report.object_class = command.actor.object_class;
    report.scale = command.actor.scale;
    report.position = command.actor.position;
    report.behaviour = type_name(command.actor.behaviour);
    return engine::ActorChange{report, 10};
}

Result<engine::Applied> FakeRig::run(engine::RemoveActor& command) {
    if (command.name != "anna") return error(ErrorKind::not_found, "name: there is no actor '" + command.name + "'");
    return engine::Applied{10};
}

Result<engine::ActorChange> FakeRig::run(engine::SetActor& command) {
    world::ActorReport report;
    report.name = command.patch.name;
    return engine::ActorChange{report, 10};
}

Result<engine::Applied> FakeRig::run(engine::SteerActors&) {
    return engine::Applied{10};
}

Result<std::shared_ptr<const engine::HeldInstant>> FakeRig::run(engine::GetInstant&) {
    auto info = std::make_shared<world::ObjectInfo>();
    info->id = ObjectId{7};
    info->name = "table";
    info->object_class = "furniture";
    info->model = std::make_shared<const world::Model>();
    auto statics = std::make_shared<world::StaticSet>();
    statics->objects.emplace_back().info = std::move(info);
    auto snapshot = std::make_shared<world::Snapshot>();
    snapshot->world_ns = 10;
    snapshot->statics = std::move(statics);
    auto instant = std::make_shared<engine::HeldInstant>();
    instant->snapshot = std::move(snapshot);
    return instant;
}

Result<engine::ObjectChange> FakeRig::run(engine::SpawnObject& command) {
    world::ObjectReport report;
    report.name = command.object.name;
    report.model = command.object.model;
    return engine::ObjectChange{report, 10};
}

Result<engine::ObjectChange> FakeRig::run(engine::SetObject& command) {
    if (command.patch.name != "table")
        return error(ErrorKind::not_found, "name: there is no object '" + command.patch.name + "'");
    world::ObjectReport report;
    report.name = command.patch.name;
    report.hidden = command.patch.hidden.value_or(false);
    return engine::ObjectChange{report, 10};
}

Result<engine::Applied> FakeRig::run(engine::RemoveObject&) {
    return engine::Applied{10};
}

Result<std::vector<world::EventReport>> FakeRig::run(engine::ListEvents&) {
    return std::vector<world::EventReport>{{"alarm", "every_s", 2, 0}};
}

Result<engine::EventChange> FakeRig::run(engine::AddEvent& command) {
    return engine::EventChange{{command.event.name, std::string(type_name(command.event.when)), 0, command.event.limit},
                               10};
}

Result<engine::Applied> FakeRig::run(engine::Act& command) {
    if (command.actions.empty()) return error(ErrorKind::invalid_argument, "do: is empty");
    return engine::Applied{10};
}

Result<engine::Applied> FakeRig::run(engine::RemoveEvent&) {
    return engine::Applied{10};
}

Result<engine::EventLog> FakeRig::run(engine::WaitEvents& command) {
    world::EventRecord record;
    record.sequence = command.since + 1;
    record.event = "alarm";
    record.data = {"{\"level\":2}"};
    return engine::EventLog{{record}, command.since + 1, 0};
}

Result<engine::SetLimit::Reply> FakeRig::run(engine::SetLimit& command) {
    return engine::SetLimit::Reply{.world_ns = 3, .limit_ns = command.until_ns.value_or(max_time_ns), .waiting = 2};
}

Result<engine::GetDigest::Reply> FakeRig::run(engine::GetDigest& command) {
    engine::GetDigest::Reply reply;
    reply.world_ns = 3;
    reply.state_ns = 2;
    reply.value = 17;
    reply.command_count = 1;
    if (command.with_parts) reply.parts = {{"camera lobby", 5}};
    return reply;
}

Result<stream::RigReport> FakeRig::run(engine::GetStats&) {
    stream::RigReport report;
    report.instants = 7;
    report.cameras = {{"lobby",
                       10,
                       9,
                       1,
                       5,
                       {1, 0, 0, 0},
                       {{"jpeg q90", 9, 9, 0, 0, {{"mjpeg", "127.0.0.1:5", 9, 8, 1, 1000, 1.5}}}}}};
    report.stages = {{"draw", {9, 1.0, 0.9, 2.0, 2.5, 3.0}}};
    return report;
}

Result<truth::TruthRef> FakeRig::run(engine::GetTruth& command) {
    std::lock_guard lock(mutex_);
    const auto camera = find(command.camera);
    if (!camera) return std::unexpected(camera.error());
    auto truth = std::make_shared<truth::TruthOfFrame>();
    truth->clock = clock_that_lies;
    truth->camera = command.camera;
    truth->sequence = 4;
    truth->world_ns = std::max<TimeNs>(command.min_ns, 160'000'000);
    truth->size = camera->camera.spec()->size;
    truth->intrinsics = camera->camera.spec()->intrinsics;
    truth::ObjectTruth person;
    person.id = ObjectId{3};
    person.object_class = "person";
    person.pixels = 30;
    person.pixels_alone = 40;
    person.box = truth::PixelBox{1, 2, 3, 10};
    person.occluded_by = ObjectId{2};
    truth->objects.push_back(person);
    return truth;
}

void FakeRig::fetch(stream::FetchRequest request, std::function<void(Result<stream::MediaUnit>)> done) {
    std::vector<std::byte> bytes;
    Result<engine::CameraReply> camera = [&] {
        std::lock_guard lock(mutex_);
        bytes = picture_;
        last_fetch_ = request;
        last_fetch_.admit = nullptr;  // it holds what is claimed for the picture
        return find(request.camera);
    }();
    if (!camera) return done(std::unexpected(camera.error()));
    if (misses_.exchange(false)) return done(error(ErrorKind::unavailable, "the world stands still"));
    if (request.kind != frame::FrameKind::color)
        return done(error(ErrorKind::unsupported, "this kind of picture is not made yet; ask for color"));
    if (request.admit)
        if (auto admitted = request.admit(camera->camera.spec()->size); !admitted)
            return done(std::unexpected(admitted.error()));
    ++pictures_;
    stream::MediaUnit unit;
    unit.info.camera = std::make_shared<const std::string>(request.camera);
    unit.info.sequence = 4;
    unit.info.world_ns = 160'000'000;
    unit.info.monotonic_ns = 12'345;
    unit.info.clock = clock_that_lies;
    unit.info.size = camera->camera.spec()->size;
    unit.info.format = request.format.pixels;
    if (request.format.codec == codec::Codec::raw) {
        unit.frame = std::make_shared<const frame::Frame>(unit.info, std::move(bytes));
    } else {
        unit.bytes = std::make_shared<const std::vector<std::byte>>(std::move(bytes));
    }
    done(std::move(unit));
}

}  // namespace camrig::control

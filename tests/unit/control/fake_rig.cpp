#include "tests/unit/control/fake_rig.h"

#include <type_traits>

namespace camrig {

void FakeRig::post(Command command) {
    if (drops_) return;
    std::visit(
        [this](auto& request) {
            using Kind = std::decay_t<decltype(request.command)>;
            {
                std::lock_guard lock(mutex_);
                if (std::is_same_v<Kind, StepWorld> && holds_) {
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

FetchRequest FakeRig::last_fetch() const {
    std::lock_guard lock(mutex_);
    return last_fetch_;
}

Result<CameraReply> FakeRig::find(const std::string& name) const {
    const auto found = cameras_.find(name);
    if (found == cameras_.end()) return error(ErrorKind::not_found, "there is no camera '" + name + "'");
    return found->second;
}

Result<CameraReply> FakeRig::run(CreateCamera& command) {
    std::lock_guard lock(mutex_);
    if (cameras_.contains(command.name))
        return error(ErrorKind::already_exists, "there is a camera '" + command.name + "'");
    if (command.place && *command.place != "door")
        return error(ErrorKind::not_found, "place: the scene has none of that name");
    CameraSpec base;
    base.name = command.name;
    auto camera = Camera(base).changed(command.patch, 0, 0);
    if (!camera) return std::unexpected(camera.error());
    CameraReply state;
    state.id = CameraId{static_cast<std::uint32_t>(cameras_.size() + 1)};
    state.camera = std::move(*camera);
    state.now.pose = state.camera.spec()->pose;
    state.sequence = 0;
    state.applied_ns = world_.world_ns;
    return cameras_[command.name] = state;
}

Result<CameraReply> FakeRig::run(SetCamera& command) {
    std::lock_guard lock(mutex_);
    auto state = find(command.name);
    if (!state) return state;
    auto camera = state->camera.changed(command.patch, 0, command.duration_ns);
    if (!camera) return std::unexpected(camera.error());
    state->camera = std::move(*camera);
    state->now.pose = state->camera.spec()->pose;
    return cameras_[command.name] = *state;
}

Result<Applied> FakeRig::run(DeleteCamera& command) {
    std::lock_guard lock(mutex_);
    if (cameras_.erase(command.name) == 0)
        return error(ErrorKind::not_found, "there is no camera '" + command.name + "'");
    return Applied{world_.world_ns};
}

Result<CameraReply> FakeRig::run(GetCamera& command) {
    std::lock_guard lock(mutex_);
    return find(command.name);
}

Result<std::vector<CameraReply>> FakeRig::run(ListCameras&) {
    std::lock_guard lock(mutex_);
    std::vector<CameraReply> all;
    for (const auto& [name, state] : cameras_) all.push_back(state);
    return all;
}

Result<PtzReply> FakeRig::tell_head(const std::string& name, const std::function<Result<void>(PtzHead&)>& tell) {
    std::lock_guard lock(mutex_);
    auto state = find(name);
    if (!state) return std::unexpected(state.error());
    auto camera = state->camera.with_head(tell);
    if (!camera) return std::unexpected(camera.error());
    cameras_[name].camera = *camera;
    const PtzHead& head = **camera->head();
    return PtzReply{head.status(0), head.at(0), 0, head.arrives_ns(), head.presets()};
}

Result<PtzReply> FakeRig::run(MovePtz& command) {
    return tell_head(command.camera, [&](PtzHead& head) { return head.move(command.move, 0); });
}

Result<PtzReply> FakeRig::run(AimPtz& command) {
    return tell_head(command.camera, [&](PtzHead& head) -> Result<void> {
        return head.aim({command.x, command.y, 1.0}, command.speed, 0);
    });
}

Result<PtzReply> FakeRig::run(PtzPresets& command) {
    return tell_head(command.camera, [&](PtzHead& head) { return head.set_preset(command.preset, 0); });
}

Result<PtzReply> FakeRig::run(StopPtz& command) {
    return tell_head(command.camera,
                     [&](PtzHead& head) -> Result<void> { return head.stop(command.pan_tilt, command.zoom, 0); });
}

Result<PtzReply> FakeRig::run(GetPtz& command) {
    return tell_head(command.camera, [](PtzHead&) -> Result<void> { return {}; });
}

Result<WorldState> FakeRig::run(LoadWorld& command) {
    std::lock_guard lock(mutex_);
    world_.scene = command.scene->name;
    world_.scene_file = command.scene->file.string();
    world_.world_ns = 0;
    return world_;
}

Result<WorldState> FakeRig::run(GetWorld&) {
    std::lock_guard lock(mutex_);
    return world_;
}

Result<WorldState> FakeRig::run(PauseWorld&) {
    std::lock_guard lock(mutex_);
    world_.paused = true;
    return world_;
}

Result<WorldState> FakeRig::run(ResumeWorld&) {
    std::lock_guard lock(mutex_);
    world_.paused = false;
    return world_;
}

Result<WorldState> FakeRig::run(StepWorld& command) {
    std::lock_guard lock(mutex_);
    last_step_ns_ = command.duration_ns;
    world_.world_ns += command.duration_ns;
    world_.applied_ns = world_.world_ns;
    return world_;
}

Result<ActorList> FakeRig::run(ListActors&) {
    ActorReport anna;
    anna.name = "anna";
    return ActorList{{anna}, {10, 0xab}};
}

Result<ActorChange> FakeRig::run(SpawnActor& command) {
    if (command.actor.name == "anna") return error(ErrorKind::already_exists, "name: 'anna' is taken");
    ActorReport report;
    report.name = command.actor.name;
    report.position = command.actor.position;
    report.behaviour = type_name(command.actor.behaviour);
    return ActorChange{report, 10};
}

Result<Applied> FakeRig::run(RemoveActor& command) {
    if (command.name != "anna") return error(ErrorKind::not_found, "name: there is no actor '" + command.name + "'");
    return Applied{10};
}

Result<ActorChange> FakeRig::run(SetActor& command) {
    ActorReport report;
    report.name = command.patch.name;
    return ActorChange{report, 10};
}

Result<Applied> FakeRig::run(SteerActors&) {
    return Applied{10};
}

Result<std::vector<EventReport>> FakeRig::run(ListEvents&) {
    return std::vector<EventReport>{{"alarm", "every_s", 2, 0}};
}

Result<EventChange> FakeRig::run(AddEvent& command) {
    return EventChange{{command.event.name, std::string(type_name(command.event.when)), 0, command.event.limit}, 10};
}

Result<Applied> FakeRig::run(RemoveEvent&) {
    return Applied{10};
}

Result<EventLog> FakeRig::run(WaitEvents& command) {
    EventRecord record;
    record.sequence = command.since + 1;
    record.event = "alarm";
    record.data = {"{\"level\":2}"};
    return EventLog{{record}, command.since + 1, 0};
}

Result<RigReport> FakeRig::run(GetStats&) {
    RigReport report;
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

Result<TruthRef> FakeRig::run(GetTruth& command) {
    std::lock_guard lock(mutex_);
    const auto camera = find(command.camera);
    if (!camera) return std::unexpected(camera.error());
    auto truth = std::make_shared<TruthOfFrame>();
    truth->camera = command.camera;
    truth->sequence = 4;
    truth->world_ns = std::max<TimeNs>(command.min_ns, 160'000'000);
    truth->size = camera->camera.spec()->size;
    truth->intrinsics = camera->camera.spec()->intrinsics;
    ObjectTruth person;
    person.id = ObjectId{3};
    person.object_class = "person";
    person.pixels = 30;
    person.pixels_alone = 40;
    person.box = PixelBox{1, 2, 3, 10};
    person.occluded_by = ObjectId{2};
    truth->objects.push_back(person);
    return truth;
}

void FakeRig::fetch(FetchRequest request, std::function<void(Result<MediaUnit>)> done) {
    Result<CameraReply> camera = [&] {
        std::lock_guard lock(mutex_);
        last_fetch_ = request;
        last_fetch_.admit = nullptr;  // it holds what is claimed for the picture
        return find(request.camera);
    }();
    if (!camera) return done(std::unexpected(camera.error()));
    if (request.kind != FrameKind::color)
        return done(error(ErrorKind::unsupported, "this kind of picture is not made yet; ask for color"));
    if (request.admit)
        if (auto admitted = request.admit(camera->camera.spec()->size); !admitted)
            return done(std::unexpected(admitted.error()));
    ++pictures_;
    MediaUnit unit;
    unit.info.camera = std::make_shared<const std::string>(request.camera);
    unit.info.sequence = 4;
    unit.info.world_ns = 160'000'000;
    unit.info.monotonic_ns = 12'345;
    unit.info.size = camera->camera.spec()->size;
    unit.info.format = request.format.pixels;
    std::vector<std::byte> bytes(picture_bytes_, std::byte{0xab});
    if (request.format.codec == Codec::raw) {
        unit.frame = std::make_shared<const Frame>(unit.info, std::move(bytes));
    } else {
        unit.bytes = std::make_shared<const std::vector<std::byte>>(std::move(bytes));
    }
    done(std::move(unit));
}

}  // namespace camrig

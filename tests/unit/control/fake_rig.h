#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "core/engine/command.h"
#include "core/stream/frame_bus.h"

namespace camrig {

/// A rig in memory: cameras with checked specs, a world that is a number with one actor and one event, pictures that
/// are bytes. Answers at once on the caller's thread, but for steps while they are held. Any thread.
class FakeRig final : public CommandPort, public FrameFetcher {
public:
    void post(Command command) override;
    void fetch(FetchRequest request, std::function<void(Result<MediaUnit>)> done) override;

    /// From now on steps wait; release() answers those that wait.
    void hold_steps();
    void release();
    std::size_t held() const;
    /// Forgets commands instead of answering them: an engine that is going down.
    void drop_commands() { drops_ = true; }

    TimeNs last_step_ns() const { return last_step_ns_; }
    FetchRequest last_fetch() const;
    void set_picture_bytes(std::size_t size) { picture_bytes_ = size; }
    /// How many were drawn.
    int pictures() const { return pictures_; }

private:
    Result<CameraReply> run(CreateCamera& command);
    Result<CameraReply> run(SetCamera& command);
    Result<Applied> run(DeleteCamera& command);
    Result<CameraReply> run(GetCamera& command);
    Result<std::vector<CameraReply>> run(ListCameras&);
    Result<PtzReply> run(MovePtz& command);
    Result<PtzReply> run(AimPtz& command);
    Result<PtzReply> run(PtzPresets& command);
    Result<PtzReply> run(StopPtz& command);
    Result<PtzReply> run(GetPtz& command);
    Result<PtzReply> tell_head(const std::string& name, const std::function<Result<void>(PtzHead&)>& tell);
    Result<WorldState> run(LoadWorld& command);
    Result<WorldState> run(GetWorld&);
    Result<WorldState> run(PauseWorld&);
    Result<WorldState> run(ResumeWorld&);
    Result<WorldState> run(StepWorld& command);
    Result<ActorList> run(ListActors&);
    Result<ActorChange> run(SpawnActor& command);
    Result<Applied> run(RemoveActor& command);
    Result<ActorChange> run(SetActor& command);
    Result<Applied> run(SteerActors& command);
    Result<std::vector<EventReport>> run(ListEvents&);
    Result<EventChange> run(AddEvent& command);
    Result<Applied> run(RemoveEvent& command);
    Result<EventLog> run(WaitEvents& command);
    Result<RigReport> run(GetStats&);
    Result<TruthRef> run(GetTruth& command);
    Result<CameraReply> find(const std::string& name) const;

    mutable std::mutex mutex_;
    std::map<std::string, CameraReply> cameras_;
    WorldState world_;
    FetchRequest last_fetch_;
    bool holds_ = false;
    std::vector<std::function<void()>> held_;
    std::atomic<bool> drops_{false};
    std::atomic<TimeNs> last_step_ns_{-1};
    std::atomic<std::size_t> picture_bytes_{3};
    std::atomic<int> pictures_{0};
};

}  // namespace camrig

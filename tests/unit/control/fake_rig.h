#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "core/engine/command.h"
#include "core/stream/frame_bus.h"

namespace camrig::control {

/// A rig in memory: cameras with checked specs, a world that is a number with one actor and one event, pictures that
/// are bytes. Answers at once on the caller's thread, but for steps while they are held. Any thread.
class FakeRig final : public engine::CommandPort, public stream::FrameFetcher {
public:
    void post(engine::Command command) override;
    void fetch(stream::FetchRequest request, std::function<void(Result<stream::MediaUnit>)> done) override;

    /// From now on steps wait; release() answers those that wait.
    void hold_steps();
    void release();
    std::size_t held() const;
    /// Forgets commands instead of answering them: an engine that is going down.
    void drop_commands() { drops_ = true; }

    TimeNs last_step_ns() const { return last_step_ns_; }
    stream::FetchRequest last_fetch() const;
    void set_picture_bytes(std::size_t size) { set_picture(std::vector(size, std::byte{0xab})); }
    void set_picture(std::vector<std::byte> picture);
    /// The next picture asked for does not come (unavailable).
    void miss_picture() { misses_ = true; }
    /// How many were drawn.
    int pictures() const { return pictures_; }

private:
    Result<engine::CameraReply> run(engine::CreateCamera& command);
    Result<engine::CameraReply> run(engine::SetCamera& command);
    Result<engine::Applied> run(engine::DeleteCamera& command);
    Result<engine::CameraReply> run(engine::GetCamera& command);
    Result<std::vector<engine::CameraReply>> run(engine::ListCameras&);
    Result<engine::PtzReply> run(engine::MovePtz& command);
    Result<engine::PtzReply> run(engine::PtzPresets& command);
    Result<engine::PtzReply> run(engine::PtzTours& command);
    Result<engine::PtzReply> run(engine::StopPtz& command);
    Result<engine::PtzReply> run(engine::GetPtz& command);
    Result<engine::FaultReply> run(engine::SetFault& command);
    Result<engine::ClearFaults::Reply> run(engine::ClearFaults& command);
    Result<engine::ListFaults::Reply> run(engine::ListFaults& command);
    Result<engine::GetReaderLog::Reply> run(engine::GetReaderLog& command);
    Result<engine::PtzReply> tell_head(const std::string& name,
                                       const std::function<Result<void>(camera::PtzHead&)>& tell);
    Result<engine::WorldState> run(engine::LoadWorld& command);
    Result<engine::WorldState> run(engine::GetWorld&);
    Result<engine::WorldState> run(engine::PauseWorld&);
    Result<engine::WorldState> run(engine::ResumeWorld&);
    Result<engine::WorldState> run(engine::StepWorld& command);
    Result<engine::ActorList> run(engine::ListActors&);
    Result<engine::ActorChange> run(engine::SpawnActor& command);
    Result<engine::Applied> run(engine::RemoveActor& command);
    Result<engine::ActorChange> run(engine::SetActor& command);
    Result<engine::Applied> run(engine::SteerActors& command);
    Result<std::shared_ptr<const engine::HeldInstant>> run(engine::GetInstant&);
    Result<engine::ObjectChange> run(engine::SpawnObject& command);
    Result<engine::ObjectChange> run(engine::SetObject& command);
    Result<engine::Applied> run(engine::RemoveObject& command);
    Result<std::vector<world::EventReport>> run(engine::ListEvents&);
    Result<engine::EventChange> run(engine::AddEvent& command);
    Result<engine::Applied> run(engine::Act& command);
    Result<engine::Applied> run(engine::RemoveEvent& command);
    Result<engine::EventLog> run(engine::WaitEvents& command);
    Result<stream::RigReport> run(engine::GetStats&);
    Result<truth::TruthRef> run(engine::GetTruth& command);
    Result<engine::SetLimit::Reply> run(engine::SetLimit& command);
    Result<engine::GetDigest::Reply> run(engine::GetDigest& command);
    Result<engine::CameraReply> find(const std::string& name) const;

    mutable std::mutex mutex_;
    std::map<std::string, engine::CameraReply> cameras_;
    engine::WorldState world_;
    stream::FetchRequest last_fetch_;
    std::uint64_t faults_ = 0;
    bool holds_ = false;
    std::vector<std::function<void()>> held_;
    std::atomic<bool> drops_{false};
    std::atomic<TimeNs> last_step_ns_{-1};
    std::vector<std::byte> picture_ = std::vector(3, std::byte{0xab});
    std::atomic<bool> misses_{false};
    std::atomic<int> pictures_{0};
};

}  // namespace camrig::control

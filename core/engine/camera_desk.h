#pragma once

#include <functional>
#include <string>

#include "core/engine/rig_state.h"
#include "core/engine/world_desk.h"

namespace camrig::engine {

/// Carries out the commands on cameras. A command that fails changes nothing. Engine's thread.
class CameraDesk {
public:
    CameraDesk(RigState& rig, WorldDesk& world) : rig_(rig), world_(world) {}

    Result<CameraReply> run(CreateCamera& command);
    Result<CameraReply> run(SetCamera& command);
    Result<Applied> run(DeleteCamera& command);
    Result<CameraReply> run(GetCamera& command);
    Result<std::vector<CameraReply>> run(ListCameras& command);
    Result<PtzReply> run(MovePtz& command);
    Result<PtzReply> run(PtzPresets& command);
    Result<PtzReply> run(PtzTours& command);
    Result<PtzReply> run(StopPtz& command);
    Result<PtzReply> run(GetPtz& command);

    /// Adds those cameras of a scene whose names are not taken: all of them or none. They are scheduled from
    /// begin_world() on.
    Result<void> add_cameras_of(const world::Scene& scene);
    /// There is a new world, and its clock does not run yet: makes its beginning the latest frame of all cameras.
    void begin_world();
    /// Draws the latest frame of each camera, whether or not somebody reads it.
    void show_all();
    /// For who asks for what the camera's last command did: where the world was paused before its next frame would show
    /// that, it shows it now.
    void show_waiting_change(CameraEntry& entry);

private:
    Result<CameraEntry*> add_camera(world::CameraSpec spec);
    /// A camera that is in the table takes part from now on.
    void start_camera(CameraEntry& entry);
    /// Fails unless the mount's actor and node exist.
    Result<void> check_mount(const world::CameraPatch& patch);
    /// Fails if this machine cannot open an output that `present` lacks. Not asked for a scene's cameras: they exist
    /// without it.
    Result<void> check_new_outputs(const world::CameraSpec& spec, const std::vector<OutputSpec>& present);
    /// The camera's newest picture shows the world of now with its present spec.
    void renew_latest(CameraEntry& entry, std::int64_t sequence);
    void renew_standing(CameraEntry& entry, TimeNs now_ns);
    /// The camera's newest picture is drawn, for who reads it.
    void show_latest(CameraEntry& entry);
    CameraReply report_of(const CameraEntry& entry) const;
    /// What its head is told now, and how it stands then.
    Result<PtzReply> tell_head(const std::string& camera,
                               const std::function<Result<void>(camera::PtzHead&, const world::Camera&, TimeNs)>& tell);
    Result<PtzReply> head_of(const CameraEntry& entry, TimeNs now_ns) const;

    RigState& rig_;
    WorldDesk& world_;
    std::vector<CameraId> added_;  ///< by add_cameras_of(), until begin_world()
};

}  // namespace camrig::engine

#pragma once

#include "core/engine/rig_state.h"
#include "core/engine/world_desk.h"

namespace camrig::engine {

/// Carries out the commands on faults of cameras. Faults act on frames that fall due after the command. A command that
/// fails changes nothing. Engine's thread.
class FaultDesk {
public:
    FaultDesk(RigState& rig, WorldDesk& world) : rig_(rig), world_(world) {}

    Result<FaultReply> run(SetFault& command);
    Result<ClearFaults::Reply> run(ClearFaults& command);
    Result<ListFaults::Reply> run(ListFaults& command);
    Result<GetReaderLog::Reply> run(GetReaderLog& command);

private:
    /// Records a change of the camera's faults; returns the world time from which its pictures show it.
    TimeNs note_command(CameraEntry& entry);

    RigState& rig_;
    WorldDesk& world_;
};

}  // namespace camrig::engine

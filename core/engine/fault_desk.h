#pragma once

#include "core/engine/rig_state.h"
#include "core/engine/world_desk.h"

namespace camrig::engine {

/// What commands say of cameras that fail. Faults act on frames that fall due from then on; what is out is out. A
/// command that fails changes nothing. Engine's thread.
class FaultDesk {
public:
    FaultDesk(RigState& rig, WorldDesk& world) : rig_(rig), world_(world) {}

    Result<FaultReply> run(SetFault& command);
    Result<ClearFaults::Reply> run(ClearFaults& command);
    Result<ListFaults::Reply> run(ListFaults& command);
    Result<GetReaderLog::Reply> run(GetReaderLog& command);

private:
    /// World time from which the camera's pictures show a command of now.
    TimeNs note_command(CameraEntry& entry);

    RigState& rig_;
    WorldDesk& world_;
};

}  // namespace camrig::engine

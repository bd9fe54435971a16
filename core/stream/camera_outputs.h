#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/stream/frame_bus.h"

namespace camrig::stream {

/// Which outputs of one kind the cameras of a bus have, and what a change of a camera means for them. For a
/// CameraObserver that opens and closes them; one thread at a time.
class CameraOutputs {
public:
    struct Change {
        std::vector<OutputSpec> gone;     ///< to be closed, before others are opened
        std::vector<OutputSpec> added;    ///< to be opened
        std::vector<OutputSpec> changed;  ///< are there, with other options than before
        std::vector<OutputSpec> kept;     ///< are as they were, though size or rate of their camera may be others
    };

    explicit CameraOutputs(std::string kind) : kind_(std::move(kind)) {}

    /// The camera is new or changed (`is_there`), or it went.
    Change update(const CameraStream& camera, bool is_there);

private:
    const std::string kind_;
    std::map<std::string, std::vector<OutputSpec>> outputs_;  ///< by camera
};

}  // namespace camrig::stream

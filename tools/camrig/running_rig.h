#pragma once

#include <memory>
#include <vector>

#include "core/engine/engine.h"
#include "core/stream/local_frame_bus.h"
#include "core/stream/worker_pool.h"
#include "tools/camrig/serve.h"

namespace camrig::cli {

/// A rig that runs, before anybody can reach it: engine, bus, and the outputs of its cameras.
struct RunningRig {
    explicit RunningRig(std::shared_ptr<frame::FramePool> pool);
    static Result<std::unique_ptr<RunningRig>> start(const ServeOptions& options, world::SceneRef scene);
    /// When no server asks it any more.
    void stop();

    stream::WorkerPool truth_text;  ///< makes text of truth, for HTTP
    stream::LocalFrameBus bus;
    std::unique_ptr<engine::Engine> engine = {};
    std::vector<std::unique_ptr<stream::CameraObserver>> outputs = {};
};

}  // namespace camrig::cli

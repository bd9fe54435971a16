#include "tools/camrig/running_rig.h"

#include <algorithm>
#include <thread>
#include <utility>

#include "tools/camrig/outputs.h"
#include "tools/camrig/rig_folder.h"

namespace camrig::cli {
namespace {

constexpr std::size_t max_truths_waiting = 64;

int count_workers() {
    return static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

}  // namespace

RunningRig::RunningRig(std::shared_ptr<frame::FramePool> pool)
    : truth_text(1, max_truths_waiting), bus({count_workers(), std::move(pool)}) {}

Result<std::unique_ptr<RunningRig>> RunningRig::start(const ServeOptions& options, world::SceneRef scene) {
    auto pool = std::make_shared<frame::FramePool>();
    auto rig = std::make_unique<RunningRig>(pool);
    engine::EngineOptions engine_options = options.engine;
    engine_options.renderer.pool = std::move(pool);
    auto engine = engine::Engine::start(std::move(scene), engine_options, rig->bus);
    if (!engine) return std::unexpected(engine.error());
    rig->engine = std::move(*engine);
    auto outputs = open_outputs({.bus = rig->bus,
                                 .fetcher = *rig->engine,
                                 .commands = *rig->engine,
                                 .device_socket = device_socket_of(options.control),
                                 .is_lockstep = options.engine.mode == engine::RunMode::lockstep});
    if (!outputs) return std::unexpected(outputs.error());
    rig->outputs = std::move(*outputs);
    return rig;
}

void RunningRig::stop() {
    truth_text.stop();
    outputs.clear();
    engine.reset();
}

}  // namespace camrig::cli

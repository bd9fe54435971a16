#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "core/base/bounded_queue.h"
#include "core/base/result.h"
#include "core/engine/command.h"
#include "core/render/renderer_factory.h"
#include "core/stream/local_frame_bus.h"

namespace camrig::engine {

struct EngineOptions {
    RunMode mode = RunMode::realtime;
    OverloadPolicy overload = OverloadPolicy::drop;
    world::Quality quality = world::Quality::simple;
    std::optional<std::uint64_t> seed;  ///< nullopt: the scene's
    TimeNs limit_ns = max_time_ns;      ///< in real time: how far the world may run at first (SetLimit)
    /// Refuse changes without a world time (Request::at_ns): another machine would carry them out at another time.
    bool is_held = false;
    std::shared_ptr<CommandJournal> journal = {};  ///< null: nobody keeps a log
    render::RendererOptions renderer;
};

/// The tick loop: the thread that owns the world and the schedule. Commands and requests for pictures come in by a
/// bounded queue, frames go out to the bus; nothing else crosses. Commands, instants, steps of the world and pictures
/// on request take turns of some ms: none of them keeps the others waiting for long, however many there are.
///
/// Any thread may post and fetch. The bus must outlive the engine.
class Engine final : public CommandPort, public stream::FrameFetcher {
public:
    /// Starts the thread, makes world and renderer on it, and creates the scene's cameras.
    static Result<std::unique_ptr<Engine>> start(world::SceneRef scene, const EngineOptions& options,
                                                 stream::LocalFrameBus& bus);
    /// Stops and joins; what is still queued is answered with `unavailable`.
    ~Engine() override;

    void post(Command command) override;
    void fetch(stream::FetchRequest request, std::function<void(Result<stream::MediaUnit>)> done) override;

    const std::string& renderer_description() const { return renderer_description_; }

private:
    struct Fetch {
        stream::FetchRequest request;
        std::function<void(Result<stream::MediaUnit>)> done;
    };
    using Message = std::variant<Command, Fetch>;

    Engine() = default;
    void run(world::SceneRef scene, const EngineOptions& options, stream::LocalFrameBus& bus,
             std::function<void(Result<void>)> started);
    static void refuse(Message& message, const Error& why);

    /// Shared with whoever still holds a frame when the engine goes: its last act is to wake the queue.
    const std::shared_ptr<BoundedQueue<Message>> queue_ = std::make_shared<BoundedQueue<Message>>(max_queued_commands);
    std::string renderer_description_;
    std::thread thread_;
};

}  // namespace camrig::engine

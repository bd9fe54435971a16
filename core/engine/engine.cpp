#include "core/engine/engine.h"

#include <future>

#include <pthread.h>

#include "core/base/clock.h"
#include "core/engine/rig.h"
#include "core/render/shared_caches.h"

namespace camrig::engine {
namespace {

/// For so long commands are done before what is due has its turn; a single command may take longer.
constexpr TimeNs command_turn_ns = 2 * ns_per_ms;
/// Of the lane for dear pictures and requests, in steps of the kernel's niceness: where there are too few cores, a
/// thread of the other lane gets about nine times its time (sched(7)).
constexpr int dear_niceness = 10;

/// Where the CPU draws, dear pictures and requests have a lane beside that of cameras that are quickly drawn. A GPU
/// draws one picture after the other anyway: there all share one lane.
Result<std::vector<std::unique_ptr<DrawLane>>> start_lanes(const render::RendererOptions& options,
                                                           const std::shared_ptr<DrawnTasks>& drawn) {
    render::RendererOptions sharing = options;
    sharing.caches = render::make_shared_caches();
    const auto make = [sharing] { return create_renderer(sharing); };
    std::vector<std::unique_ptr<DrawLane>> lanes;
    auto first = ThreadedLane::start({"camrig-draw", 0}, make, drawn);
    if (!first) return std::unexpected(first.error());
    lanes.push_back(std::move(*first));
    if (!lanes.front()->wants_second()) return lanes;
    auto second = ThreadedLane::start({"camrig-draw-2", dear_niceness}, make, drawn);
    if (!second) return std::unexpected(second.error());
    lanes.push_back(std::move(*second));
    return lanes;
}

}  // namespace

Result<std::unique_ptr<Engine>> Engine::start(world::SceneRef scene, const EngineOptions& options,
                                              stream::LocalFrameBus& bus) {
    std::unique_ptr<Engine> engine(new Engine);
    std::promise<Result<void>> promise;
    auto started = promise.get_future();
    engine->thread_ = std::thread([&engine = *engine, scene = std::move(scene), options, &bus, &promise] {
        engine.run(scene, options, bus, [&promise](Result<void> result) { promise.set_value(std::move(result)); });
    });
    pthread_setname_np(engine->thread_.native_handle(), "camrig-engine");
    if (auto result = started.get(); !result) return std::unexpected(result.error());
    return engine;
}

Engine::~Engine() {
    queue_->close();
    if (thread_.joinable()) thread_.join();
}

void Engine::run(world::SceneRef scene, const EngineOptions& options, stream::LocalFrameBus& bus,
                 std::function<void(Result<void>)> started) {
    const auto drawn = std::make_shared<DrawnTasks>(max_draw_tasks, [queue = queue_] { queue->wake(); });
    auto lanes = start_lanes(options.renderer, drawn);
    if (!lanes) return started(std::unexpected(lanes.error()));
    renderer_description_ = lanes->front()->description();
    auto rig =
        Rig::create(std::move(scene), options, std::move(*lanes), drawn, bus, [queue = queue_] { queue->wake(); });
    if (!rig) return started(std::unexpected(rig.error()));
    started({});

    while (!queue_->is_closed()) {
        queue_->wait_until((*rig)->wake_time_ns());
        const TimeNs turn_end_ns = monotonic_now_ns() + command_turn_ns;
        while (auto message = queue_->take()) {
            if (auto* command = std::get_if<Command>(&*message)) {
                (*rig)->apply(*command);
            } else {
                auto& fetch = std::get<Fetch>(*message);
                (*rig)->fetch(std::move(fetch.request), std::move(fetch.done));
            }
            if (monotonic_now_ns() >= turn_end_ns) break;
        }
        (*rig)->tick(monotonic_now_ns());
    }
    while (auto message = queue_->take()) refuse(*message, {ErrorKind::unavailable, "the rig shuts down"});
}

void Engine::refuse(Message& message, const Error& why) {
    if (auto* fetch = std::get_if<Fetch>(&message)) return fetch->done(std::unexpected(why));
    std::visit([&](auto& request) { request.done(std::unexpected(why)); }, std::get<Command>(message));
}

void Engine::post(Command command) {
    Message message(std::move(command));
    if (!queue_->put(std::move(message))) {
        refuse(message, queue_->is_closed()
                            ? Error{ErrorKind::unavailable, "the rig shuts down"}
                            : Error{ErrorKind::resource_exhausted,
                                    std::to_string(max_queued_commands) + " commands are waiting; send slower"});
    }
}

void Engine::fetch(stream::FetchRequest request, std::function<void(Result<stream::MediaUnit>)> done) {
    Message message(Fetch{std::move(request), std::move(done)});
    if (!queue_->put(std::move(message)))
        refuse(message, {ErrorKind::resource_exhausted, "too many requests are waiting; send slower"});
}

}  // namespace camrig::engine

#include <cstdint>
#include <cstdlib>
#include <string>
#include <type_traits>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <spdlog/spdlog.h>

#include "control/unrealcv/session.h"
#include "control/unrealcv/wire.h"

// What clients of UnrealCV send: frames, requests and every command's reading of its line, on a rig with a camera, an
// object and an actor, which takes every other change and refuses the rest. What must hold: no crash, one answer to
// each request, no reading on in a stream that is broken.
namespace camrig {
namespace {

void require(bool condition) {
    if (!condition) std::abort();
}

class ActingRig final : public engine::CommandPort, public stream::FrameFetcher {
public:
    void post(engine::Command command) override {
        std::visit([this](auto& request) { answer(request); }, command);
    }
    void fetch(stream::FetchRequest request, std::function<void(Result<stream::MediaUnit>)> done) override {
        frame::FrameInfo info;
        info.size = {2, 1};
        info.kind = request.kind;
        info.format = request.format.pixels;
        if (auto admitted = request.admit(info.size); !admitted) return done(std::unexpected(admitted.error()));
        stream::MediaUnit unit;
        std::vector<std::byte> bytes(bytes_of(info.format, info.size));
        unit.frame = std::make_shared<const frame::Frame>(info, std::move(bytes));
        done(std::move(unit));
    }

private:
    static engine::CameraReply camera() {
        engine::CameraReply reply;
        reply.camera = world::Camera(world::CameraSpec{});
        return reply;
    }
    static world::Instance thing(std::uint32_t id, const char* name) {
        auto info = std::make_shared<world::ObjectInfo>();
        info->id = ObjectId{id};
        info->name = name;
        info->model = std::make_shared<const world::Model>();
        world::Instance instance;
        instance.info = std::move(info);
        return instance;
    }

    void answer(engine::Request<engine::ListCameras>& request) { request.done(std::vector{camera()}); }
    void answer(engine::Request<engine::GetInstant>& request) {
        auto statics = std::make_shared<world::StaticSet>();
        statics->objects.push_back(thing(1, "a thing"));
        auto snapshot = std::make_shared<world::Snapshot>();
        snapshot->statics = std::move(statics);
        snapshot->movers.push_back(thing(2, "anna"));
        auto instant = std::make_shared<engine::HeldInstant>();
        instant->snapshot = std::move(snapshot);
        instant->scene = std::make_shared<const world::Scene>();
        request.done(instant);
    }
    template <typename C>
    void answer(engine::Request<C>& request) {
        using Reply = typename C::Reply;
        takes_ = !takes_;
        if (!takes_) return request.done(error(ErrorKind::unavailable, "no"));
        if constexpr (std::is_same_v<Reply, engine::CameraReply>)
            request.done(camera());
        else
            request.done(Reply{});
    }

    bool takes_ = false;
};

void run(std::string_view bytes) {
    ActingRig rig;
    boost::asio::io_context loop;
    // Of all requests: a loop that has run out of work once runs nothing more.
    const auto work = boost::asio::make_work_guard(loop);
    unrealcv::DoorState door{.commands = rig, .frames = rig};
    door.post = std::make_shared<control::LoopPost>(loop.get_executor());
    door.workers = std::make_shared<stream::WorkerPool>(1, 8);
    door.budget = ByteBudget::create(std::size_t{1} << 20, "enough");
    const auto session = std::make_shared<unrealcv::Session>(door, loop.get_executor());
    unrealcv::FrameReader frames;
    // In two pieces, as networks do it.
    for (const std::string_view piece : {bytes.substr(0, bytes.size() / 2), bytes.substr(bytes.size() / 2)}) {
        frames.append(piece);
        while (const auto payload = frames.next()) {
            require(frames.problem().empty());
            const auto request = unrealcv::parse_request(*payload);
            // Loading a scene reads files: not this target's business, and slow.
            if (!request || request->command.find("/level ") != std::string_view::npos) continue;
            int answers = 0;
            boost::asio::co_spawn(loop, session->answer(request->command),
                                  [&](const std::exception_ptr& thrown, const unrealcv::Answer&) {
                                      require(!thrown);
                                      ++answers;
                                  });
            while (answers == 0) loop.run_one();
            session->end_batch();
        }
    }
    if (!frames.problem().empty()) require(!frames.next());
    door.post->disconnect();
}

}  // namespace
}  // namespace camrig

extern "C" int LLVMFuzzerInitialize(int*, char***) {
    spdlog::set_level(spdlog::level::off);  // what is refused is logged, and here most is
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    camrig::run({reinterpret_cast<const char*>(data), size});
    return 0;
}

#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>

#include "control/server/loop_event.h"
#include "control/server/loop_post.h"
#include "control/unrealcv/colors.h"
#include "control/unrealcv/command.h"
#include "control/unrealcv/pictures.h"
#include "core/base/byte_budget.h"
#include "core/base/log_pace.h"
#include "core/base/thread_check.h"
#include "core/engine/command.h"
#include "core/stream/frame_bus.h"
#include "core/stream/worker_pool.h"

namespace camrig::unrealcv {

/// An object of a moment.
struct FoundObject {
    const world::Instance* instance = nullptr;
    bool moves = false;

    const std::string& name() const { return instance->info->name; }
    /// Of an actor: its front is +x.
    glm::dquat orientation() const {
        return glm::normalize(instance->orientation * glm::inverse(instance->info->heading_from_model));
    }
};

/// Objects that stand, by the names that clients know: many are asked for, and few come and go.
struct StandingObjects {
    std::shared_ptr<const world::StaticSet> set;
    std::unordered_map<std::string, const world::Instance*> by_name;
};

/// What the connections of a door share. Lives on its thread; all that it refers to outlives the door's stop().
struct DoorState {
    engine::CommandPort& commands;
    stream::FrameFetcher& frames;
    std::filesystem::path folder = {};  ///< for files; empty: none are written
    Depth depth = Depth::plane_cm;      ///< what `depth` is
    std::uint16_t port = 0;
    std::shared_ptr<control::LoopPost> post = {};
    std::shared_ptr<stream::WorkerPool> workers = {};  ///< read scenes, make long texts
    std::shared_ptr<ByteBudget> budget = {};           ///< of pictures that are made or sent
    std::shared_ptr<PictureMemory> pictures = std::make_shared<PictureMemory>();

    StandingObjects standing = {};  ///< of the moment that was asked last
    std::shared_ptr<const Colors> colors = std::make_shared<const Colors>();
    world::SceneRef scene = {};          ///< that the colours are of
    std::optional<TimeNs> tick_ns = {};  ///< what /action/tick moves the world by; nullopt: one of its steps
    std::uint64_t files = 0;             ///< that were given a name here
    LogPace refusal_log = {};            ///< of requests
    LogPace closing_log = {};            ///< of connections that were closed for what they sent
};

/// The world and its cameras at one moment, as the commands of one batch see them.
struct Moment {
    std::shared_ptr<const engine::HeldInstant> instant;
    std::vector<engine::CameraReply> cameras;  ///< in their order: UnrealCV's ids; where they were asked for

    const world::Snapshot& world() const { return *instant->snapshot; }
    camera::CameraState state_of(const engine::CameraReply& camera) const { return camera.camera.at(world()); }
};

/// An object's name in commands, where no spaces and slashes can stand.
std::string shown_name(std::string_view name);

/// What one client asks, a command at a time, and what it knows meanwhile.
///
/// Commands that came before the answer to the one before them are a batch: what they read is all of one moment, until
/// one of them changes something; the next reads show the change. Thread: the door's. Everything asked of the rig is
/// asked there, in order.
class Session : public std::enable_shared_from_this<Session> {
public:
    Session(DoorState& door, const boost::asio::any_io_executor& executor);

    /// Answers a line; what failed for lack of memory is an error like others.
    boost::asio::awaitable<Answer> answer(std::string_view line);
    /// Nothing more has come: the next command begins another batch. Not within `vbatch`.
    void end_batch();
    /// The connection is closed: nothing is waited for any more.
    void close();

    // What the commands are made of.
    DoorState& door() { return door_; }
    std::string viewmode = "lit";
    /// The next `count` commands see one moment, however late they come (vbatch).
    void begin_vbatch(int count) { vbatch_left_ = count; }

    /// The rig's answer to a command of the engine.
    template <typename C>
    boost::asio::awaitable<Result<typename C::Reply>> ask(C command) {
        auto slot = std::make_shared<Slot<typename C::Reply>>();
        door_.commands.post(engine::Request<C>{std::move(command), filler(slot)});
        co_await filled(*slot);
        co_return std::move(*slot->value);
    }
    /// The same of a command that changes something.
    template <typename C>
    boost::asio::awaitable<Answer> change(C command) {
        auto done = co_await ask(std::move(command));
        moment_.reset();
        if (!done) co_return refused(std::move(done.error().message));
        co_return std::string();
    }
    /// The moment of this batch; the error is the answer. It stays until the next change.
    boost::asio::awaitable<std::expected<const Moment*, std::string>> moment();
    /// The same with its cameras.
    boost::asio::awaitable<std::expected<const Moment*, std::string>> moment_of_cameras();
    /// Something was changed: the next read sees it.
    void changed() { moment_.reset(); }
    /// What `make` makes of the camera's picture of that moment, on a thread for such work.
    boost::asio::awaitable<Result<Body>> picture(const engine::CameraReply& camera, frame::FrameKind kind,
                                                 std::function<Result<Body>(const frame::Frame&)> make);
    /// What `make` gives, on a thread for work that takes long.
    boost::asio::awaitable<Result<std::string>> work(std::function<Result<std::string>()> make);
    /// The memory of the picture that is being answered is free.
    void sent() { claim_.reset(); }

private:
    template <typename T>
    struct Slot {
        std::optional<Result<T>> value;
    };
    /// A function that fills the slot, once, from any thread.
    template <typename T>
    auto filler(const std::shared_ptr<Slot<T>>& slot) {
        return [post = door_.post, weak = weak_from_this(), slot](Result<T> value) {
            (*post)([weak, slot, value = std::move(value)]() mutable {
                slot->value = std::move(value);
                if (const auto self = weak.lock()) self->answered_.set();
            });
        };
    }
    template <typename T>
    boost::asio::awaitable<void> filled(Slot<T>& slot) {
        while (!slot.value && !is_closed_) co_await answered_.wait();
        if (!slot.value) slot.value = error(ErrorKind::unavailable, "the connection is closed");
    }

    DoorState& door_;
    control::LoopEvent answered_;
    ThreadCheck thread_;
    std::optional<Moment> moment_;
    std::shared_ptr<std::optional<ByteBudget::Claim>> claim_;  ///< of the picture that is being answered
    int vbatch_left_ = 0;
    bool is_closed_ = false;
};

/// The camera that a [uint] names.
std::expected<const engine::CameraReply*, std::string> camera_at(const Moment& moment, std::string_view id);
/// The object that a [str] names.
std::expected<FoundObject, std::string> object_named(DoorState& door, const Moment& moment, std::string_view name);

}  // namespace camrig::unrealcv

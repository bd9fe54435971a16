#pragma once

#include <functional>
#include <string>

#include "control/onvif/authentication.h"
#include "control/onvif/event_desk.h"
#include "control/onvif/operation.h"
#include "core/stream/worker_pool.h"

namespace camrig::onvif {

/// A message that came to a device.
struct OnvifCall {
    std::string device;             ///< name of its camera; empty: a device with all cameras of the rig
    std::string host;               ///< as the client calls us, with the port
    std::string path;               ///< of the URL that was posted to
    std::optional<Role> role = {};  ///< as HTTP told already
    std::string body;
    std::uint16_t port = 0;  ///< that it came to
};
struct OnvifReply {
    int status = 200;
    std::string text;
    bool is_refused = false;   ///< it came with a wrong token
    bool asks_digest = false;  ///< the client is to come again with HTTP digest
};

/// What the rig's ONVIF devices answer. Cameras and heads are asked and told by the engine's commands, as by the
/// methods of JSON-RPC, so the last command wins and everybody sees it. Knows no transport; any thread.
class OnvifService {
public:
    struct Options {
        Site site = {};
        std::string token = {};        ///< as of Authentication
        std::vector<User> users = {};  ///< the same
        bool may_command = true;       ///< else heads are only looked at
    };
    /// The first two outlive stop(), and no command is in work when the service goes.
    OnvifService(engine::CommandPort& commands, stream::FrameFetcher& frames, Options options);
    ~OnvifService();
    OnvifService(const OnvifService&) = delete;
    OnvifService& operator=(const OnvifService&) = delete;

    /// `done` gets the answer, once, from any thread.
    void handle(const OnvifCall& call, std::function<void(OnvifReply)> done);
    Authentication& authentication() { return authentication_; }
    /// Takes no more replies of the engine and ends subscriptions. Twice is fine.
    void stop();

private:
    struct Task;
    using TaskRef = std::shared_ptr<Task>;

    /// nullopt: it may be answered. `now_ns`: since 1970, as the clock has it that the message's age is judged by.
    std::optional<OnvifReply> refuse(const Operation& operation, const SoapMessage& message,
                                     std::optional<Role> by_http, TimeNs now_ns);
    void ask_cameras(const TaskRef& task);
    void ask_head(const TaskRef& task);
    void answer(const TaskRef& task);
    void give_next_order(const TaskRef& task);
    /// Whether an order that came too late is given once more, from what is so now.
    bool retry(const TaskRef& task);
    /// Hands what the engine answered to the thread that makes text of it.
    template <typename T>
    auto on_reply(const TaskRef& task, void (OnvifService::*next)(const TaskRef&, T));
    void take_cameras(const TaskRef& task, std::vector<engine::CameraReply> cameras);
    void take_camera(const TaskRef& task, engine::CameraReply camera);
    void take_changed(const TaskRef& task, engine::CameraReply camera);
    void take_ptz(const TaskRef& task, engine::PtzReply reply);
    void take_wiped(const TaskRef& task, engine::ClearFaults::Reply reply);

    engine::CommandPort& commands_;
    const Options options_;
    Authentication authentication_;
    stream::WorkerPool replies_;
    EventDesk events_;
};

}  // namespace camrig::onvif

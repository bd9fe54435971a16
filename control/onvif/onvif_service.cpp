#include "control/onvif/onvif_service.h"

#include <algorithm>
#include <utility>

#include "core/base/clock.h"
#include "core/camera/ptz_head.h"

namespace camrig::onvif {
namespace {

constexpr std::size_t max_replies_waiting = 1024;
constexpr int max_retries = 16;

const Operation* find_operation(const XmlElement& asked) {
    static const Service services[] = {device_service(),  media_service(), media2_service(),      ptz_service(),
                                       imaging_service(), event_service(), subscription_service()};
    const auto service = std::ranges::find(services, asked.space(), &Service::space);
    if (service == std::end(services)) return nullptr;
    const auto found = std::ranges::find(service->operations, asked.name(), &Operation::name);
    return found == service->operations.end() ? nullptr : &*found;
}

OnvifReply reply_of(const Fault& fault) {
    return {.status = fault.status(), .text = fault_envelope(fault)};
}

bool is_by_fov(const PtzCommand* order) {
    const auto* const move = order ? std::get_if<engine::MovePtz>(order) : nullptr;
    return move && move->move.mode == camera::PtzMode::fov;
}

/// What the engine says of a request that was well formed.
Fault fault_of(const Error& why, const Operation& operation, const PtzCommand* order) {
    const auto sent = [&](std::string_view detail) { return Fault{true, "InvalidArgVal", detail, why.message}; };
    switch (why.kind) {
        case ErrorKind::not_found:
            return sent(!order ? "NoProfile" : "NoToken");
        case ErrorKind::invalid_argument:
            if (operation.change) return sent("ConfigModify");
            return sent(is_by_fov(order) ? "InvalidTranslation" : "InvalidPosition");
        case ErrorKind::already_exists:
            return sent("PresetExist");
        default:
            return {false, "Action", "", why.message};
    }
}

}  // namespace

struct OnvifService::Task {
    std::unique_ptr<SoapMessage> message;
    const Operation* operation;
    Asked asked;
    TimeNs received_ns;  ///< since 1970
    std::uint16_t port;  ///< that it came to
    std::vector<PtzCommand> orders = {};
    bool is_to_be_judged = false;  ///< by the camera's clock, when it is known
    std::size_t given = 0;         ///< of the orders
    int retries = 0;
    std::function<void(OnvifReply)> done;

    void finish(const Answer& answer) const {
        done(answer ? OnvifReply{.text = envelope(*answer)} : reply_of(answer.error()));
    }
};

OnvifService::OnvifService(engine::CommandPort& commands, stream::FrameFetcher& frames, Options options)
    : commands_(commands),
      options_(std::move(options)),
      authentication_(options_.token, options_.users),
      replies_(1, max_replies_waiting),
      events_(commands, frames) {}

OnvifService::~OnvifService() {
    stop();
}

void OnvifService::stop() {
    replies_.stop();
    events_.stop();
}

void OnvifService::handle(const OnvifCall& call, std::function<void(OnvifReply)> done) {
    auto message = read_soap(call.body);
    if (!message) return done(reply_of(message.error()));
    const Operation* operation = find_operation((*message)->operation);
    if (!operation) return done(reply_of(not_implemented()));
    // A camera judges the age of a message by its own clock.
    const bool by_camera = !call.device.empty() && !call.role && (*message)->token;
    const TimeNs now_ns = realtime_now_ns();
    if (!by_camera)
        if (auto refused = refuse(*operation, **message, call.role, now_ns)) return done(std::move(*refused));
    const XmlElement request = (*message)->operation;
    auto task = std::make_shared<Task>(Task{.message = std::move(*message),
                                            .operation = operation,
                                            .asked = {.site = options_.site,
                                                      .request = request,
                                                      .host = call.host,
                                                      .device = call.device,
                                                      .path = call.path,
                                                      .cameras = {},
                                                      .utc_ns = now_ns,
                                                      .users = authentication_.users()},
                                            .received_ns = now_ns,
                                            .port = call.port,
                                            .is_to_be_judged = by_camera,
                                            .done = std::move(done)});
    if (operation->orders) return ask_head(task);
    ask_cameras(task);
}

std::optional<OnvifReply> OnvifService::refuse(const Operation& operation, const SoapMessage& message,
                                               std::optional<Role> by_http, TimeNs now_ns) {
    if (operation.access == Access::pre_auth) return std::nullopt;
    std::optional<Role> role = authentication_.is_open() ? Role::administrator : by_http;
    if (!role && message.token) role = authentication_.role_of(*message.token, now_ns);
    if (!role) {
        OnvifReply reply = reply_of(not_authorized());
        reply.is_refused = message.token.has_value();
        reply.asks_digest = !message.token;
        if (reply.asks_digest) reply.status = 401;
        return reply;
    }
    Fault fault = not_authorized();
    if (*role < least_role(operation.access)) {
        fault.reason += ": this user's role does not allow it";
        return reply_of(fault);
    }
    if (!is_change(operation.access) || options_.may_command) return std::nullopt;
    fault.reason += ": this rig was started with --read-only";
    return reply_of(fault);
}

template <typename T>
auto OnvifService::on_reply(const TaskRef& task, void (OnvifService::*next)(const TaskRef&, T)) {
    return [this, task, next](Result<T> reply) {
        auto shared = std::make_shared<Result<T>>(std::move(reply));
        std::function<void()> job = [this, task, next, shared] {
            if (*shared) return (this->*next)(task, std::move(**shared));
            const PtzCommand* order = task->given > 0 ? &task->orders[task->given - 1] : nullptr;
            if (shared->error().kind == ErrorKind::already_exists && retry(task)) return;
            // Who asks may be nobody in particular yet, and the engine's words name every camera.
            if (shared->error().kind == ErrorKind::not_found && !order && !task->asked.device.empty())
                return task->finish(std::unexpected(Fault{false, "Action", {}, "the camera of this device is gone"}));
            task->finish(std::unexpected(fault_of(shared->error(), *task->operation, order)));
        };
        if (!replies_.post(std::move(job)))
            task->finish(std::unexpected(Fault{false, "Action", {}, "too many messages are in work; try again"}));
    };
}

void OnvifService::ask_cameras(const TaskRef& task) {
    if (task->asked.device.empty())
        return commands_.post(engine::Request<engine::ListCameras>{{}, on_reply(task, &OnvifService::take_cameras)});
    commands_.post(
        engine::Request<engine::GetCamera>{{task->asked.device}, on_reply(task, &OnvifService::take_camera)});
}

void OnvifService::ask_head(const TaskRef& task) {
    const Asked& asked = task->asked;
    const std::string name(asked.device.empty() ? camera_of_token(asked.request.text("ProfileToken")) : asked.device);
    commands_.post(engine::Request<engine::GetCamera>{{name}, on_reply(task, &OnvifService::take_camera)});
}

bool OnvifService::retry(const TaskRef& task) {
    // Somebody else took the number that was free; a name that the client gave stays taken.
    if (!task->asked.request.text("PresetName").empty() || ++task->retries > max_retries) return false;
    task->given = 0;
    ask_head(task);
    return true;
}

void OnvifService::take_cameras(const TaskRef& task, std::vector<engine::CameraReply> cameras) {
    for (const engine::CameraReply& one : cameras) task->asked.cameras.push_back(one.camera.spec());
    answer(task);
}

void OnvifService::take_camera(const TaskRef& task, engine::CameraReply camera) {
    task->asked.cameras = {camera.camera.spec()};
    if (!task->asked.device.empty()) task->asked.manners = manners_of(*camera.camera.spec(), task->port);
    if (!task->asked.device.empty() && camera.now.clock) {
        task->asked.clock_error_ns = camera.now.clock->stamp_error_ns;
        task->asked.utc_ns = task->received_ns + task->asked.clock_error_ns;
    }
    if (std::exchange(task->is_to_be_judged, false))
        if (auto refused = refuse(*task->operation, *task->message, std::nullopt, task->asked.utc_ns))
            return task->done(std::move(*refused));
    if (!task->operation->orders) return answer(task);
    if (camera_of_token(task->asked.request.text("ProfileToken")) != camera.camera.spec()->name)
        return task->finish(invalid_argument("NoProfile", "there is no such profile"));
    if (!camera.camera.spec()->ptz) return task->finish(std::unexpected(not_implemented("PTZNotSupported")));
    task->asked.camera = std::make_shared<const world::Camera>(std::move(camera.camera));
    auto orders = task->operation->orders(task->asked);
    if (!orders) return task->finish(std::unexpected(orders.error()));
    task->orders = std::move(*orders);
    give_next_order(task);
}

void OnvifService::answer(const TaskRef& task) {
    const Operation& operation = *task->operation;
    if (operation.on_events)
        return operation.on_events(task->asked, events_, [task](const Answer& answer) { task->finish(answer); });
    if (!operation.change) return task->finish(operation.answer(task->asked));
    auto change = operation.change(task->asked);
    if (!change) return task->finish(std::unexpected(change.error()));
    commands_.post(engine::Request<engine::SetCamera>{std::move(*change), on_reply(task, &OnvifService::take_changed)});
}

void OnvifService::take_changed(const TaskRef& task, engine::CameraReply) {
    task->finish(task->operation->answer(task->asked));
}

void OnvifService::give_next_order(const TaskRef& task) {
    PtzCommand& order = task->orders[task->given++];
    std::visit(
        [&]<typename C>(const C& command) {
            if constexpr (std::is_same_v<C, engine::ClearFaults>)
                commands_.post(engine::Request<C>{command, on_reply(task, &OnvifService::take_wiped)});
            else
                commands_.post(engine::Request<C>{command, on_reply(task, &OnvifService::take_ptz)});
        },
        order);
}

void OnvifService::take_ptz(const TaskRef& task, engine::PtzReply reply) {
    if (task->given < task->orders.size()) return give_next_order(task);
    task->finish(task->operation->reply(task->asked, reply));
}

void OnvifService::take_wiped(const TaskRef& task, engine::ClearFaults::Reply) {
    take_ptz(task, {});
}

}  // namespace camrig::onvif

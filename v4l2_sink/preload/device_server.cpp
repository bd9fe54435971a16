#include "v4l2_sink/preload/device_server.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <future>
#include <map>
#include <optional>

#include <poll.h>
#include <sys/epoll.h>
#include <sys/socket.h>

#include "core/base/clock.h"
#include "core/base/unix_listener.h"
#include "v4l2_sink/preload/device_host.h"

namespace camrig::device {

namespace {

constexpr int tick_ms = 250;
constexpr int events_at_once = 64;

/// Out of descriptors: accepting at once again would only burn the processor.
constexpr TimeNs accept_pause_ns = 100 * ns_per_ms;

std::string device_task(int number) {
    return "device " + std::to_string(number);
}

}  // namespace

/// The server's thread: sockets in, host called, sockets out.
class DeviceServer::Loop {
public:
    Loop(UnixListener listener, UniqueFd epoll, stream::FrameBus& bus, std::shared_ptr<ControlPort> controls,
         std::shared_ptr<TaskQueue> tasks, bool is_lockstep)
        : listener_(std::move(listener)),
          epoll_(std::move(epoll)),
          tasks_(tasks),
          host_(bus, std::move(controls), std::move(tasks), is_lockstep) {
        watch(listener_.fd());
        watch(tasks_->fd());
    }

    void run() {
        while (!stopping_) {
            std::array<epoll_event, events_at_once> events;
            const int count = ::epoll_wait(epoll_.get(), events.data(), events_at_once, tick_ms);
            for (int i = 0; i < count; ++i) handle(events[static_cast<std::size_t>(i)].data.fd);
            const TimeNs now_ns = monotonic_now_ns();
            if (accept_again_ns_ && now_ns >= *accept_again_ns_) {
                watch(listener_.fd());
                accept_again_ns_.reset();
            }
            host_.tick(now_ns);
            for (const auto& session : host_.take_ended()) forget(session->control_fd());
        }
        connections_.clear();
    }

    void stop() { stopping_ = true; }
    DeviceHost& host() { return host_; }

private:
    void watch(int fd) {
        epoll_event event{};
        event.events = EPOLLIN;
        event.data.fd = fd;
        ::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, fd, &event);
    }

    void handle(int fd) {
        if (fd == listener_.fd()) return accept_one();
        if (fd == tasks_->fd()) return tasks_->run();
        const auto connection = connections_.find(fd);
        if (connection == connections_.end()) return;
        const auto session = connection->second;
        std::array<std::byte, sizeof(camrig_request) + 1> message;
        const ssize_t got = ::recv(fd, message.data(), message.size(), MSG_DONTWAIT);
        if (got < 0 && (errno == EAGAIN || errno == EINTR)) return;
        if (got <= 0) {
            host_.leave(session);
            forget(fd);
            return;
        }
        host_.receive(session, std::span(message).first(static_cast<std::size_t>(got)));
    }

    void accept_one() {
        UniqueFd fd(::accept4(listener_.fd(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
        if (!fd && errno != EAGAIN && errno != EINTR && errno != ECONNABORTED) {
            ::epoll_ctl(epoll_.get(), EPOLL_CTL_DEL, listener_.fd(), nullptr);
            accept_again_ns_ = monotonic_now_ns() + accept_pause_ns;
        }
        // Beyond the limit a connection is closed again: the program's open() fails with ENODEV.
        if (!fd || connections_.size() >= max_connections) return;
        const int number = fd.get();
        connections_[number] = std::make_shared<DeviceSession>(std::move(fd));
        watch(number);
    }

    void forget(int fd) { connections_.erase(fd); }

    UnixListener listener_;
    const UniqueFd epoll_;
    std::optional<TimeNs> accept_again_ns_;  ///< the listener is not watched until then
    const std::shared_ptr<TaskQueue> tasks_;
    std::map<int, std::shared_ptr<DeviceSession>> connections_;
    DeviceHost host_;
    bool stopping_ = false;
};

Result<std::unique_ptr<DeviceServer>> DeviceServer::create(stream::FrameBus& bus, const std::string& socket_path,
                                                           std::shared_ptr<ControlPort> controls, bool is_lockstep) {
    auto listener = UnixListener::listen(socket_path, {.name = "device socket", .type = SOCK_SEQPACKET});
    if (!listener) return std::unexpected(listener.error());
    auto tree = DeviceTree::create(socket_path);
    if (!tree) return std::unexpected(tree.error());
    UniqueFd epoll(::epoll_create1(EPOLL_CLOEXEC));
    if (!epoll)
        return error(ErrorKind::resource_exhausted, "device socket " + socket_path + ": " + std::strerror(errno));
    auto tasks = std::make_shared<TaskQueue>();
    auto loop =
        std::make_unique<Loop>(std::move(*listener), std::move(epoll), bus, std::move(controls), tasks, is_lockstep);
    return std::unique_ptr<DeviceServer>(
        new DeviceServer(socket_path, std::move(*tree), std::move(loop), std::move(tasks)));
}

DeviceServer::DeviceServer(std::string socket_path, DeviceTree tree, std::unique_ptr<Loop> loop,
                           std::shared_ptr<TaskQueue> tasks)
    : socket_path_(std::move(socket_path)),
      tasks_(std::move(tasks)),
      tree_(std::move(tree)),
      loop_(std::move(loop)),
      thread_([this] { loop_->run(); }) {}

DeviceServer::~DeviceServer() {
    tasks_->post([loop = loop_.get()] { loop->stop(); });
    thread_.join();
}

Result<void> DeviceServer::add_device(int number, const std::string& camera, codec::ChromaSampling mjpg_sampling) {
    if (number < 0 || number > camrig_max_device_number)
        return error(ErrorKind::invalid_argument, "device number " + std::to_string(number) + ": must be 0 to " +
                                                      std::to_string(camrig_max_device_number));
    std::lock_guard lock(mutex_);
    if (const auto taken = numbers_.find(number); taken != numbers_.end())
        return error(ErrorKind::already_exists,
                     "device number " + std::to_string(number) + " is camera " + taken->second + "; choose another");
    if (auto added = tree_.add(number, camera); !added) return added;
    numbers_.emplace(number, camera);
    tasks_->post(device_task(number), [loop = loop_.get(), number, camera, mjpg_sampling] {
        loop->host().add_device(number, camera, mjpg_sampling);
    });
    return {};
}

void DeviceServer::remove_device(int number) {
    std::lock_guard lock(mutex_);
    const auto known = numbers_.find(number);
    if (known == numbers_.end()) return;
    tree_.remove(number, known->second);
    numbers_.erase(known);
    tasks_->post(device_task(number), [loop = loop_.get(), number] { loop->host().remove_device(number); });
}

void DeviceServer::set_standing(const std::string& camera, const fault::Standing& standing) {
    tasks_->post("standing faults of " + camera,
                 [loop = loop_.get(), camera, standing] { loop->host().set_standing(camera, standing); });
}

void DeviceServer::controls_changed(const std::string& camera, const std::vector<std::uint32_t>& ids) {
    std::lock_guard lock(mutex_);
    const auto device = std::ranges::find(numbers_, camera, &std::pair<const int, std::string>::second);
    if (device == numbers_.end()) return;
    for (const std::uint32_t id : ids)
        tasks_->post(device_task(device->first) + " control " + std::to_string(id),
                     [loop = loop_.get(), camera, id] { loop->host().control_changed(camera, id); });
}

}  // namespace camrig::device

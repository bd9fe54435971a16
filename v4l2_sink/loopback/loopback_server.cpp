#include "v4l2_sink/loopback/loopback_server.h"

#include <vector>

#include <poll.h>

#include "core/base/clock.h"

namespace camrig::device {

namespace {

constexpr int tick_ms = 250;

}  // namespace

Result<void> check_loopback(int number, const std::string& camera, LoopbackKernel& kernel) {
    const auto features = LoopbackModule(kernel).can_provide(number, camera);
    if (!features) return std::unexpected(features.error());
    if (!kernel.exists(video_path(number))) return {};
    auto good = LoopbackDevice::check(kernel, number);
    // It went in between, with the camera that had it: it can be made anew.
    if (!good && good.error().kind == ErrorKind::not_found && features->adds_devices) return {};
    return good;
}

LoopbackServer::LoopbackServer(stream::FrameBus& bus, stream::FrameFetcher& fetcher, LoopbackHost::Options options)
    : bus_(bus),
      host_(std::make_unique<LoopbackHost>(bus, fetcher, linux_kernel(), tasks_, options)),
      thread_([this] { run(); }) {
    bus_.add_observer(this);
}

LoopbackServer::~LoopbackServer() {
    bus_.remove_observer(this);
    tasks_->post([this] { stopping_ = true; });
    thread_.join();
}

void LoopbackServer::update(const stream::CameraStream& camera, bool is_there) {
    const stream::CameraOutputs::Change change = outputs_.update(camera, is_there);
    for (const OutputSpec& output : change.gone) {
        const int number = options_of<LoopbackOutput>(output).number;
        tasks_->post(std::to_string(number), [this, number] { host_->unset(number, monotonic_now_ns()); });
    }
    // A device goes on with another format, size or rate as far as its readers allow it.
    for (const auto& present : {change.added, change.changed, change.kept}) {
        for (const OutputSpec& output : present) {
            const auto options = options_of<LoopbackOutput>(output);
            LoopbackSettings settings{options.number, camera.name, loopback_format_of(camera, options)};
            tasks_->post(std::to_string(options.number),
                         [this, settings = std::move(settings)] { host_->set(settings, monotonic_now_ns()); });
        }
    }
}

void LoopbackServer::run() {
    while (!stopping_) {
        std::vector<pollfd> polled{{tasks_->fd(), POLLIN, 0}};
        for (const int fd : host_->watch_fds()) polled.push_back({fd, POLLPRI, 0});
        // Without devices there is nothing to do until somebody wants one.
        ::poll(polled.data(), polled.size(), host_->is_idle() ? -1 : tick_ms);
        if ((polled.front().revents & POLLIN) != 0) tasks_->run();
        host_->tick(monotonic_now_ns());
    }
    host_.reset();
}

}  // namespace camrig::device

#include "v4l2_sink/loopback/loopback_host.h"

#include <utility>

#include <spdlog/spdlog.h>

#include "core/base/clock.h"

namespace camrig::device {

namespace {

constexpr TimeNs retry_after_ns = ns_per_s;
constexpr TimeNs refresh_after_ns = ns_per_s;
/// udev gives a new node its group a moment after the kernel made it.
constexpr TimeNs permission_grace_ns = 3 * ns_per_s;
/// Opening anew is the only way to find out whether a format is free: a program may hold it without reading, and 0.12
/// does not tell who reads.
constexpr TimeNs look_again_ns = 5 * ns_per_s;

}  // namespace

LoopbackHost::LoopbackHost(stream::FrameBus& bus, stream::FrameFetcher& fetcher, LoopbackKernel& kernel,
                           std::shared_ptr<TaskQueue> tasks, Options options)
    : bus_(bus), fetcher_(fetcher), kernel_(kernel), module_(kernel), tasks_(std::move(tasks)), options_(options) {}

LoopbackHost::~LoopbackHost() {
    for (auto& [number, device] : devices_) {
        const auto* const open = std::get_if<Open>(&device.state);
        if (open && !device.is_own) open->sink->with_device([](LoopbackDevice& node) { node.release_format(); });
        close(device);
        if (!device.is_own) continue;
        if (const auto removed = module_.remove(number); !removed)
            spdlog::info("{}; it stays for the next rig", removed.error().message);
    }
}

void LoopbackHost::set(LoopbackSettings settings, TimeNs monotonic_ns) {
    thread_.check();
    const auto [found, is_new] = devices_.try_emplace(settings.number);
    Device& device = found->second;
    if (is_new || std::holds_alternative<Leaving>(device.state) || device.settings.camera != settings.camera) {
        close(device);
        // Made anew, under its own label; if a program has it open, it goes on under the old one.
        if (device.is_own && module_.remove(settings.number)) device.is_own = false;
    } else if (auto* const open = std::get_if<Open>(&device.state)) {
        if (std::exchange(open->shown.rate, settings.format.rate) != settings.format.rate)
            open->sink->with_device([&](LoopbackDevice& node) { node.change_rate(settings.format.rate); });
        if (std::exchange(open->shown.mjpg_sampling, settings.format.mjpg_sampling) != settings.format.mjpg_sampling)
            open->subscription.reset();  // and subscribes anew
    }
    device.settings = std::move(settings);
    device.retry_ns = device.reopen_ns = monotonic_ns;
    device.last_error.clear();
}

void LoopbackHost::unset(int number, TimeNs monotonic_ns) {
    thread_.check();
    const auto found = devices_.find(number);
    if (found == devices_.end()) return;
    Device& device = found->second;
    if (const auto* const open = std::get_if<Open>(&device.state))
        open->sink->with_device([](LoopbackDevice& node) { node.release_format(); });
    close(device);
    device.state = Leaving{};
    device.retry_ns = monotonic_ns;
}

void LoopbackHost::tick(TimeNs monotonic_ns) {
    thread_.check();
    for (auto it = devices_.begin(); it != devices_.end();) {
        Device& device = it->second;
        if (std::holds_alternative<Leaving>(device.state)) {
            it = remove(device, monotonic_ns) ? devices_.erase(it) : std::next(it);
            continue;
        }
        if (std::holds_alternative<Closed>(device.state) && monotonic_ns >= device.retry_ns) open(device, monotonic_ns);
        if (std::holds_alternative<Open>(device.state)) update(device, monotonic_ns);
        ++it;
    }
}

bool LoopbackHost::remove(Device& device, TimeNs monotonic_ns) {
    if (!device.is_own) return true;
    if (monotonic_ns < device.retry_ns) return false;
    const auto removed = module_.remove(device.settings.number);
    if (removed || removed.error().kind == ErrorKind::not_found) return true;
    report(device, removed.error(), monotonic_ns);
    return false;
}

Result<std::unique_ptr<LoopbackDevice>> LoopbackHost::try_open(Device& device, TimeNs monotonic_ns) {
    const LoopbackSettings& settings = device.settings;
    const auto provided = module_.provide(settings.number, settings.camera);
    if (!provided) return std::unexpected(provided.error());
    if (provided->is_new) {
        device.is_own = true;
        device.made_ns = monotonic_ns;
    }
    auto node = LoopbackDevice::open(kernel_, provided->features, settings.number, settings.format);
    if (!node) return std::unexpected(node.error());
    if ((*node)->buffers() != static_cast<int>(LoopbackDevice::buffer_count))
        spdlog::warn(
            "camera {}: {} has {} buffers, programs as ROS usb_cam need 4: load v4l2loopback with max_buffers=4",
            settings.camera, video_path(settings.number), (*node)->buffers());
    return node;
}

void LoopbackHost::open(Device& device, TimeNs monotonic_ns) {
    auto node = try_open(device, monotonic_ns);
    if (!node) {
        const bool may_come = node.error().kind == ErrorKind::unauthorized && device.made_ns != 0 &&
                              monotonic_ns - device.made_ns < permission_grace_ns;
        if (!may_come) return report(device, node.error(), monotonic_ns);
        device.retry_ns = monotonic_ns;
        return;
    }
    const LoopbackFormat shown = (*node)->format();
    device.state =
        Open{.sink = std::make_shared<LoopbackSink>(std::move(*node)), .shown = shown, .refresh_ns = monotonic_ns};
    if (!shown.same_pictures(device.settings.format)) return;
    device.last_error.clear();
    spdlog::info("camera {}: {} shows {}", device.settings.camera, video_path(device.settings.number),
                 shown.to_string());
}

void LoopbackHost::close(Device& device) {
    if (auto* const open = std::get_if<Open>(&device.state)) {
        open->subscription.reset();  // waits for a write under way
        open->sink->give_up();
    }
    device.state = Closed{};
}

// A format is for the life of a device: readers have mapped its buffers. So a change waits for the reader to go, and
// until then the camera's pictures are scaled to what the reader has.
LoopbackHost::Open* LoopbackHost::apply_format(Device& device, bool may_reopen, TimeNs monotonic_ns) {
    const LoopbackFormat& wanted = device.settings.format;
    if (may_reopen && !std::get<Open>(device.state).shown.same_pictures(wanted)) {
        device.reopen_ns = monotonic_ns + look_again_ns;
        close(device);
        open(device, monotonic_ns);
    }
    auto* const open = std::get_if<Open>(&device.state);
    if (!open || open->shown.same_pictures(wanted)) return open;
    report(device,
           {ErrorKind::unavailable, video_path(device.settings.number) + ": a program has it open at " +
                                        open->shown.to_string() + " and keeps getting that, scaled; it becomes " +
                                        wanted.to_string() + " when that program closes it"},
           monotonic_ns);
    device.retry_ns = monotonic_ns;  // what there is goes on
    return open;
}

void LoopbackHost::update(Device& device, TimeNs monotonic_ns) {
    auto* open = &std::get<Open>(device.state);
    const auto readers = open->sink->with_device([](LoopbackDevice& node) { return node.has_readers(); });
    if (!readers) {
        close(device);
        return report(device, readers.error(), monotonic_ns);
    }
    const bool tells = readers->has_value();
    const bool was_read = std::exchange(open->is_read, readers->value_or(true));
    const bool is_certainly_read = tells && open->is_read;
    const bool has_just_left = was_read && !open->is_read;
    open =
        apply_format(device, !is_certainly_read && (has_just_left || monotonic_ns >= device.reopen_ns), monotonic_ns);
    if (!open) return;

    const bool wanted = open->is_read || options_.is_lockstep;
    if (!wanted && open->subscription) open->subscription.reset();
    if (wanted && !open->subscription && monotonic_ns >= device.retry_ns) subscribe(device, *open, monotonic_ns);

    if (monotonic_ns >= open->refresh_ns) {
        open->refresh_ns = monotonic_ns + refresh_after_ns;
        if (!open->is_fetching && (!open->sink->has_picture() || !wanted)) fetch(device, *open);
        if (open->sink->with_device([](LoopbackDevice& node) { return node.restore_rate(); }))
            spdlog::info("{}: a program asked for another rate; it stays {} per second, the camera's",
                         video_path(device.settings.number), open->shown.rate.to_string());
    }
    const bool is_idle = tells && !open->is_read;
    if (options_.is_lockstep && !is_idle) return;
    if (const auto repeated = open->sink->repeat_if_silent(monotonic_ns); !repeated) {
        close(device);
        report(device, repeated.error(), monotonic_ns);
    }
}

LoopbackHost::Device* LoopbackHost::find(int number, const std::weak_ptr<LoopbackSink>& sink) {
    const auto found = devices_.find(number);
    if (found == devices_.end()) return nullptr;
    const auto* const open = std::get_if<Open>(&found->second.state);
    return open && open->sink == sink.lock() ? &found->second : nullptr;
}

void LoopbackHost::subscribe(Device& device, Open& open, TimeNs monotonic_ns) {
    stream::SubscribeOptions options;
    options.kind = "v4l2";
    options.peer = video_path(device.settings.number);
    const auto on_end = [this, tasks = tasks_, number = device.settings.number,
                         sink = std::weak_ptr(open.sink)](Error why) {
        tasks->post([this, number, sink, why = std::move(why)] {
            Device* const ended = find(number, sink);
            if (!ended) return;
            std::get<Open>(ended->state).subscription.reset();
            // not_found: the camera is gone, and so will be its settings. unavailable: its size changed.
            if (why.kind == ErrorKind::not_found || why.kind == ErrorKind::unavailable) return;
            close(*ended);
            report(*ended, why, monotonic_now_ns());
        });
    };
    auto subscription =
        bus_.subscribe(device.settings.camera, *media_format_of(open.shown), std::move(options), open.sink, on_end);
    if (subscription)
        open.subscription = std::move(*subscription);
    else
        report(device, subscription.error(), monotonic_ns);
}

void LoopbackHost::fetch(const Device& device, Open& open) {
    open.is_fetching = true;
    stream::FetchRequest request;
    request.camera = device.settings.camera;
    request.format = *media_format_of(open.shown);
    fetcher_.fetch(std::move(request), [this, tasks = tasks_, number = device.settings.number,
                                        sink = std::weak_ptr(open.sink)](Result<stream::MediaUnit> unit) {
        tasks->post([this, number, sink, unit = std::move(unit)] {
            Device* const waiting = find(number, sink);
            if (!waiting) return;
            auto& shows = std::get<Open>(waiting->state);
            shows.is_fetching = false;
            if (!unit) return;
            const TimeNs now_ns = monotonic_now_ns();
            if (const auto shown = shows.sink->refresh(*unit, now_ns); !shown) {
                close(*waiting);
                report(*waiting, shown.error(), now_ns);
            }
        });
    });
}

void LoopbackHost::report(Device& device, const Error& why, TimeNs monotonic_ns) {
    device.retry_ns = monotonic_ns + retry_after_ns;
    if (std::exchange(device.last_error, why.message) == why.message) return;
    const bool is_wanted = !std::holds_alternative<Leaving>(device.state);
    spdlog::error("{}: {}", is_wanted ? "camera " + device.settings.camera : video_path(device.settings.number),
                  why.message);
}

std::vector<int> LoopbackHost::watch_fds() const {
    std::vector<int> fds;
    for (const auto& [number, device] : devices_) {
        const auto* const open = std::get_if<Open>(&device.state);
        const int fd = open ? open->sink->with_device([](LoopbackDevice& node) { return node.readers_fd(); }) : -1;
        if (fd >= 0) fds.push_back(fd);
    }
    return fds;
}

}  // namespace camrig::device

#include "v4l2_sink/loopback/loopback_host.h"

#include <utility>

#include <spdlog/spdlog.h>

#include "core/base/clock.h"

namespace camrig {

namespace {

constexpr TimeNs retry_after_ns = ns_per_s;
constexpr TimeNs refresh_after_ns = ns_per_s;
/// udev gives a new node its group a moment after the kernel made it.
constexpr TimeNs permission_grace_ns = 3 * ns_per_s;
/// Opening anew is the only way to find out whether a format is free: a program may hold it without reading, and 0.12
/// does not tell who reads.
constexpr TimeNs look_again_ns = 5 * ns_per_s;

}  // namespace

LoopbackHost::LoopbackHost(FrameBus& bus, FrameFetcher& fetcher, LoopbackKernel& kernel,
                           std::shared_ptr<TaskQueue> tasks, Options options)
    : bus_(bus), fetcher_(fetcher), kernel_(kernel), module_(kernel), tasks_(std::move(tasks)), options_(options) {}

LoopbackHost::~LoopbackHost() {
    for (auto& [number, entry] : entries_) {
        if (entry.sink && !entry.is_own)
            entry.sink->with_device([](LoopbackDevice& device) { device.release_format(); });
        close(entry);
        if (!entry.is_own) continue;
        if (const auto removed = module_.remove(number); !removed)
            spdlog::info("{}; it stays for the next rig", removed.error().message);
    }
}

void LoopbackHost::set(LoopbackWish wish, TimeNs monotonic_ns) {
    Entry& entry = entries_[wish.number];
    if (!entry.wish || entry.wish->camera != wish.camera) {
        close(entry);
        // Made anew, under its own label; if a program has it open, it goes on under the old one.
        if (entry.is_own && module_.remove(wish.number)) entry.is_own = false;
    } else if (entry.sink) {
        if (std::exchange(entry.shown.rate, wish.format.rate) != wish.format.rate)
            entry.sink->with_device([&](LoopbackDevice& device) { device.change_rate(wish.format.rate); });
        if (std::exchange(entry.shown.mjpg_sampling, wish.format.mjpg_sampling) != wish.format.mjpg_sampling)
            entry.subscription.reset();  // and subscribes anew
    }
    entry.wish = std::move(wish);
    entry.retry_ns = entry.reopen_ns = monotonic_ns;
    entry.complaint.clear();
}

void LoopbackHost::unset(int number, TimeNs monotonic_ns) {
    const auto found = entries_.find(number);
    if (found == entries_.end()) return;
    found->second.wish.reset();
    found->second.retry_ns = monotonic_ns;
}

void LoopbackHost::tick(TimeNs monotonic_ns) {
    for (auto it = entries_.begin(); it != entries_.end();) {
        auto& [number, entry] = *it;
        if (!entry.wish) {
            it = discard(number, entry, monotonic_ns) ? entries_.erase(it) : std::next(it);
            continue;
        }
        if (!entry.sink && monotonic_ns >= entry.retry_ns) open(number, entry, monotonic_ns);
        if (entry.sink) attend(number, entry, monotonic_ns);
        ++it;
    }
}

bool LoopbackHost::discard(int number, Entry& entry, TimeNs monotonic_ns) {
    if (entry.sink) {
        entry.sink->with_device([](LoopbackDevice& device) { device.release_format(); });
        close(entry);
    }
    if (!entry.is_own) return true;
    if (monotonic_ns < entry.retry_ns) return false;
    const auto removed = module_.remove(number);
    if (removed || removed.error().kind == ErrorKind::not_found) return true;
    complain(number, entry, removed.error(), monotonic_ns);
    return false;
}

Result<std::unique_ptr<LoopbackDevice>> LoopbackHost::try_open(Entry& entry, TimeNs monotonic_ns) {
    const LoopbackWish& wish = *entry.wish;
    const auto provided = module_.provide(wish.number, wish.camera);
    if (!provided) return std::unexpected(provided.error());
    if (provided->is_new) {
        entry.is_own = true;
        entry.made_ns = monotonic_ns;
    }
    auto device = LoopbackDevice::open(kernel_, provided->features, wish.number, wish.format);
    if (!device) return std::unexpected(device.error());
    if ((*device)->buffers() != static_cast<int>(LoopbackDevice::buffer_count))
        spdlog::warn(
            "camera {}: {} has {} buffers, programs as ROS usb_cam need 4: load v4l2loopback with max_buffers=4",
            wish.camera, video_path(wish.number), (*device)->buffers());
    return device;
}

void LoopbackHost::open(int number, Entry& entry, TimeNs monotonic_ns) {
    auto device = try_open(entry, monotonic_ns);
    if (!device) {
        const bool may_come = device.error().kind == ErrorKind::unauthorized && entry.made_ns != 0 &&
                              monotonic_ns - entry.made_ns < permission_grace_ns;
        if (!may_come) return complain(number, entry, device.error(), monotonic_ns);
        entry.retry_ns = monotonic_ns;
        return;
    }
    entry.shown = (*device)->format();
    entry.sink = std::make_shared<LoopbackSink>(std::move(*device));
    entry.is_read = false;
    entry.refresh_ns = monotonic_ns;
    if (entry.shown.same_pictures(entry.wish->format)) {
        entry.complaint.clear();
        spdlog::info("camera {}: {} shows {}", entry.wish->camera, video_path(number), entry.shown.to_string());
    }
}

// A format is for the life of a device: readers have mapped its buffers. So a change waits for the reader to go, and
// until then the camera's pictures are scaled to what the reader has.
void LoopbackHost::follow_wish(int number, Entry& entry, bool may_reopen, TimeNs monotonic_ns) {
    if (entry.shown.same_pictures(entry.wish->format)) return;
    if (may_reopen) {
        entry.reopen_ns = monotonic_ns + look_again_ns;
        close(entry);
        open(number, entry, monotonic_ns);
    }
    if (!entry.sink || entry.shown.same_pictures(entry.wish->format)) return;
    complain(number, entry,
             {ErrorKind::unavailable, video_path(number) + ": a program has it open at " + entry.shown.to_string() +
                                          " and keeps getting that, scaled; it becomes " +
                                          entry.wish->format.to_string() + " when that program closes it"},
             monotonic_ns);
    entry.retry_ns = monotonic_ns;  // what there is goes on
}

void LoopbackHost::attend(int number, Entry& entry, TimeNs monotonic_ns) {
    const auto readers = entry.sink->with_device([](LoopbackDevice& device) { return device.has_readers(); });
    if (!readers) {
        close(entry);
        return complain(number, entry, readers.error(), monotonic_ns);
    }
    const bool tells = readers->has_value();
    const bool was_read = std::exchange(entry.is_read, readers->value_or(true));
    const bool is_certainly_read = tells && entry.is_read;
    const bool has_just_left = was_read && !entry.is_read;
    follow_wish(number, entry, !is_certainly_read && (has_just_left || monotonic_ns >= entry.reopen_ns), monotonic_ns);
    if (!entry.sink) return;

    const bool wanted = entry.is_read || options_.always_subscribed;
    if (!wanted && entry.subscription) entry.subscription.reset();
    if (wanted && !entry.subscription && monotonic_ns >= entry.retry_ns) subscribe(number, entry, monotonic_ns);

    if (monotonic_ns >= entry.refresh_ns) {
        entry.refresh_ns = monotonic_ns + refresh_after_ns;
        if (!entry.is_fetching && (!entry.sink->has_picture() || !wanted)) fetch(number, entry);
        if (entry.sink->with_device([](LoopbackDevice& device) { return device.restore_rate(); }))
            spdlog::info("{}: a program asked for another rate; it stays {} per second, the camera's",
                         video_path(number), entry.shown.rate.to_string());
    }
    if (const auto repeated = entry.sink->repeat_if_silent(monotonic_ns, tells && !entry.is_read); !repeated) {
        close(entry);
        complain(number, entry, repeated.error(), monotonic_ns);
    }
}

void LoopbackHost::subscribe(int number, Entry& entry, TimeNs monotonic_ns) {
    SubscribeOptions options;
    options.kind = "v4l2";
    options.peer = video_path(number);
    const std::weak_ptr<LoopbackSink> sink = entry.sink;
    const auto on_end = [this, tasks = tasks_, number, sink](Error why) {
        tasks->post([this, number, sink, why = std::move(why)] {
            const auto found = entries_.find(number);
            if (found == entries_.end() || !found->second.sink || found->second.sink != sink.lock()) return;
            found->second.subscription.reset();
            const TimeNs now_ns = monotonic_now_ns();
            // not_found: the camera is gone, and so will be the wish. unavailable: its size changed.
            if (why.kind == ErrorKind::not_found || why.kind == ErrorKind::unavailable) return;
            close(found->second);
            complain(number, found->second, why, now_ns);
        });
    };
    auto subscription =
        bus_.subscribe(entry.wish->camera, *media_format_of(entry.shown), std::move(options), entry.sink, on_end);
    if (subscription)
        entry.subscription = std::move(*subscription);
    else
        complain(number, entry, subscription.error(), monotonic_ns);
}

void LoopbackHost::fetch(int number, Entry& entry) {
    entry.is_fetching = true;
    FetchRequest request;
    request.camera = entry.wish->camera;
    request.format = *media_format_of(entry.shown);
    const std::weak_ptr<LoopbackSink> sink = entry.sink;
    fetcher_.fetch(std::move(request), [this, tasks = tasks_, number, sink](Result<MediaUnit> unit) {
        tasks->post([this, number, sink, unit = std::move(unit)] {
            const auto found = entries_.find(number);
            if (found == entries_.end() || !found->second.sink || found->second.sink != sink.lock()) return;
            found->second.is_fetching = false;
            if (!unit) return;
            const TimeNs now_ns = monotonic_now_ns();
            if (const auto shown = found->second.sink->refresh(*unit, now_ns); !shown) {
                close(found->second);
                complain(number, found->second, shown.error(), now_ns);
            }
        });
    });
}

void LoopbackHost::close(Entry& entry) {
    entry.subscription.reset();  // waits for a write under way
    if (entry.sink) entry.sink->give_up();
    entry.sink.reset();
    entry.is_fetching = false;
}

void LoopbackHost::complain(int number, Entry& entry, const Error& why, TimeNs monotonic_ns) {
    entry.retry_ns = monotonic_ns + retry_after_ns;
    if (std::exchange(entry.complaint, why.message) == why.message) return;
    const std::string camera = entry.wish ? "camera " + entry.wish->camera : video_path(number);
    spdlog::error("{}: {}", camera, why.message);
}

std::vector<int> LoopbackHost::watch_fds() const {
    std::vector<int> fds;
    for (const auto& [number, entry] : entries_) {
        const int fd =
            entry.sink ? entry.sink->with_device([](LoopbackDevice& device) { return device.readers_fd(); }) : -1;
        if (fd >= 0) fds.push_back(fd);
    }
    return fds;
}

}  // namespace camrig

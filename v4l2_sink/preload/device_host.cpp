#include "v4l2_sink/preload/device_host.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <linux/videodev2.h>
#include <sys/socket.h>

namespace camrig {

namespace {

constexpr TimeNs idle_repeat_ns = ns_per_s;

void copy_text(std::span<char> to, std::string_view text) {
    const std::size_t length = std::min(text.size(), to.size() - 1);
    std::memcpy(to.data(), text.data(), length);
    to[length] = 0;
}

bool same_rate(const camrig_rate& a, const camrig_rate& b) {
    return std::uint64_t{a.num} * b.den == std::uint64_t{b.num} * a.den;
}

bool offered(const camrig_description& d, const camrig_format& f) {
    bool format = false, size = false, rate = false;
    for (std::uint32_t i = 0; i < d.format_count; ++i) format = format || d.fourcc[i] == f.fourcc;
    for (std::uint32_t i = 0; i < d.size_count; ++i) size = size || (d.width[i] == f.width && d.height[i] == f.height);
    for (std::uint32_t i = 0; i < d.rate_count; ++i)
        rate = rate || (d.rate[i].num == f.rate.num && d.rate[i].den == f.rate.den);
    return format && size && rate;
}

/// A socket pair for tokens, rig to program. The program's end never becomes writable, as a capture device never does:
/// its direction is filled up here for good.
bool make_event_sockets(UniqueFd& rig, UniqueFd& program) {
    int pair[2];
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair) != 0) return false;
    rig.reset(pair[0]);
    program.reset(pair[1]);
    const int smallest = 1;
    ::setsockopt(program.get(), SOL_SOCKET, SO_SNDBUF, &smallest, sizeof smallest);
    const char filler[1024]{};
    while (::send(program.get(), filler, sizeof filler, MSG_DONTWAIT | MSG_NOSIGNAL) > 0) {
    }
    return true;
}

int errno_of(const Error& error) {
    switch (error.kind) {
        case ErrorKind::invalid_argument:
            return ERANGE;
        case ErrorKind::not_found:
            return EINVAL;
        case ErrorKind::resource_exhausted:
            return ENOMEM;
        case ErrorKind::unavailable:
            return EBUSY;
        default:
            return EIO;
    }
}

}  // namespace

DeviceHost::~DeviceHost() {
    for (const SessionRef& session : sessions_) stream_off(session);
}

void DeviceHost::add_device(int number, std::string camera, DevicePolicy policy) {
    devices_[number] = DeviceState{std::move(camera), policy, std::nullopt};
}

void DeviceHost::remove_device(int number) {
    devices_.erase(number);
    const auto sessions = sessions_;
    for (const SessionRef& session : sessions)
        if (session->number == number) end(session);
}

void DeviceHost::end(const SessionRef& session) {
    session->dead = true;
    session->event_socket.reset();  // the program sees POLLHUP: unplugged
    leave(session);
    ended_.push_back(session);
}

void DeviceHost::receive(const SessionRef& session, std::span<const std::byte> message) {
    camrig_request request{};
    if (message.size() != sizeof request || session->awaits_reply) return end(session);
    std::memcpy(&request, message.data(), sizeof request);
    const bool introduced = session->number.has_value();
    if (introduced == (request.type == camrig_request_hello)) return end(session);

    int problem = 0;
    switch (request.type) {
        case camrig_request_hello:
            problem = hello(session, request);
            break;
        case camrig_request_get_format:
            problem = get_format(session, request);
            break;
        case camrig_request_set_format:
            problem = set_format(session, request);
            break;
        case camrig_request_acquire:
            problem = acquire(session);
            break;
        case camrig_request_release:
            problem = owned_by_another(*session) ? EBUSY : 0;
            session->owns_buffers = false;
            break;
        case camrig_request_stream_on:
            problem = stream_on(session, request);
            break;
        case camrig_request_stream_off:
            stream_off(session);
            break;
        case camrig_request_get_control:
            problem = get_control(session, request);
            break;
        case camrig_request_set_controls:
            problem = set_controls(session, request);
            break;
        case camrig_request_menu:
            problem = menu(session, request);
            break;
        case camrig_request_subscribe:
            problem = subscribe(session, request);
            break;
        case camrig_request_priority:
            problem = set_priority(session, request.u.priority);
            break;
        case camrig_request_credit:
            if (session->ring) session->ring->ring->credit(*session->reader);
            return;
        default:
            return end(session);
    }
    constexpr int answered = -1;
    if (problem == answered) {
    } else if (problem != 0) {
        session->fail(request.serial, problem);
    } else {
        session->reply(request.serial, camrig_reply{});
    }
    if (session->dead) end(session);
}

int DeviceHost::describe(DeviceSession& session, const DeviceState& device, int number) {
    const auto camera = bus_.find(device.camera);
    if (!camera) return ENODEV;
    camrig_description& d = session.description;
    d = {};
    d.protocol = CAMRIG_DEVICE_PROTOCOL;
    copy_text(d.card, device.camera);
    copy_text(d.bus_info, "platform:camrig-" + std::to_string(number));
    const DeviceModes modes = modes_of(*camera);
    for (const std::uint32_t fourcc : device_fourccs) d.fourcc[d.format_count++] = fourcc;
    for (const ImageSize size : modes.sizes) {
        if (d.size_count == camrig_max_sizes) break;
        d.width[d.size_count] = static_cast<std::uint32_t>(size.width);
        d.height[d.size_count++] = static_cast<std::uint32_t>(size.height);
    }
    for (const Rate& rate : modes.rates) {
        if (d.rate_count == camrig_max_rates) break;
        d.rate[d.rate_count++] = {static_cast<std::uint32_t>(rate.num()), static_cast<std::uint32_t>(rate.den())};
    }
    for (const DeviceControl& control : controls_->list(device.camera)) {
        if (d.control_count == camrig_max_controls) break;
        camrig_control& out = d.control[d.control_count++];
        out.id = control.id;
        out.type = control.kind == DeviceControl::Kind::menu      ? V4L2_CTRL_TYPE_MENU
                   : control.kind == DeviceControl::Kind::boolean ? V4L2_CTRL_TYPE_BOOLEAN
                                                                  : V4L2_CTRL_TYPE_INTEGER;
        out.flags = control.flags;
        out.minimum = control.minimum;
        out.maximum = control.maximum;
        out.step = control.step;
        out.default_value = control.default_value;
        copy_text(out.name, control.name);
        for (std::size_t i = 0; i < control.menu.size(); ++i) {
            const std::int64_t value = control.minimum + static_cast<std::int64_t>(i);
            if (!control.menu[i].empty() && value >= 0 && value < 32) out.menu_mask |= 1u << value;
        }
    }
    d.current = {d.fourcc[0], d.width[0], d.height[0], d.rate[0]};
    // The camera may have changed since somebody set a format.
    if (device.format && offered(d, *device.format)) d.current = *device.format;
    return 0;
}

int DeviceHost::hello(const SessionRef& session, const camrig_request& request) {
    const auto device = devices_.find(static_cast<int>(request.u.hello.number));
    if (request.u.hello.number > camrig_max_device_number || device == devices_.end()) return ENODEV;
    if (request.u.hello.protocol != CAMRIG_DEVICE_PROTOCOL) return EPROTO;
    if (sessions_.size() >= max_sessions) return EBUSY;
    const int number = device->first;
    if (const int problem = describe(*session, device->second, number)) return problem;

    UniqueFd program_end;
    auto page = SharedMemory::create("camrig reader", camrig_reader_page_bytes, false);
    if (!page || !make_event_sockets(session->event_socket, program_end)) return ENOMEM;
    session->page = std::move(*page);
    session->format = session->description.current;
    session->priority = V4L2_PRIORITY_DEFAULT;
    session->number = number;

    const char* program = request.u.hello.program;
    session->stats = std::make_shared<ReaderStats>();
    session->stats->kind = "device";
    session->stats->peer = "/dev/video" + std::to_string(number) + " read by " +
                           std::string(program, ::strnlen(program, sizeof request.u.hello.program));
    session->reader = std::make_shared<RingReader>(session->event_socket.get(), &session->shared(), session->stats);
    sessions_.insert(session);
    share_priorities(number);

    camrig_reply reply{};
    reply.u.description = session->description;
    const int fds[] = {program_end.get(), session->page.fd()};
    session->reply(request.serial, reply, fds);
    return -1;
}

camrig_format DeviceHost::format_of(const DeviceSession& session) const {
    const DeviceState& device = devices_.at(*session.number);
    if (session.format_chosen || session.owns_buffers) return session.format;
    return device.format && offered(session.description, *device.format) ? *device.format : session.format;
}

int DeviceHost::get_format(const SessionRef& session, const camrig_request& request) {
    session->format = format_of(*session);
    camrig_reply reply{};
    reply.u.format = session->format;
    session->reply(request.serial, reply);
    return -1;
}

int DeviceHost::set_format(const SessionRef& session, const camrig_request& request) {
    if (!offered(session->description, request.u.format)) return EINVAL;
    if (session->owns_buffers && std::memcmp(&session->format, &request.u.format, 12) != 0) return EBUSY;
    if (owned_by_another(*session)) return EBUSY;
    for (const SessionRef& other : sessions_) {
        if (!share_queue(*session, *other)) continue;
        other->format = request.u.format;
        other->format_chosen = true;
    }
    devices_.at(*session->number).format = request.u.format;
    return 0;
}

bool DeviceHost::share_queue(const DeviceSession& a, const DeviceSession& b) const {
    return a.number == b.number && (devices_.at(*a.number).policy == DevicePolicy::exclusive || a.process == b.process);
}

bool DeviceHost::owned_by_another(const DeviceSession& session) const {
    return std::ranges::any_of(sessions_, [&](const SessionRef& other) {
        return other.get() != &session && other->owns_buffers && share_queue(session, *other);
    });
}

int DeviceHost::acquire(const SessionRef& session) {
    if (owned_by_another(*session)) return EBUSY;
    session->owns_buffers = true;
    return 0;
}

int DeviceHost::stream_on(const SessionRef& session, const camrig_request& request) {
    if (!offered(session->description, request.u.format) || session->ring) return EINVAL;
    if (owned_by_another(*session)) return EBUSY;
    auto ring = ring_for(devices_.at(*session->number).camera, request.u.format);
    if (!ring) return ring.error().kind == ErrorKind::not_found ? ENODEV : errno_of(ring.error());
    session->ring = *ring;
    session->format = request.u.format;
    camrig_reply reply{};
    reply.u.ring = session->ring->ring->attach(session->reader);
    const int fds[] = {session->ring->ring->memory_fd()};
    session->reply(request.serial, reply, fds);
    return -1;
}

void DeviceHost::stream_off(const SessionRef& session) {
    if (!session->ring) return;
    session->ring->ring->detach(session->reader);
    session->ring.reset();  // the last reader ends the subscription
}

Result<std::shared_ptr<FedRing>> DeviceHost::ring_for(const std::string& camera, const camrig_format& format) {
    const auto stream = bus_.find(camera);
    if (!stream) return std::unexpected(stream.error());
    camrig_format key = format;
    const camrig_rate own{static_cast<std::uint32_t>(stream->rate.num()),
                          static_cast<std::uint32_t>(stream->rate.den())};
    if (same_rate(format.rate, own)) key.rate = {0, 0};

    std::erase_if(rings_, [](const auto& ring) { return ring.expired(); });
    for (const auto& known : rings_)
        if (auto ring = known.lock();
            ring && ring->camera == camera && std::memcmp(&ring->format, &key, sizeof key) == 0)
            return ring;

    std::optional<Rate> rate;
    if (key.rate.num != 0) {
        const auto lower = Rate::create(key.rate.num, key.rate.den);
        if (!lower) return std::unexpected(lower.error());
        rate = *lower;
    }
    const auto media = media_format_of(format);
    if (!media) return error(ErrorKind::invalid_argument, "a pixel format that devices do not have");
    auto memory = DeviceRing::create(media->size, picture_bytes(format), rate);
    if (!memory) return std::unexpected(memory.error());
    auto ring = std::make_shared<FedRing>();
    ring->camera = camera;
    ring->format = key;
    ring->ring = std::move(*memory);
    if (auto fed = feed(ring); !fed) return std::unexpected(fed.error());
    rings_.push_back(ring);
    return ring;
}

Result<void> DeviceHost::feed(const std::shared_ptr<FedRing>& ring) {
    SubscribeOptions options;
    options.kind = "device";
    options.peer = "ring " + std::to_string(ring->format.width) + "x" + std::to_string(ring->format.height);
    if (ring->format.rate.num != 0) {
        const auto rate = Rate::create(ring->format.rate.num, ring->format.rate.den);
        if (!rate) return std::unexpected(rate.error());
        options.rate = *rate;
    }
    auto subscription = bus_.subscribe(ring->camera, *media_format_of(ring->format), std::move(options), ring->ring,
                                       [this, tasks = tasks_, weak = std::weak_ptr(ring)](const Error&) {
                                           tasks->post([this, weak] {
                                               if (auto ended = weak.lock()) ring_ended(ended);
                                           });
                                       });
    if (!subscription) return std::unexpected(subscription.error());
    ring->subscription = std::move(*subscription);
    return {};
}

void DeviceHost::ring_ended(const std::shared_ptr<FedRing>& ring) {
    // A camera that changed its size goes on in the reader's size; one that was deleted is unplugged.
    ring->subscription.reset();
    if (feed(ring)) return;
    const auto sessions = sessions_;
    for (const SessionRef& session : sessions)
        if (session->ring == ring) end(session);
}

int DeviceHost::get_control(const SessionRef& session, const camrig_request& request) {
    const auto value = controls_->get(devices_.at(*session->number).camera, request.u.control_id);
    if (!value) return errno_of(value.error());
    camrig_reply reply{};
    reply.u.controls.count = 1;
    reply.u.controls.values[0] = {request.u.control_id, *value};
    session->reply(request.serial, reply);
    return -1;
}

int DeviceHost::set_controls(const SessionRef& session, const camrig_request& request) {
    const camrig_controls_set& wish = request.u.controls;
    if (wish.count == 0 || wish.count > camrig_max_controls) return EINVAL;
    std::vector<DeviceControlValue> values;
    for (std::uint32_t i = 0; i < wish.count; ++i) {
        const camrig_description& d = session->description;
        const auto* end = d.control + d.control_count;
        const auto* known =
            std::find_if(d.control, end, [&](const camrig_control& c) { return c.id == wish.values[i].id; });
        if (known == end) return EINVAL;
        if (wish.values[i].value < known->minimum || wish.values[i].value > known->maximum) return ERANGE;
        values.push_back({wish.values[i].id, wish.values[i].value});
    }
    const std::string camera = devices_.at(*session->number).camera;
    session->awaits_reply = true;
    controls_->set(camera, values,
                   [this, tasks = tasks_, weak = std::weak_ptr(session), camera, values,
                    serial = request.serial](const Result<void>& done) {
                       tasks->post([this, weak, camera, values, serial, done] {
                           const SessionRef asker = weak.lock();
                           if (!asker) return;
                           asker->awaits_reply = false;
                           if (done) {
                               for (const auto& [id, value] : values) tell_change(asker.get(), camera, id, value);
                               asker->reply(serial, camrig_reply{});
                           } else {
                               asker->fail(serial, errno_of(done.error()));
                           }
                       });
                   });
    return -1;
}

void DeviceHost::tell_change(const DeviceSession* by, const std::string& camera, std::uint32_t id, std::int32_t value) {
    for (const SessionRef& session : sessions_) {
        const auto device = devices_.find(*session->number);
        const auto subscription = session->subscriptions.find(id);
        if (device == devices_.end() || device->second.camera != camera || subscription == session->subscriptions.end())
            continue;
        if (session.get() == by && !subscription->second) continue;
        const camrig_control_event event{camrig_message_control_event, id, value, 0};
        session->send(std::as_bytes(std::span(&event, 1)));
    }
}

void DeviceHost::controls_changed(const std::string& camera) {
    for (const DeviceControl& control : controls_->list(camera))
        if (const auto value = controls_->get(camera, control.id)) tell_change(nullptr, camera, control.id, *value);
}

int DeviceHost::menu(const SessionRef& session, const camrig_request& request) {
    for (const DeviceControl& control : controls_->list(devices_.at(*session->number).camera)) {
        if (control.id != request.u.menu.id || control.kind != DeviceControl::Kind::menu) continue;
        const std::int64_t entry = std::int64_t{request.u.menu.index} - control.minimum;
        if (entry < 0 || entry >= std::ssize(control.menu) || control.menu[static_cast<std::size_t>(entry)].empty())
            return EINVAL;
        camrig_reply reply{};
        copy_text(reply.u.menu_name, control.menu[static_cast<std::size_t>(entry)]);
        session->reply(request.serial, reply);
        return -1;
    }
    return EINVAL;
}

int DeviceHost::subscribe(const SessionRef& session, const camrig_request& request) {
    const camrig_subscribe& wish = request.u.subscribe;
    const camrig_description& d = session->description;
    const auto* end = d.control + d.control_count;
    if (std::none_of(d.control, end, [&](const camrig_control& c) { return c.id == wish.id; })) return EINVAL;
    if (wish.on != 0)
        session->subscriptions[wish.id] = wish.feedback != 0;
    else
        session->subscriptions.erase(wish.id);
    return 0;
}

int DeviceHost::set_priority(const SessionRef& session, std::uint32_t priority) {
    if (priority > V4L2_PRIORITY_RECORD) return EINVAL;
    session->priority = priority;
    share_priorities(*session->number);
    return 0;
}

void DeviceHost::share_priorities(int number) {
    std::uint32_t top = 0;
    for (const SessionRef& session : sessions_)
        if (session->number == number) top = std::max(top, session->priority);
    for (const SessionRef& session : sessions_)
        if (session->number == number) __atomic_store_n(&session->shared().top_priority, top, __ATOMIC_RELAXED);
}

void DeviceHost::leave(const SessionRef& session) {
    stream_off(session);
    if (sessions_.erase(session) > 0) share_priorities(*session->number);
}

void DeviceHost::tick(TimeNs monotonic_ns) {
    for (const auto& known : rings_)
        if (auto ring = known.lock()) ring->ring->repeat_if_idle(monotonic_ns, idle_repeat_ns);
}

std::vector<std::shared_ptr<ReaderStats>> DeviceHost::reader_stats() const {
    std::vector<std::shared_ptr<ReaderStats>> all;
    for (const SessionRef& session : sessions_) all.push_back(session->stats);
    return all;
}

}  // namespace camrig

#include "v4l2_sink/preload/device_host.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <linux/videodev2.h>
#include <sys/socket.h>

#include "v4l2_sink/preload/number_fourccs.h"

namespace camrig::device {

namespace {

bool offered(const camrig_description& d, const camrig_format& f) {
    bool format = false, size = false, rate = false;
    std::uint32_t sizes = d.size_count;
    for (std::uint32_t i = 0; i < d.format_count; ++i) {
        if (d.fourcc[i] != f.fourcc) continue;
        format = true;
        if ((d.one_size_mask >> i & 1u) != 0) sizes = 1;
    }
    for (std::uint32_t i = 0; i < sizes; ++i) size = size || (d.width[i] == f.width && d.height[i] == f.height);
    for (std::uint32_t i = 0; i < d.rate_count; ++i)
        rate = rate || (d.rate[i].num == f.rate.num && d.rate[i].den == f.rate.den);
    return format && size && rate;
}

/// A program names itself as it likes; what would move a terminal's cursor or begin a new line becomes '?'.
std::string printable(std::string_view name) {
    std::string text(name);
    std::ranges::replace_if(text, [](char c) { return c < 0x20 || c > 0x7e; }, '?');
    return text;
}

/// The reader as books and messages name it.
std::string peer_text(const DeviceSession& session, const camrig_hello& hello) {
    return "/dev/video" + std::to_string(hello.number) + " read by " +
           printable({hello.program, ::strnlen(hello.program, sizeof hello.program)}) + " (process " +
           std::to_string(session.peer_process()) + ")";
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

}  // namespace

DeviceHost::DeviceHost(stream::FrameBus& bus, std::shared_ptr<ControlPort> controls,
                       const std::shared_ptr<TaskQueue>& tasks, bool is_lockstep)
    : bus_(bus),
      controls_(std::move(controls), tasks, [this](const std::string& camera) { return openers_of(camera); }),
      rings_(bus, tasks, [this](const std::shared_ptr<FedRing>& ring) { unplug(ring); }, is_lockstep) {}

DeviceHost::~DeviceHost() {
    for (const SessionRef& session : sessions_) stream_off(session);
}

void DeviceHost::add_device(int number, std::string camera, codec::ChromaSampling mjpg_sampling) {
    thread_.check();
    remove_device(number);
    devices_[number] = DeviceState{std::move(camera), mjpg_sampling, std::nullopt};
}

void DeviceHost::remove_device(int number) {
    thread_.check();
    devices_.erase(number);
    const auto sessions = sessions_;
    for (const SessionRef& session : sessions)
        if (session->number == number) end(session);
}

void DeviceHost::set_standing(const std::string& camera, const fault::Standing& standing) {
    thread_.check();
    if (standing == fault::Standing{})
        standing_.erase(camera);
    else
        standing_[camera] = standing;
    for (const SessionRef& session : openers_of(camera)) share_errors(*session);
}

void DeviceHost::share_errors(DeviceSession& session) {
    const auto known = standing_.find(camera_of(session));
    __atomic_store_n(&session.shared().errors, known == standing_.end() ? 0 : known->second.device_errors,
                     __ATOMIC_RELEASE);
}

void DeviceHost::end(const SessionRef& session) {
    session->dead = true;
    leave(session);                 // first: nobody may send a token to a number that is free again
    session->event_socket.reset();  // the program sees POLLHUP: unplugged
    ended_.push_back(session);
}

void DeviceHost::receive(const SessionRef& session, std::span<const std::byte> message) {
    thread_.check();
    if (session->dead) return;  // its device was removed just before; the connection is closed next
    camrig_request request{};
    if (message.size() != sizeof request || session->awaits_reply) return end(session);
    std::memcpy(&request, message.data(), sizeof request);
    const bool introduced = session->number.has_value();
    if (introduced == (request.type == camrig_request_hello)) return end(session);

    Handled problem = 0;
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
            problem = controls_.get(session, camera_of(*session), request);
            break;
        case camrig_request_set_controls:
            problem = controls_.set(session, camera_of(*session), request);
            break;
        case camrig_request_menu:
            problem = controls_.menu(*session, camera_of(*session), request);
            break;
        case camrig_request_subscribe:
            problem = DeviceControls::subscribe(*session, request);
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
    if (problem && *problem != 0) session->fail(request.serial, *problem);
    if (problem && *problem == 0) session->reply(request.serial, camrig_reply{});
    if (session->dead) end(session);
}

void DeviceHost::tick(TimeNs monotonic_ns) {
    thread_.check();
    rings_.tick(monotonic_ns);
    std::vector<SessionRef> given_up;  // also since their last request, by an answer or an event
    for (const SessionRef& session : sessions_) {
        session->send_waiting();
        if (session->dead) given_up.push_back(session);
    }
    for (const SessionRef& session : given_up) end(session);
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
    for (const std::uint32_t fourcc : modes.fourccs) {
        if (d.format_count == camrig_max_formats) break;
        if (number_fourcc(fourcc) != nullptr) d.one_size_mask |= 1u << d.format_count;
        d.fourcc[d.format_count++] = fourcc;
    }
    for (const ImageSize size : modes.sizes) {
        if (d.size_count == camrig_max_sizes) break;
        d.width[d.size_count] = static_cast<std::uint32_t>(size.width);
        d.height[d.size_count++] = static_cast<std::uint32_t>(size.height);
    }
    for (const Rate& rate : modes.rates) {
        if (d.rate_count == camrig_max_rates) break;
        d.rate[d.rate_count++] = {static_cast<std::uint32_t>(rate.num()), static_cast<std::uint32_t>(rate.den())};
    }
    controls_.describe(device.camera, d);
    d.current = {d.fourcc[0], d.width[0], d.height[0], d.rate[0]};
    // The camera may have changed since somebody set a format.
    if (device.format && offered(d, *device.format)) d.current = *device.format;
    return 0;
}

Handled DeviceHost::hello(const SessionRef& session, const camrig_request& request) {
    const auto device = devices_.find(static_cast<int>(request.u.hello.number));
    if (request.u.hello.number > camrig_max_device_number || device == devices_.end()) return ENODEV;
    if (request.u.hello.protocol != CAMRIG_DEVICE_PROTOCOL) return EPROTO;
    if (sessions_.size() >= max_sessions) return EBUSY;
    if (const auto known = standing_.find(device->second.camera);
        known != standing_.end() && known->second.refuses("device")) {
        bus_.note_refused(device->second.camera, "device", peer_text(*session, request.u.hello));
        return EBUSY;
    }
    const int number = device->first;
    if (const int problem = describe(*session, device->second, number)) return problem;

    UniqueFd program_end;
    auto page = SharedMemory::create("camrig reader", camrig_reader_page_bytes, false);
    if (!page || !make_event_sockets(session->event_socket, program_end)) return ENOMEM;
    session->page = std::move(*page);
    session->format = session->description.current;
    session->priority = V4L2_PRIORITY_DEFAULT;
    session->number = number;
    session->process = std::uint64_t{request.u.hello.process[1]} << 32 | request.u.hello.process[0];

    session->stats = std::make_shared<stream::ReaderStats>();
    session->stats->kind = "device";
    session->stats->peer = peer_text(*session, request.u.hello);
    session->reader = std::make_shared<RingReader>(session->event_socket.get(), &session->shared(), session->stats);
    sessions_.insert(session);
    share_priorities(number);
    share_errors(*session);

    camrig_reply reply{};
    reply.u.description = session->description;
    const int fds[] = {program_end.get(), session->page.fd()};
    session->reply(request.serial, reply, fds);
    return answered;
}

camrig_format DeviceHost::format_of(const DeviceSession& session) const {
    const DeviceState& device = devices_.at(*session.number);
    if (session.format_chosen || session.owns_buffers) return session.format;
    return device.format && offered(session.description, *device.format) ? *device.format : session.format;
}

Handled DeviceHost::get_format(const SessionRef& session, const camrig_request& request) {
    session->format = format_of(*session);
    camrig_reply reply{};
    reply.u.format = session->format;
    session->reply(request.serial, reply);
    return answered;
}

Handled DeviceHost::set_format(const SessionRef& session, const camrig_request& request) {
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
    return a.number == b.number && a.process == b.process;
}

bool DeviceHost::owned_by_another(const DeviceSession& session) const {
    return std::ranges::any_of(sessions_, [&](const SessionRef& other) {
        return other.get() != &session && other->owns_buffers && share_queue(session, *other);
    });
}

Handled DeviceHost::acquire(const SessionRef& session) {
    if (owned_by_another(*session)) return EBUSY;
    session->owns_buffers = true;
    return 0;
}

Handled DeviceHost::stream_on(const SessionRef& session, const camrig_request& request) {
    if (!offered(session->description, request.u.format) || session->ring) return EINVAL;
    if (owned_by_another(*session)) return EBUSY;
    const DeviceState& device = devices_.at(*session->number);
    auto ring = rings_.take(device.camera, request.u.format, device.mjpg_sampling);
    if (!ring) return ring.error().kind == ErrorKind::not_found ? ENODEV : errno_of(ring.error());
    session->ring = *ring;
    session->format = request.u.format;
    camrig_reply reply{};
    reply.u.ring = session->ring->ring->attach(session->reader);
    const int fds[] = {session->ring->ring->memory_fd()};
    session->reply(request.serial, reply, fds);
    return answered;
}

void DeviceHost::stream_off(const SessionRef& session) {
    if (!session->ring) return;
    session->ring->ring->detach(session->reader);
    session->ring.reset();  // the last reader ends the subscription
}

const std::string& DeviceHost::camera_of(const DeviceSession& session) const {
    return devices_.at(*session.number).camera;
}

std::vector<std::shared_ptr<DeviceSession>> DeviceHost::openers_of(const std::string& camera) const {
    std::vector<SessionRef> openers;
    for (const SessionRef& session : sessions_) {
        const auto device = devices_.find(*session->number);
        if (device != devices_.end() && device->second.camera == camera) openers.push_back(session);
    }
    return openers;
}

void DeviceHost::unplug(const std::shared_ptr<FedRing>& ring) {
    const auto sessions = sessions_;
    for (const SessionRef& session : sessions)
        if (session->ring == ring) end(session);
}

Handled DeviceHost::set_priority(const SessionRef& session, std::uint32_t priority) {
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

}  // namespace camrig::device

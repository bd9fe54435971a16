#include "v4l2_sink/preload/device_session.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <poll.h>
#include <sys/socket.h>

namespace camrig::device {

namespace {
constexpr std::size_t max_fds = 2;
}

void copy_text(std::span<char> to, std::string_view text) {
    const std::size_t length = std::min(text.size(), to.size() - 1);
    std::memcpy(to.data(), text.data(), length);
    to[length] = 0;
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

DeviceSession::DeviceSession(UniqueFd control) : control_(std::move(control)) {}

pid_t DeviceSession::peer_process() const {
    ucred peer{};
    socklen_t length = sizeof peer;
    return ::getsockopt(control_.get(), SOL_SOCKET, SO_PEERCRED, &peer, &length) == 0 ? peer.pid : 0;
}

void DeviceSession::send(std::span<const std::byte> message, std::span<const int> fds) {
    if (dead) return;
    iovec part{const_cast<std::byte*>(message.data()), message.size()};
    alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int) * max_fds)]{};
    msghdr header{};
    header.msg_iov = &part;
    header.msg_iovlen = 1;
    CHECK(fds.size() <= max_fds);
    if (!fds.empty()) {
        header.msg_control = control;
        header.msg_controllen = CMSG_SPACE(sizeof(int) * fds.size());
        cmsghdr* rights = CMSG_FIRSTHDR(&header);
        rights->cmsg_level = SOL_SOCKET;
        rights->cmsg_type = SCM_RIGHTS;
        rights->cmsg_len = CMSG_LEN(sizeof(int) * fds.size());
        std::memcpy(CMSG_DATA(rights), fds.data(), sizeof(int) * fds.size());
    }
    // An honest library has one request under way and reads every reply, and events leave room for it.
    if (::sendmsg(control_.get(), &header, MSG_DONTWAIT | MSG_NOSIGNAL) < 0) dead = true;
}

void DeviceSession::reply(std::uint32_t serial, camrig_reply answer, std::span<const int> fds) {
    answer.type = camrig_message_reply;
    answer.serial = serial;
    send(std::as_bytes(std::span(&answer, 1)), fds);
}

void DeviceSession::fail(std::uint32_t serial, int error_number, std::uint32_t detail) {
    camrig_reply answer{};
    answer.status = error_number;
    answer.detail = detail;
    reply(serial, answer);
}

void DeviceSession::tell(const camrig_control_event& event) {
    waiting_[event.id] = event;
    send_waiting();
}

void DeviceSession::send_waiting() {
    // "Writable" is a Unix socket with a quarter of its room used at most: replies keep the rest.
    const auto takes_more = [this] {
        pollfd control{control_.get(), POLLOUT, 0};
        return ::poll(&control, 1, 0) == 1 && (control.revents & POLLOUT) != 0;
    };
    while (!dead && !waiting_.empty() && takes_more()) {
        send(std::as_bytes(std::span(&waiting_.begin()->second, 1)));
        waiting_.erase(waiting_.begin());
    }
}

}  // namespace camrig::device

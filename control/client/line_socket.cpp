#include "control/client/line_socket.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

namespace camrig::client {
namespace {

constexpr std::size_t read_bytes = 256 * 1024;

std::unexpected<camrig::Error> nobody(const std::string& peer, int reason) {
    const bool is_missing = reason == ENOENT || reason == ECONNREFUSED;
    return error(ErrorKind::unavailable, "no rig at " + peer + ": " + std::strerror(reason) +
                                             (is_missing ? "; start one with: camrig serve SCENE" : ""));
}

Result<void> wait_for(int fd, short events, Deadline deadline, const std::string& peer) {
    for (;;) {
        const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
        pollfd entry{fd, events, 0};
        const int ready = ::poll(&entry, 1, static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, 1 << 30)));
        if (ready > 0) return {};
        if (ready == 0) return error(ErrorKind::unavailable, peer + ": no answer in time");
        if (errno != EINTR) return error(ErrorKind::internal, peer + ": poll: " + std::strerror(errno));
    }
}

/// Connects a non-blocking socket; the result of a connect that took its time is in SO_ERROR.
Result<UniqueFd> connect_to(int family, const sockaddr* address, socklen_t size, Deadline deadline,
                            const std::string& peer) {
    UniqueFd fd(::socket(family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    if (!fd) return nobody(peer, errno);
    if (::connect(fd.get(), address, size) == 0) return fd;
    if (errno != EINPROGRESS) return nobody(peer, errno);
    if (auto ready = wait_for(fd.get(), POLLOUT, deadline, peer); !ready) return std::unexpected(ready.error());
    int failed = 0;
    socklen_t length = sizeof failed;
    if (::getsockopt(fd.get(), SOL_SOCKET, SO_ERROR, &failed, &length) != 0) failed = errno;
    if (failed != 0) return nobody(peer, failed);
    return fd;
}

/// Below /tmp anybody may have made the socket of this name first. Trusted are this user, root, and the owner of the
/// socket's folder where nobody else can put anything into it (a service's /run/camrig).
Result<void> check_server(int fd, const std::string& path) {
    ucred server{};
    socklen_t length = sizeof server;
    if (::getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &server, &length) != 0)
        return error(ErrorKind::unavailable, path + ": who serves it cannot be told: " + std::strerror(errno));
    if (server.uid == ::geteuid() || server.uid == 0) return {};
    const std::size_t slash = path.rfind('/');
    const std::string folder = slash == std::string::npos ? "." : path.substr(0, slash + 1);
    struct stat facts{};
    if (::stat(folder.c_str(), &facts) == 0 && facts.st_uid == server.uid && (facts.st_mode & 0022) == 0) return {};
    return error(ErrorKind::unauthorized,
                 path + ": is served by user " + std::to_string(server.uid) + ", not by user " +
                     std::to_string(::geteuid()) +
                     ": nothing was sent; to command a rig of that user, be that user (or use its TCP port and token)");
}

Result<UniqueFd> connect_unix(const Endpoint& endpoint, Deadline deadline) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (endpoint.unix_path.size() >= sizeof address.sun_path)
        return error(ErrorKind::invalid_argument, "--control " + endpoint.unix_path + ": too long for a socket's path");
    std::memcpy(address.sun_path, endpoint.unix_path.data(), endpoint.unix_path.size());
    auto fd = connect_to(AF_UNIX, reinterpret_cast<const sockaddr*>(&address), sizeof address, deadline,
                         endpoint.to_string());
    if (auto trusted = fd ? check_server(fd->get(), endpoint.to_string()) : Result<void>(); !trusted)
        return std::unexpected(trusted.error());
    return fd;
}

Result<UniqueFd> connect_tcp(const Endpoint& endpoint, Deadline deadline) {
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    const int failed = ::getaddrinfo(endpoint.host.c_str(), std::to_string(endpoint.port).c_str(), &hints, &found);
    if (failed != 0)
        return error(ErrorKind::unavailable, "no rig at " + endpoint.to_string() + ": " + ::gai_strerror(failed));
    const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owner(found, &::freeaddrinfo);
    Result<UniqueFd> fd = nobody(endpoint.to_string(), EADDRNOTAVAIL);
    for (const addrinfo* one = found; one && !fd; one = one->ai_next)
        fd = connect_to(one->ai_family, one->ai_addr, one->ai_addrlen, deadline, endpoint.to_string());
    const int on = 1;
    if (fd) ::setsockopt(fd->get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    return fd;
}

}  // namespace

Result<LineSocket> LineSocket::connect(const Endpoint& endpoint, Deadline deadline) {
    auto fd = endpoint.host.empty() ? connect_unix(endpoint, deadline) : connect_tcp(endpoint, deadline);
    if (!fd) return std::unexpected(fd.error());
    return LineSocket(std::move(*fd), endpoint.to_string());
}

Result<void> LineSocket::wait(short events, Deadline deadline) const {
    return wait_for(fd_.get(), events, deadline, peer_);
}

bool LineSocket::is_quiet() const {
    pollfd entry{fd_.get(), POLLIN, 0};
    return received_.empty() && ::poll(&entry, 1, 0) == 0;
}

Result<void> LineSocket::send(std::string_view line, Deadline deadline) {
    const std::string text = std::string(line) + "\n";
    std::size_t sent = 0;
    while (sent < text.size()) {
        const ssize_t count = ::send(fd_.get(), text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
        if (count >= 0) {
            sent += static_cast<std::size_t>(count);
        } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
            if (auto ready = wait(POLLOUT, deadline); !ready) return ready;
        } else if (errno != EINTR) {
            return error(ErrorKind::unavailable, peer_ + ": the rig has gone away: " + std::strerror(errno));
        }
    }
    return {};
}

Result<std::string> LineSocket::receive(std::size_t max_bytes, Deadline deadline) {
    std::size_t scanned = 0;
    for (;;) {
        if (const std::size_t end = received_.find('\n', scanned); end != std::string::npos) {
            std::string line = received_.substr(0, end);
            received_.erase(0, end + 1);
            return line;
        }
        scanned = received_.size();
        if (scanned > max_bytes)
            return error(ErrorKind::resource_exhausted,
                         peer_ + ": an answer of more than " + std::to_string(max_bytes) + " bytes");
        if (auto ready = wait(POLLIN, deadline); !ready) return std::unexpected(ready.error());
        received_.resize(scanned + read_bytes);
        const ssize_t count = ::recv(fd_.get(), received_.data() + scanned, read_bytes, 0);
        const int reason = errno;
        received_.resize(scanned + static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
        if (count == 0) return error(ErrorKind::unavailable, peer_ + ": the rig has ended the connection");
        if (count < 0 && reason != EAGAIN && reason != EWOULDBLOCK && reason != EINTR)
            return error(ErrorKind::unavailable, peer_ + ": the rig has gone away: " + std::strerror(reason));
    }
}

}  // namespace camrig::client

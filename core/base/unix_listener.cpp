#include "core/base/unix_listener.h"

#include <cerrno>
#include <cstring>
#include <utility>

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

namespace camrig {
namespace {

constexpr int listen_backlog = 128;

UniqueFd make_socket(int type) {
    return UniqueFd(::socket(AF_UNIX, type | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
}

/// Somebody listens there: with a full backlog, or for connections of another type, it is somebody too.
bool is_alive(const sockaddr_un& address, int type) {
    const UniqueFd probe = make_socket(type);
    if (!probe) return true;
    return ::connect(probe.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 ||
           (errno != ECONNREFUSED && errno != ENOENT);
}

/// `place` begins every message.
Result<void> clear_the_way(const std::string& place, const sockaddr_un& address, int type) {
    struct stat facts{};
    if (::lstat(address.sun_path, &facts) != 0) return {};
    if (!S_ISSOCK(facts.st_mode))
        return error(ErrorKind::unavailable,
                     place + "there is a file of that name that is no socket; choose another --control");
    if (facts.st_uid != ::geteuid())
        return error(ErrorKind::unavailable, place + "belongs to user " + std::to_string(facts.st_uid) +
                                                 ", not to user " + std::to_string(::geteuid()) +
                                                 "; have it removed, or choose another --control");
    if (is_alive(address, type))
        return error(
            ErrorKind::already_exists,
            place + "another rig lives there; end it (camrig call server.shutdown) or choose another --control");
    if (::unlink(address.sun_path) != 0)
        return error(ErrorKind::unavailable, place + "a stale socket cannot be removed: " + std::strerror(errno));
    return {};
}

}  // namespace

UnixListener::UnixListener(UnixListener&& other) noexcept
    : fd_(std::move(other.fd_)), path_(std::exchange(other.path_, {})), device_(other.device_), inode_(other.inode_) {}

UnixListener& UnixListener::operator=(UnixListener&& other) noexcept {
    if (this == &other) return *this;
    remove_file();
    fd_ = std::move(other.fd_);
    path_ = std::exchange(other.path_, {});
    device_ = other.device_;
    inode_ = other.inode_;
    return *this;
}

Result<UnixListener> UnixListener::listen(const std::string& path, UnixListenerOptions options) {
    const std::string place = options.name + std::string(" ") + path + ": ";
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path.empty() || path.size() >= sizeof address.sun_path)
        return error(ErrorKind::invalid_argument,
                     place + "a socket's path has 1 to " + std::to_string(sizeof address.sun_path - 1) + " bytes");
    std::memcpy(address.sun_path, path.data(), path.size());
    if (auto clear = clear_the_way(place, address, options.type); !clear) return std::unexpected(clear.error());

    const auto failed = [&](const std::string& what) {
        return error(ErrorKind::unavailable, place + what + std::strerror(errno));
    };
    UnixListener listener;
    listener.fd_ = make_socket(options.type);
    if (!listener.fd_) return failed("");
    // On Linux the socket's own mode becomes the file's, so there is no moment in which others may connect.
    if (::fchmod(listener.fd_.get(), 0600) != 0) return failed("");
    if (::bind(listener.fd_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
        return failed("cannot be made: ");
    listener.path_ = path;
    struct stat facts{};
    if (::lstat(path.c_str(), &facts) != 0) return failed("");
    listener.device_ = facts.st_dev;
    listener.inode_ = facts.st_ino;
    if (::chmod(path.c_str(), 0600) != 0 || ::listen(listener.fd_.get(), listen_backlog) != 0) return failed("");
    return listener;
}

void UnixListener::remove_file() noexcept {
    if (path_.empty()) return;
    struct stat facts{};
    if (::lstat(path_.c_str(), &facts) == 0 && facts.st_dev == device_ && facts.st_ino == inode_)
        ::unlink(path_.c_str());
    path_.clear();
}

}  // namespace camrig

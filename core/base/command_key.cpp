#include "core/base/command_key.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <utility>

#include <arpa/inet.h>
#include <dirent.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <unistd.h>

#include "core/base/private_folder.h"
#include "core/base/unique_fd.h"
#include "core/base/write_file.h"

namespace camrig {
namespace {

constexpr std::size_t key_bytes = 24;
constexpr std::size_t max_key_file_bytes = 256;

UniqueFd open_key(const char* path) {
    return UniqueFd(::open(path, O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
}

/// Whether the rig that wrote it lives. Where the file system knows no locks it is believed to.
bool is_held(const UniqueFd& key) {
    return ::flock(key.get(), LOCK_SH | LOCK_NB) != 0;
}

/// Needs the folder's lock: else a key that is just written could be taken for one that was left.
void remove_left_keys(const std::string& folder) {
    const std::unique_ptr<DIR, int (*)(DIR*)> entries(::opendir(folder.c_str()), ::closedir);
    if (!entries) return;
    while (const dirent* const entry = ::readdir(entries.get())) {
        if (!std::string_view(entry->d_name).ends_with(".key")) continue;
        const std::string path = folder + "/" + entry->d_name;
        if (const UniqueFd key = open_key(path.c_str()); key && !is_held(key)) ::unlink(path.c_str());
    }
}

}  // namespace

Result<std::string> new_command_key() {
    std::array<unsigned char, key_bytes> bytes{};
    // Requests of up to 256 bytes are neither cut nor interrupted (getrandom(2)).
    if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
        return error(ErrorKind::unavailable, std::string("no random numbers for a key: ") + std::strerror(errno));
    std::string key;
    for (const unsigned char byte : bytes) {
        key += "0123456789abcdef"[byte >> 4];
        key += "0123456789abcdef"[byte & 15];
    }
    return key;
}

std::string command_key_path(std::string_view address, std::uint16_t port) {
    const std::string host(address);
    return user_runtime_folder() + "/" + (host.find(':') == std::string::npos ? host : "[" + host + "]") + ":" +
           std::to_string(port) + ".key";
}

Result<CommandKeyFile> CommandKeyFile::create(std::string_view key, std::string_view address, std::uint16_t port) {
    const std::string folder = user_runtime_folder();
    if (auto made = make_private_folder(folder); !made) return std::unexpected(made.error());
    const UniqueFd one_at_a_time(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (one_at_a_time) ::flock(one_at_a_time.get(), LOCK_EX);
    remove_left_keys(folder);
    // A new file takes the old one's place in one step: a client sees one key or the other, never half of one.
    const std::string path = command_key_path(address, port);
    const std::string line = std::string(key) + "\n";
    if (auto written = write_atomically(path, std::as_bytes(std::span(line)), 0600); !written)
        return std::unexpected(written.error());
    UniqueFd lock = open_key(path.c_str());
    if (lock) ::flock(lock.get(), LOCK_EX);
    return CommandKeyFile(path, std::move(lock));
}

CommandKeyFile::CommandKeyFile(CommandKeyFile&& other) noexcept
    : path_(std::exchange(other.path_, {})), lock_(std::move(other.lock_)) {}

CommandKeyFile::~CommandKeyFile() {
    if (!path_.empty()) ::unlink(path_.c_str());
}

std::optional<std::string> read_command_key(std::string_view address, std::uint16_t port) {
    if (!check_private_folder(user_runtime_folder())) return std::nullopt;
    const UniqueFd file = open_key(command_key_path(address, port).c_str());
    if (!file || !is_held(file)) return std::nullopt;
    std::array<char, max_key_file_bytes> bytes{};
    const ssize_t size = ::read(file.get(), bytes.data(), bytes.size());
    std::string key(bytes.data(), static_cast<std::size_t>(size > 0 ? size : 0));
    while (key.ends_with('\n')) key.pop_back();
    return key.empty() ? std::nullopt : std::optional(key);
}

std::optional<std::string> read_command_key_for(int socket) {
    sockaddr_storage peer{};
    socklen_t length = sizeof peer;
    if (::getpeername(socket, reinterpret_cast<sockaddr*>(&peer), &length) != 0) return std::nullopt;
    const auto* four = reinterpret_cast<const sockaddr_in*>(&peer);
    const auto* six = reinterpret_cast<const sockaddr_in6*>(&peer);
    const bool is_four = peer.ss_family == AF_INET;
    if (!is_four && peer.ss_family != AF_INET6) return std::nullopt;
    std::array<char, INET6_ADDRSTRLEN> address{};
    const void* number = is_four ? static_cast<const void*>(&four->sin_addr) : &six->sin6_addr;
    if (!::inet_ntop(peer.ss_family, number, address.data(), address.size())) return std::nullopt;
    return read_command_key(address.data(), ntohs(is_four ? four->sin_port : six->sin6_port));
}

}  // namespace camrig

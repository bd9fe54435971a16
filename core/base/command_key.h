#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/base/unique_fd.h"

namespace camrig {

/// The key that commands need over loopback HTTP and TCP.
///
/// On loopback every user of the machine reaches every port, so who may command is told by a file: the rig makes a key
/// at its start and writes it where only its own user can read, once for each address it listens on; clients of the
/// same user find it by the address they are connected to. The name holds the whole address, because another user may
/// listen on the same port of [::1] and must not be given the key of 127.0.0.1.

/// 48 hexadecimal digits from the kernel's random numbers.
Result<std::string> new_command_key();

/// USER_RUNTIME_FOLDER/127.0.0.1:8080.key; `address` in numbers, as getpeername() tells it.
std::string command_key_path(std::string_view address, std::uint16_t port);

/// A key's file for as long as the rig listens; mode 0600, locked (flock(2)). What a rig that was killed left behind
/// is free: nobody believes it, so that no stranger who listens there afterwards is shown it, and who comes next
/// removes it.
class CommandKeyFile {
public:
    static Result<CommandKeyFile> create(std::string_view key, std::string_view address, std::uint16_t port);
    CommandKeyFile(CommandKeyFile&& other) noexcept;
    CommandKeyFile& operator=(CommandKeyFile&&) = delete;
    ~CommandKeyFile();

    const std::string& path() const { return path_; }

private:
    CommandKeyFile(std::string path, UniqueFd lock) : path_(std::move(path)), lock_(std::move(lock)) {}

    std::string path_;
    UniqueFd lock_;
};

/// The key of the rig that listens there, if this user has one; believed only where nobody else could have written it
/// and while that rig lives.
std::optional<std::string> read_command_key(std::string_view address, std::uint16_t port);
/// The same for the other end of a connected TCP socket.
std::optional<std::string> read_command_key_for(int socket);

}  // namespace camrig

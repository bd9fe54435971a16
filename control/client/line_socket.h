#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "control/client/endpoint.h"
#include "core/base/command_key.h"
#include "core/base/result.h"
#include "core/base/unique_fd.h"

namespace camrig::client {

using Deadline = std::chrono::steady_clock::time_point;

/// A connected stream socket that speaks in lines, with a deadline for every call. One thread at a time.
class LineSocket {
public:
    /// unauthorized: the Unix socket is served by a stranger, who is told nothing.
    static Result<LineSocket> connect(const Endpoint& endpoint, Deadline deadline);
    /// Takes a connected, non-blocking socket. `peer`: how messages name the other side.
    LineSocket(UniqueFd fd, std::string peer) : fd_(std::move(fd)), peer_(std::move(peer)) {}

    Result<void> send(std::string_view line, Deadline deadline);
    /// The next line without its end, at most `max_bytes` long.
    Result<std::string> receive(std::size_t max_bytes, Deadline deadline);
    /// False when the other side has closed it or has sent what nobody asked for.
    bool is_quiet() const;
    /// TCP on this machine: the key that a rig of this user wrote for whom it listens to there.
    std::optional<std::string> command_key() const { return read_command_key_for(fd_.get()); }

private:
    Result<void> wait(short events, Deadline deadline) const;

    UniqueFd fd_;
    std::string peer_;
    std::string received_;
};

}  // namespace camrig::client

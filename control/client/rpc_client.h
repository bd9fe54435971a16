#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "control/client/line_socket.h"
#include "core/base/result.h"

namespace camrig::client {

struct RpcClientOptions {
    Endpoint endpoint;
    std::string token = {};  ///< shown first, TCP only; empty: the key of this user's rig there, if it has one
    std::chrono::milliseconds connect_timeout{5'000};
};

/// Calls methods of a rig over its control socket, one at a time; blocks until the answer is there or the time is over.
///
/// Thread: one at a time. The rig's errors come with their kind and message. After an error of the connection itself
/// (`unavailable`) every further call fails; connect anew.
class RpcClient {
public:
    static Result<RpcClient> connect(const RpcClientOptions& options);
    /// Over a connection that is there already and has shown its token.
    explicit RpcClient(LineSocket socket) : socket_(std::move(socket)) {}

    Result<nlohmann::json> call(std::string_view method, const nlohmann::json& params = nlohmann::json::object(),
                                std::chrono::milliseconds timeout = default_timeout);

    /// Whether the next call has a connection that is in order, as far as can be known before.
    bool is_usable() const { return !is_broken_ && socket_.is_quiet(); }

    static constexpr std::chrono::milliseconds default_timeout{30'000};
    /// Bound of one reply: the largest frame.get in base64, plus headroom.
    static constexpr std::size_t max_reply_bytes = std::size_t{80} << 20;

private:
    LineSocket socket_;
    std::int64_t next_id_ = 1;
    bool is_broken_ = false;
};

}  // namespace camrig::client

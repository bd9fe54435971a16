#pragma once

#include <chrono>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include <camrig/rig.h>

#include "control/client/rpc_client.h"

namespace camrig::client {

/// Connection pool. Calls from any thread: each takes an idle connection, or makes one, and puts it back if it is still
/// in order.
class Connections {
public:
    explicit Connections(ConnectOptions options) : options_(std::move(options)) {}
    const ConnectOptions& options() const { return options_; }

    /// The result of the method; throws Error.
    nlohmann::json call(std::string_view method, const nlohmann::json& params = nlohmann::json::object());
    nlohmann::json call(std::string_view method, const nlohmann::json& params, std::chrono::milliseconds timeout);
    /// Asked once: where the rig's HTTP and RTSP are, "http://host:port". Error unsupported where it serves none.
    std::string url_of(const std::string& service);

private:
    RpcClient take();

    /// More callers at a time than this make a connection for each call.
    static constexpr std::size_t max_idle = 4;

    const ConnectOptions options_;
    std::mutex mutex_;
    std::vector<RpcClient> idle_;  ///< guarded by mutex_
    nlohmann::json info_;          ///< guarded by mutex_
};

}  // namespace camrig::client

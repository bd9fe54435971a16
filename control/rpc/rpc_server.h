#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "control/rpc/method.h"
#include "core/base/result.h"
#include "core/engine/command.h"
#include "core/stream/frame_bus.h"

namespace camrig {

/// What the methods work on; all of it must outlive the server.
struct RpcContext {
    CommandPort& commands;
    FrameFetcher& frames;
    /// Facts for server.info that only the composition root knows: renderer, ports, scene. May be empty.
    std::function<nlohmann::json()> info;
    /// Asks the program to end, after the answer has gone out.
    std::function<void()> shutdown;
};

/// Decodes JSON-RPC text, checks it against the method table and runs the methods. Knows no transport; any thread.
class RpcServer {
public:
    explicit RpcServer(RpcContext context);

    /// Handles one message (one request or one batch). `done` gets the answer, exactly once, from any thread; an empty
    /// string means there is nothing to answer (notifications only).
    void handle(std::string_view text, std::function<void(std::string)> done);

    const std::vector<Method>& methods() const { return methods_; }
    /// How often each method was called; tests use it to see that none was left out.
    std::map<std::string, std::uint64_t> calls() const;

private:
    void call(const nlohmann::json& params, std::size_t method, RpcReply done);

    RpcContext context_;
    std::vector<Method> methods_;
    std::map<std::string, std::size_t, std::less<>> by_name_;
    std::vector<std::atomic<std::uint64_t>> calls_;
};

/// The whole table. The methods keep a reference to the context.
std::vector<Method> make_methods(RpcContext& context, std::function<nlohmann::json()> call_counts);

/// docs/control-protocol.md's reference part.
std::string methods_as_markdown(const std::vector<Method>& methods);

}  // namespace camrig

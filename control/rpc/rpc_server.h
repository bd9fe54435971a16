#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "control/rpc/json_rpc.h"
#include "control/rpc/limits.h"
#include "control/rpc/method.h"
#include "core/base/result.h"
#include "core/engine/command.h"
#include "core/stream/frame_bus.h"
#include "core/stream/worker_pool.h"

namespace camrig::control {

/// A log of commands: its file, and how much of that is written.
struct LogPlace {
    std::filesystem::path file;
    std::uintmax_t bytes = 0;
};

/// What the methods work on; all of it must outlive the server's stop().
struct RpcContext {
    engine::CommandPort& commands;
    stream::FrameFetcher& frames;
    /// Facts for server.info that only the composition root knows: renderer, ports, scene. May be empty.
    std::function<nlohmann::json()> info = {};
    /// Asks the program to end, after the answer has gone out.
    std::function<void()> shutdown = {};
    /// What `auth` compares with; empty: any token will do.
    std::string token = {};
    ControlLimits limits = {};
    /// Said to a command of somebody who may only look: what to do about it.
    std::string how_to_command = "commands are taken on the control socket only";
    /// Errors about files below this folder are told in full to everybody who may command.
    std::filesystem::path scenes = {};
    /// Facts of this program, by name: build and the mathematics in use (rig.identity). May be empty.
    std::function<nlohmann::json()> identity = {};
    /// The log of commands as it is when this is called, on the engine's thread; may be empty: there is none.
    std::function<Result<LogPlace>()> log = {};
    /// Somebody keeps a log of commands, or compares what they were: they come with their text.
    bool keeps_text = false;

    // Made by the server: what all answers and the pictures being made for them count against; one thread reads scenes,
    // one backdrops, one turns the engine's replies into text, one searches the cameras of photos.
    std::shared_ptr<ByteBudget> budget = {};
    std::shared_ptr<stream::WorkerPool> loader = {};
    std::shared_ptr<stream::WorkerPool> backdrops = {};
    std::shared_ptr<stream::WorkerPool> replies = {};
    std::shared_ptr<stream::WorkerPool> searches = {};
};

/// Decodes JSON-RPC text, checks it against the method table and runs the methods. Knows no transport; any thread.
///
/// The requests of a message are started in their order, and the engine runs commands in that order; answers come when
/// they are ready. Only world.load reads its files first, for itself.
class RpcServer {
public:
    explicit RpcServer(RpcContext context);
    ~RpcServer();
    RpcServer(const RpcServer&) = delete;
    RpcServer& operator=(const RpcServer&) = delete;

    /// Handles one message (one request or one batch). `done` gets the answer, exactly once, from any thread; one
    /// without pieces means there is nothing to answer (notifications only). `done` may outlive the server.
    ///
    /// Answers are bounded before memory is taken for them: each by ControlLimits::reply_bytes, a batch as a whole by
    /// the same, and all by `peer_budget`, a share of budget() (null: by that alone). What does not fit becomes an
    /// error.
    ///
    /// takes_bytes: the bytes of a picture may follow the line of an answer.
    ///
    /// False: a backdrop's files are to be read, which takes long, so a thread of the server's starts the requests and
    /// calls `started` then. Who wants commands in order gives the next message only after that.
    bool handle(std::string_view text, std::function<void(RpcAnswer)> done, Authority authority = Authority::own,
                const std::shared_ptr<ByteBudget>& peer_budget = {}, bool takes_bytes = false,
                std::function<void()> started = {});
    const std::shared_ptr<ByteBudget>& budget() const { return context_.budget; }

    /// Waits for the scene and the backdrop being read and the search in progress (seconds), answers requests that wait
    /// for such with `unavailable`, and leaves commands and frames alone from then on, as far as those go. To be called
    /// before these go. Twice is fine.
    void stop();

    const std::vector<Method>& methods() const { return methods_; }
    /// How often each method was called; tests use it to see that none was left out.
    std::map<std::string, std::uint64_t> calls() const;

private:
    void call(const nlohmann::json& params, std::size_t method, Authority authority, RpcReply done);
    /// `done`, but what an error tells of files elsewhere goes to the log instead.
    RpcReply without_foreign_files(const nlohmann::json& params, RpcReply done) const;

    RpcContext context_;
    std::vector<Method> methods_;
    std::map<std::string, std::size_t, std::less<>> by_name_;
    std::vector<std::atomic<std::uint64_t>> calls_;
};

/// The whole table. The methods keep a reference to the context.
std::vector<Method> make_methods(RpcContext& context, std::function<nlohmann::json()> call_counts);

/// The table without a rig, for documentation: every handler answers `unavailable`.
const std::vector<Method>& documented_methods();
/// One of them, which must be there.
const Method& documented_method(std::string_view name);

/// Methods, and the parameters of objects, for programs: what server.describe answers and `camrig methods --json`
/// prints.
nlohmann::json protocol_description();

/// The whole of docs/control-protocol.md.
std::string control_protocol_markdown(const std::vector<Method>& methods);

}  // namespace camrig::control

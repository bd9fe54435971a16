#include <algorithm>
#include <chrono>
#include <functional>
#include <future>
#include <optional>

#include "control/rpc/command_log.h"
#include "control/rpc/rpc_server.h"

namespace camrig::control {
namespace {

using nlohmann::json;

/// So many are on their way at once: fewer than Agenda takes.
constexpr std::size_t max_batch_of_replay = 1000;

class Replay {
public:
    Replay(RpcServer& rpc, bool stands, TimeNs end_ns, const std::function<bool()>& must_end)
        : rpc_(rpc), must_end_(must_end), is_lockstep_(stands), stands_(stands), end_ns_(end_ns) {}

    Result<void> run(const LoggedCommand& command) {
        if (command.method == "world.step") {
            // However early it was asked for, it began when the one before it ended; one that was given up ended here.
            target_ns_ =
                command.has_failed ? command.at_ns : std::max(target_ns_, command.at_ns) + step_ns(command.params);
            return {};
        }
        const bool has_time = command.method.starts_with("world.") == false;
        if (!has_time || waiting_.size() >= max_batch_of_replay || (stands_ && command.at_ns > now_ns_))
            if (auto good = reach(command.at_ns); !good) return good;
        json params = command.params;
        if (has_time) params["at_ns"] = command.at_ns;
        waiting_.push_back({send(command.method, params), command});
        last_ns_ = command.at_ns;
        return has_time ? Result<void>() : change_clock(command.method);
    }
    Result<void> finish(const std::optional<SavedState>& saved) {
        if (auto good = reach(std::max({last_ns_, target_ns_, saved ? saved->world_ns : 0})); !good) return good;
        if (saved)
            if (auto same = compare(*saved); !same) return same;
        if (is_lockstep_) return {};
        if (auto set = call("world.limit", {{"clock_ns", now_ns_}}); !set) return set;
        return call("world.limit", {{"until_ns", max_time_ns}});
    }
    Result<void> begin() { return is_lockstep_ ? Result<void>() : hurry(); }

private:
    /// The clock is at the end: the world runs after it as fast as it can, as far as it may.
    Result<void> hurry() { return call("world.limit", {{"clock_ns", end_ns_}}); }
    static TimeNs step_ns(const json& params) {
        if (params.contains("nanoseconds")) return params["nanoseconds"].get<TimeNs>();
        return std::llround(params.value("seconds", 0.0) * 1e9);
    }
    /// All before that time is done, and the world is there.
    Result<void> reach(TimeNs world_ns) {
        if (stands_) {
            if (world_ns > now_ns_)
                if (auto stepped = call("world.step", {{"nanoseconds", world_ns - now_ns_}}); !stepped) return stepped;
        } else {
            auto there = send("world.digest", {{"at_ns", world_ns}});
            if (auto raised = call("world.limit", {{"until_ns", world_ns}}); !raised) return raised;
            if (const auto answer = wait_for(there); !answer) return std::unexpected(answer.error());
        }
        now_ns_ = world_ns;
        return collect();
    }
    Result<void> compare(const SavedState& saved) {
        auto asked = send("world.digest", {{"at_ns", saved.world_ns}});
        const auto told = wait_for(asked);
        if (!told) return std::unexpected(told.error());
        const std::string hash = told->value("hash", "");
        if (hash == saved.hash) return {};
        return error(ErrorKind::invalid_argument, "what comes of its commands is not the world that was saved: at " +
                                                      std::to_string(saved.world_ns) + " ns that had the hash " +
                                                      saved.hash + ", this one has " + hash +
                                                      "; was it saved by another build of camrig?");
    }
    Result<void> change_clock(const std::string& method) {
        if (auto good = collect(); !good) return good;
        if (method == "world.load") now_ns_ = last_ns_ = target_ns_ = 0;
        if (method == "world.pause") stands_ = true;
        if (method == "world.resume") stands_ = false;
        return stands_ ? Result<void>() : hurry();
    }
    Result<void> collect() {
        for (auto& [answer, command] : std::exchange(waiting_, {})) {
            const auto given = wait_for(answer);
            if (!given && given.error().kind == ErrorKind::unavailable) return std::unexpected(given.error());
            const std::string line = "line " + std::to_string(command.line);
            if (!given && !command.has_failed) return at(line, given.error());
            if (given && command.has_failed)
                return error(ErrorKind::invalid_argument,
                             line + ": " + command.method + " failed then, and does not now");
        }
        return {};
    }
    std::future<Result<json>> send(const std::string& method, const json& params) {
        auto promise = std::make_shared<std::promise<Result<json>>>();
        auto answer = promise->get_future();
        const json request = {{"jsonrpc", "2.0"}, {"id", 0}, {"method", method}, {"params", params}};
        const auto done = [promise, method](const RpcAnswer& reply) {
            const json value = json::parse(reply.joined(), nullptr, false);
            if (value.is_object() && value.contains("result")) return promise->set_value(value["result"]);
            const std::string why = value.is_object() ? value["error"].value("message", "") : "no answer";
            promise->set_value(error(ErrorKind::invalid_argument, method + ": " + why));
        };
        const auto started = std::make_shared<std::promise<void>>();
        if (!rpc_.handle(request.dump(), done, Authority::own, {}, false, [started] { started->set_value(); }))
            started->get_future().wait();
        return answer;
    }
    Result<void> call(const std::string& method, const json& params) {
        auto asked = send(method, params);
        if (const auto answer = wait_for(asked); !answer) return std::unexpected(answer.error());
        return {};
    }
    /// Or until it must end.
    Result<json> wait_for(std::future<Result<json>>& answer) const {
        while (answer.wait_for(std::chrono::milliseconds(50)) != std::future_status::ready)
            if (must_end_()) return error(ErrorKind::unavailable, "was ended");
        return answer.get();
    }

    RpcServer& rpc_;
    const std::function<bool()>& must_end_;
    const bool is_lockstep_;
    bool stands_;
    TimeNs end_ns_;
    TimeNs now_ns_ = 0, last_ns_ = 0;
    TimeNs target_ns_ = 0;  ///< of the last world.step
    struct Sent {
        std::future<Result<json>> answer;
        const LoggedCommand& command;  ///< of the log
    };
    std::vector<Sent> waiting_;
};

}  // namespace

Result<void> replay(const ReadCommandLog& log, RpcServer& rpc, const std::function<bool()>& must_end) {
    TimeNs end_ns = log.saved ? log.saved->world_ns : 0;
    for (const LoggedCommand& command : log.commands) end_ns = std::max(end_ns, command.at_ns);
    Replay again(rpc, log.identity.value("mode", "") == "lockstep", end_ns, must_end);
    if (auto begun = again.begin(); !begun) return begun;
    for (const LoggedCommand& command : log.commands)
        if (auto done = again.run(command); !done) return done;
    return again.finish(log.saved);
}

}  // namespace camrig::control

#include "tools/camrig/command_history.h"

#include <array>
#include <fstream>
#include <future>

#include <spdlog/spdlog.h>

#include "control/rpc/methods.h"
#include "core/base/clock.h"
#include "core/base/digest.h"
#include "core/base/math_fingerprint.h"

namespace camrig::cli {
namespace {

using nlohmann::json;

std::uint64_t digest_of_program() {
    std::ifstream program("/proc/self/exe", std::ios::binary);
    Digest digest;
    std::array<char, 1 << 16> chunk;
    while (program.read(chunk.data(), chunk.size()) || program.gcount() > 0)
        digest.add_bytes({chunk.data(), static_cast<std::size_t>(program.gcount())});
    return digest.value();
}

Result<json> identity_of(control::RpcServer& rpc) {
    std::promise<std::string> promise;
    rpc.handle(R"({"jsonrpc":"2.0","id":0,"method":"rig.identity"})",
               [&promise](const control::RpcAnswer& answer) { promise.set_value(answer.joined()); });
    json answer = json::parse(promise.get_future().get(), nullptr, false);
    if (answer.is_object() && answer.contains("result")) return answer["result"];
    return error(ErrorKind::unavailable, "rig.identity: " + answer.dump());
}

}  // namespace

nlohmann::json program_identity() {
    static const json identity{{"build", control::hex_text(digest_of_program())},
                               {"mathematics", control::hex_text(math_fingerprint())}};
    return identity;
}

Result<CommandHistory> CommandHistory::open(const ServeOptions& options) {
    CommandHistory history;
    if (!options.replay.empty()) {
        auto read = control::read_command_log(options.replay);
        if (!read) return at("--replay", read.error());
        history.before_ = std::move(*read);
    }
    if (options.log.empty()) return history;
    auto writer = history.before_ ? control::CommandLogWriter::go_on(options.log, *history.before_)
                                  : control::CommandLogWriter::create(options.log);
    if (!writer) return at("--log", writer.error());
    history.writer_ = std::move(*writer);
    return history;
}

void CommandHistory::prepare(const ServeOptions& options, engine::EngineOptions& engine) const {
    engine.is_held = options.is_held;
    engine.journal = writer_;
    const bool waits = options.is_held || before_;
    if (waits && engine.mode == engine::RunMode::realtime) engine.limit_ns = 0;
}

Result<void> CommandHistory::begin(const ServeOptions& options, control::RpcServer& rpc,
                                   const std::function<bool()>& must_end) {
    if (!before_ && !writer_) return {};
    const auto identity = identity_of(rpc);
    if (!identity) return std::unexpected(identity.error());
    if (!before_) {
        writer_->begin(*identity);
        return {};
    }
    if (const std::string difference = control::difference_of(before_->identity, *identity); !difference.empty())
        return error(ErrorKind::invalid_argument,
                     "--replay " + options.replay.string() + ": is of another world: " + difference);
    if (writer_) writer_->set_muted(true);
    const TimeNs start_ns = monotonic_now_ns();
    if (auto done = control::replay(*before_, rpc, must_end); !done)
        return at("--replay " + options.replay.string(), done.error());
    if (writer_) writer_->set_muted(false);
    spdlog::info("--replay: {} commands done again in {:.1f} s", before_->commands.size(),
                 static_cast<double>(monotonic_now_ns() - start_ns) * 1e-9);
    if (before_->saved)
        spdlog::info("--replay: this is the world that was saved: its state has the hash {} at {:.3f} s",
                     before_->saved->hash, static_cast<double>(before_->saved->world_ns) * 1e-9);
    return {};
}

void CommandHistory::undo() {
    if (writer_) writer_->leave_as_found();
}

std::function<Result<control::LogPlace>()> CommandHistory::log() const {
    if (!writer_) return {};
    return [writer = writer_] { return writer->place(); };
}

}  // namespace camrig::cli

#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "control/rpc/command_log.h"
#include "control/rpc/rpc_server.h"
#include "tools/camrig/serve.h"

namespace camrig::cli {

/// What `--log` and `--replay` of `camrig serve` do.
class CommandHistory {
public:
    /// Opens and reads the files, before there is a rig. Errors name the option.
    static Result<CommandHistory> open(const ServeOptions& options);
    /// The engine's options with what it needs.
    void prepare(const ServeOptions& options, engine::EngineOptions& engine) const;
    /// Does again what was done, until it must end, and begins to write. Before anybody else can command.
    Result<void> begin(const ServeOptions& options, control::RpcServer& rpc, const std::function<bool()>& must_end);
    /// The rig is not to serve after all: the log is as if it had not been begun.
    void undo();
    /// Empty: there is no log.
    std::function<Result<control::LogPlace>()> log() const;

private:
    std::optional<control::ReadCommandLog> before_;
    std::shared_ptr<control::CommandLogWriter> writer_;
};

/// For rig.identity: `build` and `mathematics`.
nlohmann::json program_identity();

}  // namespace camrig::cli

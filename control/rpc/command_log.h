#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "control/rpc/rpc_server.h"
#include "core/base/result.h"
#include "core/base/unique_fd.h"
#include "core/engine/command.h"

namespace camrig::control {

/// A command as a log has it.
struct LoggedCommand {
    TimeNs at_ns = 0;  ///< world time at which it was done
    std::string method;
    nlohmann::json params;
    bool has_failed = false;  ///< a later one of its actions: those before it are done; of a step: it was given up
    std::size_t line = 0;     ///< of the file, from 1
};

/// The last line of a saved world (world.save): what its state was, to be compared when all has been done again.
struct SavedState {
    TimeNs world_ns = 0;
    std::string hash;  ///< as world.digest tells it
};

/// A log of commands as it was read: a line of JSON for what it is of, then one for each command, in the order in which
/// they were done. A last line that was cut off is as if it were not there.
struct ReadCommandLog {
    std::filesystem::path file;
    nlohmann::json identity;
    std::vector<LoggedCommand> commands;
    std::uintmax_t whole_bytes = 0;  ///< without what was cut off, and without the last line of a saved world
    std::optional<SavedState> saved = {};
};

inline constexpr std::uintmax_t max_log_bytes = std::uintmax_t{1} << 30;

/// Errors name file and line.
Result<ReadCommandLog> read_command_log(const std::filesystem::path& file);

/// Of the members by which two worlds differ whose commands have different effects: the first that is not equal, with
/// both values. Empty: none.
std::string difference_of(const nlohmann::json& recorded, const nlohmann::json& own);

/// Writes the log: each command when it is done, by one write, so that what was answered is there when the process is
/// killed. When it cannot be written, or has max_log_bytes, it ends, and the program's log says so.
class CommandLogWriter final : public engine::CommandJournal {
public:
    /// A new log. already_exists: there is something in that file. unavailable: it cannot be written.
    static Result<std::shared_ptr<CommandLogWriter>> create(const std::filesystem::path& file);
    /// Goes on with one that was read, behind its last whole line: in its own file, or in a new one, a branch.
    static Result<std::shared_ptr<CommandLogWriter>> go_on(const std::filesystem::path& file,
                                                           const ReadCommandLog& log);

    /// The first line of a new log.
    void begin(const nlohmann::json& identity);
    /// For a rig that never served: the file is again what it was when this was made.
    void leave_as_found();
    /// While it is, what is noted is not written: it stands there already.
    void set_muted(bool is_muted) { is_muted_ = is_muted; }
    void note(TimeNs at_ns, const std::string& text, bool has_failed) override;
    /// Of the engine's thread, which writes: what stands there now. unavailable: it has ended.
    Result<LogPlace> place() const;

private:
    /// What a file had behind `bytes` when it was found is `cut`; a new one had nothing.
    CommandLogWriter(UniqueFd file, std::string name, std::uintmax_t bytes, std::optional<std::string> cut)
        : file_(std::move(file)),
          name_(std::move(name)),
          bytes_(bytes),
          found_(cut ? bytes : 0),
          cut_(std::move(cut)) {}
    void write(const std::string& line);

    UniqueFd file_;
    const std::string name_;
    std::uintmax_t bytes_;
    const std::uintmax_t found_;
    const std::optional<std::string> cut_;
    std::atomic<bool> is_muted_{false};
};

/// A world of its own file beside the log, LOG.NAME.save: what stands in the log, and a line that says what comes of
/// it. already_exists: a world of this name is saved. unavailable: it cannot be written.
Result<std::filesystem::path> save_world(const LogPlace& log, const std::string& name, const SavedState& state);

/// Does all of it again, as fast as the machine can, on a rig of world time 0 that may not run yet (in real time with
/// the limit 0). Afterwards world time is that of the last command, or of the saved state, and runs on. Errors name the
/// line, or that the state is not the saved one. `must_end` is asked all the while: true ends it, with unavailable.
Result<void> replay(const ReadCommandLog& log, RpcServer& rpc, const std::function<bool()>& must_end);

}  // namespace camrig::control

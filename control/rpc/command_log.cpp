#include "control/rpc/command_log.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include "control/rpc/json_rpc.h"
#include "core/base/json_reader.h"
#include "core/base/write_file.h"

namespace camrig::control {
namespace {

using nlohmann::json;

Error bad_line(const std::filesystem::path& file, std::size_t line, const std::string& what) {
    return {ErrorKind::invalid_argument, file.string() + ": line " + std::to_string(line) + ": " + what};
}

Result<LoggedCommand> read_command(const json& value) {
    LoggedCommand command;
    JsonReader reader(value, "");
    reader.required("at_ns", command.at_ns);
    reader.required("method", command.method);
    reader.optional("failed", command.has_failed);
    if (const json* params = reader.find("params")) command.params = *params;
    if (auto good = reader.finish(); !good) return std::unexpected(good.error());
    if (!command.params.is_object() || command.at_ns < 0)
        return error(ErrorKind::invalid_argument, "is no command of a log: {\"at_ns\", \"method\", \"params\"}");
    return command;
}

Result<SavedState> read_saved(const json& value) {
    SavedState state;
    int version = 0;
    JsonReader reader(value, "");
    reader.required("camrig_save", version);
    reader.required("world_ns", state.world_ns);
    reader.required("hash", state.hash);
    if (auto good = reader.finish(); !good) return std::unexpected(good.error());
    if (version != 1 || state.world_ns < 0)
        return error(ErrorKind::invalid_argument, "is no saved state of this version");
    return state;
}

}  // namespace

Result<ReadCommandLog> read_command_log(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::error_code failed;
    const auto bytes = std::filesystem::file_size(file, failed);
    if (!in || failed) return error(ErrorKind::not_found, file.string() + ": cannot be read");
    if (bytes > max_log_bytes)
        return error(ErrorKind::invalid_argument, file.string() + ": has more than 1 GiB and is no log of commands");
    ReadCommandLog log;
    log.file = file;
    std::string text;
    for (std::size_t line = 1; std::getline(in, text); ++line) {
        if (in.eof()) {  // without its end
            spdlog::warn("{}: line {} was cut off and is left out", file.string(), line);
            break;
        }
        const auto value = parse_json(text, max_request_bytes + 1024);
        if (!value) return std::unexpected(bad_line(file, line, value.error().message));
        if (line == 1) {
            if (!value->is_object() || value->value("camrig_log", json()) != 1 || !value->contains("identity"))
                return std::unexpected(bad_line(file, line, "no log of commands of this version begins so"));
            log.identity = (*value)["identity"];
        } else if (log.saved) {
            return std::unexpected(bad_line(file, line, "nothing comes behind the state of a saved world"));
        } else if (value->is_object() && value->contains("camrig_save")) {
            auto saved = read_saved(*value);
            if (!saved) return std::unexpected(bad_line(file, line, saved.error().message));
            log.saved = std::move(*saved);
            continue;
        } else {
            auto command = read_command(*value);
            if (!command) return std::unexpected(bad_line(file, line, command.error().message));
            command->line = line;
            log.commands.push_back(std::move(*command));
        }
        log.whole_bytes += text.size() + 1;
    }
    if (log.identity.is_null()) return error(ErrorKind::invalid_argument, file.string() + ": is empty, and no log");
    return log;
}

std::string difference_of(const json& recorded, const json& own) {
    for (const char* member : {"scene_hash", "seed", "step_ns", "mode", "mathematics"}) {
        const json a = recorded.value(member, json()), b = own.value(member, json());
        if (a != b) return std::string(member) + " was " + a.dump() + ", is " + b.dump();
    }
    return {};
}

Result<std::shared_ptr<CommandLogWriter>> CommandLogWriter::create(const std::filesystem::path& file) {
    UniqueFd made(::open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600));
    struct stat state{};
    if (!made || ::fstat(made.get(), &state) != 0)
        return error(ErrorKind::unavailable, file.string() + ": cannot be written: " + std::strerror(errno));
    if (state.st_size > 0)
        return error(ErrorKind::already_exists,
                     file.string() + ": there is something in it; give another file, or --replay it too to go on");
    return std::shared_ptr<CommandLogWriter>(new CommandLogWriter(std::move(made), file.string(), 0, {}));
}

Result<std::shared_ptr<CommandLogWriter>> CommandLogWriter::go_on(const std::filesystem::path& file,
                                                                  const ReadCommandLog& log) {
    std::error_code failed;
    std::optional<std::string> cut;
    if (std::filesystem::equivalent(file, log.file, failed)) {
        std::ifstream in(file, std::ios::binary);
        in.seekg(static_cast<std::streamoff>(log.whole_bytes));
        cut.emplace(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
    } else {
        auto branch = create(file);
        if (!branch) return std::unexpected(branch.error());
        if (!std::filesystem::copy_file(log.file, file, std::filesystem::copy_options::overwrite_existing, failed))
            return error(ErrorKind::unavailable, file.string() + ": cannot be written: " + failed.message());
    }
    UniqueFd made(::open(file.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC));
    if (!made || ::ftruncate(made.get(), static_cast<off_t>(log.whole_bytes)) != 0)
        return error(ErrorKind::unavailable, file.string() + ": cannot be written: " + std::strerror(errno));
    return std::shared_ptr<CommandLogWriter>(
        new CommandLogWriter(std::move(made), file.string(), log.whole_bytes, std::move(cut)));
}

Result<std::filesystem::path> save_world(const LogPlace& log, const std::string& name, const SavedState& state) {
    const std::filesystem::path file = log.file.string() + "." + name + ".save", part = file.string() + ".part";
    std::error_code failed;
    if (std::filesystem::exists(file, failed))
        return error(ErrorKind::already_exists, file.string() + ": is there already; give another name");
    const auto give_up = [&](const std::string& why) {
        std::filesystem::remove(part, failed);
        return error(ErrorKind::unavailable, file.string() + ": cannot be written: " + why);
    };
    if (!std::filesystem::copy_file(log.file, part, std::filesystem::copy_options::overwrite_existing, failed))
        return give_up(failed.message());
    std::filesystem::resize_file(part, log.bytes, failed);  // without what was written since
    if (failed) return give_up(failed.message());
    const std::string line = json{{"camrig_save", 1}, {"world_ns", state.world_ns}, {"hash", state.hash}}.dump() + "\n";
    const UniqueFd end(::open(part.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC));
    if (!end) return give_up(std::strerror(errno));
    if (auto written = write_all(end.get(), std::as_bytes(std::span(line)), part.string()); !written)
        return give_up(written.error().message);
    if (::fsync(end.get()) != 0) return give_up(std::strerror(errno));
    std::filesystem::rename(part, file, failed);
    if (failed) return give_up(failed.message());
    return file;
}

void CommandLogWriter::begin(const json& identity) {
    write(json{{"camrig_log", 1}, {"identity", identity}}.dump() + "\n");
}

Result<LogPlace> CommandLogWriter::place() const {
    if (!file_)
        return error(ErrorKind::unavailable,
                     name_ +
                         ": this log of commands has ended, as the rig's own log says: what was done since is in no "
                         "file, and the world cannot be saved");
    return LogPlace{name_, bytes_};
}

void CommandLogWriter::leave_as_found() {
    if (!file_ || ::ftruncate(file_.get(), static_cast<off_t>(found_)) != 0) return;
    if (cut_) write(*cut_);
    file_.reset();
}

void CommandLogWriter::note(TimeNs at_ns, const std::string& text, bool has_failed) {
    if (is_muted_) return;
    write("{\"at_ns\":" + std::to_string(at_ns) + (has_failed ? ",\"failed\":true," : ",") + text.substr(1) + "\n");
}

void CommandLogWriter::write(const std::string& line) {
    if (!file_) return;
    const auto written = bytes_ + line.size() > max_log_bytes
                             ? error(ErrorKind::resource_exhausted, name_ + ": it has 1 GiB")
                             : write_all(file_.get(), std::as_bytes(std::span(line)), name_);
    if (written) {
        bytes_ += line.size();
        return;
    }
    spdlog::error("{}; the log of commands ends here", written.error().message);
    file_.reset();
}

}  // namespace camrig::control

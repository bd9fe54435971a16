#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "control/client/rpc_client.h"
#include "core/base/result.h"

namespace camrig::cli {

inline constexpr int exit_failed = 1;
inline constexpr int exit_usage = 2;

/// What a command does, once its options are read. Returns the exit code.
using CliAction = std::function<int()>;

/// What every command of the command line has: its options for all, where it prints, and how it reaches the rig.
struct CliContext {
    std::ostream& out;
    std::ostream& err;
    bool json = false;
    std::string control = {};
    std::filesystem::path token_file = {};
    CliAction action = {};  ///< of the command that was given

    Result<client::RpcClient> connect() const;
    /// One call on a connection of its own.
    Result<nlohmann::json> call(std::string_view method, const nlohmann::json& params = nlohmann::json::object(),
                                std::chrono::milliseconds timeout = client::RpcClient::default_timeout) const;

    /// One line on err; with --json an object: {"error": {"kind", "message"}}.
    int fail(const Error& why) const;
    /// The same of a command line that is wrong in itself.
    int usage(const std::string& why) const;
    /// --json: the value as it is. Else the words.
    int print(const nlohmann::json& value, const std::string& words) const;
};

/// What a missing or strange field of an answer means.
Error unexpected_answer(const nlohmann::json::exception& problem);

/// "X,Y,Z" -> [X, Y, Z]: exactly `count` finite numbers.
Result<nlohmann::json> parse_numbers(std::string_view option, std::string_view text, std::size_t count);
/// "640x480" -> [640, 480].
Result<nlohmann::json> parse_size(std::string_view text);
/// A number, or the text as it is: "30000/1001".
nlohmann::json number_or_text(const std::string& text);

/// Columns as wide as they need, the first row is the heading; from column `text_columns` on to the right.
std::string table(const std::vector<std::vector<std::string>>& rows, std::size_t text_columns = 1);
/// "12.340 s"
std::string seconds_text(const nlohmann::json& nanoseconds);
/// A number with few digits, or the text itself.
std::string plain_text(const nlohmann::json& value);

}  // namespace camrig::cli

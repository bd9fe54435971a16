#include "tools/camrig/cli_context.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <optional>
#include <ostream>

#include "core/base/token.h"

namespace camrig::cli {
namespace {

using nlohmann::json;

/// One line, whatever the other side put into it.
std::string one_line(std::string text) {
    std::ranges::replace_if(text, [](unsigned char c) { return c < 0x20 || c == 0x7f; }, ' ');
    return text;
}

/// Integers stay integers: the protocol tells 640 from 640.0.
std::optional<json> parse_number(std::string_view text) {
    const char* const end = text.data() + text.size();
    std::int64_t whole = 0;
    if (const auto [stop, failed] = std::from_chars(text.data(), end, whole); failed == std::errc() && stop == end)
        return whole;
    double number = 0;
    const auto [stop, failed] = std::from_chars(text.data(), end, number);
    if (failed != std::errc() || stop != end || !std::isfinite(number)) return std::nullopt;
    return number;
}

}  // namespace

Result<client::RpcClient> CliContext::connect() const {
    auto endpoint = client::Endpoint::parse(control.empty() ? client::default_control() : control);
    if (!endpoint) return std::unexpected(endpoint.error());
    client::RpcClientOptions options{.endpoint = std::move(*endpoint)};
    if (!token_file.empty()) {
        auto token = read_token_file(token_file);
        if (!token) return std::unexpected(token.error());
        options.token = std::move(*token);
    }
    return client::RpcClient::connect(options);
}

Result<json> CliContext::call(std::string_view method, const nlohmann::json& params,
                              std::chrono::milliseconds timeout) const {
    auto client = connect();
    if (!client) return std::unexpected(client.error());
    return client->call(method, params, timeout);
}

int CliContext::fail(const Error& why) const {
    using nlohmann::json;
    const json told{{"error", {{"kind", to_string(why.kind)}, {"message", why.message}}}};
    if (this->json)
        err << told.dump(-1, ' ', false, json::error_handler_t::replace) << std::endl;
    else
        err << "camrig: " << one_line(why.message) << std::endl;
    return exit_failed;
}

int CliContext::usage(const std::string& why) const {
    fail({ErrorKind::invalid_argument, why});
    return exit_usage;
}

int CliContext::print(const nlohmann::json& value, const std::string& words) const {
    if (json) {
        out << value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) << "\n";
    } else if (!words.empty()) {
        out << words << (words.ends_with('\n') ? "" : "\n");
    }
    out.flush();
    if (out.good()) return 0;
    return fail({ErrorKind::unavailable, "the output cannot be written"});
}

Error unexpected_answer(const nlohmann::json::exception& problem) {
    // "[json.exception.out_of_range.403] key 'x' not found" -> what a person needs.
    const std::string_view what = problem.what();
    const auto end = what.find("] ");
    return {ErrorKind::unsupported,
            "the rig's answer is not what this camrig expects; is the rig of another version? (" +
                std::string(end == std::string_view::npos ? what : what.substr(end + 2)) + ")"};
}

Result<json> parse_numbers(std::string_view option, std::string_view text, std::size_t count) {
    json numbers = json::array();
    for (std::string_view rest = text; numbers.size() < count;) {
        const std::size_t comma = std::min(rest.find(','), rest.size());
        auto number = parse_number(rest.substr(0, comma));
        if (!number) break;
        numbers.push_back(std::move(*number));
        rest.remove_prefix(std::min(comma + 1, rest.size()));
    }
    const auto commas = static_cast<std::size_t>(std::ranges::count(text, ','));
    if (numbers.size() == count && commas == count - 1) return numbers;
    return error(ErrorKind::invalid_argument, std::string(option) + ": takes " + std::to_string(count) +
                                                  " numbers with commas between, e.g. 1,2.5,-3");
}

Result<json> parse_size(std::string_view text) {
    int width = 0, height = 0;
    const char* const end = text.data() + text.size();
    const auto [cross, bad_width] = std::from_chars(text.data(), end, width);
    if (bad_width == std::errc() && cross != end && *cross == 'x') {
        const auto [stop, bad_height] = std::from_chars(cross + 1, end, height);
        if (bad_height == std::errc() && stop == end) return json{width, height};
    }
    return error(ErrorKind::invalid_argument, "--size: takes WIDTHxHEIGHT, e.g. 640x480");
}

json number_or_text(const std::string& text) {
    auto number = parse_number(text);
    return number ? *number : json(text);
}

std::string table(const std::vector<std::vector<std::string>>& rows, std::size_t text_columns) {
    std::vector<std::size_t> widths;
    for (const auto& row : rows) {
        widths.resize(std::max(widths.size(), row.size()));
        for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
    }
    std::string text;
    for (const auto& row : rows) {
        std::string line;
        for (std::size_t i = 0; i < row.size(); ++i) {
            const std::string padding(widths[i] - row[i].size(), ' ');
            line += (i ? "  " : "") + (i < text_columns ? row[i] + padding : padding + row[i]);
        }
        line.erase(line.find_last_not_of(' ') + 1);
        text += line + "\n";
    }
    return text;
}

std::string seconds_text(const json& nanoseconds) {
    if (!nanoseconds.is_number()) return "?";
    char text[64];
    std::snprintf(text, sizeof text, "%.3f s", nanoseconds.get<double>() / 1e9);
    return text;
}

std::string plain_text(const json& value) {
    if (value.is_string()) return value.get<std::string>();
    if (!value.is_number_float()) return value.dump();
    const double number = value.get<double>();
    char text[64];
    // An angle of 4e-16 is rounding, not a fact that people want to read.
    std::snprintf(text, sizeof text, "%.6g", std::abs(number) < 1e-12 ? 0.0 : number);
    return text;
}

}  // namespace camrig::cli

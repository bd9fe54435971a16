#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/result.h"

namespace camrig {

/// Parses untrusted JSON. Refuses text over `max_bytes`, nesting over 64, duplicate keys and trailing text.
/// The error names line and column.
Result<nlohmann::json> parse_json(std::string_view text, std::size_t max_bytes);

/// Reads one JSON object field by field and remembers the first error, with the JSON path of the place:
///
///     JsonReader reader(json, "cameras[0]");
///     reader.required("name", spec.name);
///     reader.optional("near", spec.near_m);
///     if (auto done = reader.finish(); !done) return std::unexpected(done.error());   // unknown keys are errors
///
/// After the first error every further call does nothing, so a reader needs one check at its end. While an ErrorList
/// lives in the thread, it reads on instead and tells that list every error, the first of each key.
/// The JSON object must outlive the reader.
class JsonReader {
public:
    JsonReader(const nlohmann::json& object, std::string path);

    /// Whether the key is there (marks it as known).
    bool has(std::string_view key);
    /// Whether the key is there and null (marks it as known).
    bool has_null(std::string_view key);
    bool ok() const { return !error_; }
    /// Whether the value of this key is to be looked at: no error yet, or, with an ErrorList, none of this key.
    bool ok(std::string_view key) const;
    const std::string& path() const { return path_; }
    /// "cameras[0].name", for messages.
    std::string path_of(std::string_view key) const;

    void required(std::string_view key, bool& out);
    void required(std::string_view key, std::string& out);
    void required(std::string_view key, std::int64_t& out);
    void required(std::string_view key, int& out);
    void required(std::string_view key, std::uint64_t& out);
    /// Finite numbers only.
    void required(std::string_view key, double& out);
    void required(std::string_view key, float& out);
    /// An array of exactly this many finite numbers.
    void required(std::string_view key, std::span<double> out);

    template <typename T>
    void optional(std::string_view key, T& out) {
        if (find(key)) required(key, out);
    }
    template <typename T>
    void optional(std::string_view key, std::optional<T>& out) {
        if (!find(key)) return;
        T value{};
        required(key, value);
        if (ok(key)) out = std::move(value);
    }

    /// The raw value of a key (marks it as known); nullptr when absent or after an error.
    const nlohmann::json* find(std::string_view key);
    /// An array value with at most `max_items`; an empty one when absent.
    std::span<const nlohmann::json> array(std::string_view key, std::size_t max_items);
    /// Remembers an error at a key, e.g. for a value out of range.
    void fail(std::string_view key, std::string message, ErrorKind kind = ErrorKind::invalid_argument);
    /// Remembers the error of a nested result.
    void fail(Error error);
    /// Remembers the error of a check whose message begins with a key of this object ("size: 1x1; ..."), at that key.
    void fail_inside(const Error& error);
    /// What is known here depends on a key that is wrong: no other key is told to be unknown.
    void allow_unknown() { allows_unknown_ = true; }

    /// The first error, or an error that names a key nobody asked for (and the known ones).
    Result<void> finish();

private:
    const nlohmann::json* need(std::string_view key);

    const nlohmann::json* object_;
    std::string path_;
    std::set<std::string, std::less<>> known_;
    std::set<std::string, std::less<>> failed_;  ///< keys with an error that an ErrorList was told
    bool allows_unknown_ = false;
    std::optional<Error> error_;
};

}  // namespace camrig

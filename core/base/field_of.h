#pragma once

#include <concepts>
#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/field.h"
#include "core/base/field_table.h"
#include "core/base/json_reader.h"
#include "core/base/named.h"

namespace camrig {

/// Changes to some members of a T, in the order in which they are made.
template <typename T>
class Changes {
public:
    void change(std::function<void(T&)> one) { changes_.push_back(std::move(one)); }
    void apply_to(T& target) const {
        for (const auto& one : changes_) one(target);
    }

private:
    std::vector<std::function<void(T&)>> changes_;
};

/// An entry of the table of a struct T: the description, and the way from and to JSON. What is read becomes a change of
/// the Patch.
template <typename T, typename Patch>
struct FieldOf {
    Field field = {};
    std::function<void(JsonReader&, Patch&)> read = {};  ///< empty: output only, or read by another entry or the caller
    std::function<nlohmann::json(const T&)> write = {};  ///< empty: input only, or written by the caller
    bool has_checked_range = false;                      ///< of all values, also those that came not through JSON
};

template <typename T>
concept HasFields = requires { fields_of(std::type_identity<T>{}).front().field; };

template <typename T>
struct ValueOf {
    using type = T;
};
template <typename T>
struct ValueOf<std::optional<T>> {
    using type = T;
};
template <typename T>
inline constexpr bool is_optional = !std::same_as<typename ValueOf<T>::type, T>;

template <typename Table>
std::vector<Field> descriptions_of(const Table& table) {
    std::vector<Field> fields;
    for (const auto& each : table) fields.push_back(each.field);
    return fields;
}

template <HasFields T>
std::vector<Field> descriptions_of() {
    return descriptions_of(fields_of(std::type_identity<T>{}));
}

template <typename T, typename Patch>
nlohmann::json write_fields(const std::vector<FieldOf<T, Patch>>& table, const T& from) {
    nlohmann::json out = nlohmann::json::object();
    for (const auto& each : table) {
        if (!each.write) continue;
        nlohmann::json value = each.write(from);
        if (!value.is_null() || each.field.is_nullable()) out[each.field.name] = std::move(value);
    }
    return out;
}

/// Reads what is there; the caller finishes the reader.
template <typename T, typename Patch>
void read_fields(const std::vector<FieldOf<T, Patch>>& table, JsonReader& reader, Patch& patch) {
    for (const auto& each : table)
        if (each.read) each.read(reader, patch);
}

/// A whole T: what is not given has its default. `check` is asked when all keys were read without error, for what they
/// demand of each other. Finishes the reader.
template <typename T>
Result<T> read_all(const std::vector<FieldOf<T>>& table, JsonReader& reader,
                   void (*check)(const T&, JsonReader&) = nullptr) {
    Changes<T> changes;
    read_fields(table, reader, changes);
    T value;
    changes.apply_to(value);
    if (check && reader.ok()) check(value, reader);
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    return value;
}

template <HasFields T>
Result<T> read_all(JsonReader& reader, void (*check)(const T&, JsonReader&) = nullptr) {
    return read_all(fields_of(std::type_identity<T>{}), reader, check);
}
template <HasFields T>
Result<T> read_all(const nlohmann::json& value, const std::string& path,
                   void (*check)(const T&, JsonReader&) = nullptr) {
    JsonReader reader(value, path);
    return read_all<T>(reader, check);
}

/// The first value out of its range, with its path below T ("controls.gain_db: must be 0 to 24"): for values that did
/// not come through JSON.
template <typename T, typename Patch>
Result<void> check_fields(const std::vector<FieldOf<T, Patch>>& table, const T& value) {
    for (const auto& each : table) {
        if (!each.has_checked_range) continue;
        if (auto problem = problem_of(each.field, each.write(value)))
            return error(ErrorKind::invalid_argument, each.field.name + *problem);
    }
    return {};
}

template <typename V>
nlohmann::json json_of(const V& value) {
    if constexpr (is_optional<V>)
        return value ? json_of(*value) : nlohmann::json(nullptr);
    else if constexpr (HasNames<V>)
        return std::string(to_string(value));
    else if constexpr (HasFields<V>)
        return write_fields(fields_of(std::type_identity<V>{}), value);
    else
        return value;
}

/// A number, text, truth value or name. Nothing, and the error remembered at the key: not of that type or out of range.
template <typename V>
std::optional<V> read_value(JsonReader& reader, const Field& field) {
    const nlohmann::json* const json = reader.find(field.name);
    if (!json) {
        if (field.required) reader.fail(field.name, "is missing");
        return std::nullopt;
    }
    V value{};
    if constexpr (HasNames<V>) {
        std::string name;
        reader.required(field.name, name);
        if (!reader.ok(field.name)) return std::nullopt;
        auto named = parse_name<V>(name);
        if (!named) {
            reader.fail(field.name, named.error().message);
            return std::nullopt;
        }
        value = *named;
    } else {
        reader.required(field.name, value);
    }
    if (!reader.ok(field.name)) return std::nullopt;
    if (auto problem = problem_of(field, *json)) {
        reader.fail(field.name, problem->substr(2));
        return std::nullopt;
    }
    return value;
}

/// The changes that an object says. Nothing: it is not there, or wrong, and the error remembered.
template <HasFields V>
std::optional<Changes<V>> read_changes(JsonReader& reader, const Field& field) {
    const nlohmann::json* const json = reader.find(field.name);
    if (!json) return std::nullopt;
    JsonReader nested(*json, reader.path_of(field.name));
    Changes<V> changes;
    read_fields(fields_of(std::type_identity<V>{}), nested, changes);
    if (auto done = nested.finish(); !done) {
        reader.fail(done.error());
        return std::nullopt;
    }
    return changes;
}

/// The same as a V of its own: what is not given has its default.
template <HasFields V>
std::optional<V> read_object(JsonReader& reader, const Field& field) {
    const auto changes = read_changes<V>(reader, field);
    if (!changes) return std::nullopt;
    V value;
    changes->apply_to(value);
    return value;
}

/// What the type says of a description: JSON type, choices, parts.
template <typename Member>
Field typed(Field field) {
    using V = typename ValueOf<Member>::type;
    if constexpr (HasFields<V>)
        field.parts = descriptions_of(fields_of(std::type_identity<V>{}));
    else if constexpr (HasNames<V>)
        for (const auto& each : names_of(std::type_identity<V>{})) field.choices.emplace_back(each.name);
    if (field.type.empty())
        field.type = HasFields<V>             ? "object"
                     : std::same_as<V, bool>  ? "boolean"
                     : std::integral<V>       ? "integer"
                     : std::floating_point<V> ? "number"
                                              : "string";
    if (!field.word.empty()) field.type += " or \"" + field.word + "\"";
    if (field.is_nullable()) field.type += " or null";
    return field;
}

/// The default of a parameter as documentation shows it.
std::string fallback_text(const Field& field, const nlohmann::json& value);

/// The entry of a member: bool, number, std::string, an enum with names, a struct with a table; or an optional of one,
/// whose absence is null or the field's word.
template <auto member, typename T, typename Member, typename Patch>
FieldOf<T, Patch> entry_at(Field given) {
    using V = typename ValueOf<Member>::type;
    FieldOf<T, Patch> entry;
    entry.field = typed<Member>(std::move(given));
    entry.write = [word = entry.field.word](const T& from) {
        nlohmann::json value = json_of(from.*member);
        return value.is_null() && !word.empty() ? nlohmann::json(word) : value;
    };
    entry.read = [field = entry.field](JsonReader& reader, Patch& patch) {
        if constexpr (is_optional<Member>) {
            const nlohmann::json* const json = reader.find(field.name);
            const bool is_word = json && !field.word.empty() && *json == field.word;
            if (is_word || (field.is_nullable() && reader.has_null(field.name)))
                return patch.change([](T& target) { (target.*member).reset(); });
        }
        if constexpr (HasFields<V>) {
            const auto changes = read_changes<V>(reader, field);
            if (!changes) return;
            patch.change([changes = *changes](T& target) {
                if constexpr (is_optional<Member>) {
                    if (!(target.*member)) (target.*member).emplace();
                    changes.apply_to(*(target.*member));
                } else {
                    changes.apply_to(target.*member);
                }
            });
        } else if (auto value = read_value<V>(reader, field)) {
            patch.change([value = std::move(*value)](T& target) { target.*member = value; });
        }
    };
    entry.has_checked_range = true;
    if (entry.field.fallback.empty() && !entry.field.required)
        entry.field.fallback = fallback_text(entry.field, entry.write(T{}));
    return entry;
}

template <typename>
struct MemberPointer;
template <typename T, typename Member>
struct MemberPointer<Member T::*> {
    using Struct = T;
    using Value = Member;
};

/// field_at<&CameraSpec::near_m>({.name = "near", ...}): the entry of a table.
template <auto member, typename Patch = Changes<typename MemberPointer<decltype(member)>::Struct>>
auto field_at(Field field) {
    using Pointer = MemberPointer<decltype(member)>;
    return entry_at<member, typename Pointer::Struct, typename Pointer::Value, Patch>(std::move(field));
}

/// The entry of a member that is output only: written to JSON, never read from it.
template <auto member>
auto told_at(Field field) {
    using Pointer = MemberPointer<decltype(member)>;
    using T = typename Pointer::Struct;
    return FieldOf<T>{.field = typed<typename Pointer::Value>(std::move(field)),
                      .write = [](const T& from) { return json_of(from.*member); }};
}

}  // namespace camrig

#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/field_of.h"

namespace camrig {

/// One kind of what has several, described: its name, what it does, and its keys in JSON beside the one that names it.
struct KindDescription {
    std::string name;
    std::string doc;
    std::vector<Field> fields = {};
    std::string rule = {};  ///< JSON schema of what its keys demand of each other
};

/// One alternative of a std::variant: the description, and how it is read. The caller finishes the reader.
template <typename Variant>
struct Kind {
    KindDescription description;
    std::function<Variant(JsonReader&)> read;
};

/// The kind that is a T, with the table of its fields. `check` is asked when all of them were read: for what they
/// demand of each other, which `description.rule` tells programs. `initial`: what is not given in JSON.
template <typename Variant, typename T>
Kind<Variant> kind_of(KindDescription description, const std::vector<FieldOf<T>>& table,
                      std::function<void(const T&, JsonReader&)> check = {}, const T& initial = {}) {
    description.fields = descriptions_of(table);
    return {std::move(description), [table, check = std::move(check), initial](JsonReader& reader) {
                Changes<T> changes;
                read_fields(table, reader, changes);
                T value = initial;
                changes.apply_to(value);
                if (check && reader.ok()) check(value, reader);
                return Variant(std::move(value));
            }};
}

template <typename Variant>
std::vector<KindDescription> descriptions_of(const std::vector<Kind<Variant>>& kinds) {
    std::vector<KindDescription> all;
    for (const auto& kind : kinds) all.push_back(kind.description);
    return all;
}

/// Reads the kind that the value of `key` names. An unknown one is an error at the key, and gives a default.
template <typename Variant>
Variant read_kind(const std::vector<Kind<Variant>>& kinds, JsonReader& reader, std::string_view key) {
    std::string name;
    reader.required(key, name);
    std::string known;
    for (const auto& kind : kinds) {
        if (kind.description.name == name) return kind.read(reader);
        known += (known.empty() ? "" : ", ") + kind.description.name;
    }
    reader.allow_unknown();
    if (reader.ok(key)) reader.fail(key, "'" + name.substr(0, 40) + "' is none of " + known);
    return {};
}

/// A whole object of one of these kinds. Finishes the reader.
template <typename Variant>
Result<Variant> read_whole_kind(const std::vector<Kind<Variant>>& kinds, JsonReader& reader, std::string_view key) {
    Variant made = read_kind(kinds, reader, key);
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    return made;
}
template <typename Variant>
Result<Variant> read_whole_kind(const std::vector<Kind<Variant>>& kinds, const nlohmann::json& value, std::string path,
                                std::string_view key) {
    JsonReader reader(value, std::move(path));
    return read_whole_kind(kinds, reader, key);
}

}  // namespace camrig

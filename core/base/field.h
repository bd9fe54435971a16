#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace camrig {

/// The numbers that a parameter may have, or how many characters a text.
struct Range {
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
    bool is_low_out = false;   ///< the low end itself is not in it
    bool is_high_out = false;  ///< the high end itself is not in it

    bool has_low() const { return low > -std::numeric_limits<double>::infinity(); }
    bool has_high() const { return high < std::numeric_limits<double>::infinity(); }
    bool contains(double number) const;
    /// "1 to 10", "over 0 and at most 1e6", "at least 0"; empty without ends.
    std::string words() const;
};

/// One parameter, or one field of an answer, described: documentation, scene schema, clients and user interfaces are
/// made from this.
struct Field {
    std::string name = {};
    /// Of its JSON, as documentation shows it: "number", "[x, y, z]", "string or null", "object", ... Clients are
    /// generated for the types that control/rpc/generated_files knows.
    std::string type = {};
    std::string doc = {};  ///< without range and choices, which documentation adds
    bool required = false;
    std::string unit = {};      ///< "m", "deg", "ns", ...; empty: none
    std::string fallback = {};  ///< what holds when the parameter is not given; empty: nothing, or as it is

    Range range = {};
    std::vector<std::string> choices = {};
    std::string null = {};          ///< what null means, where null is taken
    std::string word = {};          ///< taken instead of a value: "auto"
    std::vector<Field> parts = {};  ///< of an object; of each of a list of objects
    std::string shape = {};         ///< the type of an object, as clients name it: "Lens"
    bool is_whole = false;          ///< an object that is given takes the place of all of the one before
    /// Who sets it. `client`: input only (place). `rig`: output only; as input it is accepted and ignored (id), so that
    /// what a rig answered can be given back to it.
    enum class By : std::uint8_t { both, client, rig } by = By::both;
    std::string label = {};   ///< for people; empty: the name with spaces
    std::string option = {};  ///< of the command line, without dashes; empty: the name with dashes
    std::string schema = {};  ///< JSON schema, where it does not follow from the above

    bool is_nullable() const { return !null.empty(); }
    /// The type without " or null" and the word.
    std::string plain_type() const;
    std::string label_text() const;
    std::string option_text() const;
    /// Range, choices, words and the meaning of null.
    std::string doc_text() const;
};

/// What is wrong with a value of the right JSON type, from the field's name on: ": must be 1 to 10"; of an object,
/// ".gain_db: must be 0 to 24".
std::optional<std::string> problem_of(const Field& field, const nlohmann::json& value);

/// The description for programs: {name, type, doc, and where there are any: required, unit, default, minimum, maximum,
/// exclusive_minimum, exclusive_maximum, choices, null, word, label, by, whole, fields}.
nlohmann::json to_json(const Field& field);
nlohmann::json to_json(const std::vector<Field>& fields);

}  // namespace camrig

#include "core/base/json_reader.h"

#include <cmath>
#include <limits>

#include "core/base/error_list.h"

namespace camrig {
namespace {

constexpr int max_depth = 64;

std::string type_name(const nlohmann::json& value) {
    return value.is_number() ? "number" : value.type_name();
}

/// Looks for what plain parsing lets through. A pass of its own, because nlohmann's parser with a callback (3.11) walks
/// all earlier siblings at the end of every object: quadratic, minutes for a megabyte of "[{},{},...".
struct FormCheck : nlohmann::json_sax<nlohmann::json> {
    bool too_deep = false;
    std::string duplicate;

    bool start_object(std::size_t) override {
        keys_.emplace_back();
        return enter();
    }
    bool key(string_t& name) override {
        if (!keys_.back().insert(name).second) duplicate = name;
        return duplicate.empty();
    }
    bool end_object() override {
        keys_.pop_back();
        --depth_;
        return true;
    }
    bool start_array(std::size_t) override { return enter(); }
    bool end_array() override {
        --depth_;
        return true;
    }
    bool null() override { return true; }
    bool boolean(bool) override { return true; }
    bool number_integer(number_integer_t) override { return true; }
    bool number_unsigned(number_unsigned_t) override { return true; }
    bool number_float(number_float_t, const string_t&) override { return true; }
    bool string(string_t&) override { return true; }
    bool binary(binary_t&) override { return true; }
    /// The second pass says what is wrong.
    bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception&) override { return false; }

private:
    bool enter() {
        too_deep = ++depth_ > max_depth;
        return !too_deep;
    }
    int depth_ = 0;
    std::vector<std::set<std::string>> keys_;
};

}  // namespace

Result<nlohmann::json> parse_json(std::string_view text, std::size_t max_bytes) {
    if (text.size() > max_bytes) {
        return error(ErrorKind::resource_exhausted, "JSON text of " + std::to_string(text.size()) + " bytes; at most " +
                                                        std::to_string(max_bytes) + " are taken");
    }
    try {
        FormCheck form;
        nlohmann::json::sax_parse(text, &form);
        if (form.too_deep) {
            return error(ErrorKind::invalid_argument,
                         "JSON nested deeper than " + std::to_string(max_depth) + " levels");
        }
        if (!form.duplicate.empty())
            return error(ErrorKind::invalid_argument, "JSON object has key '" + form.duplicate + "' twice");
        return nlohmann::json::parse(text);
    } catch (const nlohmann::json::exception& problem) {
        std::string what = problem.what();
        // "[json.exception.parse_error.101] parse error at line 1, column 2: ..." -> what a person needs.
        if (const auto end = what.find("] "); end != std::string::npos) what.erase(0, end + 2);
        // What was read last is told where it is a word of JSON, and not where it is much of somebody's file.
        constexpr std::string_view last_read = "last read: '";
        constexpr std::size_t most_of_it = 12;
        if (const auto begin = what.find(last_read); begin != std::string::npos) {
            const std::size_t from = begin + last_read.size(), expected = what.rfind("'; expected ");
            const std::size_t end = expected != std::string::npos && expected >= from ? expected : what.size() - 1;
            if (end > from + most_of_it) what.replace(from - 1, end + 1 - (from - 1), "a long text");
        }
        return error(ErrorKind::invalid_argument, "not JSON: " + what.substr(0, 300));
    }
}

JsonReader::JsonReader(const nlohmann::json& object, std::string path) : object_(&object), path_(std::move(path)) {
    if (!object.is_object()) {
        fail(Error{ErrorKind::invalid_argument,
                   (path_.empty() ? "value" : path_) + ": expected an object, got " + type_name(object)});
    }
}

bool JsonReader::has(std::string_view key) {
    known_.emplace(key);
    return object_->is_object() && object_->contains(key);
}

bool JsonReader::has_null(std::string_view key) {
    return has(key) && object_->find(key)->is_null();
}

bool JsonReader::ok(std::string_view key) const {
    return ErrorList::current() ? !failed_.contains(key) : ok();
}

std::string JsonReader::path_of(std::string_view key) const {
    return path_.empty() ? std::string(key) : path_ + "." + std::string(key);
}

const nlohmann::json* JsonReader::find(std::string_view key) {
    if (!has(key) || (error_ && !ErrorList::current())) return nullptr;
    return &*object_->find(key);
}

const nlohmann::json* JsonReader::need(std::string_view key) {
    const nlohmann::json* value = find(key);
    if (!value) fail(key, "is missing");
    return value;
}

void JsonReader::required(std::string_view key, bool& out) {
    const auto* value = need(key);
    if (!value) return;
    if (!value->is_boolean()) return fail(key, "expected true or false, got " + type_name(*value));
    out = value->get<bool>();
}

void JsonReader::required(std::string_view key, std::string& out) {
    const auto* value = need(key);
    if (!value) return;
    if (!value->is_string()) return fail(key, "expected a string, got " + type_name(*value));
    out = value->get<std::string>();
}

void JsonReader::required(std::string_view key, std::int64_t& out) {
    const auto* value = need(key);
    if (!value) return;
    const bool fits =
        value->is_number_integer() &&
        (!value->is_number_unsigned() ||
         value->get<std::uint64_t>() <= static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()));
    if (!fits) return fail(key, "expected an integer, got " + value->dump().substr(0, 40));
    out = value->get<std::int64_t>();
}

void JsonReader::required(std::string_view key, std::uint64_t& out) {
    const auto* value = need(key);
    if (!value) return;
    if (!value->is_number_unsigned())
        return fail(key, "expected an integer from 0, got " + value->dump().substr(0, 40));
    out = value->get<std::uint64_t>();
}

void JsonReader::required(std::string_view key, int& out) {
    std::int64_t wide = 0;
    required(key, wide);
    if (!ok(key)) return;
    if (wide < std::numeric_limits<int>::min() || wide > std::numeric_limits<int>::max())
        return fail(key, std::to_string(wide) + " is out of range");
    out = static_cast<int>(wide);
}

void JsonReader::required(std::string_view key, double& out) {
    const auto* value = need(key);
    if (!value) return;
    if (!value->is_number()) return fail(key, "expected a number, got " + type_name(*value));
    const double number = value->get<double>();
    if (!std::isfinite(number)) return fail(key, "expected a finite number");
    out = number;
}

void JsonReader::required(std::string_view key, float& out) {
    double wide = out;
    required(key, wide);
    out = static_cast<float>(wide);
}

void JsonReader::required(std::string_view key, std::span<double> out) {
    const auto* value = need(key);
    if (!value) return;
    const std::string wanted = "expected an array of " + std::to_string(out.size()) + " numbers";
    if (!value->is_array() || value->size() != out.size()) return fail(key, wanted);
    for (std::size_t i = 0; i < out.size(); ++i) {
        const auto& item = (*value)[i];
        if (!item.is_number() || !std::isfinite(item.get<double>())) return fail(key, wanted);
        out[i] = item.get<double>();
    }
}

std::span<const nlohmann::json> JsonReader::array(std::string_view key, std::size_t max_items) {
    const auto* value = find(key);
    if (!value) return {};
    if (!value->is_array()) {
        fail(key, "expected an array, got " + type_name(*value));
        return {};
    }
    if (value->size() > max_items) {
        fail(key, std::to_string(value->size()) + " items; at most " + std::to_string(max_items) + " are taken",
             ErrorKind::resource_exhausted);
        return {};
    }
    const auto& items = value->get_ref<const nlohmann::json::array_t&>();
    return {items.data(), items.size()};
}

void JsonReader::fail(std::string_view key, std::string message, ErrorKind kind) {
    ErrorList* const list = ErrorList::current();
    // Of what is no object at all nothing more is said.
    if (list && object_->is_object() && failed_.emplace(key).second) list->add(path_of(key), message);
    if (!error_) error_ = Error{kind, path_of(key) + ": " + message};
}

void JsonReader::fail(Error error) {
    if (ErrorList* const list = ErrorList::current()) list->add(path_, error);
    if (!error_) error_ = std::move(error);
}

void JsonReader::fail_inside(const Error& error) {
    const auto colon = error.message.find(": ");
    if (colon == std::string::npos) return fail(Error{error.kind, path_ + ": " + error.message});
    fail(error.message.substr(0, colon), error.message.substr(colon + 2), error.kind);
}

Result<void> JsonReader::finish() {
    const bool lists_all = ErrorList::current() != nullptr && object_->is_object() && !allows_unknown_;
    if (!error_ || lists_all) {
        for (const auto& [key, value] : object_->items()) {
            if (known_.contains(key)) continue;
            std::string names;
            for (const auto& name : known_) names += (names.empty() ? "" : ", ") + name;
            fail(key.substr(0, 60), "unknown key; known here: " + names);
            if (!lists_all) break;
        }
    }
    if (error_) return std::unexpected(*error_);
    return {};
}

}  // namespace camrig

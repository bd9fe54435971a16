#include "core/camera/yaml_document.h"

#include <algorithm>
#include <string>

#include <yaml-cpp/yaml.h>

namespace camrig::camera {
namespace {

constexpr int max_depth = 16;
constexpr int max_values = 20000;
/// Brackets open at once in the text; asked before the parser runs, which recurses for each of them.
constexpr int max_open_brackets = 64;
constexpr std::size_t max_shown = 80;

std::string printable(std::string text) {
    if (text.size() > max_shown) text = text.substr(0, max_shown) + "...";
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7e) c = '?';
    return text;
}

class Converter {
public:
    Result<nlohmann::json> convert(const YAML::Node& node, const std::string& path, int depth) {
        if (depth > max_depth) return refuse(path, "is nested more than 16 deep");
        if (++values_ > max_values) return refuse(path, "is one value too many; at most 20000 are read");
        switch (node.Type()) {
            case YAML::NodeType::Scalar:
                return nlohmann::json(node.Scalar());
            case YAML::NodeType::Sequence:
                return convert_sequence(node, path, depth);
            case YAML::NodeType::Map:
                return convert_map(node, path, depth);
            case YAML::NodeType::Null:
            case YAML::NodeType::Undefined:
                break;
        }
        return nlohmann::json();
    }

private:
    static std::unexpected<Error> refuse(const std::string& path, const char* what) {
        return error(ErrorKind::invalid_argument, (path.empty() ? "the document" : path) + " " + what);
    }

    Result<nlohmann::json> convert_sequence(const YAML::Node& node, const std::string& path, int depth) {
        nlohmann::json out = nlohmann::json::array();
        for (const YAML::Node& item : node) {
            auto value = convert(item, path + "[" + std::to_string(out.size()) + "]", depth + 1);
            if (!value) return value;
            out.push_back(std::move(*value));
        }
        return out;
    }

    Result<nlohmann::json> convert_map(const YAML::Node& node, const std::string& path, int depth) {
        nlohmann::json out = nlohmann::json::object();
        for (const auto& item : node) {
            if (!item.first.IsScalar()) return refuse(path, "has a key that is not plain text");
            const std::string& key = item.first.Scalar();
            const std::string inner = path.empty() ? printable(key) : path + "." + printable(key);
            if (out.contains(key)) return refuse(inner, "is given twice");
            auto value = convert(item.second, inner, depth + 1);
            if (!value) return value;
            out[key] = std::move(*value);
        }
        return out;
    }

    int values_ = 0;
};

Result<void> check_brackets(std::string_view text) {
    int open = 0;
    for (const char c : text) {
        if (c == '[' || c == '{') ++open;
        if (c == ']' || c == '}') open = std::max(0, open - 1);
        if (open > max_open_brackets)
            return error(ErrorKind::invalid_argument, "more than 64 brackets are open at once");
    }
    return {};
}

}  // namespace

Result<nlohmann::json> parse_yaml(std::string_view text) {
    if (text.size() > max_yaml_bytes)
        return error(ErrorKind::invalid_argument, "is larger than 256 KiB; no calibration is");
    if (text.find('\0') != std::string_view::npos)
        return error(ErrorKind::invalid_argument, "holds zero bytes; it is no text file");
    if (auto good = check_brackets(text); !good) return std::unexpected(good.error());
    // FileStorage starts with "%YAML:1.0", which is no YAML directive ("%YAML 1.0" would be). The line stays, empty, so
    // that line numbers in messages are right.
    if (text.starts_with("%YAML:")) text.remove_prefix(std::min(text.find('\n'), text.size()));
    try {
        return Converter().convert(YAML::Load(std::string(text)), "", 0);
    } catch (const YAML::Exception& problem) {
        const std::string line = problem.mark.is_null() ? "" : "line " + std::to_string(problem.mark.line + 1) + ": ";
        return error(ErrorKind::invalid_argument, line + printable(problem.msg));
    } catch (const std::exception& problem) {
        return error(ErrorKind::invalid_argument, "is no YAML: " + printable(problem.what()));
    }
}

}  // namespace camrig::camera

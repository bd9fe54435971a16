#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <pugixml.hpp>

#include "core/base/result.h"

/// Reading XML that strangers send, and writing ours. pugixml expands no entities but the five of XML and loads
/// nothing; prefixes it leaves to its callers.
namespace camrig::onvif {

inline constexpr std::size_t max_xml_bytes = 256 * 1024;
inline constexpr int max_xml_depth = 64;
inline constexpr std::size_t max_xml_elements = 4096;

/// An element, or none; a view of a document that outlives it.
class XmlElement {
public:
    XmlElement() = default;
    explicit XmlElement(pugi::xml_node node) : node_(node) {}
    explicit operator bool() const { return !node_.empty(); }

    /// Without its prefix.
    std::string_view name() const;
    /// The namespace that its prefix stands for; empty: none.
    std::string_view space() const;
    /// The first child element of that name, whatever its namespace: clients are careless with those of inner elements.
    XmlElement child(std::string_view name) const;
    XmlElement first_child() const;
    /// Whether one of its children has that name and that text.
    bool has_child_of_text(std::string_view name, std::string_view text) const;
    /// Of the child of that name: its text without blanks around it; empty: there is no such child.
    std::string_view text(std::string_view child) const { return this->child(child).text(); }
    std::string_view text() const;
    /// Of that name and no namespace, so written without a prefix, as those of ONVIF are; nullopt: there is none.
    std::optional<std::string_view> attribute(std::string_view name) const;

private:
    pugi::xml_node node_;
};

/// invalid_argument: no XML, a document type, or beyond the bounds above.
Result<void> parse_xml(std::string_view text, pugi::xml_document& document);

/// Without blanks around it.
std::string_view trimmed(std::string_view text);
/// Whether XML 1.0 can say it.
bool is_xml_text(std::string_view text);
/// For text and attributes; what XML cannot say becomes '?'.
std::string escaped(std::string_view text);
/// Six decimals, a point, no exponent, no negative zero, in every locale.
std::string number(double value);
/// <name attributes>content</name>; the content is markup. `attributes` is empty or as in `token="a" fixed="true"`.
std::string element(std::string_view name, std::string_view content, std::string_view attributes = {});
/// The same around text, which is escaped.
std::string text_element(std::string_view name, std::string_view text);

}  // namespace camrig::onvif

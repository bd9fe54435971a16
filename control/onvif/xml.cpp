#include "control/onvif/xml.h"

#include <charconv>
#include <cmath>
#include <cstdint>

namespace camrig::onvif {
namespace {

constexpr std::string_view blanks = " \t\r\n";

std::string_view local_name(std::string_view name) {
    return name.substr(name.find(':') + 1);  // npos + 1 is 0
}

Error bad(const char* why) {
    return {ErrorKind::invalid_argument, std::string("the message is no XML that this camera reads: ") + why};
}

/// Bytes of the UTF-8 character at the begin of `text` that XML 1.0 can say; 0: there is none.
std::size_t character_bytes(std::string_view text) {
    const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
    if (byte(0) < 0x80) return byte(0) >= 0x20 || blanks.contains(text[0]) ? 1 : 0;
    const std::size_t bytes = byte(0) >= 0xF0 ? 4 : byte(0) >= 0xE0 ? 3 : 2;
    if (byte(0) < 0xC2 || byte(0) > 0xF4 || text.size() < bytes) return 0;
    std::uint32_t code = byte(0) & (0x7Fu >> bytes);
    for (std::size_t i = 1; i < bytes; ++i) {
        if ((byte(i) & 0xC0) != 0x80) return 0;
        code = code << 6 | (byte(i) & 0x3Fu);
    }
    constexpr std::uint32_t shortest[] = {0x80, 0x800, 0x10000};
    const bool is_surrogate = code >= 0xD800 && code < 0xE000;
    const bool is_good =
        code >= shortest[bytes - 2] && code <= 0x10FFFF && !is_surrogate && code != 0xFFFE && code != 0xFFFF;
    return is_good ? bytes : 0;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(blanks);
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(blanks) - begin + 1);
}

std::string_view XmlElement::name() const {
    return local_name(node_.name());
}

std::string_view XmlElement::space() const {
    const std::string_view full = node_.name();
    const std::size_t colon = full.find(':');
    const std::string wanted =
        colon == std::string_view::npos ? "xmlns" : "xmlns:" + std::string(full.substr(0, colon));
    for (pugi::xml_node at = node_; at; at = at.parent())
        if (const auto found = at.attribute(wanted.c_str())) return found.value();
    return {};
}

XmlElement XmlElement::child(std::string_view name) const {
    for (const pugi::xml_node one : node_.children())
        if (one.type() == pugi::node_element && local_name(one.name()) == name) return XmlElement(one);
    return {};
}

bool XmlElement::has_child_of_text(std::string_view name, std::string_view text) const {
    for (const pugi::xml_node one : node_.children())
        if (local_name(one.name()) == name && XmlElement(one).text() == text) return true;
    return false;
}

XmlElement XmlElement::first_child() const {
    for (const pugi::xml_node one : node_.children())
        if (one.type() == pugi::node_element) return XmlElement(one);
    return {};
}

std::string_view XmlElement::text() const {
    return trimmed(node_.text().get());
}

std::optional<std::string_view> XmlElement::attribute(std::string_view name) const {
    for (const pugi::xml_attribute one : node_.attributes())
        if (one.name() == name) return one.value();
    return std::nullopt;
}

Result<void> parse_xml(std::string_view text, pugi::xml_document& document) {
    if (text.size() > max_xml_bytes) return std::unexpected(bad("it is too long"));
    const auto parsed =
        document.load_buffer(text.data(), text.size(), pugi::parse_default | pugi::parse_doctype, pugi::encoding_utf8);
    if (!parsed) return std::unexpected(bad(parsed.description()));
    std::size_t elements = 0;
    int depth = 0;
    for (pugi::xml_node at = document.first_child(); at;) {
        if (at.type() == pugi::node_doctype) return std::unexpected(bad("SOAP has no document type"));
        if (at.type() == pugi::node_element && ++elements > max_xml_elements)
            return std::unexpected(bad("it has too many elements"));
        if (at.first_child()) {
            if (++depth >= max_xml_depth) return std::unexpected(bad("its elements are too deep"));
            at = at.first_child();
            continue;
        }
        while (at && !at.next_sibling()) {
            at = at.parent();
            --depth;
        }
        if (at) at = at.next_sibling();
    }
    return {};
}

bool is_xml_text(std::string_view text) {
    while (!text.empty()) {
        const std::size_t bytes = character_bytes(text);
        if (bytes == 0) return false;
        text.remove_prefix(bytes);
    }
    return true;
}

std::string escaped(std::string_view text) {
    std::string safe;
    while (!text.empty()) {
        const std::size_t bytes = character_bytes(text);
        if (bytes == 0)
            safe += '?';
        else if (text.front() == '&')
            safe += "&amp;";
        else if (text.front() == '<')
            safe += "&lt;";
        else if (text.front() == '>')
            safe += "&gt;";
        else if (text.front() == '"')
            safe += "&quot;";
        else
            safe += text.substr(0, bytes);
        text.remove_prefix(std::max<std::size_t>(bytes, 1));
    }
    return safe;
}

std::string number(double value) {
    constexpr int decimals = 6;
    constexpr double largest = 1e15;
    if (!(std::abs(value) < largest)) value = 0.0;
    if (std::abs(value) < 0.5e-6) value = 0.0;  // so that it is no "-0.000000" either
    char text[40];
    const auto [end, failed] = std::to_chars(text, text + sizeof text, value, std::chars_format::fixed, decimals);
    return failed == std::errc{} ? std::string(text, end) : "0.000000";
}

std::string element(std::string_view name, std::string_view content, std::string_view attributes) {
    std::string made = "<" + std::string(name);
    if (!attributes.empty()) made.append(" ").append(attributes);
    if (content.empty()) return made + "/>";
    return made.append(">").append(content).append("</").append(name).append(">");
}

std::string text_element(std::string_view name, std::string_view text) {
    return element(name, escaped(text));
}

}  // namespace camrig::onvif

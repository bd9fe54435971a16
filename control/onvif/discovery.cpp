#include "control/onvif/discovery.h"

#include <algorithm>

#include "control/onvif/soap.h"

namespace camrig::onvif {
namespace {

constexpr std::string_view discovery_space = "http://schemas.xmlsoap.org/ws/2005/04/discovery";
constexpr std::size_t max_words = 16;
constexpr std::size_t max_id = 256;

std::vector<std::string> words_of(std::string_view text) {
    std::vector<std::string> words;
    while (words.size() < max_words) {
        text = trimmed(text);
        if (text.empty()) break;
        const std::size_t end = std::min(text.find_first_of(" \t\r\n"), text.size());
        words.emplace_back(text.substr(0, end));
        text.remove_prefix(end);
    }
    return words;
}

std::string lower(std::string_view text) {
    std::string made(text);
    for (char& one : made)
        if (one >= 'A' && one <= 'Z') one = static_cast<char>(one - 'A' + 'a');
    return made;
}

/// Scheme and authority, whose letters' case is of no account, and the path.
std::pair<std::string, std::string_view> parts_of(std::string_view uri) {
    const std::size_t authority = uri.find("//");
    const std::size_t path =
        std::min(authority == std::string_view::npos ? 0 : uri.find('/', authority + 2), uri.size());
    return {lower(uri.substr(0, path)), uri.substr(path)};
}

/// By whole segments of the path: ".../Profile" is a prefix of ".../Profile/Streaming", ".../Prof" is none.
bool is_prefix(std::string_view asked, std::string_view ours) {
    const auto [asked_begin, asked_path] = parts_of(asked);
    const auto [our_begin, our_path] = parts_of(ours);
    if (asked_begin != our_begin) return false;
    std::string_view path = asked_path;
    while (path.ends_with('/')) path.remove_suffix(1);
    return our_path.starts_with(path) && (our_path.size() == path.size() || our_path[path.size()] == '/');
}

std::string message(std::string_view action, const DiscoveryHead& head, std::string_view to,
                    std::string_view relates_to, std::string_view body) {
    static constexpr std::string_view begin =
        R"(<?xml version="1.0" encoding="UTF-8"?>)"
        "\n"
        R"(<s:Envelope xmlns:s="http://www.w3.org/2003/05/soap-envelope")"
        R"( xmlns:a="http://schemas.xmlsoap.org/ws/2004/08/addressing")"
        R"( xmlns:d="http://schemas.xmlsoap.org/ws/2005/04/discovery")"
        R"( xmlns:dn="http://www.onvif.org/ver10/network/wsdl" xmlns:tds="http://www.onvif.org/ver10/device/wsdl">)";
    const std::string fields = element("a:Action", std::string(discovery_space) + "/" + std::string(action)) +
                               element("a:MessageID", head.id) +
                               (relates_to.empty() ? "" : text_element("a:RelatesTo", relates_to)) +
                               element("a:To", to) +
                               element("d:AppSequence", "",
                                       "InstanceId=\"" + std::to_string(head.instance) + "\" MessageNumber=\"" +
                                           std::to_string(head.number) + "\"");
    return std::string(begin) + element("s:Header", fields) + element("s:Body", body) + "</s:Envelope>";
}

std::string reference(const DiscoveredDevice& device) {
    return element("a:EndpointReference", text_element("a:Address", device.address));
}

std::string facts(const DiscoveredDevice& device) {
    std::string scopes;
    for (const std::string& scope : device.scopes) scopes += (scopes.empty() ? "" : " ") + scope;
    return reference(device) + "<d:Types>dn:NetworkVideoTransmitter tds:Device</d:Types>" +
           text_element("d:Scopes", scopes) + text_element("d:XAddrs", device.url) +
           "<d:MetadataVersion>1</d:MetadataVersion>";
}

constexpr std::string_view everybody = "urn:schemas-xmlsoap-org:ws:2005:04:discovery";
constexpr std::string_view who_asked = "http://schemas.xmlsoap.org/ws/2004/08/addressing/role/anonymous";

}  // namespace

std::optional<DiscoveryQuestion> read_question(std::string_view text) {
    if (text.size() > max_discovery_bytes) return std::nullopt;
    const auto message = read_soap(text);
    if (!message) return std::nullopt;
    const XmlElement asked = (*message)->operation;
    const XmlElement header = XmlElement((*message)->document).first_child().child("Header");
    DiscoveryQuestion question{.is_resolve = asked.name() == "Resolve", .id = std::string(header.text("MessageID"))};
    if (asked.space() != discovery_space || (!question.is_resolve && asked.name() != "Probe")) return std::nullopt;
    if (question.id.empty() || question.id.size() > max_id) return std::nullopt;
    if (question.is_resolve) {
        question.address = asked.child("EndpointReference").text("Address");
        return question;
    }
    for (const std::string& type : words_of(asked.text("Types")))
        question.types.push_back(type.substr(type.find(':') + 1));  // npos + 1 is 0
    const XmlElement scopes = asked.child("Scopes");
    question.scopes = words_of(scopes.text());
    const std::string_view rule = scopes.attribute("MatchBy").value_or("");
    question.is_exact = rule.ends_with("/strcmp0");
    if (!rule.empty() && !question.is_exact && !rule.ends_with("/rfc3986")) return std::nullopt;
    return question;
}

bool is_asked_for(const DiscoveredDevice& device, const DiscoveryQuestion& question) {
    if (question.is_resolve) return question.address == device.address;
    const bool has_types = std::ranges::all_of(
        question.types, [](const std::string& type) { return type == "NetworkVideoTransmitter" || type == "Device"; });
    const auto has_scope = [&](const std::string& asked) {
        return std::ranges::any_of(device.scopes, [&](const std::string& ours) {
            return question.is_exact ? asked == ours : is_prefix(asked, ours);
        });
    };
    return has_types && std::ranges::all_of(question.scopes, has_scope);
}

std::string match_message(const DiscoveryHead& head, const DiscoveryQuestion& question,
                          const DiscoveredDevice& device) {
    const std::string kind = question.is_resolve ? "ResolveMatch" : "ProbeMatch";
    return message(kind + "es", head, who_asked, question.id,
                   element("d:" + kind + "es", element("d:" + kind, facts(device))));
}

std::string hello_message(const DiscoveryHead& head, const DiscoveredDevice& device) {
    return message("Hello", head, everybody, "", element("d:Hello", facts(device)));
}

std::string bye_message(const DiscoveryHead& head, const DiscoveredDevice& device) {
    return message("Bye", head, everybody, "", element("d:Bye", reference(device)));
}

}  // namespace camrig::onvif

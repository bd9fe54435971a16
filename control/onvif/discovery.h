#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Messages of WS-Discovery (April 2005) as ONVIF Core (7, "Device discovery") uses it. Pure.
namespace camrig::onvif {

inline constexpr std::size_t max_discovery_bytes = 8 * 1024;  ///< of a question

/// What a client asks all devices of its network.
struct DiscoveryQuestion {
    bool is_resolve = false;               ///< else a Probe
    std::string id;                        ///< of the message
    std::vector<std::string> types = {};   ///< of a Probe, without prefixes; a device has all of them
    std::vector<std::string> scopes = {};  ///< the same
    bool is_exact = false;                 ///< scopes are compared letter by letter ("strcmp0"), not as by "rfc3986"
    std::string address = {};              ///< of a Resolve
};
/// nullopt: it is none, or asks for matches in a way that we do not know; both are answered by silence.
std::optional<DiscoveryQuestion> read_question(std::string_view text);

struct DiscoveredDevice {
    std::string address;  ///< "urn:uuid:..."
    std::vector<std::string> scopes;
    std::string url;
};
bool is_asked_for(const DiscoveredDevice& device, const DiscoveryQuestion& question);

/// What is said of every message: which of the rig's it is.
struct DiscoveryHead {
    std::string id;  ///< its own: "urn:uuid:..."
    std::uint64_t instance = 0, number = 0;
};
std::string match_message(const DiscoveryHead& head, const DiscoveryQuestion& question, const DiscoveredDevice& device);
/// A device has come, or goes.
std::string hello_message(const DiscoveryHead& head, const DiscoveredDevice& device);
std::string bye_message(const DiscoveryHead& head, const DiscoveredDevice& device);

}  // namespace camrig::onvif

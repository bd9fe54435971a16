#include "control/onvif/device_identity.h"

#include <cstdint>
#include <cstdio>

#include <unistd.h>

namespace camrig::onvif {
namespace {

/// FNV-1a.
std::uint64_t number_of(std::string_view device) {
    std::uint64_t number = 0xcbf29ce484222325;
    for (const char one : host_name() + "/" + std::string(device))
        number = (number ^ static_cast<unsigned char>(one)) * 0x100000001b3;
    return number;
}

std::string hex_of(std::uint64_t number, int digits) {
    char text[17];
    std::snprintf(text, sizeof text, "%0*llx", digits,
                  static_cast<unsigned long long>(digits == 16 ? number : number & ((1ull << 4 * digits) - 1)));
    return text;
}

}  // namespace

std::string host_name() {
    char name[256] = {};
    return ::gethostname(name, sizeof name - 1) == 0 ? name : "camrig";
}

std::string serial_number(std::string_view device) {
    return hex_of(number_of(device), 16);
}

std::string hardware_address(std::string_view device) {
    const std::string digits = hex_of(number_of(device), 10);
    std::string text = "02";
    for (std::size_t i = 0; i < digits.size(); i += 2) text += ":" + digits.substr(i, 2);
    return text;
}

std::string endpoint_address(std::string_view device) {
    const std::uint64_t number = number_of(device);
    const std::string digits = hex_of(number * 0x9e3779b97f4a7c15, 16) + hex_of(number, 16);
    // A UUID of version 8, "custom" (RFC 9562, 5.8).
    return "urn:uuid:" + digits.substr(0, 8) + "-" + digits.substr(8, 4) + "-8" + digits.substr(13, 3) + "-8" +
           digits.substr(17, 3) + "-" + digits.substr(20);
}

std::vector<std::string> scopes_of(std::string_view device, bool has_heads) {
    const std::string begin = "onvif://www.onvif.org/";
    std::vector<std::string> scopes{begin + "Profile/Streaming", begin + "type/video_encoder"};
    if (has_heads) scopes.push_back(begin + "type/ptz");
    scopes.push_back(begin + "name/" + (device.empty() ? "camrig" : std::string(device)));
    scopes.push_back(begin + "hardware/camrig");
    scopes.push_back(begin + "MAC/" + hardware_address(device));
    return scopes;
}

}  // namespace camrig::onvif

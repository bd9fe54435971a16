#pragma once

#include <string>
#include <string_view>
#include <vector>

/// What clients know a device again by: made of the machine's name and that of its camera (empty: the device with all
/// cameras), so the same each time.
namespace camrig::onvif {

std::string host_name();
/// 16 hexadecimal digits.
std::string serial_number(std::string_view device);
/// Of a locally administered address, which no maker of devices has.
std::string hardware_address(std::string_view device);
/// "urn:uuid:..."
std::string endpoint_address(std::string_view device);
std::vector<std::string> scopes_of(std::string_view device, bool has_heads);

}  // namespace camrig::onvif

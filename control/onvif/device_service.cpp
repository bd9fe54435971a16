#include <chrono>
#include <cstdint>
#include <cstdio>

#include <unistd.h>

#include "control/onvif/operation.h"

// ONVIF Core, "Device management": what the device is, and where its services are.
namespace camrig::onvif {
namespace {

constexpr std::string_view media_space = "http://www.onvif.org/ver10/media/wsdl";
constexpr std::string_view ptz_space = "http://www.onvif.org/ver20/ptz/wsdl";
constexpr std::string_view imaging_space = "http://www.onvif.org/ver20/imaging/wsdl";
constexpr std::string_view device_space = "http://www.onvif.org/ver10/device/wsdl";

std::string host_name() {
    char name[256] = {};
    return ::gethostname(name, sizeof name - 1) == 0 ? name : "camrig";
}

/// A number of the device, the same each time: clients know a device again by what is made of it. FNV-1a.
std::uint64_t number_of(const Asked& asked) {
    std::uint64_t number = 0xcbf29ce484222325;
    for (const char one : host_name() + "/" + asked.device)
        number = (number ^ static_cast<unsigned char>(one)) * 0x100000001b3;
    return number;
}

std::string hex_of(std::uint64_t number, int digits) {
    char text[17];
    std::snprintf(text, sizeof text, "%0*llx", digits,
                  static_cast<unsigned long long>(digits == 16 ? number : number & ((1ull << 4 * digits) - 1)));
    return text;
}

/// Of a locally administered address, which no maker of devices has.
std::string hardware_address(const Asked& asked) {
    const std::string digits = hex_of(number_of(asked), 10);
    std::string text = "02";
    for (std::size_t i = 0; i < digits.size(); i += 2) text += ":" + digits.substr(i, 2);
    return text;
}

std::string device_name(const Asked& asked) {
    return asked.device.empty() ? "camrig" : asked.device;
}

/// Without brackets and port.
std::string address_of(std::string_view host) {
    if (host.starts_with('[')) return std::string(host.substr(1, host.find(']') - 1));
    return std::string(host.substr(0, host.find(':')));
}

std::string_view port_of(std::string_view host) {
    const std::size_t colon = host.rfind(':');
    return colon == std::string_view::npos || host.ends_with(']') ? "80" : host.substr(colon + 1);
}

Answer get_system_date_and_time(const Asked& asked) {
    const std::chrono::sys_seconds at{std::chrono::seconds(asked.utc_ns / ns_per_s)};
    const auto days = std::chrono::floor<std::chrono::days>(at);
    const std::chrono::year_month_day date(days);
    const std::chrono::hh_mm_ss time(at - days);
    const auto whole = [](const char* name, auto value) { return element(name, std::to_string(value)); };
    const std::string when =
        element("tt:Time", whole("tt:Hour", time.hours().count()) + whole("tt:Minute", time.minutes().count()) +
                               whole("tt:Second", time.seconds().count())) +
        element("tt:Date", whole("tt:Year", static_cast<int>(date.year())) +
                               whole("tt:Month", static_cast<unsigned>(date.month())) +
                               whole("tt:Day", static_cast<unsigned>(date.day())));
    return response("tds:GetSystemDateAndTime",
                    element("tds:SystemDateAndTime",
                            "<tt:DateTimeType>NTP</tt:DateTimeType><tt:DaylightSavings>false</tt:DaylightSavings>"
                            "<tt:TimeZone><tt:TZ>UTC0</tt:TZ></tt:TimeZone>" +
                                element("tt:UTCDateTime", when) + element("tt:LocalDateTime", when)));
}

Answer get_services(const Asked& asked) {
    std::string all;
    const auto add = [&](std::string_view space) {
        all += element("tds:Service", element("tds:Namespace", space) + text_element("tds:XAddr", asked.device_url()) +
                                          "<tds:Version><tt:Major>2</tt:Major><tt:Minor>60</tt:Minor></tds:Version>");
    };
    add(device_space);
    add(media_space);
    if (asked.has_heads()) add(ptz_space);
    add(imaging_space);
    add(event_space);
    return response("tds:GetServices", all);
}

Answer get_service_capabilities(const Asked&) {
    return response("tds:GetServiceCapabilities",
                    R"(<tds:Capabilities><tds:Network IPFilter="false" ZeroConfiguration="false" IPVersion6="true")"
                    R"( DynDNS="false"/><tds:Security TLS1.0="false" UsernameToken="true" HttpDigest="true"/>)"
                    R"(<tds:System DiscoveryResolve="false" DiscoveryBye="false" RemoteDiscovery="false")"
                    R"( SystemBackup="false" SystemLogging="false" FirmwareUpgrade="false"/></tds:Capabilities>)");
}

Answer get_capabilities(const Asked& asked) {
    const std::string here = text_element("tt:XAddr", asked.device_url());
    std::string all = element("tt:Device", here) +
                      element("tt:Events", here +
                                               "<tt:WSSubscriptionPolicySupport>false</tt:WSSubscriptionPolicySupport>"
                                               "<tt:WSPullPointSupport>true</tt:WSPullPointSupport>"
                                               "<tt:WSPausableSubscriptionManagerInterfaceSupport>false"
                                               "</tt:WSPausableSubscriptionManagerInterfaceSupport>") +
                      element("tt:Imaging", here) +
                      element("tt:Media", here +
                                              "<tt:StreamingCapabilities><tt:RTPMulticast>false</tt:RTPMulticast>"
                                              "<tt:RTP_TCP>true</tt:RTP_TCP><tt:RTP_RTSP_TCP>true</tt:RTP_RTSP_TCP>"
                                              "</tt:StreamingCapabilities>");
    if (asked.has_heads()) all += element("tt:PTZ", here);
    return response("tds:GetCapabilities", element("tds:Capabilities", all));
}

Answer get_device_information(const Asked& asked) {
    return response("tds:GetDeviceInformation",
                    "<tds:Manufacturer>camrig</tds:Manufacturer><tds:Model>virtual camera</tds:Model>" +
                        text_element("tds:FirmwareVersion", asked.site.version) +
                        text_element("tds:SerialNumber", hex_of(number_of(asked), 16)) +
                        text_element("tds:HardwareId", "camrig"));
}

Answer get_network_interfaces(const Asked& asked) {
    const std::string address = address_of(asked.host);
    const bool is_ipv4 = !address.empty() && address.find_first_not_of("0123456789.") == std::string::npos;
    const std::string info =
        element("tt:Info", "<tt:Name>eth0</tt:Name>" + text_element("tt:HwAddress", hardware_address(asked)) +
                               "<tt:MTU>1500</tt:MTU>");
    const std::string manual =
        is_ipv4 ? element("tt:Manual", text_element("tt:Address", address) + "<tt:PrefixLength>24</tt:PrefixLength>")
                : "";
    return response("tds:GetNetworkInterfaces",
                    element("tds:NetworkInterfaces",
                            "<tt:Enabled>true</tt:Enabled>" + info +
                                element("tt:IPv4", "<tt:Enabled>true</tt:Enabled>" +
                                                       element("tt:Config", manual + "<tt:DHCP>false</tt:DHCP>")),
                            R"(token="eth0")"));
}

Answer get_network_protocols(const Asked& asked) {
    const auto one = [](const char* name, std::string_view port) {
        return element("tds:NetworkProtocols",
                       text_element("tt:Name", name) + "<tt:Enabled>true</tt:Enabled>" + text_element("tt:Port", port));
    };
    return response("tds:GetNetworkProtocols",
                    one("HTTP", port_of(asked.host)) + one("RTSP", std::to_string(asked.site.rtsp_port)));
}

Answer get_scopes(const Asked& asked) {
    std::string all;
    const auto add = [&](const std::string& scope) {
        all += element("tds:Scopes", "<tt:ScopeDef>Fixed</tt:ScopeDef>" +
                                         text_element("tt:ScopeItem", "onvif://www.onvif.org/" + scope));
    };
    add("Profile/Streaming");
    add("type/video_encoder");
    if (asked.has_heads()) add("type/ptz");
    add("name/" + device_name(asked));
    add("hardware/camrig");
    add("MAC/" + hardware_address(asked));
    return response("tds:GetScopes", all);
}

Answer get_hostname(const Asked&) {
    return response("tds:GetHostname", element("tds:HostnameInformation", "<tt:FromDHCP>false</tt:FromDHCP>" +
                                                                              text_element("tt:Name", host_name())));
}

Answer get_endpoint_reference(const Asked& asked) {
    const std::uint64_t number = number_of(asked);
    const std::string digits = hex_of(number * 0x9e3779b97f4a7c15, 16) + hex_of(number, 16);
    // A UUID of version 8, "custom" (RFC 9562, 5.8).
    return response(
        "tds:GetEndpointReference",
        text_element("tds:GUID", "urn:uuid:" + digits.substr(0, 8) + "-" + digits.substr(8, 4) + "-8" +
                                     digits.substr(13, 3) + "-8" + digits.substr(17, 3) + "-" + digits.substr(20)));
}

/// What many ask for and little depends on.
constexpr const char* no_dhcp = "<tt:FromDHCP>false</tt:FromDHCP>";

const Operation operations[] = {
    {"GetSystemDateAndTime", get_system_date_and_time, Access::open},
    {"GetServices", get_services, Access::open},
    {"GetServiceCapabilities", get_service_capabilities, Access::open},
    {"GetCapabilities", get_capabilities, Access::open},
    {"GetHostname", get_hostname, Access::open},
    {"GetEndpointReference", get_endpoint_reference, Access::open},
    {"GetWsdlUrl",
     [](const Asked&) -> Answer {
         return response("tds:GetWsdlUrl", "<tds:WsdlUrl>http://www.onvif.org/</tds:WsdlUrl>");
     },
     Access::open},
    {"GetDeviceInformation", get_device_information},
    {"GetNetworkInterfaces", get_network_interfaces},
    {"GetNetworkProtocols", get_network_protocols},
    {"GetScopes", get_scopes},
    {"GetDNS", [](const Asked&) -> Answer { return response("tds:GetDNS", element("tds:DNSInformation", no_dhcp)); }},
    {"GetNTP", [](const Asked&) -> Answer { return response("tds:GetNTP", element("tds:NTPInformation", no_dhcp)); }},
    {"GetNetworkDefaultGateway",
     [](const Asked&) -> Answer {
         return response("tds:GetNetworkDefaultGateway", element("tds:NetworkGateway", ""));
     }},
    {"GetDiscoveryMode",
     [](const Asked&) -> Answer {
         return response("tds:GetDiscoveryMode", "<tds:DiscoveryMode>NonDiscoverable</tds:DiscoveryMode>");
     }},
    {"GetUsers", [](const Asked&) -> Answer { return response("tds:GetUsers", ""); }},
    {"GetRelayOutputs", [](const Asked&) -> Answer { return response("tds:GetRelayOutputs", ""); }},
};

}  // namespace

Service device_service() {
    return {device_space, operations};
}

}  // namespace camrig::onvif

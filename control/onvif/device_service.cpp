#include <chrono>

#include "control/onvif/device_identity.h"
#include "control/onvif/operation.h"

// ONVIF Core, "Device management": what the device is, and where its services are.
namespace camrig::onvif {
namespace {

constexpr std::string_view media_space = "http://www.onvif.org/ver10/media/wsdl";
constexpr std::string_view media2_space = "http://www.onvif.org/ver20/media/wsdl";
constexpr std::string_view ptz_space = "http://www.onvif.org/ver20/ptz/wsdl";
constexpr std::string_view imaging_space = "http://www.onvif.org/ver20/imaging/wsdl";
constexpr std::string_view device_space = "http://www.onvif.org/ver10/device/wsdl";

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
    const auto at =
        std::chrono::floor<std::chrono::seconds>(std::chrono::sys_time(std::chrono::nanoseconds(asked.utc_ns)));
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
    add(media2_space);
    if (asked.has_heads()) add(ptz_space);
    add(imaging_space);
    add(event_space);
    return response("tds:GetServices", all);
}

Answer get_service_capabilities(const Asked& asked) {
    const std::string discovers = asked.site.is_discoverable ? "true" : "false";
    return response(
        "tds:GetServiceCapabilities",
        R"(<tds:Capabilities><tds:Network IPFilter="false" ZeroConfiguration="false" IPVersion6="true")"
        R"( DynDNS="false"/><tds:Security TLS1.0="false" UsernameToken="true" HttpDigest="true" DefaultAccessPolicy="true"/>)"
        R"(<tds:System DiscoveryResolve=")" +
            discovers + R"(" DiscoveryBye=")" + discovers +
            R"(" RemoteDiscovery="false")"
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
                        text_element("tds:SerialNumber", serial_number(asked.device)) +
                        text_element("tds:HardwareId", "camrig"));
}

Answer get_network_interfaces(const Asked& asked) {
    const std::string address = address_of(asked.host);
    const bool is_ipv4 = !address.empty() && address.find_first_not_of("0123456789.") == std::string::npos;
    const std::string info =
        element("tt:Info", "<tt:Name>eth0</tt:Name>" + text_element("tt:HwAddress", hardware_address(asked.device)) +
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
    for (const std::string& scope : scopes_of(asked.device, asked.has_heads()))
        all += element("tds:Scopes", "<tt:ScopeDef>Fixed</tt:ScopeDef>" + text_element("tt:ScopeItem", scope));
    return response("tds:GetScopes", all);
}

Answer get_hostname(const Asked&) {
    return response("tds:GetHostname", element("tds:HostnameInformation", "<tt:FromDHCP>false</tt:FromDHCP>" +
                                                                              text_element("tt:Name", host_name())));
}

Answer get_endpoint_reference(const Asked& asked) {
    return response("tds:GetEndpointReference", text_element("tds:GUID", endpoint_address(asked.device)));
}

/// Without their passwords, as the standard wants.
Answer get_users(const Asked& asked) {
    std::string all;
    for (const User& user : asked.users) {
        static constexpr std::string_view levels[] = {"User", "Operator", "Administrator"};
        all += element("tds:User", text_element("tt:Username", user.name) +
                                       element("tt:UserLevel", levels[static_cast<std::size_t>(user.role)]));
    }
    return response("tds:GetUsers", all);
}

/// The users are those of a file, which is read at the start; without one there are none that could be changed.
Answer refuse_change_of_users(const Asked& asked, Fault fault) {
    if (asked.users.empty()) return std::unexpected(not_implemented());
    fault.reason = "the users are those of the file that --onvif-users names; it is read when the rig starts";
    return std::unexpected(std::move(fault));
}

/// What many ask for and little depends on.
constexpr const char* no_dhcp = "<tt:FromDHCP>false</tt:FromDHCP>";

const Operation operations[] = {
    {"GetSystemDateAndTime", get_system_date_and_time, Access::pre_auth},
    {"GetServices", get_services, Access::pre_auth},
    {"GetServiceCapabilities", get_service_capabilities, Access::pre_auth},
    {"GetCapabilities", get_capabilities, Access::pre_auth},
    {"GetHostname", get_hostname, Access::pre_auth},
    {"GetEndpointReference", get_endpoint_reference, Access::pre_auth},
    {"GetWsdlUrl",
     [](const Asked&) -> Answer {
         return response("tds:GetWsdlUrl", "<tds:WsdlUrl>http://www.onvif.org/</tds:WsdlUrl>");
     },
     Access::pre_auth},
    {"GetDeviceInformation", get_device_information, Access::read_system},
    {"GetNetworkInterfaces", get_network_interfaces, Access::read_system},
    {"GetNetworkProtocols", get_network_protocols, Access::read_system},
    {"GetScopes", get_scopes, Access::read_system},
    {"GetDNS", [](const Asked&) -> Answer { return response("tds:GetDNS", element("tds:DNSInformation", no_dhcp)); },
     Access::read_system},
    {"GetNTP", [](const Asked&) -> Answer { return response("tds:GetNTP", element("tds:NTPInformation", no_dhcp)); },
     Access::read_system},
    {"GetNetworkDefaultGateway",
     [](const Asked&) -> Answer { return response("tds:GetNetworkDefaultGateway", element("tds:NetworkGateway", "")); },
     Access::read_system},
    {"GetDiscoveryMode",
     [](const Asked& asked) -> Answer {
         const char* const mode = asked.site.is_discoverable ? "Discoverable" : "NonDiscoverable";
         return response("tds:GetDiscoveryMode", element("tds:DiscoveryMode", mode));
     },
     Access::read_system},
    {"GetUsers", get_users, Access::read_system_secret},
    {"CreateUsers",
     [](const Asked& asked) { return refuse_change_of_users(asked, {false, "Action", "TooManyUsers", {}}); },
     Access::write_system},
    {"SetUser",
     [](const Asked& asked) { return refuse_change_of_users(asked, {true, "InvalidArgVal", "FixedUser", {}}); },
     Access::write_system},
    {"DeleteUsers",
     [](const Asked& asked) { return refuse_change_of_users(asked, {true, "InvalidArgVal", "FixedUser", {}}); },
     Access::write_system},
    {"GetRelayOutputs", [](const Asked&) -> Answer { return response("tds:GetRelayOutputs", ""); }},
};

}  // namespace

Service device_service() {
    return {device_space, operations};
}

}  // namespace camrig::onvif

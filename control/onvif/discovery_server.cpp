#include "control/onvif/discovery_server.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <future>
#include <map>
#include <set>
#include <utility>

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <openssl/rand.h>
#include <poll.h>
#include <pthread.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <unistd.h>

#include "control/onvif/device_identity.h"
#include "core/base/clock.h"

namespace camrig::onvif {
namespace {

constexpr std::uint16_t discovery_port = 3702;
constexpr const char* discovery_group = "239.255.255.250";
constexpr auto engine_time = std::chrono::seconds(2);

sockaddr_in endpoint(in_addr address, std::uint16_t port) {
    sockaddr_in made{};
    made.sin_family = AF_INET;
    made.sin_addr = address;
    made.sin_port = htons(port);
    return made;
}

in_addr group_address() {
    in_addr address{};
    ::inet_pton(AF_INET, discovery_group, &address);
    return address;
}

std::string text_of(in_addr address) {
    std::array<char, INET_ADDRSTRLEN> text{};
    return ::inet_ntop(AF_INET, &address, text.data(), text.size());
}

Error failed(const char* what) {
    return {ErrorKind::unavailable, std::string("--onvif-discovery: ") + what + ": " + std::strerror(errno)};
}

/// A random UUID (RFC 9562, 5.4).
std::string new_id() {
    std::array<unsigned char, 16> bytes{};
    CHECK(RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) == 1);
    bytes[6] = static_cast<unsigned char>((bytes[6] & 0x0F) | 0x40);
    bytes[8] = static_cast<unsigned char>((bytes[8] & 0x3F) | 0x80);
    std::string text = "urn:uuid:";
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        if (i == 4 || i == 6 || i == 8 || i == 10) text += '-';
        for (const int digit : {bytes[i] >> 4, bytes[i] & 15}) text += "0123456789abcdef"[digit];
    }
    return text;
}

}  // namespace

Result<DiscoveryServer::Interface> DiscoveryServer::find_interface(const std::string& name, const std::string& host) {
    const auto refuse = [](std::string why) { return error(ErrorKind::invalid_argument, "--onvif-discovery: " + why); };
    ifaddrs* all = nullptr;
    if (::getifaddrs(&all) != 0) return std::unexpected(failed("the interfaces cannot be read"));
    const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> keep(all, ::freeifaddrs);
    std::set<std::string> names;
    std::string addresses;
    in_addr listened{};
    const bool is_number = ::inet_pton(AF_INET, host.c_str(), &listened) == 1;
    const bool is_any = host == "::" || (is_number && listened.s_addr == INADDR_ANY);
    for (const ifaddrs* one = all; one; one = one->ifa_next) {
        names.insert(one->ifa_name);
        if (one->ifa_name != name || !one->ifa_addr || one->ifa_addr->sa_family != AF_INET) continue;
        Interface found{reinterpret_cast<const sockaddr_in*>(one->ifa_addr)->sin_addr,
                        reinterpret_cast<const sockaddr_in*>(one->ifa_netmask)->sin_addr,
                        static_cast<int>(::if_nametoindex(name.c_str()))};
        if (is_any || (is_number && listened.s_addr == found.address.s_addr)) return found;
        addresses += (addresses.empty() ? "" : " or ") + text_of(found.address);
    }
    if (!addresses.empty())
        return refuse("who finds the cameras on " + name + " cannot reach them at --host " + host + "; give --host " +
                      addresses + " or 0.0.0.0");
    if (names.contains(name)) return refuse("the interface " + name + " has no address of IPv4");
    std::string list;
    for (const std::string& one : names) list += (list.empty() ? "" : ", ") + one;
    return refuse("there is no interface '" + name + "'; there are " + list);
}

Result<void> DiscoveryServer::open(const Interface& found) {
    interface_ = found;
    questions_ = UniqueFd(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    answers_ = UniqueFd(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    wake_ = UniqueFd(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
    if (questions_.get() < 0 || answers_.get() < 0 || wake_.get() < 0)
        return std::unexpected(failed("no socket can be had"));
    const auto set = [](int fd, int level, int option, const auto& value) {
        return ::setsockopt(fd, level, option, &value, sizeof value) == 0;
    };
    // Bound to the group: what is sent to an address of ours never comes here. Other programs may listen too.
    const sockaddr_in here = endpoint(group_address(), discovery_port), from = endpoint(found.address, 0);
    const ip_mreqn membership{group_address(), found.address, found.index};
    if (!set(questions_.get(), SOL_SOCKET, SO_REUSEADDR, 1) ||
        ::bind(questions_.get(), reinterpret_cast<const sockaddr*>(&here), sizeof here) != 0 ||
        !set(questions_.get(), IPPROTO_IP, IP_MULTICAST_ALL, 0) ||
        !set(questions_.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, membership))
        return std::unexpected(failed("UDP 3702 cannot be listened on"));
    if (::bind(answers_.get(), reinterpret_cast<const sockaddr*>(&from), sizeof from) != 0 ||
        !set(answers_.get(), IPPROTO_IP, IP_MULTICAST_IF, membership) ||
        !set(answers_.get(), IPPROTO_IP, IP_MULTICAST_TTL, 1))
        return std::unexpected(failed("nothing can be sent on this interface"));
    instance_ = static_cast<std::uint64_t>(realtime_now_ns() / ns_per_s);
    allowed_ns_ = monotonic_now_ns();
    thread_ = std::thread([this] { run(); });
    return {};
}

Result<std::unique_ptr<DiscoveryServer>> DiscoveryServer::create(const std::string& interface, const std::string& host,
                                                                 engine::CommandPort& commands) {
    const auto found = find_interface(interface, host);
    if (!found) return std::unexpected(found.error());
    std::unique_ptr<DiscoveryServer> made(new DiscoveryServer(commands));
    if (auto opened = made->open(*found); !opened) return std::unexpected(opened.error());
    return made;
}

DiscoveryServer::~DiscoveryServer() {
    stop();
}

void DiscoveryServer::add(const std::string& device, std::uint16_t port) {
    changes_.put({{device, port}, true});
}

void DiscoveryServer::remove(const std::string& device, std::uint16_t port) {
    changes_.put({{device, port}, false});
}

void DiscoveryServer::stop() {
    if (!thread_.joinable()) return;
    changes_.close();
    ::eventfd_write(wake_.get(), 1);
    thread_.join();
}

void DiscoveryServer::run() {
    ::pthread_setname_np(::pthread_self(), "camrig-discover");
    while (!changes_.is_closed()) {
        pollfd ready[] = {{questions_.get(), POLLIN, 0}, {wake_.get(), POLLIN, 0}};
        if (::poll(ready, 2, -1) < 0 && errno != EINTR)
            return spdlog::error("{}", failed("devices are not found from now on").message);
        eventfd_t ignored = 0;
        ::eventfd_read(wake_.get(), &ignored);
        tell_changes();
        if (ready[0].revents & POLLIN) answer_question();
    }
    for (const Device& device : devices_) tell_gone(device);
}

void DiscoveryServer::tell_gone(const Device& device) {
    send(bye_message(next_head(), {.address = endpoint_address(device.name), .scopes = {}, .url = {}}),
         endpoint(group_address(), discovery_port));
}

void DiscoveryServer::tell_changes() {
    std::map<Device, bool> last;  // a device that came and went meanwhile was never there
    for (const Change& change : changes_.take_all()) last[change.device] = change.has_come;
    std::vector<Device> come;
    for (const auto& [device, has_come] : last) {
        const bool was_there = std::erase(devices_, device) > 0;
        if (has_come)
            come.push_back(device);
        else if (was_there)
            tell_gone(device);
    }
    if (come.empty()) return;
    devices_.insert(devices_.end(), come.begin(), come.end());
    const sockaddr_in everybody = endpoint(group_address(), discovery_port);
    for (const DiscoveredDevice& one : describe(come)) send(hello_message(next_head(), one), everybody);
}

void DiscoveryServer::answer_question() {
    std::array<char, max_discovery_bytes + 1> text;
    sockaddr_in from{};
    socklen_t size = sizeof from;
    const ssize_t got =
        ::recvfrom(questions_.get(), text.data(), text.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
    if (got <= 0 || from.sin_family != AF_INET) return;
    const in_addr_t mask = interface_.mask.s_addr;
    if ((from.sin_addr.s_addr & mask) != (interface_.address.s_addr & mask)) return;
    if (!may_send()) return;  // before anybody is asked
    const auto question = read_question({text.data(), static_cast<std::size_t>(got)});
    if (!question) return;
    for (const DiscoveredDevice& one : describe(devices_)) {
        if (!is_asked_for(one, *question)) continue;
        if (!may_send()) return;
        send(match_message(next_head(), *question, one), from);
    }
}

std::vector<DiscoveredDevice> DiscoveryServer::describe(const std::vector<Device>& devices) {
    using Cameras = Result<std::vector<engine::CameraReply>>;
    auto asked = std::make_shared<std::promise<Cameras>>();
    auto answer = asked->get_future();
    commands_.post(
        engine::Request<engine::ListCameras>{{}, [asked](Cameras made) { asked->set_value(std::move(made)); }});
    if (answer.wait_for(engine_time) != std::future_status::ready) return {};
    const Cameras cameras = answer.get();
    if (!cameras) return {};
    std::map<std::string, bool> have_heads;
    for (const engine::CameraReply& one : *cameras) {
        const bool has_head = one.camera.spec()->ptz.has_value();
        have_heads[one.camera.spec()->name] = has_head;
        have_heads[""] |= has_head;
    }
    std::vector<DiscoveredDevice> described;
    for (const Device& one : devices) {
        const auto found = have_heads.find(one.name);
        if (found == have_heads.end() && !one.name.empty()) continue;  // its camera has gone meanwhile
        const bool has_heads = found != have_heads.end() && found->second;
        described.push_back(
            {endpoint_address(one.name), scopes_of(one.name, has_heads),
             "http://" + text_of(interface_.address) + ":" + std::to_string(one.port) + "/onvif/device_service"});
    }
    return described;
}

DiscoveryHead DiscoveryServer::next_head() {
    return {new_id(), instance_, ++number_};
}

bool DiscoveryServer::may_send() {
    const TimeNs now_ns = monotonic_now_ns();
    allowance_ = std::min(max_burst, allowance_ + refill_per_s * static_cast<double>(now_ns - allowed_ns_) / ns_per_s);
    allowed_ns_ = now_ns;
    if (allowance_ < 1.0) return false;
    allowance_ -= 1.0;
    return true;
}

void DiscoveryServer::send(const std::string& text, const sockaddr_in& to) {
    // What the network does not take is lost, as datagrams may be: clients ask again.
    static_cast<void>(::sendto(answers_.get(), text.data(), text.size(), MSG_NOSIGNAL,
                               reinterpret_cast<const sockaddr*>(&to), sizeof to));
}

}  // namespace camrig::onvif

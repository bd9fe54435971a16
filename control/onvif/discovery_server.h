#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <netinet/in.h>
#include <sys/eventfd.h>

#include "control/onvif/discovery.h"
#include "core/base/bounded_queue.h"
#include "core/base/result.h"
#include "core/base/time.h"
#include "core/base/unique_fd.h"
#include "core/engine/command.h"

namespace camrig::onvif {

/// Lets clients of one network find the rig's devices: answers WS-Discovery on UDP 3702 of one interface, by IPv4, and
/// says Hello and Bye as devices come and go.
///
/// Only questions to the group 239.255.255.250, which routers do not pass on, and from the interface's own network are
/// answered, max_burst at once and refill_per_s then: nobody elsewhere can be flooded with our answers.
class DiscoveryServer {
public:
    static constexpr double max_burst = 256, refill_per_s = 64;  ///< datagrams
    static constexpr std::size_t max_changes = 65'536;           ///< that wait; more ports than there are

    /// `host` is where the devices' ports are listened on. invalid_argument: there is no such interface, it has no
    /// address of IPv4, or the ports cannot be reached on it; unavailable: UDP 3702 cannot be had.
    static Result<std::unique_ptr<DiscoveryServer>> create(const std::string& interface, const std::string& host,
                                                           engine::CommandPort& commands);
    ~DiscoveryServer();
    DiscoveryServer(const DiscoveryServer&) = delete;
    DiscoveryServer& operator=(const DiscoveryServer&) = delete;

    /// Of a camera, or with an empty name that of all. Any thread; neither waits.
    void add(const std::string& device, std::uint16_t port);
    void remove(const std::string& device, std::uint16_t port);
    /// Says Bye of all and ends the thread. Twice is fine. The commands outlive it.
    void stop();

private:
    struct Device {
        std::string name;
        std::uint16_t port = 0;
        friend auto operator<=>(const Device&, const Device&) = default;
    };
    struct Interface {
        in_addr address{}, mask{};
        int index = 0;
    };
    explicit DiscoveryServer(engine::CommandPort& commands) : commands_(commands) {}
    static Result<Interface> find_interface(const std::string& name, const std::string& host);
    Result<void> open(const Interface& found);

    struct Change {
        Device device;
        bool has_come = false;
    };

    void run();
    void tell_changes();
    void tell_gone(const Device& device);
    void answer_question();
    std::vector<DiscoveredDevice> describe(const std::vector<Device>& devices);
    DiscoveryHead next_head();
    void send(const std::string& text, const sockaddr_in& to);
    bool may_send();

    engine::CommandPort& commands_;
    Interface interface_;
    UniqueFd questions_, answers_, wake_;
    BoundedQueue<Change> changes_{max_changes, [this] { ::eventfd_write(wake_.get(), 1); }};
    std::thread thread_;
    // Of the thread.
    std::vector<Device> devices_;
    std::uint64_t instance_ = 0, number_ = 0;
    double allowance_ = max_burst;
    TimeNs allowed_ns_ = 0;
};

}  // namespace camrig::onvif

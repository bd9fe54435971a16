// Any messages from a hostile program: the rig answers or hangs up, and an honest program beside it is served.
#include <cstring>

#include <sys/socket.h>

#include "core/stream/local_frame_bus.h"
#include "v4l2_sink/preload/device_host.h"

namespace {

using namespace camrig;

/// One control of each kind.
class SomeControls final : public device::ControlPort {
public:
    std::vector<device::DeviceControl> list(std::string_view) override {
        using enum device::DeviceControl::Kind;
        return {{1, integer, "integer", -5, 5, 1, 0, 0, {}},
                {2, boolean, "boolean", 0, 1, 1, 0, 0, {}},
                {3, menu, "menu", 0, 1, 1, 0, 0, {"off", "on"}}};
    }
    Result<std::int32_t> get(std::string_view, std::uint32_t id) override {
        if (id < 1 || id > 3) return error(ErrorKind::not_found, "no such control");
        return 0;
    }
    void set(std::string_view, std::span<const device::DeviceControlValue> values,
             std::function<void(Result<void>)> done) override {
        for (const auto& [id, value] : values) CHECK(id >= 1 && id <= 3 && value >= -5 && value <= 5);
        done({});
    }
};

struct Peer {
    Peer() {
        int pair[2];
        CHECK(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair) == 0);
        theirs.reset(pair[0]);
        session = std::make_shared<device::DeviceSession>(UniqueFd(pair[1]));
    }
    void drain() const {
        alignas(cmsghdr) char control[256];
        char bytes[camrig_max_message];
        iovec part{bytes, sizeof bytes};
        for (;;) {
            msghdr header{};
            header.msg_iov = &part;
            header.msg_iovlen = 1;
            header.msg_control = control;
            header.msg_controllen = sizeof control;
            if (::recvmsg(theirs.get(), &header, MSG_DONTWAIT | MSG_CMSG_CLOEXEC) <= 0) return;
            for (cmsghdr* c = CMSG_FIRSTHDR(&header); c != nullptr; c = CMSG_NXTHDR(&header, c)) {
                int fds[8];
                const std::size_t count = (c->cmsg_len - CMSG_LEN(0)) / sizeof(int);
                std::memcpy(fds, CMSG_DATA(c), count * sizeof(int));
                for (std::size_t i = 0; i < count; ++i) ::close(fds[i]);
            }
        }
    }
    UniqueFd theirs;
    std::shared_ptr<device::DeviceSession> session;
};

camrig_request hello() {
    camrig_request request{};
    request.type = camrig_request_hello;
    request.u.hello.protocol = CAMRIG_DEVICE_PROTOCOL;
    request.u.hello.number = 10;
    return request;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static stream::LocalFrameBus* const bus = [] {
        auto* made = new stream::LocalFrameBus({1, std::make_shared<frame::FramePool>()});
        made->add_camera({CameraId{1}, "lobby", {64, 48}, Rate()});
        return made;
    }();
    const auto tasks = std::make_shared<device::TaskQueue>();
    device::DeviceHost host(*bus, std::make_shared<SomeControls>(), tasks);
    host.add_device(10, "lobby", codec::ChromaSampling::yuv422);
    Peer hostile, honest;
    const camrig_request first = hello();
    host.receive(honest.session, std::as_bytes(std::span(&first, 1)));
    // Half of the inputs get past the door.
    if (size > 0 && (data[0] & 1) != 0) host.receive(hostile.session, std::as_bytes(std::span(&first, 1)));

    // Each message: one byte of type, one of length, then bytes; the rest of a full-sized request is zero.
    for (std::size_t at = 1; at + 2 <= size && !hostile.session->dead;) {
        camrig_request request{};
        const std::size_t length = std::min<std::size_t>(data[at + 1], size - at - 2);
        std::memcpy(reinterpret_cast<char*>(&request) + 4, data + at + 2, std::min(length, sizeof request - 4));
        request.type = data[at] % 16;
        const std::size_t sent = data[at] >= 0xf0 ? length : sizeof request;  // now and then a wrong size
        host.receive(hostile.session, std::as_bytes(std::span(&request, 1)).first(std::min(sent, sizeof request)));
        tasks->run();
        hostile.drain();
        at += 2 + length;
    }
    camrig_request format{};
    format.type = camrig_request_get_format;
    host.receive(honest.session, std::as_bytes(std::span(&format, 1)));
    CHECK(!honest.session->dead);
    host.take_ended();
    if (!hostile.session->dead) host.leave(hostile.session);
    host.leave(honest.session);
    return 0;
}

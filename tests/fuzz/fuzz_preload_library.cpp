// Any answers and any ring from a hostile rig: the library returns errors and pictures, and never touches other memory
// of the program it lives in.
#include <algorithm>
#include <cstring>

#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include "core/base/result.h"
#include "v4l2_sink/preload/client/device.h"

namespace {

using namespace camrig::device;

constexpr std::uint32_t ring_room = 65536, slots = 6, slot_bytes = 512, slot_stride = 4096, first_slot_at = 4096;

/// What an honest rig says of a camera of 16x16.
camrig_description sound_description() {
    camrig_description d{};
    d.protocol = CAMRIG_DEVICE_PROTOCOL;
    std::strcpy(d.card, "lobby");
    std::strcpy(d.bus_info, "platform:camrig-10");
    d.format_count = d.size_count = d.rate_count = d.control_count = 1;
    d.fourcc[0] = V4L2_PIX_FMT_YUYV;
    d.width[0] = d.height[0] = 16;
    d.rate[0] = {25, 1};
    d.current = {d.fourcc[0], d.width[0], d.height[0], d.rate[0]};
    std::strcpy(d.control[0].name, "Brightness");
    d.control[0].id = V4L2_CID_BRIGHTNESS;
    d.control[0].type = V4L2_CTRL_TYPE_INTEGER;
    d.control[0].maximum = 255;
    d.control[0].step = 1;
    return d;
}

/// And how it shares its pictures.
camrig_ring_header sound_ring() {
    camrig_ring_header ring{};
    ring.protocol = CAMRIG_DEVICE_PROTOCOL;
    ring.slots = slots;
    ring.slot_bytes = slot_bytes;
    ring.slot_stride = slot_stride;
    ring.data_offset = first_slot_at;
    ring.published = slots;
    for (std::uint32_t n = 0; n < slots; ++n) ring.slot[n] = {2 * n + 2, n, n, slot_bytes, 0, 0};
    return ring;
}

/// The input says in which bits a hostile rig differs, so that it goes as deep whatever the protocol's number and
/// layout are.
template <typename T>
void change(T& value, const std::uint8_t* data, std::size_t size) {
    auto* const bytes = reinterpret_cast<std::uint8_t*>(&value);
    for (std::size_t i = 0; i < std::min(size, sizeof value); ++i) bytes[i] ^= data[i];
}

int sealed_memory(const camrig_ring_header& ring) {
    const int fd = ::memfd_create("fuzz", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    CHECK(fd >= 0 && ::ftruncate(fd, ring_room) == 0);
    CHECK(::pwrite(fd, &ring, sizeof ring, 0) == sizeof ring);
    ::fcntl(fd, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW);
    return fd;
}

void send_message(int socket, const void* message, std::size_t bytes, int fd) {
    iovec part{const_cast<void*>(message), bytes};
    alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))]{};
    msghdr header{};
    header.msg_iov = &part;
    header.msg_iovlen = 1;
    if (fd >= 0) {
        header.msg_control = control;
        header.msg_controllen = sizeof control;
        cmsghdr* rights = CMSG_FIRSTHDR(&header);
        rights->cmsg_level = SOL_SOCKET;
        rights->cmsg_type = SCM_RIGHTS;
        rights->cmsg_len = CMSG_LEN(sizeof(int));
        std::memcpy(CMSG_DATA(rights), &fd, sizeof(int));
    }
    ::sendmsg(socket, &header, MSG_DONTWAIT | MSG_NOSIGNAL);
}

template <typename T>
void call(Device& device, int fd, unsigned request, T argument) {
    device_ioctl(device, fd, request, &argument);
}

constexpr unsigned capture = V4L2_BUF_TYPE_VIDEO_CAPTURE;

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const bool is_honest = size == 0;  // libFuzzer begins with it
    camrig_description description = sound_description();
    const std::size_t of_description = std::min(size, sizeof description);
    change(description, data, of_description);
    data += of_description;
    size -= of_description;
    if (!description_is_sound(description)) {
        CHECK(!is_honest);
        return 0;
    }
    // Big pictures only cost the fuzzer time.
    for (std::uint32_t i = 0; i < description.size_count; ++i)
        if (description.width[i] > 256 || description.height[i] > 256) return 0;
    if (description.current.width > 256 || description.current.height > 256) return 0;

    Device* device = allocate();
    CHECK(device != nullptr);
    int control[2], events[2];
    CHECK(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, control) == 0);
    CHECK(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, events) == 0);
    device->control_fd = hide_fd(control[0], device);
    device->wake_fd = hide_fd(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC), device);
    device->page = static_cast<camrig_reader_page*>(
        ::mmap(nullptr, camrig_reader_page_bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
    change(*device->page, data, size);
    device->page->top_priority = 0;  // or nothing else happens
    device->description = description;
    device->format = description.current;

    // All answers are there before the questions: the rest of the input cut into replies, one of them with a ring.
    camrig_ring_header shared = sound_ring();
    change(shared, data, size);
    const int ring = sealed_memory(shared);
    std::size_t at = 0;
    for (std::uint32_t serial = 1; serial <= 24; ++serial) {
        camrig_reply reply{};
        reply.u.ring = {0, ring_room, slots, slot_bytes};
        const std::size_t length = std::min<std::size_t>(64, size - at);
        change(reply, data + at, length);
        at += length;
        reply.type = camrig_message_reply;
        reply.serial = serial;
        if (reply.status % 4 != 0) reply.status = 0;  // mostly yes
        send_message(control[1], &reply, sizeof reply, ring);
        if (serial % 8 == 0) {
            camrig_control_event event{camrig_message_control_event, length >= 4 ? *(data + at - 4) : 0u, 1, 0};
            send_message(control[1], &event, sizeof event, -1);
        }
    }
    ::shutdown(control[1], SHUT_WR);  // then the rig is gone
    for (int i = 0; i < 40; ++i) ::send(events[1], "t", 1, MSG_DONTWAIT | MSG_NOSIGNAL);

    const int fd = events[0];
    v4l2_format format{};
    format.type = capture;
    format.fmt.pix.width = size > 0 ? data[0] : 1;
    format.fmt.pix.height = 100;
    format.fmt.pix.pixelformat = description.fourcc[0];
    call(*device, fd, VIDIOC_S_FMT, format);
    call(*device, fd, VIDIOC_G_FMT, format);
    call(*device, fd, VIDIOC_G_CTRL, v4l2_control{description.control[0].id, 0});
    call(*device, fd, VIDIOC_S_CTRL, v4l2_control{description.control[0].id, 1});
    v4l2_queryctrl query{};
    for (query.id = V4L2_CTRL_FLAG_NEXT_CTRL; device_ioctl(*device, fd, VIDIOC_QUERYCTRL, &query) == 0;
         query.id |= V4L2_CTRL_FLAG_NEXT_CTRL) {
    }
    v4l2_querymenu menu{};
    menu.id = description.control[0].id;
    menu.index = 1;
    call(*device, fd, VIDIOC_QUERYMENU, menu);
    v4l2_event_subscription subscription{};
    subscription.type = V4L2_EVENT_CTRL;
    subscription.id = description.control[0].id;
    subscription.flags = V4L2_EVENT_SUB_FL_SEND_INITIAL;
    call(*device, fd, VIDIOC_SUBSCRIBE_EVENT, subscription);
    v4l2_requestbuffers request{};
    request.count = 4;
    request.type = capture;
    request.memory = V4L2_MEMORY_MMAP;
    call(*device, fd, VIDIOC_REQBUFS, request);
    v4l2_buffer buffer{};
    buffer.type = capture;
    buffer.memory = V4L2_MEMORY_MMAP;
    for (buffer.index = 0; buffer.index < 4; ++buffer.index) call(*device, fd, VIDIOC_QBUF, buffer);
    call(*device, fd, VIDIOC_STREAMON, capture);
    std::uint32_t pictures = 0;
    for (; pictures < slots; ++pictures) {
        buffer.index = 0;
        if (device_ioctl(*device, fd, VIDIOC_DQBUF, &buffer) != 0) break;
        CHECK(buffer.index < 4 && buffer.bytesused <= buffer.length);
        device_ioctl(*device, fd, VIDIOC_QBUF, &buffer);
    }
    CHECK(!is_honest || pictures == slots);
    v4l2_event event{};
    call(*device, fd, VIDIOC_DQEVENT, event);
    call(*device, fd, VIDIOC_STREAMOFF, capture);
    release(device);
    for (const int end : {control[1], events[0], events[1], ring}) ::close(end);
    return 0;
}

#include <fcntl.h>
#include <poll.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/un.h>

#include "v4l2_sink/preload/client/device.h"
#include "v4l2_sink/preload/client/paths.h"
#include "v4l2_sink/preload/client/sys.h"

namespace camrig::device {

namespace {

constexpr int fds_per_message = 2;

struct Message {
    union {
        uint32_t type;
        camrig_reply reply;
        camrig_control_event event;
    } u;
    size_t bytes = 0;
    int fds[fds_per_message] = {-1, -1};
};

void close_all(int* fds) {
    for (int i = 0; i < fds_per_message; ++i)
        if (fds[i] >= 0) sys_close(fds[i]);
}

/// 0 when a message came, EAGAIN, or ENODEV when the rig is gone.
int receive(int fd, Message& message) {
    iovec part{&message.u, sizeof message.u};
    alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int) * fds_per_message)];
    msghdr header{};
    header.msg_iov = &part;
    header.msg_iovlen = 1;
    header.msg_control = control;
    header.msg_controllen = sizeof control;
    long got;
    do got = raw_syscall(SYS_recvmsg, fd, arg(&header), MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
    while (got == -EINTR);
    if (got == -EAGAIN) return EAGAIN;
    if (got <= 0) return ENODEV;
    message.bytes = static_cast<size_t>(got);
    for (cmsghdr* c = CMSG_FIRSTHDR(&header); c != nullptr; c = CMSG_NXTHDR(&header, c)) {
        if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SCM_RIGHTS) continue;
        const size_t count = (c->cmsg_len - CMSG_LEN(0)) / sizeof(int);
        memcpy(message.fds, CMSG_DATA(c), (count < fds_per_message ? count : fds_per_message) * sizeof(int));
    }
    return 0;
}

int wait_readable(int fd, int timeout_ms) {
    pollfd wait{fd, POLLIN, 0};
    timespec limit{timeout_ms / 1000, (timeout_ms % 1000) * 1'000'000L};
    // The kernel writes the time left into `limit`, so an interrupted wait goes on with the rest.
    for (;;) {
        const long ready = raw_syscall(SYS_ppoll, arg(&wait), 1, arg(&limit));
        if (ready > 0) return 0;
        if (ready != -EINTR) return EIO;
    }
}

/// Handles what is not a reply. Call with control_lock held.
void take_event(Device& device, Message& message) {
    close_all(message.fds);
    if (message.bytes == sizeof(camrig_control_event) && message.u.type == camrig_message_control_event)
        push_control_event(device, message.u.event.id, message.u.event.value, V4L2_EVENT_CTRL_CH_VALUE,
                           message.u.event.flags);
}

bool is_text(const char* text, size_t room) {
    return memchr(text, 0, room) != nullptr;
}

int connect_to_rig() {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const char* path = socket_path();
    const size_t length = strlen(path);
    if (length == 0 || length >= sizeof address.sun_path) return -ENODEV;
    memcpy(address.sun_path, path, length + 1);
    const int fd = static_cast<int>(raw_syscall(SYS_socket, AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
    if (fd < 0) return fd;
    long result;
    do result = raw_syscall(SYS_connect, fd, arg(&address), sizeof address);
    while (result == -EINTR);
    if (failed(result)) {
        sys_close(fd);
        return result == -EACCES || result == -EPERM ? -EACCES : -ENODEV;
    }
    return fd;
}

void read_program_name(char* name, size_t room) {
    memset(name, 0, room);
    const long fd = raw_syscall(SYS_openat, AT_FDCWD, arg("/proc/self/comm"), O_RDONLY | O_CLOEXEC);
    if (failed(fd)) return;
    const long got = raw_syscall(SYS_read, fd, arg(name), static_cast<long>(room) - 1);
    sys_close(static_cast<int>(fd));
    if (got > 0 && name[got - 1] == '\n') name[got - 1] = 0;
}

/// Says hello; on success the device is ready and the program's descriptor is returned.
int introduce(Device& device, uint32_t number) {
    camrig_request request{};
    request.type = camrig_request_hello;
    request.u.hello.protocol = CAMRIG_DEVICE_PROTOCOL;
    request.u.hello.number = number;
    read_program_name(request.u.hello.program, sizeof request.u.hello.program);
    const uint64_t process = process_mark();
    request.u.hello.process[0] = static_cast<uint32_t>(process);
    request.u.hello.process[1] = static_cast<uint32_t>(process >> 32);
    camrig_reply reply;
    int fds[fds_per_message] = {-1, -1};
    if (const int problem = transact(device, request, reply, fds)) {
        close_all(fds);
        return -problem;
    }
    device.page = nullptr;
    // Sealed against shrinking, so that touching it can never raise SIGBUS.
    if (fds[1] >= 0 && (sys_fcntl(fds[1], F_GET_SEALS) & F_SEAL_SHRINK) != 0)
        device.page = static_cast<camrig_reader_page*>(
            sys_map(camrig_reader_page_bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fds[1]));
    if (fds[1] >= 0) sys_close(fds[1]);
    fds[1] = -1;
    if (device.page == nullptr || fds[0] < 0 || fds[0] >= max_fds || !description_is_sound(reply.u.description)) {
        close_all(fds);
        return -EPROTO;
    }
    device.number = number;
    device.description = reply.u.description;
    device.format = reply.u.description.current;
    return fds[0];
}

}  // namespace

bool description_is_sound(const camrig_description& d) {
    if (d.protocol != CAMRIG_DEVICE_PROTOCOL || !is_text(d.card, sizeof d.card) ||
        !is_text(d.bus_info, sizeof d.bus_info) || d.format_count == 0 || d.format_count > camrig_max_formats ||
        d.size_count == 0 || d.size_count > camrig_max_sizes || d.rate_count == 0 || d.rate_count > camrig_max_rates ||
        d.control_count > camrig_max_controls)
        return false;
    for (uint32_t i = 0; i < d.size_count; ++i)
        if (d.width[i] == 0 || d.width[i] > 8192 || d.height[i] == 0 || d.height[i] > 8192) return false;
    for (uint32_t i = 0; i < d.rate_count; ++i)
        if (d.rate[i].num == 0 || d.rate[i].den == 0) return false;
    // A number that V4L2's "next control" flags could be mistaken for would send an enumerating program round in
    // circles.
    constexpr uint32_t highest_id = 0x0fffffff;
    for (uint32_t i = 0; i < d.control_count; ++i)
        if (!is_text(d.control[i].name, sizeof d.control[i].name) || d.control[i].id == 0 ||
            d.control[i].id > highest_id)
            return false;
    return d.current.width > 0 && d.current.width <= 8192 && d.current.height > 0 && d.current.height <= 8192 &&
           d.current.rate.num > 0 && d.current.rate.den > 0;
}

int transact(Device& device, camrig_request& request, camrig_reply& reply, int* fds) {
    Locked guard(device.control_lock);
    if (device.broken) return ENODEV;
    request.serial = ++device.serial;
    long sent;
    do sent = raw_syscall(SYS_sendto, device.control_fd, arg(&request), sizeof request, MSG_NOSIGNAL);
    while (sent == -EINTR);
    if (failed(sent)) {
        device.broken = true;
        return ENODEV;
    }
    for (;;) {
        Message message;
        int problem = receive(device.control_fd, message);
        if (problem == EAGAIN) {
            problem = wait_readable(device.control_fd, reply_timeout_ms);
            if (problem == 0) continue;
        }
        if (problem != 0) {
            device.broken = true;
            return problem;
        }
        if (message.bytes != sizeof(camrig_reply) || message.u.reply.type != camrig_message_reply ||
            message.u.reply.serial != request.serial) {
            take_event(device, message);
            continue;
        }
        reply = message.u.reply;
        if (fds != nullptr)
            memcpy(fds, message.fds, sizeof message.fds);
        else
            close_all(message.fds);
        return reply.status >= 0 && reply.status < 4096 ? reply.status : EPROTO;
    }
}

void collect_events(Device& device) {
    Locked guard(device.control_lock);
    for (int i = 0; i < max_pending_events && !device.broken; ++i) {
        Message message;
        if (receive(device.control_fd, message) != 0) return;
        take_event(device, message);
    }
}

int events_fd(Device& device) {
    Locked guard(device.control_lock);
    return device.broken ? -1 : device.control_fd;
}

int open_device(uint32_t number, int flags) {
    const int control = connect_to_rig();
    if (control < 0) return control;
    Device* device = allocate();
    if (device == nullptr) {
        sys_close(control);
        return -EMFILE;
    }
    device->control_fd = hide_fd(control, device);
    device->wake_fd = hide_fd(static_cast<int>(raw_syscall(SYS_eventfd2, 0, EFD_CLOEXEC | EFD_NONBLOCK)), device);
    const int fd = device->wake_fd < 0 ? -EMFILE : introduce(*device, number);
    if (fd < 0) {
        release(device);
        return fd;
    }
    if ((flags & O_CLOEXEC) == 0) sys_fcntl(fd, F_SETFD, 0);
    if ((flags & O_NONBLOCK) != 0) sys_fcntl(fd, F_SETFL, O_NONBLOCK);
    bind_fd(fd, device);
    return fd;
}

}  // namespace camrig::device

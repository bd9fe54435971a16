
#include <cerrno>

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <string.h>
#include <sys/auxv.h>
#include <sys/mman.h>
#include <sys/socket.h>

#include "v4l2_sink/preload/client/device.h"
#include "v4l2_sink/preload/client/sys.h"

namespace camrig::device {

namespace {

constexpr uint32_t default_least_buffers = 2;
constexpr uint64_t max_buffer_memory = uint64_t{8} << 30;  // address space; memory is used as pictures arrive
constexpr uint32_t capture = V4L2_BUF_TYPE_VIDEO_CAPTURE;
constexpr uint32_t buffer_capabilities = V4L2_BUF_CAP_SUPPORTS_MMAP | V4L2_BUF_CAP_SUPPORTS_ORPHANED_BUFS;

int simple(Device& device, uint32_t type) {
    camrig_request request{};
    request.type = type;
    camrig_reply reply;
    return transact(device, request, reply, nullptr);
}

/// A fault of the camera lets this call fail.
bool fails(const Device& device, camrig_call call) {
    return (__atomic_load_n(&device.page->errors, __ATOMIC_ACQUIRE) >> call & 1u) != 0;
}

/// As after vb2_queue_error(): nothing more comes until STREAMOFF.
bool has_failed(Device& device) {
    if (device.streaming && fails(device, camrig_call_streaming)) device.failed = true;
    return device.failed;
}

void fill(const Device& device, uint32_t index, v4l2_buffer& out) {
    const Buffer& buffer = device.buffers[index];
    memset(&out, 0, sizeof out);
    out.index = index;
    out.type = capture;
    out.memory = V4L2_MEMORY_MMAP;
    out.m.offset = static_cast<uint32_t>(buffer.offset);
    out.length = buffer.length;
    out.field = V4L2_FIELD_NONE;
    out.flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE | buffer.flags;
    if (buffer.mapped) out.flags |= V4L2_BUF_FLAG_MAPPED;
    if (buffer.state == BufferState::queued) out.flags |= V4L2_BUF_FLAG_QUEUED;
    if (buffer.state == BufferState::prepared) out.flags |= V4L2_BUF_FLAG_PREPARED;
    out.bytesused = buffer.bytes_used;
    out.sequence = buffer.sequence;
    out.timestamp.tv_sec = static_cast<long>(buffer.monotonic_ns / 1'000'000'000u);
    out.timestamp.tv_usec = static_cast<long>(buffer.monotonic_ns % 1'000'000'000u / 1000u);
}

/// Whole pages that hold so many bytes: mmap() takes offsets of whole pages only, of 4, 16 or 64 KiB.
uint64_t in_pages(uint32_t length) {
    const uint64_t page_mask = getauxval(AT_PAGESZ) - 1;
    return (length + page_mask) & ~page_mask;
}

/// Adds up to `count` buffers of `length` bytes; how many were added.
uint32_t add_buffers(Device& device, uint32_t count, uint32_t length) {
    const uint64_t room = in_pages(length);
    if (device.buffer_fd < 0) {
        const long fd = raw_syscall(SYS_memfd_create, arg("camrig buffers"), MFD_CLOEXEC);
        if (failed(fd)) return 0;
        device.buffer_fd = hide_fd(static_cast<int>(fd), &device);
        device.buffer_end = 0;
    }
    uint32_t added = 0;
    for (; added < count && device.buffer_count < camrig_max_buffers; ++added) {
        // m.offset has 32 bits.
        if (device.buffer_end + room > max_buffer_memory || device.buffer_end > UINT32_MAX) break;
        if (failed(raw_syscall(SYS_ftruncate, device.buffer_fd, static_cast<long>(device.buffer_end + room)))) break;
        void* memory = sys_map(room, PROT_READ | PROT_WRITE, MAP_SHARED, device.buffer_fd, device.buffer_end);
        if (memory == nullptr) break;
        Buffer& buffer = device.buffers[device.buffer_count++];
        buffer = {};
        buffer.length = length;
        buffer.offset = device.buffer_end;
        buffer.memory = static_cast<uint8_t*>(memory);
        device.buffer_end += room;
    }
    return added;
}

void wake(Device& device) {
    if (device.waiters == 0) return;
    ++device.wakes;
    device.waking = device.waiters;
    const uint64_t one = 1;
    raw_syscall(SYS_write, device.wake_fd, arg(&one), sizeof one);
}

/// `wakes`: how many there were when the wait began. The last thread to be woken clears wake_fd: if the first did, the
/// others would sleep on; if none did, nobody could wait any more.
void end_wait(Device& device, uint32_t wakes) {
    --device.waiters;
    if (wakes == device.wakes || --device.waking > 0) return;
    uint64_t drained;
    raw_syscall(SYS_read, device.wake_fd, arg(&drained), sizeof drained);
}

void stop(Device& device, int fd) {
    if (device.streaming) {
        device.streaming = false;
        simple(device, camrig_request_stream_off);
        // The rig has answered, so no token follows: what is in the socket belongs to the past.
        char token;
        while (raw_syscall(SYS_recvfrom, fd, arg(&token), 1, MSG_DONTWAIT) > 0) {
        }
        drop_ring(device);
    }
    for (uint32_t i = 0; i < device.buffer_count; ++i) {
        Buffer& buffer = device.buffers[i];
        buffer.state = BufferState::dequeued;
        buffer.bytes_used = buffer.sequence = buffer.flags = 0;
        buffer.monotonic_ns = 0;
    }
    device.failed = false;
    device.queue_first = device.queue_count = 0;
    wake(device);
}

/// In lockstep the rig may wait for a buffer or for a picture to be taken.
void tell_if_wanted(Device& device) {
    // The rig sets wants_credit before it looks at `queued` a last time (lockstep), so one of us sees the other.
    if (device.streaming && __atomic_load_n(&device.page->wants_credit, __ATOMIC_SEQ_CST) != 0) {
        camrig_request request{};
        request.type = camrig_request_credit;
        Locked guard(device.control_lock);
        raw_syscall(SYS_sendto, device.control_fd, arg(&request), sizeof request, MSG_NOSIGNAL | MSG_DONTWAIT);
    }
}

void tell_credit(Device& device) {
    __atomic_store_n(&device.page->queued, ++device.queued, __ATOMIC_SEQ_CST);
    tell_if_wanted(device);
}

/// The buffer a call names, if it may be handed over by the program; null otherwise.
Buffer* handed_over(Device& device, const v4l2_buffer& requested) {
    if (requested.type != capture || requested.memory != V4L2_MEMORY_MMAP || requested.index >= device.buffer_count)
        return nullptr;
    return &device.buffers[requested.index];
}

enum class Taken { picture, nothing, gone };

Taken try_take(Device& device, int fd, uint32_t& index) {
    char token;
    const bool has_buffer = device.queue_count > 0;
    const long got = raw_syscall(SYS_recvfrom, fd, arg(&token), 1, MSG_DONTWAIT | (has_buffer ? 0 : MSG_PEEK));
    if (got == 0) return Taken::gone;
    if (failed(got)) return got == -EAGAIN || got == -EINTR ? Taken::nothing : Taken::gone;
    if (!has_buffer) return Taken::nothing;
    index = device.queue[device.queue_first];
    device.queue_first = (device.queue_first + 1) % camrig_max_buffers;
    --device.queue_count;
    Buffer& buffer = device.buffers[index];
    if (!take_picture(device, buffer)) {
        buffer.bytes_used = 0;
        buffer.flags = V4L2_BUF_FLAG_ERROR;
    }
    buffer.state = BufferState::dequeued;
    __atomic_store_n(&device.page->taken, ++device.taken, __ATOMIC_SEQ_CST);
    tell_if_wanted(device);
    return Taken::picture;
}

}  // namespace

void drop_buffers(Device& device) {
    for (uint32_t i = 0; i < device.buffer_count; ++i)
        sys_unmap(device.buffers[i].memory, in_pages(device.buffers[i].length));
    device.buffer_count = 0;
    device.buffer_end = 0;
    close_hidden(device.buffer_fd);  // the program's own mappings stay valid until it unmaps them
}

int request_buffers(Device& device, v4l2_requestbuffers& request) {
    const uint32_t count = request.count, type = request.type, memory = request.memory;
    request.capabilities = buffer_capabilities;
    request.flags = 0;
    memset(request.reserved, 0, sizeof request.reserved);
    if (type != capture || memory != V4L2_MEMORY_MMAP) return EINVAL;
    if (outranked(device)) return EBUSY;
    Locked guard(device.lock);
    if (device.streaming) return EBUSY;
    if (count > 0 && fails(device, camrig_call_reqbufs)) return EINVAL;
    const bool had_buffers = device.buffer_count > 0;
    if (!had_buffers && count > 0)
        if (const int problem = simple(device, camrig_request_acquire)) return problem;
    stop(device, -1);
    drop_buffers(device);
    if (count == 0) {
        request.count = 0;
        // An owner elsewhere makes this EBUSY, as in vb2.
        return simple(device, camrig_request_release);
    }
    const uint32_t wanted = count < default_least_buffers ? default_least_buffers
                            : count > camrig_max_buffers  ? static_cast<uint32_t>(camrig_max_buffers)
                                                          : count;
    if (const int problem = refresh_format(device)) return problem;
    const uint32_t bytes = image_bytes(device.format.fourcc, device.format.width, device.format.height);
    request.count = add_buffers(device, wanted, bytes);
    if (request.count > 0) return 0;
    simple(device, camrig_request_release);
    return ENOMEM;
}

int create_buffers(Device& device, v4l2_create_buffers& request) {
    request.capabilities = buffer_capabilities;
    request.flags = 0;
    memset(request.reserved, 0, sizeof request.reserved);
    if (outranked(device)) return EBUSY;
    Locked guard(device.lock);
    request.index = device.buffer_count;
    if (request.count == 0) return request.memory == V4L2_MEMORY_MMAP ? 0 : EINVAL;
    if (request.format.type != capture || request.memory != V4L2_MEMORY_MMAP) return EINVAL;
    if (const int problem = refresh_format(device)) return problem;
    const uint32_t least = image_bytes(device.format.fourcc, device.format.width, device.format.height);
    const uint32_t bytes = request.format.fmt.pix.sizeimage;
    if (bytes < least || bytes > (1u << 30)) return EINVAL;
    if (fails(device, camrig_call_reqbufs)) return EINVAL;
    if (device.buffer_count >= camrig_max_buffers) return ENOBUFS;
    const bool had_buffers = device.buffer_count > 0;
    if (!had_buffers)
        if (const int problem = simple(device, camrig_request_acquire)) return problem;
    request.count = add_buffers(device, request.count, bytes);
    if (request.count > 0) return 0;
    if (!had_buffers) simple(device, camrig_request_release);
    return ENOMEM;
}

int query_buffer(Device& device, v4l2_buffer& buffer) {
    Locked guard(device.lock);
    if (buffer.type != capture || buffer.index >= device.buffer_count) return EINVAL;
    fill(device, buffer.index, buffer);
    return 0;
}

int prepare_buffer(Device& device, v4l2_buffer& requested) {
    Locked guard(device.lock);
    Buffer* buffer = handed_over(device, requested);
    if (buffer == nullptr || buffer->state != BufferState::dequeued) return EINVAL;
    buffer->state = BufferState::prepared;
    fill(device, requested.index, requested);
    return 0;
}

int queue_buffer(Device& device, v4l2_buffer& requested) {
    Locked guard(device.lock);
    Buffer* buffer = handed_over(device, requested);
    if (buffer == nullptr || buffer->state == BufferState::queued) return EINVAL;
    if ((requested.flags & V4L2_BUF_FLAG_REQUEST_FD) != 0) return EBADR;
    if (has_failed(device)) return EIO;
    if (fails(device, camrig_call_qbuf)) return EINVAL;
    buffer->state = BufferState::queued;
    buffer->flags = 0;
    device.queue[(device.queue_first + device.queue_count++) % camrig_max_buffers] = requested.index;
    fill(device, requested.index, requested);
    tell_credit(device);
    if (device.queue_count == 1) wake(device);  // a DQBUF may wait without any buffer
    return 0;
}

int dequeue_buffer(Device& device, int fd, v4l2_buffer& out) {
    if (out.type != capture) return EINVAL;
    bool waited = false;
    uint32_t wakes = 0;
    for (;;) {
        pollfd wait[2]{};
        {
            Locked guard(device.lock);
            if (waited) end_wait(device, wakes);
            if (!device.streaming) return EINVAL;
            if (has_failed(device)) return EIO;
            uint32_t index = 0;
            switch (try_take(device, fd, index)) {
                case Taken::picture:
                    if (device.failed) return EIO;
                    fill(device, index, out);
                    return 0;
                case Taken::gone:
                    return ENODEV;
                case Taken::nothing:
                    break;
            }
            const int flags = sys_fcntl(fd, F_GETFL);
            if (flags < 0) return EBADF;
            if ((flags & O_NONBLOCK) != 0) return EAGAIN;
            ++device.waiters;
            wakes = device.wakes;
            waited = true;
            // Without a buffer only the rig's death is of interest on the socket.
            wait[0] = {fd, static_cast<short>(device.queue_count > 0 ? POLLIN : 0), 0};
            wait[1] = {device.wake_fd, POLLIN, 0};
        }
        if (raw_syscall(SYS_ppoll, arg(wait), 2) == -EINTR) {
            Locked guard(device.lock);
            end_wait(device, wakes);
            return EINTR;
        }
    }
}

int stream_on(Device& device, uint32_t type) {
    if (type != capture) return EINVAL;
    if (outranked(device)) return EBUSY;
    Locked guard(device.lock);
    if (device.streaming) return 0;
    if (device.buffer_count == 0) {
        // Somebody else may own the device: that is EBUSY rather than EINVAL.
        const int problem = simple(device, camrig_request_acquire);
        if (problem == 0) simple(device, camrig_request_release);
        return problem != 0 ? problem : EINVAL;
    }
    if (fails(device, camrig_call_streamon)) return EINVAL;
    device.taken = 0;
    device.queued = device.queue_count;
    __atomic_store_n(&device.page->taken, 0, __ATOMIC_RELAXED);
    __atomic_store_n(&device.page->queued, device.queued, __ATOMIC_RELEASE);
    camrig_request request{};
    request.type = camrig_request_stream_on;
    request.u.format = device.format;
    camrig_reply reply;
    int fds[2] = {-1, -1};
    int problem = transact(device, request, reply, fds);
    if (fds[1] >= 0) sys_close(fds[1]);
    if (problem != 0) {
        if (fds[0] >= 0) sys_close(fds[0]);
        return problem;
    }
    problem = attach_ring(device, fds[0], reply.u.ring);
    if (problem != 0) {
        simple(device, camrig_request_stream_off);
        return problem;
    }
    device.streaming = true;
    wake(device);
    return 0;
}

int stream_off(Device& device, int fd, uint32_t type) {
    if (type != capture) return EINVAL;
    if (outranked(device)) return EBUSY;
    Locked guard(device.lock);
    stop(device, fd);
    return 0;
}

int find_mapping(Device& device, size_t length, uint64_t offset) {
    Locked guard(device.lock);
    for (uint32_t i = 0; i < device.buffer_count; ++i) {
        Buffer& buffer = device.buffers[i];
        if (buffer.offset != offset) continue;
        if (length > in_pages(buffer.length)) return -EINVAL;
        buffer.mapped = true;
        return device.buffer_fd;
    }
    return -EINVAL;
}

}  // namespace camrig::device

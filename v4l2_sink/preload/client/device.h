#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include <linux/videodev2.h>
#include <pthread.h>

#include "v4l2_sink/preload/protocol.h"

// An open /dev/videoN inside a program: what the kernel would keep in a struct file and a vb2_queue.
//
// Everything here runs in somebody else's process: no exceptions, no C++ runtime, no threads of our own, no allocation
// in the frame path; whatever the rig sends is checked before use. Functions return 0 or an errno value.
namespace camrig::device {

inline constexpr int max_open_devices = 256;   // per process
inline constexpr int max_fds = 65536;          // higher descriptors are never ours
inline constexpr int internal_fd_floor = 512;  // ours hide up there, away from select() and "close 3..255" loops
inline constexpr int reply_timeout_ms = 5000;  // a rig that does not answer for so long is gone
inline constexpr int max_pending_events = 32;

enum class BufferState : uint8_t { dequeued, prepared, queued };

struct Buffer {
    BufferState state = BufferState::dequeued;
    bool mapped = false;
    uint32_t length = 0;  // bytes, as asked for; the memory is whole pages
    uint64_t offset = 0;  // in buffer_fd; also the offset the program gives to mmap()
    uint8_t* memory = nullptr;
    uint32_t bytes_used = 0;
    uint32_t sequence = 0;
    uint32_t flags = 0;  // V4L2_BUF_FLAG_ERROR
    uint64_t monotonic_ns = 0;
};

struct Subscription {
    uint32_t type = 0, id = 0, flags = 0;
};

struct Device {
    // Lifetime: one reference per descriptor and per call in progress. The memory is never freed, only used again.
    std::atomic<int> references{0};

    // Guards everything below but the control channel.
    pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

    // Control channel; control_lock is taken inside lock.
    pthread_mutex_t control_lock = PTHREAD_MUTEX_INITIALIZER;
    int control_fd = -1;
    uint32_t serial = 0;
    bool broken = false;
    v4l2_event events[max_pending_events];
    uint32_t event_first = 0, event_count = 0, event_sequence = 0;
    Subscription subscriptions[camrig_max_controls + 4];

    uint32_t number = 0;
    camrig_description description;
    camrig_format format;
    bool format_chosen = false;
    uint32_t priority = V4L2_PRIORITY_DEFAULT;

    int buffer_fd = -1;
    uint64_t buffer_end = 0;
    uint32_t buffer_count = 0;
    bool streaming = false;
    bool failed = false;  // while streaming: vb2's fatal error
    Buffer buffers[camrig_max_buffers];
    uint32_t queue[camrig_max_buffers];  // indices, oldest first
    uint32_t queue_first = 0, queue_count = 0;
    int wake_fd = -1;                             // wakes a blocked DQBUF
    uint32_t waiters = 0, waking = 0, wakes = 0;  // threads in DQBUF; those of them to be woken yet; how often

    camrig_reader_page* page = nullptr;
    const camrig_ring_header* ring = nullptr;
    uint64_t ring_bytes = 0;
    uint32_t ring_slots = 0, ring_slot_bytes = 0, ring_stride = 0;  // checked copies: the rig may change its own
    uint64_t ring_data = 0;
    uint64_t first = 0;
    uint64_t taken = 0;
    uint64_t queued = 0;
};

class Locked {
public:
    explicit Locked(pthread_mutex_t& mutex) : mutex_(mutex) { pthread_mutex_lock(&mutex_); }
    ~Locked() { pthread_mutex_unlock(&mutex_); }
    Locked(const Locked&) = delete;
    Locked& operator=(const Locked&) = delete;

private:
    pthread_mutex_t& mutex_;
};

// --- table of descriptors (table.cpp) ---

/// 0: not ours. Else a Device*, with the lowest bit set when the descriptor is one of the library's own.
extern std::atomic<uintptr_t> fd_table[max_fds];

inline bool is_ours(int fd) {
    return static_cast<unsigned>(fd) < static_cast<unsigned>(max_fds) &&
           fd_table[fd].load(std::memory_order_relaxed) != 0;
}
/// The device behind a program's descriptor, with a reference; null when it is not ours.
Device* acquire(int fd);
void release(Device* device);
/// A device slot with one reference; null when too many are open.
Device* allocate();
void bind_fd(int fd, Device* device);  // takes over one reference
/// Forgets a program's descriptor (it is about to be closed).
void unbind_fd(int fd);
/// Moves a descriptor of the library's own out of the program's way and protects it.
int hide_fd(int fd, Device* device);
void close_hidden(int& fd);
/// True when this descriptor is the library's own: the program must not close it.
bool is_hidden(int fd);
/// Makes room when the program dup2()s onto one of the library's own descriptors.
void relocate_hidden(int fd);
/// True in a vfork() child, which shares our memory but not our descriptors: nothing may be recorded there.
bool in_borrowed_memory();
/// What tells this program from all others: drawn at random at its start, anew after fork().
uint64_t process_mark();

/// Holds a reference for the length of a call.
class Ref {
public:
    explicit Ref(int fd) : device_(acquire(fd)) {}
    ~Ref() {
        if (device_ != nullptr) release(device_);
    }
    Ref(const Ref&) = delete;
    Ref& operator=(const Ref&) = delete;
    Device* get() const { return device_; }

private:
    Device* device_;
};

// --- connection (connection.cpp) ---

/// Opens device `number` as open() would; a descriptor or -errno.
int open_device(uint32_t number, int flags);
/// One request and its reply. `fds` receives up to two descriptors (-1 where none came). Any thread.
int transact(Device& device, camrig_request& request, camrig_reply& reply, int* fds);
/// Takes in control events that have arrived, without waiting.
void collect_events(Device& device);
/// What is readable when a control event has come; -1 when none will: nobody reads what comes on a broken channel.
int events_fd(Device& device);
bool description_is_sound(const camrig_description& description);

// --- formats (formats.cpp) ---

int query_capabilities(Device& device, v4l2_capability& capability);
int enum_format(Device& device, v4l2_fmtdesc& desc);
int enum_frame_size(Device& device, v4l2_frmsizeenum& size);
int enum_frame_interval(Device& device, v4l2_frmivalenum& interval);
int get_format(Device& device, v4l2_format& format);
int try_format(Device& device, v4l2_format& format);
int set_format(Device& device, v4l2_format& format);
int get_parm(Device& device, v4l2_streamparm& parm);
int set_parm(Device& device, v4l2_streamparm& parm);
int get_selection(Device& device, v4l2_selection& selection);
int crop_capabilities(Device& device, v4l2_cropcap& cropcap);
uint32_t image_bytes(uint32_t fourcc, uint32_t width, uint32_t height);
/// The rig knows the device's format, which another opener may have chosen; with buffers it is settled here. Call with
/// lock held.
int refresh_format(Device& device);
/// Another opener has a higher V4L2 priority: calls that change things are refused.
bool outranked(const Device& device);

// --- buffers (buffers.cpp) ---

int request_buffers(Device& device, v4l2_requestbuffers& request);
int create_buffers(Device& device, v4l2_create_buffers& request);
int query_buffer(Device& device, v4l2_buffer& buffer);
int prepare_buffer(Device& device, v4l2_buffer& buffer);
int queue_buffer(Device& device, v4l2_buffer& buffer);
int dequeue_buffer(Device& device, int fd, v4l2_buffer& buffer);
int stream_on(Device& device, uint32_t type);
int stream_off(Device& device, int fd, uint32_t type);
/// Where mmap() of this length and offset leads: a descriptor and the same offset, or -errno.
int find_mapping(Device& device, size_t length, uint64_t offset);
void drop_ring(Device& device);
void drop_buffers(Device& device);

// --- ring (ring.cpp) ---

/// Maps and checks the memory the rig sent; takes over `fd`.
int attach_ring(Device& device, int fd, const camrig_ring_place& place);
/// Copies the next picture into the buffer; false when none could be had whole.
bool take_picture(Device& device, Buffer& buffer);

// --- controls and events (controls.cpp) ---

int query_control(Device& device, v4l2_query_ext_ctrl& query);
int query_menu(Device& device, v4l2_querymenu& menu);
int get_control(Device& device, v4l2_control& control);
int set_control(Device& device, v4l2_control& control);
int ext_controls(Device& device, unsigned request, v4l2_ext_controls& controls);
int subscribe_event(Device& device, const v4l2_event_subscription& requested);
int unsubscribe_event(Device& device, const v4l2_event_subscription& requested);
int dequeue_event(Device& device, int fd, v4l2_event& event);
/// True when VIDIOC_DQEVENT has something: what poll() calls POLLPRI.
bool event_pending(Device& device);
/// For the connection: a control event from the rig. Call with control_lock held.
void push_control_event(Device& device, uint32_t id, int32_t value, uint32_t changes, uint32_t flags);

// --- dispatch (ioctl.cpp) ---

/// VIDIOC_* on one of our descriptors; 0 or an errno value, ENOTTY for what a camera does not have.
int device_ioctl(Device& device, int fd, unsigned request, void* argument);

}  // namespace camrig::device

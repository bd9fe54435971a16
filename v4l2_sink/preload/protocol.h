#pragma once

// What the rig and the library in a program say to each other. Plain data of fixed size, no pointers, native byte
// order (both ends are on one machine); used by C++ on the rig's side and by the library, which has no C++ runtime.
//
//   program -> library --control socket (SOCK_SEQPACKET, one request at a time)--> rig
//                      <--reply; control events in between; file descriptors as SCM_RIGHTS--
//   program's own fd = event socket: one byte ("token") per frame that can be dequeued; closed by the rig = unplugged
//   reader page (shared, one per open device): credits of the library, displacement count of the rig
//   ring (read-only for the library, one per camera, format, size and rate): the pictures
//
// Credits. The library counts buffers queued (Q) and frames taken (R), the rig frames appended since STREAM_ON (H),
// tokens sent (T) and frames displaced (D), and H = T + D + pending (pending is only ever > 0 in lockstep). A token is
// sent when T < Q (a buffer waits for it) and T - R < slots - slot_margin (its picture cannot be overwritten soon);
// otherwise the oldest picture not yet taken gives way to the new one: D rises. The next picture to take is number
// first + D + R. So the fd is readable while, and only while, a frame can be dequeued, and a program that slept gets
// the newest pictures, in order, with a gap in the sequence.

#include <stdint.h>

#define CAMRIG_DEVICE_PROTOCOL 5u

enum {
    camrig_max_formats = 8,
    camrig_max_sizes = 16,
    camrig_max_rates = 16,
    camrig_max_controls = 24,
    camrig_max_menu_items = 16,
    camrig_max_message = 4096,
    camrig_max_buffers = 32,  // VIDEO_MAX_FRAME
    camrig_min_slots = 6,     // of a ring
    camrig_max_slots = 40,    // camrig_max_buffers and room for the writer
    camrig_slot_margin = 2,   // slots that are never promised to a reader
    camrig_max_device_number = 255,
    camrig_reader_page_bytes = 4096,
};

enum camrig_request_type {
    camrig_request_hello = 1,
    camrig_request_get_format,  // of the device, for readers that have not chosen
    camrig_request_set_format,
    camrig_request_acquire,  // before the first buffers: of the openers of one program one owns them
    camrig_request_release,
    camrig_request_stream_on,
    camrig_request_stream_off,
    camrig_request_get_control,
    camrig_request_set_controls,  // all or none is checked by the rig
    camrig_request_menu,
    camrig_request_subscribe,  // control events
    camrig_request_priority,
    camrig_request_credit,  // no reply: a buffer was queued and the rig had asked to be told
};

enum camrig_message_type {
    camrig_message_reply = 100,
    camrig_message_control_event = 101,
};

// Calls that a fault of the camera lets fail (vivid's "Inject VIDIOC_REQBUFS Error" and the others beside it).
enum camrig_call {
    camrig_call_reqbufs = 0,  // EINVAL
    camrig_call_qbuf,         // EINVAL
    camrig_call_streamon,     // EINVAL
    camrig_call_streaming,    // VIDIOC_QBUF and VIDIOC_DQBUF: EIO, until VIDIOC_STREAMOFF
};

struct camrig_rate {
    uint32_t num, den;  // frames per second = num / den
};

struct camrig_format {
    uint32_t fourcc;
    uint32_t width, height;
    struct camrig_rate rate;
};

struct camrig_control_value {
    uint32_t id;
    int32_t value;
};

struct camrig_control {
    uint32_t id;
    uint32_t type;   // V4L2_CTRL_TYPE_INTEGER, BOOLEAN, MENU
    uint32_t flags;  // V4L2_CTRL_FLAG_*
    int32_t minimum, maximum, step, default_value;
    uint32_t menu_mask;  // menu: bit n set = value n exists (0..31)
    char name[32];
};

struct camrig_hello {
    uint32_t protocol;
    uint32_t number;   // N of /dev/videoN
    char program[32];  // for statistics and messages
    // Drawn at random by the program (two halves of 64 bits): its openers of a device share one queue. Process numbers
    // would not do, a program in another container has none here.
    uint32_t process[2];
};

struct camrig_controls_set {
    uint32_t count;
    struct camrig_control_value values[camrig_max_controls];
};

struct camrig_menu_query {
    uint32_t id, index;
};

struct camrig_subscribe {
    uint32_t id;
    uint32_t on;        // 1: tell me of changes by others, 0: no longer
    uint32_t feedback;  // 1: of my own too
};

struct camrig_request {
    uint32_t type;
    uint32_t serial;  // comes back in the reply
    union {
        struct camrig_hello hello;
        struct camrig_format format;  // set_format, stream_on
        uint32_t control_id;
        struct camrig_controls_set controls;
        struct camrig_menu_query menu;
        struct camrig_subscribe subscribe;
        uint32_t priority;
    } u;
};

struct camrig_description {
    uint32_t protocol;
    char card[32];
    char bus_info[32];
    uint32_t format_count, size_count, rate_count, control_count;
    uint32_t one_size_mask;  // bit n set: format n comes in the first size alone
    uint32_t pad_;
    uint32_t fourcc[camrig_max_formats];
    uint32_t width[camrig_max_sizes], height[camrig_max_sizes];
    struct camrig_rate rate[camrig_max_rates];
    struct camrig_format current;
    struct camrig_control control[camrig_max_controls];
};

struct camrig_ring_place {
    uint64_t first;       // number of the first picture this reader may take
    uint64_t ring_bytes;  // size of the memory that came along
    uint32_t slots;
    uint32_t slot_bytes;  // room for one picture
};

struct camrig_reply {
    uint32_t type;  // camrig_message_reply
    uint32_t serial;
    int32_t status;   // 0 or an errno value
    uint32_t detail;  // set_controls: index of the value that was refused
    union {
        struct camrig_description description;
        struct camrig_format format;
        struct camrig_ring_place ring;
        struct camrig_controls_set controls;
        char menu_name[32];
    } u;
};

struct camrig_control_event {
    uint32_t type;  // camrig_message_control_event
    uint32_t id;
    int32_t value;
    uint32_t flags;
};

// One open device. Each side writes its own half and only reads the other's. The rig created and sealed the memory.
struct camrig_reader_page {
    // written by the rig
    uint64_t displaced;     // D
    uint32_t wants_credit;  // lockstep: send camrig_request_credit after queuing a buffer
    uint32_t top_priority;  // highest V4L2 priority among the openers of this device
    uint32_t errors;        // a bit for each camrig_call that fails
    uint8_t pad_[108];
    // written by the library
    uint64_t queued;  // Q
    uint64_t taken;   // R
};

// Start of the ring's memory; the slots' pictures follow, each at data_offset + slot * slot_stride.
struct camrig_ring_slot {
    uint64_t version;  // 2 n + 1 while picture n is written, 2 n + 2 once it is complete
    uint64_t monotonic_ns;
    uint32_t sequence;
    uint32_t bytes;
    uint32_t flags;  // camrig_slot_...
    uint32_t pad_;
};
#define camrig_slot_error 1u   // the picture comes with V4L2_BUF_FLAG_ERROR
#define camrig_slot_failed 2u  // it does not come: from it on the stream has failed, as by camrig_call_streaming

struct camrig_ring_header {
    uint32_t protocol;
    uint32_t slots;
    uint32_t slot_bytes;
    uint32_t slot_stride;
    uint64_t data_offset;
    uint64_t published;  // pictures so far
    struct camrig_ring_slot slot[camrig_max_slots];
};

#ifdef __cplusplus
static_assert(sizeof(camrig_request) <= camrig_max_message);
static_assert(sizeof(camrig_reply) <= camrig_max_message);
static_assert(sizeof(camrig_reader_page) == 144);
static_assert(sizeof(camrig_ring_header) == 32 + 32 * camrig_max_slots);
// A 32-bit library talks to a 64-bit rig: no struct may depend on the alignment of uint64_t.
static_assert(sizeof(camrig_ring_place) == 24 && sizeof(camrig_reply) % 8 == 0);
#endif


#include <cerrno>

#include <errno.h>
#include <fcntl.h>
#include <sched.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include "v4l2_sink/preload/client/device.h"
#include "v4l2_sink/preload/client/sys.h"

namespace camrig::device {

namespace {

constexpr int max_attempts = 8;  // a copy fails only if the ring went round meanwhile; then a newer picture waits
constexpr uint64_t max_ring_bytes = uint64_t{4} << 30;

// The copy races with the writer by design (a seqlock): the version tells afterwards whether it was whole.
#if defined(__SANITIZE_THREAD__)
__attribute__((no_sanitize("thread"))) void copy_out(uint8_t* to, const uint8_t* from, size_t bytes) {
    const volatile uint8_t* source = from;
    for (size_t i = 0; i < bytes; ++i) to[i] = source[i];
}
#else
void copy_out(uint8_t* to, const uint8_t* from, size_t bytes) {
    memcpy(to, from, bytes);
}
#endif

}  // namespace

void drop_ring(Device& device) {
    sys_unmap(const_cast<camrig_ring_header*>(device.ring), device.ring_bytes);
    device.ring = nullptr;
    device.ring_bytes = 0;
}

int attach_ring(Device& device, int fd, const camrig_ring_place& place) {
    drop_ring(device);
    struct stat info;
    const bool sealed = fd >= 0 && (sys_fcntl(fd, F_GET_SEALS) & F_SEAL_SHRINK) != 0;
    const bool big_enough = sealed && !failed(raw_syscall(SYS_fstat, fd, arg(&info))) && info.st_size > 0 &&
                            place.ring_bytes >= sizeof(camrig_ring_header) && place.ring_bytes <= max_ring_bytes &&
                            static_cast<uint64_t>(info.st_size) >= place.ring_bytes;
    void* memory = big_enough ? sys_map(place.ring_bytes, PROT_READ, MAP_SHARED, fd) : nullptr;
    if (fd >= 0) sys_close(fd);
    if (memory == nullptr) return EPROTO;
    device.ring = static_cast<const camrig_ring_header*>(memory);
    device.ring_bytes = place.ring_bytes;

    // Copied once and checked, because the other side could change them later.
    device.ring_slots = device.ring->slots;
    device.ring_slot_bytes = device.ring->slot_bytes;
    device.ring_stride = device.ring->slot_stride;
    device.ring_data = device.ring->data_offset;
    device.first = place.first;
    const uint64_t end = device.ring_data + uint64_t{device.ring_stride} * device.ring_slots;
    if (device.ring->protocol != CAMRIG_DEVICE_PROTOCOL || device.ring_slots < camrig_min_slots ||
        device.ring_slots > camrig_max_slots || device.ring_stride < device.ring_slot_bytes ||
        device.ring_data < sizeof(camrig_ring_header) || device.ring_data > place.ring_bytes ||
        end > place.ring_bytes) {
        drop_ring(device);
        return EPROTO;
    }
    return 0;
}

bool take_picture(Device& device, Buffer& buffer) {
    for (int attempt = 0; attempt < max_attempts; ++attempt) {
        const uint64_t displaced = __atomic_load_n(&device.page->displaced, __ATOMIC_ACQUIRE);
        const uint64_t number = device.first + displaced + device.taken;
        const uint32_t index = static_cast<uint32_t>(number % device.ring_slots);
        const camrig_ring_slot& slot = device.ring->slot[index];
        const uint64_t version = __atomic_load_n(&slot.version, __ATOMIC_ACQUIRE);
        if (version != 2 * number + 2) {
            raw_syscall(SYS_sched_yield);
            continue;
        }
        const uint32_t bytes = slot.bytes, flags = slot.flags, sequence = slot.sequence;
        const uint64_t stamp = slot.monotonic_ns;
        if (bytes > device.ring_slot_bytes || bytes > buffer.length) break;
        copy_out(
            buffer.memory,
            reinterpret_cast<const uint8_t*>(device.ring) + device.ring_data + uint64_t{index} * device.ring_stride,
            bytes);
        __atomic_thread_fence(__ATOMIC_ACQUIRE);
        if (__atomic_load_n(&slot.version, __ATOMIC_RELAXED) != version) continue;
        buffer.bytes_used = bytes;
        buffer.sequence = sequence;
        buffer.monotonic_ns = stamp;
        buffer.flags = (flags & camrig_slot_error) != 0 ? V4L2_BUF_FLAG_ERROR : 0;
        if ((flags & camrig_slot_failed) != 0) device.failed = true;
        return true;
    }
    return false;
}

}  // namespace camrig::device

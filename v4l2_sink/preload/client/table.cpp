#include <initializer_list>

#include <fcntl.h>

#include "v4l2_sink/preload/client/device.h"
#include "v4l2_sink/preload/client/sys.h"

namespace camrig::device {

std::atomic<uintptr_t> fd_table[max_fds];

namespace {

Device devices[max_open_devices];
pthread_mutex_t table_lock = PTHREAD_MUTEX_INITIALIZER;
std::atomic<int> own_pid{0};
std::atomic<uint64_t> own_mark{0};

constexpr uintptr_t hidden_bit = 1;

// fork() copies our memory: no lock may be held by a thread that the child does not have.
bool locked_for_fork[max_open_devices];

void before_fork() {
    pthread_mutex_lock(&table_lock);
    for (int i = 0; i < max_open_devices; ++i) {
        locked_for_fork[i] = devices[i].references.load(std::memory_order_relaxed) > 0;
        if (!locked_for_fork[i]) continue;
        pthread_mutex_lock(&devices[i].lock);
        pthread_mutex_lock(&devices[i].control_lock);
    }
}
void unlock_all() {
    for (int i = 0; i < max_open_devices; ++i) {
        if (!locked_for_fork[i]) continue;
        pthread_mutex_unlock(&devices[i].control_lock);
        pthread_mutex_unlock(&devices[i].lock);
    }
    pthread_mutex_unlock(&table_lock);
}
void know_ourselves() {
    own_pid.store(sys_getpid(), std::memory_order_relaxed);
    uint64_t mark = 0;
    raw_syscall(SYS_getrandom, arg(&mark), sizeof mark, 0);
    own_mark.store(mark, std::memory_order_relaxed);
}
void after_fork_in_child() {
    know_ourselves();
    unlock_all();
}

__attribute__((constructor)) void start() {
    know_ourselves();
    pthread_atfork(before_fork, unlock_all, after_fork_in_child);
}

void destroy(Device& device) {
    drop_ring(device);
    drop_buffers(device);
    close_hidden(device.buffer_fd);
    close_hidden(device.wake_fd);
    close_hidden(device.control_fd);  // the rig sees the reader leave
    sys_unmap(device.page, camrig_reader_page_bytes);
    device.page = nullptr;
}

void reset(Device& device) {
    device.serial = 0;
    device.broken = false;
    device.failed = false;
    device.event_first = device.event_count = device.event_sequence = 0;
    for (Subscription& subscription : device.subscriptions) subscription = {};
    device.format_chosen = false;
    device.priority = V4L2_PRIORITY_DEFAULT;
    device.buffer_end = 0;
    device.buffer_count = 0;
    device.streaming = false;
    device.queue_first = device.queue_count = 0;
    device.waiters = device.waking = 0;
}

}  // namespace

bool in_borrowed_memory() {
    const int known = own_pid.load(std::memory_order_relaxed);
    return known != 0 && known != sys_getpid();
}

uint64_t process_mark() {
    return own_mark.load(std::memory_order_relaxed);
}

Device* acquire(int fd) {
    if (!is_ours(fd)) return nullptr;
    const uintptr_t entry = fd_table[fd].load(std::memory_order_acquire);
    if (entry == 0 || (entry & hidden_bit) != 0) return nullptr;
    auto* device = reinterpret_cast<Device*>(entry);
    int references = device->references.load(std::memory_order_relaxed);
    do {
        if (references <= 0) return nullptr;
    } while (!device->references.compare_exchange_weak(references, references + 1, std::memory_order_acq_rel));
    if (fd_table[fd].load(std::memory_order_acquire) == entry) return device;
    release(device);  // closed in between
    return nullptr;
}

void release(Device* device) {
    constexpr int dying = -1;  // nobody may take a reference any more, and the slot is not free yet
    int references = device->references.load(std::memory_order_relaxed);
    while (!device->references.compare_exchange_weak(references, references == 1 ? dying : references - 1,
                                                     std::memory_order_acq_rel)) {
    }
    if (references != 1) return;
    destroy(*device);
    device->references.store(0, std::memory_order_release);
}

Device* allocate() {
    Locked guard(table_lock);
    for (Device& device : devices) {
        int free = 0;
        if (device.references.compare_exchange_strong(free, 1, std::memory_order_acq_rel)) {
            reset(device);
            return &device;
        }
    }
    return nullptr;
}

void bind_fd(int fd, Device* device) {
    fd_table[fd].store(reinterpret_cast<uintptr_t>(device), std::memory_order_release);
}

void unbind_fd(int fd) {
    if (!is_ours(fd) || is_hidden(fd)) return;
    const uintptr_t entry = fd_table[fd].exchange(0, std::memory_order_acq_rel);
    if (entry != 0) release(reinterpret_cast<Device*>(entry));
}

bool is_hidden(int fd) {
    return is_ours(fd) && (fd_table[fd].load(std::memory_order_relaxed) & hidden_bit) != 0;
}

int hide_fd(int fd, Device* device) {
    if (fd < 0) return fd;
    const int high = sys_fcntl(fd, F_DUPFD_CLOEXEC, internal_fd_floor);
    if (high >= 0) {
        sys_close(fd);
        fd = high;
    }
    if (fd < max_fds) fd_table[fd].store(reinterpret_cast<uintptr_t>(device) | hidden_bit, std::memory_order_release);
    return fd;
}

void close_hidden(int& fd) {
    if (fd < 0) return;
    if (fd < max_fds) fd_table[fd].store(0, std::memory_order_release);
    sys_close(fd);
    fd = -1;
}

void relocate_hidden(int fd) {
    auto* device = reinterpret_cast<Device*>(fd_table[fd].load(std::memory_order_acquire) & ~hidden_bit);
    Locked guard(device->lock);
    Locked control(device->control_lock);
    for (int* own : {&device->control_fd, &device->wake_fd, &device->buffer_fd}) {
        if (*own != fd) continue;
        const int moved = sys_fcntl(fd, F_DUPFD_CLOEXEC, internal_fd_floor);
        if (moved < 0 || moved >= max_fds) return;
        fd_table[moved].store(reinterpret_cast<uintptr_t>(device) | hidden_bit, std::memory_order_release);
        fd_table[fd].store(0, std::memory_order_release);
        *own = moved;
    }
}

}  // namespace camrig::device

// POLLPRI. Frames need no help: a program's descriptor is a socket that is readable when a frame is. Control events
// come on the control socket, so waits that ask for exceptional conditions watch that one as well. epoll has no such
// help.

#include <poll.h>
#include <string.h>
#include <sys/select.h>
#include <time.h>

#include "v4l2_sink/preload/client/device.h"
#include "v4l2_sink/preload/client/hook.h"
#include "v4l2_sink/preload/client/sys.h"

HOOK(int, poll, (pollfd * fds, nfds_t count, int timeout_ms))
HOOK(int, ppoll, (pollfd * fds, nfds_t count, const timespec* timeout, const sigset_t* mask))
HOOK(int, __poll_chk, (pollfd * fds, nfds_t count, int timeout_ms, size_t room))
HOOK(int, __ppoll_chk, (pollfd * fds, nfds_t count, const timespec* timeout, const sigset_t* mask, size_t room))
HOOK(int, select, (int count, fd_set* in, fd_set* out, fd_set* other, timeval* timeout))
HOOK(int, pselect, (int count, fd_set* in, fd_set* out, fd_set* other, const timespec* timeout, const sigset_t* mask))

using namespace camrig::device;

namespace {

constexpr nfds_t max_watched = 256;  // longer lists are passed on as they are

int64_t now_ns() {
    timespec now;
    raw_syscall(SYS_clock_gettime, CLOCK_MONOTONIC, arg(&now));
    return int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

/// What is left of a time limit; a null limit stays null.
const timespec* left_of(const timespec* limit, int64_t start_ns, timespec& left) {
    if (limit == nullptr) return nullptr;
    int64_t ns = int64_t{limit->tv_sec} * 1'000'000'000 + limit->tv_nsec - (now_ns() - start_ns);
    if (ns < 0) ns = 0;
    left = {ns / 1'000'000'000, ns % 1'000'000'000};
    return &left;
}

bool asks_for_events(const pollfd* fds, nfds_t count) {
    for (nfds_t i = 0; i < count; ++i)
        if ((fds[i].events & POLLPRI) != 0 && is_ours(fds[i].fd)) return true;
    return false;
}

int poll_with_events(pollfd* fds, nfds_t count, const timespec* limit, const sigset_t* mask) {
    pollfd watched[2 * max_watched];
    const int64_t start = now_ns();
    for (;;) {
        nfds_t extra = 0;
        bool pending = false;
        memcpy(watched, fds, count * sizeof *fds);
        for (nfds_t i = 0; i < count; ++i) {
            if ((fds[i].events & POLLPRI) == 0) continue;
            const Ref device(fds[i].fd);
            if (device.get() == nullptr) continue;
            pending = pending || event_pending(*device.get());
            watched[count + extra++] = {events_fd(*device.get()), POLLIN, 0};
        }
        timespec left{};
        const timespec* wait = pending ? &left : left_of(limit, start, left);
        if (real::ppoll(watched, count + extra, wait, mask) < 0) return -1;
        int ready = 0;
        for (nfds_t i = 0; i < count; ++i) {
            fds[i].revents = watched[i].revents;
            if ((fds[i].events & POLLPRI) != 0) {
                const Ref device(fds[i].fd);
                // One that is gone counts as exceptional too, as in the kernel (v4l2_poll).
                const bool gone = (fds[i].revents & POLLHUP) != 0;
                if (device.get() != nullptr && (gone || event_pending(*device.get()))) fds[i].revents |= POLLPRI;
            }
            if (fds[i].revents != 0) ++ready;
        }
        // Nothing: what woke us was another thread's reply, or time is over.
        if (ready > 0 || (limit != nullptr && (left_of(limit, start, left)->tv_sec | left.tv_nsec) == 0)) return ready;
    }
}

bool asks_for_events(int count, const fd_set* other) {
    if (other == nullptr) return false;
    for (int fd = 0; fd < count && fd < FD_SETSIZE; ++fd)
        if (FD_ISSET(fd, other) && is_ours(fd)) return true;
    return false;
}

/// select() in terms of poll.
int select_with_events(int count, fd_set* in, fd_set* out, fd_set* other, const timespec* limit, const sigset_t* mask) {
    pollfd fds[max_watched];
    nfds_t used = 0;
    for (int fd = 0; fd < count && fd < FD_SETSIZE; ++fd) {
        short events = 0;
        if (in != nullptr && FD_ISSET(fd, in)) events |= POLLIN;
        if (out != nullptr && FD_ISSET(fd, out)) events |= POLLOUT;
        if (other != nullptr && FD_ISSET(fd, other)) events |= POLLPRI;
        if (events == 0) continue;
        if (used == max_watched) return fail(ENOMEM);
        fds[used++] = {fd, events, 0};
    }
    if (poll_with_events(fds, used, limit, mask) < 0) return -1;
    int ready = 0;
    for (nfds_t i = 0; i < used; ++i) {
        const int fd = fds[i].fd;
        const short got = fds[i].revents;
        if ((got & POLLNVAL) != 0) return fail(EBADF);
        const auto note = [&](fd_set* set, short wanted, short conditions) {
            if ((fds[i].events & wanted) == 0) return;
            if ((got & conditions) != 0)
                ++ready;
            else
                FD_CLR(fd, set);
        };
        note(in, POLLIN, POLLIN | POLLHUP | POLLERR);
        note(out, POLLOUT, POLLOUT | POLLERR);
        note(other, POLLPRI, POLLPRI);
    }
    return ready;
}

timespec from_ms(int ms) {
    return {ms / 1000, (ms % 1000) * 1'000'000L};
}

}  // namespace

int hook_poll(pollfd* fds, nfds_t count, int timeout_ms) {
    if (count > max_watched || !asks_for_events(fds, count)) return real::poll(fds, count, timeout_ms);
    const timespec limit = from_ms(timeout_ms);
    return poll_with_events(fds, count, timeout_ms < 0 ? nullptr : &limit, nullptr);
}
int hook_ppoll(pollfd* fds, nfds_t count, const timespec* timeout, const sigset_t* mask) {
    if (count > max_watched || !asks_for_events(fds, count)) return real::ppoll(fds, count, timeout, mask);
    return poll_with_events(fds, count, timeout, mask);
}
int hook___poll_chk(pollfd* fds, nfds_t count, int timeout_ms, size_t room) {
    if (count > max_watched || count * sizeof *fds > room || !asks_for_events(fds, count))
        return real::__poll_chk(fds, count, timeout_ms, room);
    return hook_poll(fds, count, timeout_ms);
}
int hook___ppoll_chk(pollfd* fds, nfds_t count, const timespec* timeout, const sigset_t* mask, size_t room) {
    if (count > max_watched || count * sizeof *fds > room || !asks_for_events(fds, count))
        return real::__ppoll_chk(fds, count, timeout, mask, room);
    return poll_with_events(fds, count, timeout, mask);
}
int hook_select(int count, fd_set* in, fd_set* out, fd_set* other, timeval* timeout) {
    if (!asks_for_events(count, other)) return real::select(count, in, out, other, timeout);
    timespec limit{};
    if (timeout != nullptr) limit = {timeout->tv_sec, timeout->tv_usec * 1000L};
    const int64_t start = now_ns();
    const int ready = select_with_events(count, in, out, other, timeout != nullptr ? &limit : nullptr, nullptr);
    if (timeout != nullptr) {  // Linux tells what was left
        timespec left{};
        left_of(&limit, start, left);
        *timeout = {left.tv_sec, left.tv_nsec / 1000};
    }
    return ready;
}
int hook_pselect(int count, fd_set* in, fd_set* out, fd_set* other, const timespec* timeout, const sigset_t* mask) {
    if (!asks_for_events(count, other)) return real::pselect(count, in, out, other, timeout, mask);
    return select_with_events(count, in, out, other, timeout, mask);
}

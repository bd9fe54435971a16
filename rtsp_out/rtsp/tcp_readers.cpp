#include "rtsp_out/rtsp/tcp_readers.h"

#include <iterator>
#include <utility>

namespace camrig::rtsp {

void TcpReaders::add(GSocket* socket) {
    remove(socket);
    std::lock_guard lock(mutex_);
    sockets_.emplace_back(socket);
}

void TcpReaders::remove(GSocket* socket) {
    std::lock_guard lock(mutex_);
    std::erase_if(sockets_, [socket](GObjectWeak& one) {
        const auto there = one.lock<GSocket>();
        return !there || there.get() == socket;
    });
}

TcpReaders::Takes TcpReaders::take() {
    std::lock_guard lock(mutex_);
    bool takes = false;
    for (auto reader = sockets_.begin(); reader != sockets_.end() && !takes;) {
        const auto socket = reader->lock<GSocket>();
        takes = socket && g_socket_condition_check(socket.get(), G_IO_OUT) != 0;
        reader = socket ? std::next(reader) : sockets_.erase(reader);
    }
    takes = takes || sockets_.empty();
    if (!takes) {
        has_missed_ = true;
        return Takes::no;
    }
    return std::exchange(has_missed_, false) ? Takes::yes_again : Takes::yes;
}

}  // namespace camrig::rtsp

#pragma once

#include <list>
#include <mutex>

#include <gio/gio.h>

#include "rtsp_out/rtsp/gst_handle.h"

namespace camrig::rtsp {

/// The connections over which clients read one stream by TCP. Any thread.
class TcpReaders {
public:
    enum class Takes { no, yes, yes_again };  ///< yes_again: the first yes after a no, so packets were left out

    /// One that is there already stays.
    void add(GSocket* socket);
    void remove(GSocket* socket);
    /// Whether any socket is writable. Yes where there is none.
    Takes take();

private:
    std::mutex mutex_;
    /// Weak: gst-rtsp-server closes a connection by letting go of it.
    std::list<GObjectWeak> sockets_;
    bool has_missed_ = false;  ///< packets were left out since the last that went on
};

}  // namespace camrig::rtsp

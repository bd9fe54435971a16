#pragma once

#include <deque>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gst/rtsp-server/rtsp-server.h>

#include "core/base/connection_counts.h"
#include "core/base/log_pace.h"
#include "core/base/thread_check.h"
#include "rtsp_out/rtsp/bounded_connection.h"
#include "rtsp_out/rtsp/failed_logins.h"
#include "rtsp_out/rtsp/gst_handle.h"
#include "rtsp_out/rtsp/mount_path.h"
#include "rtsp_out/rtsp/rtsp_options.h"

namespace camrig::rtsp {

/// The RTSP connections: who may come in, what each has asked for, how they are tuned, and how they end. A stranger is
/// a client that has not shown yet that it may read.
///
/// A client that cannot be served gets its status with a reason of our own ("415 RTP carries JPEG of ..."), which is
/// what programs show to their users. Server thread for every call but counts().
class ClientTable {
public:
    /// Why a path cannot be had by who asks from this address; no error when it can.
    using Refusal = std::function<Result<void>(const std::string& path, const std::string& address)>;

    ClientTable(const RtspLimits& limits, Refusal refusal) : limits_(limits), refusal_(std::move(refusal)) {}
    ~ClientTable();
    ClientTable(const ClientTable&) = delete;
    ClientTable& operator=(const ClientTable&) = delete;

    /// May a connection from here come in? A stranger may have to go for it (RtspLimits).
    bool make_room(const std::string& address);
    /// Lets the stranger go who has been there longest, if there is one.
    void shed();
    /// Has this address tried too many wrong tokens?
    bool must_wait(const std::string& address) const;
    /// A connection was taken in, on a guarded socket.
    void add(GstRTSPClient* client);
    /// Ends the connections of strangers who say nothing and of requests that do not come to their end: now and then.
    void close_idle(TimeNs monotonic_ns);
    /// Lets go of clients that have gone, a while after: now and then.
    ///
    /// Sending threads use a client without a reference to it, and ask our thread to close it when they cannot send
    /// (GStreamer 1.22 to 1.26, do_send_data in rtsp-client.c). That takes microseconds; only a thread that was
    /// interrupted in the middle is late.
    void let_go(TimeNs monotonic_ns);
    /// Those who have asked for this path or what lies under it.
    std::vector<GObjectHandle<GstRTSPClient>> clients_of(const std::string& path) const;
    std::vector<GObjectHandle<GstRTSPClient>> all() const;
    /// Any thread.
    ConnectionCounts counts() const { return counts_.read(); }

private:
    struct Client {
        ConnectionGuardRef guard;
        std::string address;
        TimeNs quiet_since_ns = 0;  ///< since its connection or its last good request
        std::uint64_t number = 0;   ///< in the order of their coming
        int wrong_tokens = 0;
        bool is_stranger = true;
        bool leaves = false;  ///< is being closed
        std::set<std::string> paths;
        std::string reason;       ///< for the answer being made
        bool is_sent_to = false;  ///< pictures over its connection
    };
    using Clients = std::map<GstRTSPClient*, Client>;

    struct Departed {
        GObjectHandle<GstRTSPClient> client;
        TimeNs since_ns = 0;
    };

    void tune(GSocket* socket) const;
    void close(GstRTSPClient* client, Client& record);
    void log(const std::string& address, const std::string& what);
    void read_answer(GstRTSPClient* client, Client& record, const GstRTSPContext& context, GstRTSPStatusCode status);
    GstRTSPStatusCode on_ask(GstRTSPClient* client, const GstRTSPContext* context);
    static void on_closed(GstRTSPClient* client, void* table);
    static void on_play(GstRTSPClient* client, GstRTSPContext* context, void* table);
    static void on_setup(GstRTSPClient* client, GstRTSPContext* context, void* table);
    static void on_answer(GstRTSPClient* client, GstRTSPContext* context, GstRTSPMessage* answer, void* table);

    const RtspLimits limits_;
    const Refusal refusal_;
    Clients clients_;
    FailedLogins failed_logins_;
    LogPace log_pace_;
    LiveConnectionCounts counts_;
    std::deque<Departed> departed_;
    std::uint64_t last_number_ = 0;
    ThreadCheck thread_;
};

/// Its connection ends with RST, and what waits to be sent is not (socket(7), SO_LINGER).
void break_when_closed(GstRTSPClient* client);

/// Closes a connection from the main loop, not from inside one of its callbacks.
void close_later(GMainContext* context, GstRTSPClient* client);

}  // namespace camrig::rtsp

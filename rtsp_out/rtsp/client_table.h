#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
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

class MediaFeed;

/// The RTSP connections: limits on their number, their socket options, the paths that each has requested, and closing
/// them. A stranger is a client that has not authenticated yet or, where no token is set, has set up no stream yet.
///
/// A client that cannot be served gets its status with a reason phrase of our own ("415 RTP carries JPEG of ..."),
/// which is what programs show to their users. Server thread for every call but counts().
class ClientTable {
public:
    /// Whether a client at this address may have this path; the error says why not.
    using Refusal = std::function<Result<void>(const std::string& path, const std::string& address)>;

    ClientTable(const RtspLimits& limits, Refusal refusal) : limits_(limits), refusal_(std::move(refusal)) {}
    ~ClientTable();
    ClientTable(const ClientTable&) = delete;
    ClientTable& operator=(const ClientTable&) = delete;

    /// Whether another connection from this address may be accepted. Closes the oldest stranger if that makes the room
    /// (RtspLimits).
    bool make_room(const std::string& address);
    /// Closes the oldest stranger, if there is one.
    void shed();
    /// Whether this address has sent too many wrong tokens (FailedLogins).
    bool must_wait(const std::string& address) const;
    /// Adds a client that was accepted, on a guarded socket (guard_socket).
    void add(GstRTSPClient* client);
    /// Closes strangers that have been silent, and clients whose request takes too long to arrive (RtspLimits). To be
    /// called at least once a second.
    void close_idle(TimeNs monotonic_ns);
    /// Releases the references to clients that were closed some time ago. To be called at least once a second.
    ///
    /// Why not at once: sending threads use a client without a reference to it, and ask our thread to close it when
    /// they cannot send (GStreamer 1.22 to 1.26, do_send_data in rtsp-client.c). That takes microseconds; only a thread
    /// that was interrupted in the middle is late.
    void let_go(TimeNs monotonic_ns);
    /// The clients that have requested this path or one below it.
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
        std::set<std::weak_ptr<MediaFeed>, std::owner_less<>> plays;
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
    static void on_rest(GstRTSPClient* client, GstRTSPContext* context, void* table);
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

/// When this client is closed, its connection ends with RST and unsent data is discarded (socket(7), SO_LINGER).
void break_when_closed(GstRTSPClient* client);

/// Closes a connection from the main loop, not from inside one of its callbacks.
void close_later(GMainContext* context, GstRTSPClient* client);

}  // namespace camrig::rtsp

#pragma once

#include <atomic>
#include <chrono>
#include <list>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "core/base/byte_budget.h"
#include "core/base/log_pace.h"
#include "core/base/wall_offset.h"
#include "core/stream/sink.h"
#include "rtsp_out/http/http_options.h"

namespace camrig::http {

class HttpConnection;

/// HttpCounts while the server runs; any thread.
struct LiveCounts {
    LiveConnectionCounts connections;
    std::atomic<std::uint64_t> requests{0}, errors{0}, streams_open{0}, first_parts{0}, repeated_parts{0}, stalled{0};

    HttpCounts read() const {
        return {connections.read(), requests, errors, streams_open, first_parts, repeated_parts, stalled};
    }
};

/// What all connections of one server share. Lives on the server's thread, but for the atomics.
struct ServerState {
    explicit ServerState(HttpOptions chosen) : options(std::move(chosen)) {}

    const HttpOptions options;
    LiveCounts counts;
    std::atomic<std::uint64_t> camera_changes{0};  ///< changes of any camera so far; streams check if it was theirs
    /// Fetches (pictures, truths) in progress. Shared, because a fetch may end after the server.
    std::shared_ptr<std::atomic<std::size_t>> fetches = std::make_shared<std::atomic<std::size_t>>(0);
    std::map<std::string, std::map<stream::MediaFormat, int>>
        streams_by_format;  ///< camera -> form of its JPEGs -> streams
    /// Bounds the bytes of pictures; one counts from before it is drawn until it is sent.
    const std::shared_ptr<ByteBudget> pictures = ByteBudget::create(
        options.limits.picture_bytes,
        "too many large pictures are being made or sent at once; read those that are due, try again");
    std::set<HttpConnection*> connections;  ///< open ones
    std::list<HttpConnection*> waiting;     ///< those whose next request has not arrived whole, longest wait first
    WallOffset wall;
    LogPace token_log, accept_log;
    bool stopping = false;
};

/// A fetch that counts against HttpLimits::fetches from begin() until `done` is called or forgotten.
class FetchTicket {
public:
    /// Null when the limit is reached.
    static std::shared_ptr<FetchTicket> begin(ServerState& state) {
        if (state.fetches->fetch_add(1) >= state.options.limits.fetches) {
            state.fetches->fetch_sub(1);
            return nullptr;
        }
        return std::shared_ptr<FetchTicket>(new FetchTicket(state.fetches));
    }
    ~FetchTicket() { count_->fetch_sub(1); }
    FetchTicket(const FetchTicket&) = delete;
    FetchTicket& operator=(const FetchTicket&) = delete;

private:
    explicit FetchTicket(std::shared_ptr<std::atomic<std::size_t>> count) : count_(std::move(count)) {}
    const std::shared_ptr<std::atomic<std::size_t>> count_;
};

}  // namespace camrig::http

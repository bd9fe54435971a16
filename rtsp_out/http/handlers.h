#pragma once

#include <memory>
#include <string>
#include <string_view>

#include <boost/asio/awaitable.hpp>

#include "rtsp_out/http/async_event.h"
#include "rtsp_out/http/reply.h"
#include "rtsp_out/http/route.h"
#include "rtsp_out/http/server_state.h"
#include "rtsp_out/http/target.h"

namespace camrig::http {

/// A request that was read, checked (access.h) and routed.
struct HttpRequest {
    std::string method;
    unsigned version = 11;
    bool keep_alive = false;
    bool embeds = false;  ///< made by a page of HttpOptions::embedders
    Target target;
    HttpRoute route;
    std::string if_none_match;
    std::string body;
    bool may_command = false;  ///< POST /rpc: may call methods that change something
    DeviceCall call;           ///< on the port of a network camera: all but its body
};

/// Answers everything but streams. Server's thread; waits on `event`; throws nothing.
boost::asio::awaitable<Reply> answer(ServerState& state, AsyncEventRef event, const HttpRequest& request);

}  // namespace camrig::http

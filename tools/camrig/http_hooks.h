#pragma once

#include "control/rpc/rpc_server.h"
#include "core/engine/engine.h"
#include "core/stream/worker_pool.h"
#include "rtsp_out/http/http_server.h"

namespace camrig::cli {

/// What the HTTP server asks of the rig. The engine's thread has no time for text, and the server's must not wait for
/// it.
http::HttpHooks http_hooks(control::RpcServer& rpc, control::Authority granted, engine::Engine& engine,
                           stream::WorkerPool& truth_text);

}  // namespace camrig::cli

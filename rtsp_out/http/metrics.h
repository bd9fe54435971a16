#pragma once

#include <string>

#include "core/stream/statistics.h"
#include "rtsp_out/http/http_options.h"

namespace camrig::http {

/// Prometheus text exposition format 0.0.4 of everything the rig counts. Pure.
std::string to_prometheus(const stream::RigReport& report, const HttpCounts& http);

}  // namespace camrig::http

#pragma once

#include <gst/rtsp-server/rtsp-server.h>

#include "core/base/result.h"
#include "rtsp_out/rtsp/gst_handle.h"
#include "rtsp_out/rtsp/rtsp_options.h"

namespace camrig {

/// Who may talk to the server: nobody is asked without a token; with one, every request of every method needs digest
/// authentication (RFC 2617) as user "camrig" with the token as password, and answers 401 without it. Null without a
/// token.
GObjectHandle<GstRTSPAuth> create_rtsp_auth(const RtspOptions& options);

/// What makes all connections TLS; null where none is given.
Result<GObjectHandle<GTlsCertificate>> load_rtsp_certificate(const RtspOptions& options);

/// Without a token only an address of this machine's loopback will do.
Result<void> check_rtsp_host(const RtspOptions& options);
bool is_loopback_address(const std::string& host);
/// "0.0.0.0" or "::".
bool is_any_address(const std::string& host);

}  // namespace camrig

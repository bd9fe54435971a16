#pragma once

#include <gst/rtsp-server/rtsp-server.h>

#include "core/base/result.h"
#include "rtsp_out/rtsp/gst_handle.h"
#include "rtsp_out/rtsp/rtsp_options.h"

namespace camrig::rtsp {

/// Authentication for the server: with a token, every request of every method needs digest authentication (RFC 2617)
/// as user "camrig" with the token as password, else it is answered with 401. Without a token null: no authentication.
GObjectHandle<GstRTSPAuth> create_rtsp_auth(const RtspOptions& options);

/// The server's TLS certificate with its key; null if the options name none. invalid_argument: it cannot be loaded.
Result<GObjectHandle<GTlsCertificate>> load_rtsp_certificate(const RtspOptions& options);

}  // namespace camrig::rtsp

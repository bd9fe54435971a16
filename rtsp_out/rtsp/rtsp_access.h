#pragma once

#include <gst/rtsp-server/rtsp-server.h>

#include "core/base/result.h"
#include "rtsp_out/rtsp/gst_handle.h"
#include "rtsp_out/rtsp/rtsp_options.h"

namespace camrig::rtsp {

/// Who may talk to the server: nobody is asked without a token; with one, every request of every method needs digest
/// authentication (RFC 2617) as user "camrig" with the token as password, and answers 401 without it. Null without a
/// token.
GObjectHandle<GstRTSPAuth> create_rtsp_auth(const RtspOptions& options);

/// What makes all connections TLS; null where none is given.
Result<GObjectHandle<GTlsCertificate>> load_rtsp_certificate(const RtspOptions& options);

}  // namespace camrig::rtsp

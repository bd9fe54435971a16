#include "rtsp_out/rtsp/rtsp_access.h"

#include <string_view>

namespace camrig::rtsp {
namespace {

constexpr const char* role = "reader";

/// gst-rtsp-server asks for credentials only where a stream is touched; this asks for every request.
struct RtspGate {
    GstRTSPAuth parent;
};
struct RtspGateClass {
    GstRTSPAuthClass parent;
};

G_DEFINE_TYPE(RtspGate, rtsp_gate, GST_TYPE_RTSP_AUTH)

void rtsp_gate_init(RtspGate*) {}

void refuse(GstRTSPAuth* auth, GstRTSPContext* context) {
    gst_rtsp_message_init_response(context->response, GST_RTSP_STS_UNAUTHORIZED,
                                   gst_rtsp_status_as_text(GST_RTSP_STS_UNAUTHORIZED), context->request);
    GST_RTSP_AUTH_GET_CLASS(auth)->generate_authenticate_header(auth, context);
    gst_rtsp_client_send_message(context->client, context->session, context->response);
}

gboolean gate_check(GstRTSPAuth* auth, GstRTSPContext* context, const gchar* what) {
    // Clients never choose where their packets go.
    if (std::string_view(what) == GST_RTSP_AUTH_CHECK_TRANSPORT_CLIENT_SETTINGS) return FALSE;
    if (!context->token) GST_RTSP_AUTH_GET_CLASS(auth)->authenticate(auth, context);
    if (context->token) return TRUE;
    refuse(auth, context);
    return FALSE;
}

void rtsp_gate_class_init(RtspGateClass* gate) {
    GST_RTSP_AUTH_CLASS(gate)->check = gate_check;
}

}  // namespace

Result<GObjectHandle<GTlsCertificate>> load_rtsp_certificate(const RtspOptions& options) {
    if (!options.key.empty() && options.certificate.empty())
        return error(ErrorKind::invalid_argument, "--rtsp-key: needs --rtsp-cert too");
    if (options.certificate.empty()) return GObjectHandle<GTlsCertificate>();
    const std::string key = options.key.empty() ? options.certificate.string() : options.key.string();
    GError* failed = nullptr;
    GTlsCertificate* certificate = g_tls_certificate_new_from_files(options.certificate.c_str(), key.c_str(), &failed);
    if (certificate) return GObjectHandle<GTlsCertificate>(certificate);
    const std::string why = failed->message;
    g_error_free(failed);
    return error(ErrorKind::invalid_argument, "--rtsp-cert " + options.certificate.string() + ", --rtsp-key " + key +
                                                  ": " + why + "; give a certificate and its key as PEM");
}

GObjectHandle<GstRTSPAuth> create_rtsp_auth(const RtspOptions& options) {
    if (options.token.empty()) return nullptr;
    GObjectHandle<GstRTSPAuth> auth(GST_RTSP_AUTH(g_object_new(rtsp_gate_get_type(), nullptr)));
    GstRTSPToken* token = gst_rtsp_token_new(GST_RTSP_TOKEN_MEDIA_FACTORY_ROLE, G_TYPE_STRING, role, nullptr);
    gst_rtsp_auth_set_supported_methods(auth.get(), GST_RTSP_AUTH_DIGEST);
    gst_rtsp_auth_add_digest(auth.get(), rtsp_user, options.token.c_str(), token);
    gst_rtsp_token_unref(token);
    return auth;
}

}  // namespace camrig::rtsp

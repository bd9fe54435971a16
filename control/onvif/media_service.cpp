#include <algorithm>
#include <cmath>

#include "control/onvif/operation.h"
#include "control/onvif/ptz_description.h"

// ONVIF Media (ver10): profiles, which put together a camera's source, one of its two streams and its head; and where
// streams and pictures are.
namespace camrig::onvif {
namespace {

using world::CameraSpec;

constexpr double default_bits_per_pixel = 0.15;  ///< as the RTSP server takes them

std::string range(std::string_view name, double low, double high) {
    const auto whole = [](double value) { return std::to_string(static_cast<long long>(value)); };
    return element(name, element("tt:Min", whole(low)) + element("tt:Max", whole(high)));
}

std::string size_element(std::string_view name, ImageSize size) {
    return element(name,
                   element("tt:Width", std::to_string(size.width)) + element("tt:Height", std::to_string(size.height)));
}

int frame_rate(const CameraSpec& spec) {
    return std::max(1, static_cast<int>(std::lround(spec.rate.hertz())));
}

std::string token_attribute(const std::string& token) {
    return "token=\"" + token + "\"";
}

std::string jpeg_token(const CameraSpec& spec) {
    return spec.name + std::string(jpeg_ending);
}

std::string source_configuration(const CameraSpec& spec, std::string_view tag) {
    return element(tag,
                   text_element("tt:Name", spec.name) + "<tt:UseCount>2</tt:UseCount>" +
                       text_element("tt:SourceToken", spec.name) +
                       element("tt:Bounds", "",
                               "x=\"0\" y=\"0\" width=\"" + std::to_string(spec.size.width) + "\" height=\"" +
                                   std::to_string(spec.size.height) + "\""),
                   token_attribute(spec.name));
}

/// The camera's output {kind: "rtsp"} of H.264; empty options: it has none, and so the defaults.
nlohmann::json h264_options(const CameraSpec& spec) {
    for (const OutputSpec& output : spec.outputs)
        if (output.kind == "rtsp" && output.options.value("codec", "h264") == "h264") return output.options;
    return nlohmann::json::object();
}

std::string encoder_configuration(const CameraSpec& spec, bool is_jpeg, std::string_view tag) {
    const nlohmann::json h264 = h264_options(spec);
    const double bits = default_bits_per_pixel * spec.size.width * spec.size.height * spec.rate.hertz();
    const int bitrate = h264.value("bitrate_kbps", std::max(1, static_cast<int>(bits / 1000)));
    const int gov = std::max(1, static_cast<int>(std::lround(h264.value("key_interval_s", 2.0) * spec.rate.hertz())));
    const std::string profile = h264.value("profile", "main");
    const std::string shown = profile == "high" ? "High" : profile == "baseline" ? "Baseline" : "Main";
    const std::string rate_control =
        element("tt:RateControl", element("tt:FrameRateLimit", std::to_string(frame_rate(spec))) +
                                      "<tt:EncodingInterval>1</tt:EncodingInterval>" +
                                      element("tt:BitrateLimit", std::to_string(bitrate)));
    const std::string of_h264 =
        element("tt:H264", element("tt:GovLength", std::to_string(gov)) + element("tt:H264Profile", shown));
    return element(tag,
                   text_element("tt:Name", is_jpeg ? jpeg_token(spec) : spec.name) + "<tt:UseCount>1</tt:UseCount>" +
                       element("tt:Encoding", is_jpeg ? "JPEG" : "H264") + size_element("tt:Resolution", spec.size) +
                       "<tt:Quality>1.000000</tt:Quality>" + rate_control + (is_jpeg ? "" : of_h264) +
                       "<tt:Multicast><tt:Address><tt:Type>IPv4</tt:Type><tt:IPv4Address>0.0.0.0</tt:IPv4Address>"
                       "</tt:Address><tt:Port>0</tt:Port><tt:TTL>0</tt:TTL><tt:AutoStart>false</tt:AutoStart>"
                       "</tt:Multicast><tt:SessionTimeout>PT60S</tt:SessionTimeout>",
                   token_attribute(is_jpeg ? jpeg_token(spec) : spec.name));
}

std::string profile(const CameraSpec& spec, bool is_jpeg, std::string_view tag) {
    const std::string token = is_jpeg ? jpeg_token(spec) : spec.name;
    std::string content = text_element("tt:Name", token) + source_configuration(spec, "tt:VideoSourceConfiguration") +
                          encoder_configuration(spec, is_jpeg, "tt:VideoEncoderConfiguration");
    if (spec.ptz) content += ptz_configuration(spec, "tt:PTZConfiguration");
    return element(tag, content, token_attribute(token) + " fixed=\"true\"");
}

/// Of all cameras, one after the other.
template <typename Make>
std::string of_all(const Asked& asked, Make make) {
    std::string all;
    for (const CameraSpecRef& spec : asked.cameras) all += make(*spec);
    return all;
}

bool names_jpeg(const Asked& asked, std::string_view child) {
    return asked.request.text(child).ends_with(jpeg_ending);
}

Answer get_profiles(const Asked& asked) {
    return response("trt:GetProfiles", of_all(asked, [](const CameraSpec& spec) {
                        return profile(spec, false, "trt:Profiles") + profile(spec, true, "trt:Profiles");
                    }));
}

Answer get_profile(const Asked& asked) {
    const auto camera = camera_of(asked, "ProfileToken", "NoProfile");
    if (!camera) return std::unexpected(camera.error());
    return response("trt:GetProfile", profile(**camera, names_jpeg(asked, "ProfileToken"), "trt:Profile"));
}

Answer get_video_sources(const Asked& asked) {
    return response("trt:GetVideoSources", of_all(asked, [](const CameraSpec& spec) {
                        return element("trt:VideoSources",
                                       element("tt:Framerate", number(spec.rate.hertz())) +
                                           size_element("tt:Resolution", spec.size),
                                       token_attribute(spec.name));
                    }));
}

Answer sources(const Asked& asked, std::string_view operation) {
    return response(operation, of_all(asked, [](const CameraSpec& spec) {
                        return source_configuration(spec, "trt:Configurations");
                    }));
}

Answer encoders(const Asked& asked, std::string_view operation) {
    return response(operation, of_all(asked, [](const CameraSpec& spec) {
                        return encoder_configuration(spec, false, "trt:Configurations") +
                               encoder_configuration(spec, true, "trt:Configurations");
                    }));
}

Answer get_source_configuration(const Asked& asked) {
    const auto camera = camera_of(asked, "ConfigurationToken", "NoConfig");
    if (!camera) return std::unexpected(camera.error());
    return response("trt:GetVideoSourceConfiguration", source_configuration(**camera, "trt:Configuration"));
}

Answer get_encoder_configuration(const Asked& asked) {
    const auto camera = camera_of(asked, "ConfigurationToken", "NoConfig");
    if (!camera) return std::unexpected(camera.error());
    return response("trt:GetVideoEncoderConfiguration",
                    encoder_configuration(**camera, names_jpeg(asked, "ConfigurationToken"), "trt:Configuration"));
}

/// The camera that a request for options names, by configuration or profile; else the first.
Answered<CameraSpecRef> camera_of_options(const Asked& asked) {
    for (const char* child : {"ConfigurationToken", "ProfileToken"})
        if (!asked.request.text(child).empty()) return camera_of(asked, child, "NoConfig");
    if (asked.cameras.empty()) return invalid_argument("NoConfig", "there is no camera");
    return asked.cameras.front();
}

/// What a camera's streams are is what they can be: their settings are the rig's to change.
Answer get_encoder_options(const Asked& asked) {
    const auto camera = camera_of_options(asked);
    if (!camera) return std::unexpected(camera.error());
    const CameraSpec& spec = **camera;
    const std::string rates = range("tt:FrameRateRange", 1, frame_rate(spec)) + range("tt:EncodingIntervalRange", 1, 1);
    const std::string sizes = size_element("tt:ResolutionsAvailable", spec.size);
    return response("trt:GetVideoEncoderConfigurationOptions",
                    element("trt:Options", range("tt:QualityRange", 1, 1) + element("tt:JPEG", sizes + rates) +
                                               element("tt:H264", sizes + range("tt:GovLengthRange", 1, 600) + rates +
                                                                      "<tt:H264ProfilesSupported>Main"
                                                                      "</tt:H264ProfilesSupported>")));
}

Answer get_source_options(const Asked& asked) {
    const auto camera = camera_of_options(asked);
    if (!camera) return std::unexpected(camera.error());
    const ImageSize size = (*camera)->size;
    return response(
        "trt:GetVideoSourceConfigurationOptions",
        element("trt:Options", element("tt:BoundsRange", range("tt:XRange", 0, 0) + range("tt:YRange", 0, 0) +
                                                             range("tt:WidthRange", size.width, size.width) +
                                                             range("tt:HeightRange", size.height, size.height)) +
                                   text_element("tt:VideoSourceTokensAvailable", (*camera)->name)));
}

Answer media_uri(std::string_view operation, const std::string& uri) {
    return response(operation, element("trt:MediaUri", text_element("tt:Uri", uri) +
                                                           "<tt:InvalidAfterConnect>false</tt:InvalidAfterConnect>"
                                                           "<tt:InvalidAfterReboot>false</tt:InvalidAfterReboot>"
                                                           "<tt:Timeout>PT0S</tt:Timeout>"));
}

std::string without_port(const std::string& host) {
    if (host.starts_with('[')) return host.substr(0, host.find(']') + 1);
    return host.substr(0, host.find(':'));
}

Answer get_stream_uri(const Asked& asked) {
    const auto camera = camera_of(asked, "ProfileToken", "NoProfile");
    if (!camera) return std::unexpected(camera.error());
    return media_uri("trt:GetStreamUri", asked.site.rtsp_scheme + "://" + without_port(asked.host) + ":" +
                                             std::to_string(asked.site.rtsp_port) + "/" + (*camera)->name +
                                             (names_jpeg(asked, "ProfileToken") ? "/mjpeg" : ""));
}

Answer get_snapshot_uri(const Asked& asked) {
    const auto camera = camera_of(asked, "ProfileToken", "NoProfile");
    if (!camera) return std::unexpected(camera.error());
    return media_uri("trt:GetSnapshotUri", "http://" + asked.host + "/cameras/" + (*camera)->name + "/snapshot.jpg");
}

Answer get_service_capabilities(const Asked& asked) {
    return response("trt:GetServiceCapabilities",
                    element("trt:Capabilities",
                            element("trt:ProfileCapabilities", "",
                                    "MaximumNumberOfProfiles=\"" + std::to_string(2 * asked.cameras.size()) + "\"") +
                                R"(<trt:StreamingCapabilities RTPMulticast="false" RTP_TCP="true")"
                                R"( RTP_RTSP_TCP="true"/>)",
                            R"(SnapshotUri="true" Rotation="false")"));
}

#define CAMRIG_EMPTY_ANSWER(NAME) {NAME, [](const Asked&) -> Answer { return response("trt:" NAME, ""); }}

const Operation operations[] = {
    {"GetServiceCapabilities", get_service_capabilities, Access::open},
    {"GetProfiles", get_profiles},
    {"GetProfile", get_profile},
    {"GetVideoSources", get_video_sources},
    {"GetVideoSourceConfigurations",
     [](const Asked& asked) { return sources(asked, "trt:GetVideoSourceConfigurations"); }},
    {"GetCompatibleVideoSourceConfigurations",
     [](const Asked& asked) { return sources(asked, "trt:GetCompatibleVideoSourceConfigurations"); }},
    {"GetVideoSourceConfiguration", get_source_configuration},
    {"GetVideoSourceConfigurationOptions", get_source_options},
    {"GetVideoEncoderConfigurations",
     [](const Asked& asked) { return encoders(asked, "trt:GetVideoEncoderConfigurations"); }},
    {"GetCompatibleVideoEncoderConfigurations",
     [](const Asked& asked) { return encoders(asked, "trt:GetCompatibleVideoEncoderConfigurations"); }},
    {"GetVideoEncoderConfiguration", get_encoder_configuration},
    {"GetVideoEncoderConfigurationOptions", get_encoder_options},
    {"GetGuaranteedNumberOfVideoEncoderInstances",
     [](const Asked&) -> Answer {
         return response("trt:GetGuaranteedNumberOfVideoEncoderInstances",
                         "<trt:TotalNumber>2</trt:TotalNumber><trt:JPEG>1</trt:JPEG><trt:H264>1</trt:H264>");
     }},
    {"GetStreamUri", get_stream_uri},
    {"GetSnapshotUri", get_snapshot_uri},
    // Clients that record sound and metadata ask for them: there are none.
    CAMRIG_EMPTY_ANSWER("GetAudioSources"),
    CAMRIG_EMPTY_ANSWER("GetAudioOutputs"),
    CAMRIG_EMPTY_ANSWER("GetAudioSourceConfigurations"),
    CAMRIG_EMPTY_ANSWER("GetAudioEncoderConfigurations"),
    CAMRIG_EMPTY_ANSWER("GetAudioOutputConfigurations"),
    CAMRIG_EMPTY_ANSWER("GetAudioDecoderConfigurations"),
    CAMRIG_EMPTY_ANSWER("GetMetadataConfigurations"),
    CAMRIG_EMPTY_ANSWER("GetVideoAnalyticsConfigurations"),
    CAMRIG_EMPTY_ANSWER("SetSynchronizationPoint"),
};

#undef CAMRIG_EMPTY_ANSWER

}  // namespace

Service media_service() {
    return {"http://www.onvif.org/ver10/media/wsdl", operations};
}

}  // namespace camrig::onvif

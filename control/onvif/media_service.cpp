#include <algorithm>
#include <cmath>

#include "control/onvif/media.h"
#include "control/onvif/ptz_description.h"

// ONVIF Media (ver10): profiles, which put together a camera's source, one of its streams and its head; and where
// streams and pictures are. It knows no H.265: an encoder of that codec is seen and set by Media2, and by this service
// is only set to another codec.
namespace camrig::onvif {
namespace {

using world::CameraSpec;

/// Whole frames a second, as this service tells them.
int frame_rate(const Rate& rate) {
    return std::max(1, static_cast<int>(std::lround(rate.hertz())));
}

/// The rate that clients mean by the number that this service tells for it; of other numbers themselves.
double rate_meant(const CameraSpec& camera, double told) {
    const auto rates = rates_for(camera);
    const auto distance = [told](const Rate& rate) { return std::abs(rate.hertz() - told); };
    const auto nearest = std::ranges::min_element(rates, {}, distance);
    return nearest != rates.end() && frame_rate(*nearest) == told ? nearest->hertz() : told;
}

bool is_known(const VideoStream& stream) {
    return stream.codec != "h265";
}

std::string encoder_configuration(const CameraSpec& camera, const VideoStream& stream, std::string_view tag) {
    const bool is_jpeg = stream.codec == "mjpeg";
    const std::string rate_control =
        element("tt:RateControl", element("tt:FrameRateLimit", std::to_string(frame_rate(stream.rate))) +
                                      "<tt:EncodingInterval>1</tt:EncodingInterval>" +
                                      element("tt:BitrateLimit", std::to_string(stream.bitrate_kbps)));
    const std::string of_h264 = element("tt:H264", element("tt:GovLength", std::to_string(gov_length(stream))) +
                                                       element("tt:H264Profile", profile_name(stream.profile)));
    const std::string token = token_of(camera, stream);
    return element(tag,
                   text_element("tt:Name", token) + "<tt:UseCount>1</tt:UseCount>" +
                       element("tt:Encoding", is_jpeg ? "JPEG" : "H264") + size_element("tt:Resolution", stream.size) +
                       element("tt:Quality", number(is_jpeg ? stream.quality : quality_range.high)) + rate_control +
                       (is_jpeg ? "" : of_h264) + std::string(no_multicast) +
                       "<tt:SessionTimeout>PT60S</tt:SessionTimeout>",
                   token_attribute(token));
}

std::string profile(const Asked& asked, const CameraSpec& camera, const VideoStream& stream, std::string_view tag) {
    const std::string token = token_of(camera, stream);
    std::string content =
        text_element("tt:Name", token) + source_configuration(asked, camera, "tt:VideoSourceConfiguration");
    if (is_known(stream)) content += encoder_configuration(camera, stream, "tt:VideoEncoderConfiguration");
    if (camera.ptz) content += ptz_configuration(camera, "tt:PTZConfiguration");
    return element(tag, content, token_attribute(token) + " fixed=\"true\"");
}

/// Of all cameras, one after the other.
template <typename Make>
std::string of_all(const Asked& asked, Make make) {
    std::string all;
    for (const CameraSpecRef& camera : asked.cameras) all += make(*camera);
    return all;
}

Answer get_profiles(const Asked& asked) {
    return response("trt:GetProfiles", of_all(asked, [&](const CameraSpec& camera) {
                        std::string all;
                        for (const VideoStream& stream : streams_of(asked, camera))
                            all += profile(asked, camera, stream, "trt:Profiles");
                        return all;
                    }));
}

Answer get_profile(const Asked& asked) {
    const auto chosen = chosen_by(asked, asked.request.text("ProfileToken"), "NoProfile");
    if (!chosen) return std::unexpected(chosen.error());
    return response("trt:GetProfile", profile(asked, *chosen->camera, chosen->stream, "trt:Profile"));
}

Answer get_video_sources(const Asked& asked) {
    return response("trt:GetVideoSources", of_all(asked, [](const CameraSpec& camera) {
                        return element("trt:VideoSources",
                                       element("tt:Framerate", number(camera.rate.hertz())) +
                                           size_element("tt:Resolution", camera.size),
                                       token_attribute(camera.name));
                    }));
}

Answer sources(const Asked& asked, std::string_view operation) {
    return response(operation, of_all(asked, [&](const CameraSpec& camera) {
                        return source_configuration(asked, camera, "trt:Configurations");
                    }));
}

Answer encoders(const Asked& asked, std::string_view operation) {
    return response(operation, of_all(asked, [&](const CameraSpec& camera) {
                        std::string all;
                        for (const VideoStream& stream : streams_of(asked, camera))
                            if (is_known(stream)) all += encoder_configuration(camera, stream, "trt:Configurations");
                        return all;
                    }));
}

Answer get_source_configuration(const Asked& asked) {
    const auto camera = camera_of(asked, "ConfigurationToken", "NoConfig");
    if (!camera) return std::unexpected(camera.error());
    return response("trt:GetVideoSourceConfiguration", source_configuration(asked, **camera, "trt:Configuration"));
}

Answer get_encoder_configuration(const Asked& asked) {
    const auto chosen = chosen_by(asked, asked.request.text("ConfigurationToken"), "NoConfig");
    if (!chosen) return std::unexpected(chosen.error());
    if (!is_known(chosen->stream)) return invalid_argument("NoConfig", "it is of H.265, which is told by Media2");
    return response("trt:GetVideoEncoderConfiguration",
                    encoder_configuration(*chosen->camera, chosen->stream, "trt:Configuration"));
}

/// What a request for options names, by configuration or profile; else the first of all.
Answered<Chosen> chosen_for_options(const Asked& asked) {
    for (const auto& [child, detail] : {std::pair{"ConfigurationToken", "NoConfig"}, {"ProfileToken", "NoProfile"}})
        if (const auto token = asked.request.text(child); !token.empty()) return chosen_by(asked, token, detail);
    for (const CameraSpecRef& camera : asked.cameras)
        for (VideoStream& stream : streams_of(asked, *camera)) return Chosen{camera, std::move(stream)};
    return invalid_argument("NoConfig", "there is no camera");
}

/// What the stream can be made to be with one codec.
std::string options_with(const Chosen& chosen, const std::string& codec, std::string_view tag) {
    const CameraSpec& camera = *chosen.camera;
    std::string sizes;
    for (const ImageSize size : sizes_for(camera, chosen.stream, codec))
        sizes += size_element("tt:ResolutionsAvailable", size);
    const std::string rates = whole_range("tt:FrameRateRange", {1, frame_rate(camera.rate)}) +
                              whole_range("tt:EncodingIntervalRange", {1, 1});
    if (codec == "mjpeg") return element(tag, sizes + rates);
    std::string profiles;
    for (const char* name : {"Baseline", "Main", "High"}) profiles += element("tt:H264ProfilesSupported", name);
    return element(tag, sizes + whole_range("tt:GovLengthRange", gov_range(chosen.stream.rate)) + rates + profiles);
}

Answer get_encoder_options(const Asked& asked) {
    const auto chosen = chosen_for_options(asked);
    if (!chosen) return std::unexpected(chosen.error());
    const auto codecs = codecs_for(*chosen->camera, chosen->stream, false);
    std::string all = whole_range("tt:QualityRange", quality_range);
    for (const auto& [codec, tag] : {std::pair{"mjpeg", "tt:JPEG"}, {"h264", "tt:H264"}})  // the schema's order
        if (std::ranges::find(codecs, codec) != codecs.end()) all += options_with(*chosen, codec, tag);
    return response("trt:GetVideoEncoderConfigurationOptions", element("trt:Options", all));
}

Answered<engine::SetCamera> set_encoder_configuration(const Asked& asked) {
    const XmlElement wanted = asked.request.child("Configuration");
    const auto chosen = chosen_by(asked, wanted.attribute("token").value_or(""), "NoConfig");
    if (!chosen) return std::unexpected(chosen.error());
    auto wish = wish_in(wanted, frame_rate(chosen->stream.rate));
    if (!wish) return std::unexpected(wish.error());
    if (wish->frame_rate && *wish->frame_rate != wish->told_rate)
        wish->frame_rate = rate_meant(*chosen->camera, *wish->frame_rate);
    const std::string_view encoding = wanted.text("Encoding");
    if (encoding != "H264" && encoding != "JPEG") return invalid_argument("ConfigModify", "Encoding is H264 or JPEG");
    wish->codec = encoding == "H264" ? "h264" : "mjpeg";
    const XmlElement h264 = wanted.child("H264");
    const auto gov = number_in(h264.text("GovLength")),
               interval = number_in(wanted.child("RateControl").text("EncodingInterval"));
    for (const auto* one : {&gov, &interval})
        if (!*one) return std::unexpected(one->error());
    if (interval->value_or(1) != 1) return invalid_argument("ConfigModify", "EncodingInterval is 1");
    wish->gov_length = *gov;
    if (const std::string_view name = h264.text("H264Profile"); !name.empty()) {
        auto known = h264_profile_of(name);
        if (!known) return std::unexpected(known.error());
        wish->profile = std::move(*known);
    }
    return change_to(asked, *chosen, *wish);
}

Answer get_source_options(const Asked& asked) {
    const auto chosen = chosen_for_options(asked);
    if (!chosen) return std::unexpected(chosen.error());
    return response("trt:GetVideoSourceConfigurationOptions", source_options(*chosen->camera, "trt:Options"));
}

/// Where something of the profile that the request names is.
Answer media_uri(const Asked& asked, std::string_view operation,
                 std::string (*uri_of)(const Asked& asked, const Chosen& chosen)) {
    const auto chosen = chosen_by(asked, asked.request.text("ProfileToken"), "NoProfile");
    if (!chosen) return std::unexpected(chosen.error());
    return response(operation, element("trt:MediaUri", text_element("tt:Uri", uri_of(asked, *chosen)) +
                                                           "<tt:InvalidAfterConnect>false</tt:InvalidAfterConnect>"
                                                           "<tt:InvalidAfterReboot>false</tt:InvalidAfterReboot>"
                                                           "<tt:Timeout>PT0S</tt:Timeout>"));
}

Answer get_service_capabilities(const Asked& asked) {
    return response("trt:GetServiceCapabilities",
                    element("trt:Capabilities",
                            element("trt:ProfileCapabilities", "",
                                    "MaximumNumberOfProfiles=\"" +
                                        std::to_string(std::size(stream_endings) * asked.cameras.size()) + "\"") +
                                R"(<trt:StreamingCapabilities RTPMulticast="false" RTP_TCP="true")"
                                R"( RTP_RTSP_TCP="true"/>)",
                            R"(SnapshotUri="true" Rotation="false")"));
}

#define CAMRIG_EMPTY_ANSWER(NAME) {NAME, [](const Asked&) -> Answer { return response("trt:" NAME, ""); }}

const Operation operations[] = {
    {"GetServiceCapabilities", get_service_capabilities, Access::pre_auth},
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
    {.name = "SetVideoEncoderConfiguration",
     .answer = [](const Asked&) -> Answer { return response("trt:SetVideoEncoderConfiguration", ""); },
     .access = Access::actuate,
     .change = set_encoder_configuration},
    {"GetGuaranteedNumberOfVideoEncoderInstances",
     [](const Asked&) -> Answer {
         return response("trt:GetGuaranteedNumberOfVideoEncoderInstances",
                         "<trt:TotalNumber>3</trt:TotalNumber><trt:JPEG>2</trt:JPEG><trt:H264>2</trt:H264>");
     }},
    {"GetStreamUri", [](const Asked& asked) { return media_uri(asked, "trt:GetStreamUri", stream_uri); }},
    {"GetSnapshotUri", [](const Asked& asked) { return media_uri(asked, "trt:GetSnapshotUri", snapshot_uri); }},
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

#include <algorithm>
#include <iterator>

#include "control/onvif/media.h"
#include "control/onvif/ptz_description.h"

// ONVIF Media2 (ver20): the same profiles as Media, with all codecs.
namespace camrig::onvif {
namespace {

using world::CameraSpec;

constexpr std::pair<std::string_view, std::string_view> encodings[] = {
    {"h264", "H264"}, {"h265", "H265"}, {"mjpeg", "JPEG"}};

std::string_view encoding_of(std::string_view codec) {
    const auto known = std::ranges::find(encodings, codec, &std::pair<std::string_view, std::string_view>::first);
    return known == std::end(encodings) ? codec : known->second;
}

std::string encoder_configuration(const CameraSpec& camera, const VideoStream& stream, std::string_view tag) {
    const bool is_jpeg = stream.codec == "mjpeg";
    const std::string token = token_of(camera, stream);
    std::string attributes = token_attribute(token);
    if (!is_jpeg)
        attributes += " GovLength=\"" + std::to_string(gov_length(stream)) + "\" Profile=\"" +
                      (stream.codec == "h264" ? profile_name(stream.profile) : "Main") + "\"";
    return element(tag,
                   text_element("tt:Name", token) + "<tt:UseCount>1</tt:UseCount>" +
                       element("tt:Encoding", encoding_of(stream.codec)) + size_element("tt:Resolution", stream.size) +
                       element("tt:RateControl", element("tt:FrameRateLimit", number(stream.rate.hertz())) +
                                                     element("tt:BitrateLimit", std::to_string(stream.bitrate_kbps))) +
                       std::string(no_multicast) +
                       element("tt:Quality", number(is_jpeg ? stream.quality : quality_range.high)),
                   attributes);
}

/// Which configurations a request for profiles wants to see with them.
bool wants(const Asked& asked, std::string_view type) {
    return asked.request.has_child_of_text("Type", type) || asked.request.has_child_of_text("Type", "All");
}

std::string profile(const Asked& asked, const CameraSpec& camera, const VideoStream& stream) {
    const std::string token = token_of(camera, stream);
    std::string parts;
    if (wants(asked, "VideoSource")) parts += source_configuration(asked, camera, "tr2:VideoSource");
    if (wants(asked, "VideoEncoder")) parts += encoder_configuration(camera, stream, "tr2:VideoEncoder");
    if (camera.ptz && wants(asked, "PTZ")) parts += ptz_configuration(camera, "tr2:PTZ");
    return element("tr2:Profiles",
                   text_element("tr2:Name", token) + (parts.empty() ? "" : element("tr2:Configurations", parts)),
                   token_attribute(token) + " fixed=\"true\"");
}

/// Those that a request means: one by its child of that name, else all.
Answered<std::vector<Chosen>> all_chosen(const Asked& asked, std::string_view child, std::string_view detail) {
    std::vector<Chosen> all;
    if (const std::string_view token = asked.request.text(child); !token.empty()) {
        auto one = chosen_by(asked, token, detail);
        if (!one) return std::unexpected(one.error());
        all.push_back(std::move(*one));
        return all;
    }
    for (const CameraSpecRef& camera : asked.cameras)
        for (VideoStream& stream : streams_of(asked, *camera)) all.push_back({camera, std::move(stream)});
    return all;
}

Answer get_profiles(const Asked& asked) {
    const auto chosen = all_chosen(asked, "Token", "NoProfile");
    if (!chosen) return std::unexpected(chosen.error());
    std::string all;
    for (const auto& [camera, stream] : *chosen) all += profile(asked, *camera, stream);
    return response("tr2:GetProfiles", all);
}

/// By configuration, by profile, or all (tr2:GetConfiguration). The source's configuration bears its camera's name.
Answered<std::vector<Chosen>> configured(const Asked& asked) {
    if (!asked.request.text("ConfigurationToken").empty()) return all_chosen(asked, "ConfigurationToken", "NoConfig");
    return all_chosen(asked, "ProfileToken", "NoProfile");
}

Answer get_encoder_configurations(const Asked& asked) {
    const auto chosen = configured(asked);
    if (!chosen) return std::unexpected(chosen.error());
    std::string all;
    for (const auto& [camera, stream] : *chosen) all += encoder_configuration(*camera, stream, "tr2:Configurations");
    return response("tr2:GetVideoEncoderConfigurations", all);
}

Answer get_source_configurations(const Asked& asked) {
    const auto chosen = configured(asked);
    if (!chosen) return std::unexpected(chosen.error());
    std::string all;
    const CameraSpec* last = nullptr;  // a camera's streams stand together and share its source
    for (const auto& [camera, stream] : *chosen) {
        if (camera.get() != last) all += source_configuration(asked, *camera, "tr2:Configurations");
        last = camera.get();
    }
    return response("tr2:GetVideoSourceConfigurations", all);
}

Answered<Chosen> first_configured(const Asked& asked) {
    auto chosen = configured(asked);
    if (!chosen) return std::unexpected(chosen.error());
    if (chosen->empty()) return invalid_argument("NoConfig", "there is no camera");
    return std::move(chosen->front());
}

Answer get_source_options(const Asked& asked) {
    const auto chosen = first_configured(asked);
    if (!chosen) return std::unexpected(chosen.error());
    return response("tr2:GetVideoSourceConfigurationOptions", source_options(*chosen->camera, "tr2:Options"));
}

/// What the stream can be made to be with one codec.
std::string options_with(const Chosen& chosen, const std::string& codec) {
    const auto& [camera, stream] = chosen;
    std::string sizes, rates;
    for (const ImageSize size : sizes_for(*camera, stream, codec))
        sizes += size_element("tt:ResolutionsAvailable", size);
    for (const Rate& rate : rates_for(*camera)) rates += (rates.empty() ? "" : " ") + number(rate.hertz());
    std::string attributes = "FrameRatesSupported=\"" + rates + "\"";
    if (codec != "mjpeg") {
        const IntRange gov = gov_range(stream.rate);
        attributes = "GovLengthRange=\"" + std::to_string(gov.low) + " " + std::to_string(gov.high) + "\" " +
                     attributes + " ProfilesSupported=\"" + (codec == "h264" ? "Baseline Main High" : "Main") + "\"";
    }
    return element("tr2:Options",
                   element("tt:Encoding", encoding_of(codec)) + whole_range("tt:QualityRange", quality_range) + sizes +
                       whole_range("tt:BitrateRange", bitrate_range_kbps),
                   attributes);
}

Answer get_encoder_options(const Asked& asked) {
    const auto chosen = first_configured(asked);
    if (!chosen) return std::unexpected(chosen.error());
    std::string all;
    for (const std::string& codec : codecs_for(*chosen->camera, chosen->stream, asked.site.has_h265))
        all += options_with(*chosen, codec);
    return response("tr2:GetVideoEncoderConfigurationOptions", all);
}

Answered<engine::SetCamera> set_encoder_configuration(const Asked& asked) {
    const XmlElement wanted = asked.request.child("Configuration");
    const auto chosen = chosen_by(asked, wanted.attribute("token").value_or(""), "NoConfig");
    if (!chosen) return std::unexpected(chosen.error());
    auto wish = wish_in(wanted, chosen->stream.rate.hertz());
    if (!wish) return std::unexpected(wish.error());
    const auto encoding =
        std::ranges::find(encodings, wanted.text("Encoding"), &std::pair<std::string_view, std::string_view>::second);
    if (encoding == std::end(encodings)) return invalid_argument("ConfigModify", "Encoding is H264, H265 or JPEG");
    wish->codec = std::string(encoding->first);
    const auto gov = number_in(wanted.attribute("GovLength").value_or(""));
    if (!gov) return std::unexpected(gov.error());
    wish->gov_length = *gov;
    if (const auto name = wanted.attribute("Profile"); name && !name->empty()) {
        if (encoding->first == "h265" && *name != "Main")
            return invalid_argument("ConfigModify", "the profile of H.265 is Main");
        auto known = h264_profile_of(*name);
        if (!known) return std::unexpected(known.error());
        wish->profile = std::move(*known);
    }
    return change_to(asked, *chosen, *wish);
}

Answer get_encoder_instances(const Asked& asked) {
    const auto camera = camera_of(asked, "ConfigurationToken", "NoConfig");
    if (!camera) return std::unexpected(camera.error());
    const auto one = [](std::string_view encoding, int number) {
        return element("tr2:Codec", element("tr2:Encoding", encoding) + element("tr2:Number", std::to_string(number)));
    };
    return response("tr2:GetVideoEncoderInstances",
                    element("tr2:Info", one("JPEG", 2) + one("H264", 2) + (asked.site.has_h265 ? one("H265", 2) : "") +
                                            "<tr2:Total>3</tr2:Total>"));
}

Answer uri(const Asked& asked, std::string_view operation, std::string (*uri_of)(const Asked&, const Chosen&)) {
    const auto chosen = chosen_by(asked, asked.request.text("ProfileToken"), "NoProfile");
    if (!chosen) return std::unexpected(chosen.error());
    return response(operation, text_element("tr2:Uri", uri_of(asked, *chosen)));
}

Answer get_stream_uri(const Asked& asked) {
    const std::string_view protocol = asked.request.text("Protocol");
    if (!protocol.empty() && protocol != "RTSP" && protocol != "RtspUnicast")
        return invalid_argument("InvalidStreamSetup", "Protocol is RTSP or RtspUnicast");
    return uri(asked, "tr2:GetStreamUri", stream_uri);
}

Answer get_service_capabilities(const Asked& asked) {
    return response("tr2:GetServiceCapabilities",
                    element("tr2:Capabilities",
                            element("tr2:ProfileCapabilities", "",
                                    "MaximumNumberOfProfiles=\"" +
                                        std::to_string(std::size(stream_endings) * asked.cameras.size()) +
                                        R"(" ConfigurationsSupported="VideoSource VideoEncoder)" +
                                        (asked.has_heads() ? " PTZ" : "") + "\"") +
                                R"(<tr2:StreamingCapabilities RTSPStreaming="true" RTPMulticast="false")"
                                R"( RTP_RTSP_TCP="true"/>)",
                            R"(SnapshotUri="true" Rotation="false")"));
}

#define CAMRIG_EMPTY_ANSWER(NAME) {NAME, [](const Asked&) -> Answer { return response("tr2:" NAME, ""); }}

const Operation operations[] = {
    {"GetServiceCapabilities", get_service_capabilities, Access::pre_auth},
    {"GetProfiles", get_profiles},
    {"GetVideoSourceConfigurations", get_source_configurations},
    {"GetVideoSourceConfigurationOptions", get_source_options},
    {"GetVideoEncoderConfigurations", get_encoder_configurations},
    {"GetVideoEncoderConfigurationOptions", get_encoder_options},
    {.name = "SetVideoEncoderConfiguration",
     .answer = [](const Asked&) -> Answer { return response("tr2:SetVideoEncoderConfiguration", ""); },
     .access = Access::actuate,
     .change = set_encoder_configuration},
    {"GetVideoEncoderInstances", get_encoder_instances},
    {"GetStreamUri", get_stream_uri},
    {"GetSnapshotUri", [](const Asked& asked) { return uri(asked, "tr2:GetSnapshotUri", snapshot_uri); }},
    // Clients that record sound and metadata ask for them: there are none.
    CAMRIG_EMPTY_ANSWER("GetAudioSourceConfigurations"),
    CAMRIG_EMPTY_ANSWER("GetAudioEncoderConfigurations"),
    CAMRIG_EMPTY_ANSWER("GetAudioOutputConfigurations"),
    CAMRIG_EMPTY_ANSWER("GetAudioDecoderConfigurations"),
    CAMRIG_EMPTY_ANSWER("GetMetadataConfigurations"),
    CAMRIG_EMPTY_ANSWER("GetAnalyticsConfigurations"),
};

#undef CAMRIG_EMPTY_ANSWER

}  // namespace

Service media2_service() {
    return {"http://www.onvif.org/ver20/media/wsdl", operations};
}

}  // namespace camrig::onvif

#include "control/onvif/media.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/base/output_family.h"

namespace camrig::onvif {

using world::CameraSpec;

const std::string_view no_multicast =
    "<tt:Multicast><tt:Address><tt:Type>IPv4</tt:Type><tt:IPv4Address>0.0.0.0</tt:IPv4Address></tt:Address>"
    "<tt:Port>0</tt:Port><tt:TTL>0</tt:TTL><tt:AutoStart>false</tt:AutoStart></tt:Multicast>";

Answered<Chosen> chosen_by(const Asked& asked, std::string_view token, std::string_view detail) {
    for (const CameraSpecRef& camera : asked.cameras)
        for (VideoStream& stream : streams_of(asked, *camera))
            if (token_of(*camera, stream) == token) return Chosen{camera, std::move(stream)};
    return invalid_argument(detail, "there is no profile or configuration of that token");
}

std::vector<VideoStream> streams_of(const Asked& asked, const CameraSpec& camera) {
    return asked.site.streams ? asked.site.streams(camera) : std::vector<VideoStream>{};
}

std::string whole_range(std::string_view name, IntRange range) {
    return element(name, element("tt:Min", std::to_string(range.low)) + element("tt:Max", std::to_string(range.high)));
}

std::string size_element(std::string_view name, ImageSize size) {
    return element(name,
                   element("tt:Width", std::to_string(size.width)) + element("tt:Height", std::to_string(size.height)));
}

std::string token_attribute(const std::string& token) {
    return "token=\"" + token + "\"";
}

std::string profile_name(const std::string& profile) {
    return profile == "high" ? "High" : profile == "baseline" ? "Baseline" : "Main";
}

Answered<std::string> h264_profile_of(std::string_view name) {
    for (const char* profile : {"baseline", "main", "high"})
        if (profile_name(profile) == name) return profile;
    return invalid_argument("ConfigModify", "the profile of H.264 is Baseline, Main or High");
}

std::string source_configuration(const Asked& asked, const CameraSpec& camera, std::string_view tag) {
    return element(tag,
                   text_element("tt:Name", camera.name) +
                       element("tt:UseCount", std::to_string(streams_of(asked, camera).size())) +
                       text_element("tt:SourceToken", camera.name) +
                       element("tt:Bounds", "",
                               "x=\"0\" y=\"0\" width=\"" + std::to_string(camera.size.width) + "\" height=\"" +
                                   std::to_string(camera.size.height) + "\""),
                   token_attribute(camera.name));
}

std::string source_options(const CameraSpec& camera, std::string_view tag) {
    const auto [width, height] = camera.size;
    return element(tag, element("tt:BoundsRange", whole_range("tt:XRange", {0, 0}) + whole_range("tt:YRange", {0, 0}) +
                                                      whole_range("tt:WidthRange", {width, width}) +
                                                      whole_range("tt:HeightRange", {height, height})) +
                            text_element("tt:VideoSourceTokensAvailable", camera.name));
}

std::string stream_uri(const Asked& asked, const Chosen& chosen) {
    const std::string& host = asked.host;
    const std::string name =
        host.starts_with('[') ? host.substr(0, host.find(']') + 1) : host.substr(0, host.find(':'));
    const std::string& ending = chosen.stream.ending;
    return asked.site.rtsp_scheme + "://" + name + ":" + std::to_string(asked.site.rtsp_port) + "/" +
           chosen.camera->name + (ending.empty() ? "" : "/" + ending);
}

std::string snapshot_uri(const Asked& asked, const Chosen& chosen) {
    return "http://" + asked.host + "/cameras/" + chosen.camera->name + "/snapshot.jpg";
}

Answered<std::optional<double>> number_in(std::string_view text) {
    if (text.empty()) return std::nullopt;
    double value = 0.0;
    const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (failed != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
        return invalid_argument("ConfigModify", "'" + std::string(text.substr(0, 64)) + "' is no number");
    return value;
}

Answered<std::optional<ImageSize>> size_in(const XmlElement& resolution) {
    if (!resolution) return std::nullopt;
    const auto width = number_in(resolution.text("Width")), height = number_in(resolution.text("Height"));
    for (const auto* side : {&width, &height}) {
        if (!*side) return std::unexpected(side->error());
        const double pixels = (*side)->value_or(0.0);
        if (!(pixels >= 1 && pixels <= max_image_size.width && pixels == std::floor(pixels)))
            return invalid_argument("ConfigModify", "Resolution is a Width and a Height in pixels");
    }
    return ImageSize{static_cast<int>(**width), static_cast<int>(**height)};
}

Answered<StreamWish> wish_in(const XmlElement& configuration, double told_rate) {
    StreamWish wish{.told_rate = told_rate};
    const auto size = size_in(configuration.child("Resolution"));
    if (!size) return std::unexpected(size.error());
    wish.size = *size;
    const XmlElement control = configuration.child("RateControl");
    for (const auto& [text, target] : {std::pair{control.text("FrameRateLimit"), &wish.frame_rate},
                                       {control.text("BitrateLimit"), &wish.bitrate_kbps},
                                       {configuration.text("Quality"), &wish.quality}}) {
        const auto number = number_in(text);
        if (!number) return std::unexpected(number.error());
        *target = *number;
    }
    return wish;
}

Answered<engine::SetCamera> change_to(const Asked& asked, const Chosen& chosen, const StreamWish& wish) {
    auto output = output_for(*chosen.camera, chosen.stream, wish, asked.site.has_h265);
    if (!output) return invalid_argument("ConfigModify", output.error().message);
    engine::SetCamera command{.name = chosen.camera->name, .patch = {}};
    // Of the camera as it is then: what others change meanwhile stays.
    command.patch.change([output = std::move(*output)](CameraSpec& camera) {
        const auto present =
            std::ranges::find_if(camera.outputs, [&](const OutputSpec& one) { return is_same_output(one, output); });
        if (present == camera.outputs.end())
            camera.outputs.push_back(output);
        else
            *present = output;
    });
    return command;
}

}  // namespace camrig::onvif

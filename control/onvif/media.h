#pragma once

#include "control/onvif/operation.h"
#include "control/onvif/video_stream.h"

/// What the services Media and Media2 have in common: sources, where streams and pictures are, and how a stream is
/// changed.
namespace camrig::onvif {

/// A stream that a request means.
struct Chosen {
    CameraSpecRef camera;
    VideoStream stream;
};
/// By a token of a profile or an encoder's configuration; else the fault with this detail ("NoProfile").
Answered<Chosen> chosen_by(const Asked& asked, std::string_view token, std::string_view detail);
/// The streams of a camera, main first.
std::vector<VideoStream> streams_of(const Asked& asked, const world::CameraSpec& camera);

/// tt:Min and tt:Max in an element of that name.
std::string whole_range(std::string_view name, IntRange range);
std::string size_element(std::string_view name, ImageSize size);
std::string token_attribute(const std::string& token);
/// "Main" of "main".
std::string profile_name(const std::string& profile);
/// And back; ConfigModify: the encoders have none of that name.
Answered<std::string> h264_profile_of(std::string_view name);
/// Multicast is not set by ONVIF: an address of nothing.
extern const std::string_view no_multicast;

std::string source_configuration(const Asked& asked, const world::CameraSpec& camera, std::string_view tag);
std::string source_options(const world::CameraSpec& camera, std::string_view tag);
std::string stream_uri(const Asked& asked, const Chosen& chosen);
std::string snapshot_uri(const Asked& asked, const Chosen& chosen);

/// A number that a request gives; nullopt: it does not, a fault: it is none.
Answered<std::optional<double>> number_in(std::string_view text);
/// The size in an element tt:Resolution; nullopt: there is none.
Answered<std::optional<ImageSize>> size_in(const XmlElement& resolution);
/// The part of a wish that both services say alike: resolution, rate control and quality.
Answered<StreamWish> wish_in(const XmlElement& configuration, double told_rate);
/// The command that fulfils the wish; ConfigModify: it cannot be.
Answered<engine::SetCamera> change_to(const Asked& asked, const Chosen& chosen, const StreamWish& wish);

}  // namespace camrig::onvif

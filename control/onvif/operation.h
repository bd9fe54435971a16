#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "control/onvif/device_manners.h"
#include "control/onvif/soap.h"
#include "control/onvif/users.h"
#include "control/onvif/video_stream.h"
#include "core/engine/command.h"

namespace camrig::onvif {

/// What devices tell of the rig around them.
struct Site {
    std::string version;
    std::string rtsp_scheme = "rtsp";
    std::uint16_t rtsp_port = 0;
    /// A camera's RTSP streams as they are, main first; empty: there are none.
    std::function<std::vector<VideoStream>(const world::CameraSpec&)> streams = {};
    bool has_h265 = false;         ///< streams can have that codec
    bool is_discoverable = false;  ///< by WS-Discovery
};

/// The access classes of ONVIF Core (5.9.4, "Access control"): what an operation does to the device.
enum class Access : std::uint8_t {
    pre_auth,               ///< PRE_AUTH: everybody may, known or not
    read_system,            ///< READ_SYSTEM: what the device is and how it is set
    read_system_sensitive,  ///< READ_SYSTEM_SENSITIVE: of that, what is not everybody's matter
    read_system_secret,     ///< READ_SYSTEM_SECRET: of that, what is a secret, as who the users are
    write_system,           ///< WRITE_SYSTEM: changes how the device is set
    unrecoverable,          ///< UNRECOVERABLE: changes that cannot be taken back, as a reset
    read_media,             ///< READ_MEDIA: profiles, streams, events, where heads are
    actuate,                ///< ACTUATE: turns heads and changes streams
};
/// The least of the roles that may, by the standard's default access policy; of pre_auth, which is nobody's, user.
Role least_role(Access access);
/// Whether it does more than look.
bool is_change(Access access);

using CameraSpecRef = std::shared_ptr<const world::CameraSpec>;

/// What an operation is answered from.
struct Asked {
    const Site& site;
    XmlElement request;
    std::string host;                                  ///< as the client calls us, with the port
    std::string device;                                ///< the device's camera; empty: the device has all of the rig
    std::string path;                                  ///< of the URL that was posted to
    std::vector<CameraSpecRef> cameras;                ///< of the device; of an operation on a head, its only
    std::shared_ptr<const world::Camera> camera = {};  ///< of an operation on a head
    TimeNs utc_ns = 0;                                 ///< when it came, by the device's clock
    TimeNs clock_error_ns = 0;                         ///< of that clock: a camera's own on its device, else 0
    std::span<const User> users = {};
    OnvifOutput manners = {};  ///< of the device

    std::string device_url() const { return "http://" + host + "/onvif/device_service"; }
    bool has_heads() const;
};

/// What heads are told, by the same commands as the methods ptz.* and fault.wipe give.
using PtzCommand =
    std::variant<engine::GetPtz, engine::MovePtz, engine::StopPtz, engine::PtzPresets, engine::ClearFaults>;

class EventDesk;

/// An operation answers from what is known of the cameras, once it has changed one of them if that is what it does; or
/// it tells a head something and answers from that; or it asks the desk of events, which may answer later.
struct Operation {
    std::string_view name;
    Answer (*answer)(const Asked&) = nullptr;
    Access access = Access::read_media;
    /// For the head of the profile that the request names; in this order, at least one.
    Answered<std::vector<PtzCommand>> (*orders)(const Asked&) = nullptr;
    std::string (*reply)(const Asked&, const engine::PtzReply&) = nullptr;  ///< to the last of them
    Answered<engine::SetCamera> (*change)(const Asked&) = nullptr;          ///< done before it answers
    /// `asked` may be read until it returns; `done` is called once, from any thread.
    void (*on_events)(const Asked&, EventDesk&, std::function<void(Answer)> done) = nullptr;
};

/// The operations of a service, by the namespace of their requests.
struct Service {
    std::string_view space;
    std::span<const Operation> operations;
};
Service device_service();
Service media_service();
Service media2_service();
Service ptz_service();
Service imaging_service();
inline constexpr std::string_view event_space = "http://www.onvif.org/ver10/events/wsdl";
Service event_service();
/// Of WS-BaseNotification: what is done about a subscription.
Service subscription_service();

// Tokens. A camera's source, head's configuration and node bear its name, and so do profile and encoder's configuration
// of its main stream; those of its other streams have an ending that no name of a camera has (camera_of_token()).
/// The device's camera whose token is the request's child of that name, which as "ProfileToken" may be one of any of
/// its streams; else the fault with this detail.
Answered<CameraSpecRef> camera_of(const Asked& asked, std::string_view child, std::string_view detail);
/// <PREFIX:NAMEResponse>content</...>
std::string response(std::string_view operation, std::string_view content);
inline constexpr TimeNs day_ns = 86'400 * ns_per_s;
/// An xs:duration of whole and parts of days, hours, minutes and seconds; nullopt: it is none, or over the longest.
std::optional<TimeNs> duration_of(std::string_view text, TimeNs longest_ns = day_ns);

}  // namespace camrig::onvif

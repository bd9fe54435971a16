#pragma once

#include <bitset>
#include <compare>
#include <cstdint>
#include <string>
#include <string_view>

#include "control/onvif/soap.h"
#include "core/base/time.h"

/// What devices tell of by themselves: topics of the ONVIF event service (Core 9) and their messages. Pure.
namespace camrig::onvif {

enum class EventTopic : std::uint8_t {
    motion,
    scene_change,
    too_blurry,
    too_bright,
    too_dark,
    cell_motion,  ///< what motion tells, by the other name that clients look for
    tamper,       ///< what scene_change tells, the same
    digital_input
};
inline constexpr std::size_t event_topic_count = 8;
using EventTopics = std::bitset<event_topic_count>;
/// Those about the pictures of a camera.
EventTopics picture_topics();

/// Something that is so or not, and who it is about: a camera, or the digital input.
struct EventProperty {
    EventTopic topic{};
    std::string source;
    friend auto operator<=>(const EventProperty&, const EventProperty&) = default;
};

struct EventMessage {
    enum class Kind : std::uint8_t { initialized, changed, deleted };
    EventProperty property;
    bool state = false;
    Kind kind = Kind::changed;
    TimeNs utc_ns = 0;
};
/// <wsnt:NotificationMessage>
std::string notification(const EventMessage& message);

/// <wstop:TopicSet>: every topic, and what its messages hold.
std::string topic_set();
/// The topics that a wsnt:Filter lets through; without one, all. A fault: content is to be filtered, a dialect that is
/// none of ONVIF's two, or an expression that no topic of ours fits.
Answered<EventTopics> read_filter(XmlElement filter);

}  // namespace camrig::onvif

#include <charconv>

#include "control/onvif/authentication.h"
#include "control/onvif/event_desk.h"
#include "control/onvif/operation.h"
#include "core/base/clock.h"

// ONVIF events (Core 9): topics, and pull points on which clients wait for messages about them (WS-BaseNotification).
namespace camrig::onvif {
namespace {

using Done = std::function<void(Answer)>;

constexpr TimeNs longest_asked_ns = 366 * day_ns;  ///< what is granted is PullPoints' matter
constexpr std::string_view subscription_path = "/onvif/sub/";

/// In UTC, of an end by CLOCK_MONOTONIC.
std::string end_text(TimeNs utc_ns, TimeNs ends_ns) {
    return text_of_time(utc_ns + std::max(TimeNs{0}, ends_ns - monotonic_now_ns()));
}

/// How long a subscription is asked to live: a duration, or a time.
Answered<TimeNs> life_of(const Asked& asked, std::string_view child) {
    const std::string_view text = asked.request.text(child);
    if (text.empty()) return PullPoints::default_life_ns;
    if (const auto lasts = duration_of(text, longest_asked_ns)) return *lasts;
    if (const auto until = time_of_text(text); until && *until > asked.utc_ns) return *until - asked.utc_ns;
    return std::unexpected(Fault{true,
                                 "wsnt:UnacceptableTerminationTimeFault",
                                 {},
                                 std::string(child) + " is a duration as PT60S, or a time to come"});
}

/// 0, which none has: the path is that of no subscription.
std::uint64_t subscription_of(const Asked& asked) {
    std::string_view path = asked.path;
    if (!path.starts_with(subscription_path)) return 0;
    path.remove_prefix(subscription_path.size());
    std::uint64_t number = 0;
    const auto [end, failed] = std::from_chars(path.data(), path.data() + path.size(), number);
    return failed == std::errc{} && end == path.data() + path.size() ? number : 0;
}

void create(const Asked& asked, EventDesk& desk, Done done) {
    const auto topics = read_filter(asked.request.child("Filter"));
    if (!topics) return done(std::unexpected(topics.error()));
    const auto life = life_of(asked, "InitialTerminationTime");
    if (!life) return done(std::unexpected(life.error()));
    const auto made = desk.subscribe(asked.device, *topics, *life);
    if (!made) return done(std::unexpected(made.error()));
    const std::string url = "http://" + asked.host + std::string(subscription_path) + std::to_string(made->number);
    done(response("tev:CreatePullPointSubscription",
                  element("tev:SubscriptionReference", text_element("wsa5:Address", url)) +
                      element("wsnt:CurrentTime", text_of_time(asked.utc_ns)) +
                      element("wsnt:TerminationTime", end_text(asked.utc_ns, made->ends_ns))));
}

void pull(const Asked& asked, EventDesk& desk, Done done) {
    const std::string_view given = asked.request.text("Timeout"), limit_text = asked.request.text("MessageLimit");
    const auto wait = given.empty() ? std::optional(PullPoints::max_pull_ns) : duration_of(given, longest_asked_ns);
    std::size_t limit = PullPoints::max_messages;
    const auto [end, failed] = std::from_chars(limit_text.data(), limit_text.data() + limit_text.size(), limit);
    if (!wait || (!limit_text.empty() && (failed != std::errc{} || end != limit_text.data() + limit_text.size())))
        return done(invalid_argument("", "Timeout is a duration as PT60S, MessageLimit a number"));
    desk.pull(asked.device, subscription_of(asked), *wait, limit,
              [done = std::move(done), error_ns = asked.clock_error_ns](const Answered<PullPoints::Pulled>& pulled) {
                  if (!pulled) return done(std::unexpected(pulled.error()));
                  // The question may be a minute old.
                  const TimeNs utc_ns = realtime_now_ns() + error_ns;
                  std::string content = element("tev:CurrentTime", text_of_time(utc_ns)) +
                                        element("tev:TerminationTime", end_text(utc_ns, pulled->ends_ns));
                  for (EventMessage message : pulled->messages) {
                      message.utc_ns += error_ns;
                      content += notification(message);
                  }
                  done(response("tev:PullMessages", content));
              });
}

void renew(const Asked& asked, EventDesk& desk, Done done) {
    const auto life = life_of(asked, "TerminationTime");
    if (!life) return done(std::unexpected(life.error()));
    const auto ends_ns = desk.renew(asked.device, subscription_of(asked), *life);
    if (!ends_ns) return done(std::unexpected(ends_ns.error()));
    // In the other order than elsewhere, by the schema.
    done(response("wsnt:Renew", element("wsnt:TerminationTime", end_text(asked.utc_ns, *ends_ns)) +
                                    element("wsnt:CurrentTime", text_of_time(asked.utc_ns))));
}

void unsubscribe(const Asked& asked, EventDesk& desk, Done done) {
    const auto gone = desk.unsubscribe(asked.device, subscription_of(asked));
    if (!gone) return done(std::unexpected(gone.error()));
    done(response("wsnt:Unsubscribe", ""));
}

void synchronize(const Asked& asked, EventDesk& desk, Done done) {
    const auto told = desk.synchronize(asked.device, subscription_of(asked));
    if (!told) return done(std::unexpected(told.error()));
    done(response("tev:SetSynchronizationPoint", ""));
}

Answer get_event_properties(const Asked&) {
    return response(
        "tev:GetEventProperties",
        "<tev:TopicNamespaceLocation>http://www.onvif.org/onvif/ver10/topics/topicns.xml</tev:TopicNamespaceLocation>"
        "<wsnt:FixedTopicSet>true</wsnt:FixedTopicSet>" +
            topic_set() +
            "<wsnt:TopicExpressionDialect>http://www.onvif.org/ver10/tev/topicExpression/ConcreteSet"
            "</wsnt:TopicExpressionDialect>"
            "<wsnt:TopicExpressionDialect>http://docs.oasis-open.org/wsn/t-1/TopicExpression/Concrete"
            "</wsnt:TopicExpressionDialect>"
            "<tev:MessageContentFilterDialect>http://www.onvif.org/ver10/tev/messageContentFilter/ItemFilter"
            "</tev:MessageContentFilterDialect>"
            "<tev:MessageContentSchemaLocation>http://www.onvif.org/onvif/ver10/schema/onvif.xsd"
            "</tev:MessageContentSchemaLocation>");
}

Answer get_service_capabilities(const Asked&) {
    return response(
        "tev:GetServiceCapabilities",
        element("tev:Capabilities", "",
                R"(WSSubscriptionPolicySupport="false" WSPullPointSupport="true")"
                R"( WSPausableSubscriptionManagerInterfaceSupport="false" MaxPullPoints=")" +
                    std::to_string(PullPoints::max_per_device) + R"(" PersistentNotificationStorage="false")"));
}

const Operation operations[] = {
    {.name = "GetServiceCapabilities", .answer = get_service_capabilities, .access = Access::pre_auth},
    {.name = "GetEventProperties", .answer = get_event_properties},
    {.name = "CreatePullPointSubscription", .on_events = create},
    {.name = "PullMessages", .on_events = pull},
    {.name = "SetSynchronizationPoint", .on_events = synchronize},
};

const Operation manager_operations[] = {
    {.name = "Renew", .on_events = renew},
    {.name = "Unsubscribe", .on_events = unsubscribe},
};

}  // namespace

Service event_service() {
    return {event_space, operations};
}

Service subscription_service() {
    return {"http://docs.oasis-open.org/wsn/b-2", manager_operations};
}

}  // namespace camrig::onvif

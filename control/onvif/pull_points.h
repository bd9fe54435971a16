#pragma once

#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "control/onvif/event_topic.h"

namespace camrig::onvif {

/// The pull points of a rig's devices (ONVIF Core 9.2, "Real-time Pull-Point Notification Interface"): who subscribed
/// to what and until when, and messages that wait to be pulled. Has no clock and no thread: times are of
/// CLOCK_MONOTONIC and given by the caller; of one caller at a time.
class PullPoints {
public:
    static constexpr std::size_t max_per_device = 8, max_subscriptions = 256;
    /// That wait in one, or as many as there are states if those are more; the oldest go.
    static constexpr std::size_t max_messages = 256;
    static constexpr TimeNs max_pull_ns = 60 * ns_per_s;
    static constexpr TimeNs default_life_ns = 60 * ns_per_s, max_life_ns = 3600 * ns_per_s;

    struct Pulled {
        std::vector<EventMessage> messages;
        TimeNs ends_ns = 0;
    };
    using Done = std::function<void(Answered<Pulled>)>;
    /// Pulls that are answered by what was done; the caller calls them.
    using Due = std::vector<std::function<void()>>;

    struct Subscribed {
        std::uint64_t number = 0;
        TimeNs ends_ns = 0;
    };
    /// Messages of what is so begin it. A fault: there are too many.
    Answered<Subscribed> subscribe(std::string device, EventTopics topics, TimeNs life_ns, TimeNs now_ns);
    /// Of the following, a fault: this device has no such subscription, or not any more.
    Answered<TimeNs> renew(const std::string& device, std::uint64_t number, TimeNs life_ns, TimeNs now_ns);
    Answered<void> unsubscribe(const std::string& device, std::uint64_t number, TimeNs now_ns, Due& due);
    /// Tells again of all that is so.
    Answered<void> synchronize(const std::string& device, std::uint64_t number, TimeNs now_ns, TimeNs utc_ns, Due& due);
    /// Answered when there is a message, when the time is over, or when the next pull of this subscription comes. It
    /// lives at least default_life_ns longer than that.
    void pull(const std::string& device, std::uint64_t number, TimeNs wait_ns, std::size_t limit, TimeNs now_ns,
              Done done, Due& due);

    void tell(const EventProperty& property, bool state, TimeNs utc_ns, Due& due);
    /// Of everything about this source, where nothing can be told any more.
    void forget(const std::string& source, TimeNs utc_ns, Due& due);
    /// Ends what is over, and everything with no subscription left to tell of.
    void expire(TimeNs now_ns, Due& due);
    /// Answers all pulls, empty.
    void end(Due& due);

    bool empty() const { return subscriptions_.empty(); }
    /// Whether anybody subscribed to scene events.
    bool hears_inputs() const { return wanted({}).test(static_cast<std::size_t>(EventTopic::digital_input)); }
    /// When expire() has something to do.
    TimeNs next_ns() const;
    /// What anybody subscribed to about this camera, or with the empty name about the rig.
    EventTopics wanted(const std::string& source) const;

private:
    struct Pull {
        TimeNs ends_ns = 0;
        std::size_t limit = 0;
        Done done;
    };
    struct Subscription {
        std::string device;  ///< empty: of all cameras
        EventTopics topics;
        TimeNs ends_ns = 0;
        std::deque<EventMessage> messages = {};
        std::optional<Pull> pull = {};
    };

    Answered<Subscription*> find(const std::string& device, std::uint64_t number, TimeNs now_ns);
    /// Nobody watches: what was so may be otherwise when the next one subscribes.
    void forget_unheard();
    static bool hears(const Subscription& one, const EventProperty& property);
    void tell_all(const EventMessage& message, Due& due);
    static void answer(Subscription& one, Due& due);
    void put(Subscription& one, EventMessage message) const;

    std::map<std::uint64_t, Subscription> subscriptions_;
    struct State {
        bool is_so = false;
        TimeNs utc_ns = 0;
    };
    std::map<EventProperty, State> states_;
    std::uint64_t last_number_ = 0;
};

}  // namespace camrig::onvif

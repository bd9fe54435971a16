#include "control/onvif/pull_points.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace camrig::onvif {
namespace {

TimeNs life_of(TimeNs asked_ns) {
    return std::clamp(asked_ns, TimeNs{ns_per_s}, PullPoints::max_life_ns);
}

}  // namespace

Answered<PullPoints::Subscribed> PullPoints::subscribe(std::string device, EventTopics topics, TimeNs life_ns,
                                                       TimeNs now_ns) {
    const auto of_device =
        std::ranges::count_if(subscriptions_, [&](const auto& one) { return one.second.device == device; });
    if (subscriptions_.size() >= max_subscriptions || static_cast<std::size_t>(of_device) >= max_per_device)
        return std::unexpected(
            Fault{false, "wsnt:SubscribeCreationFailedFault", {}, "there are too many subscriptions"});
    const std::uint64_t number = ++last_number_;
    Subscription& made = subscriptions_[number] = {std::move(device), topics, now_ns + life_of(life_ns)};
    for (const auto& [property, state] : states_)
        if (hears(made, property)) put(made, {property, state.is_so, EventMessage::Kind::initialized, state.utc_ns});
    return Subscribed{number, made.ends_ns};
}

Answered<PullPoints::Subscription*> PullPoints::find(const std::string& device, std::uint64_t number, TimeNs now_ns) {
    const auto found = subscriptions_.find(number);
    if (found != subscriptions_.end() && found->second.device == device && found->second.ends_ns > now_ns)
        return &found->second;
    return std::unexpected(
        Fault{true, "wsrf-rw:ResourceUnknownFault", {}, "there is no such subscription, or its time is over"});
}

Answered<TimeNs> PullPoints::renew(const std::string& device, std::uint64_t number, TimeNs life_ns, TimeNs now_ns) {
    const auto one = find(device, number, now_ns);
    if (!one) return std::unexpected(one.error());
    return (*one)->ends_ns = now_ns + life_of(life_ns);
}

Answered<void> PullPoints::unsubscribe(const std::string& device, std::uint64_t number, TimeNs now_ns, Due& due) {
    const auto one = find(device, number, now_ns);
    if (!one) return std::unexpected(one.error());
    (*one)->messages.clear();
    answer(**one, due);
    subscriptions_.erase(number);
    forget_unheard();
    return {};
}

Answered<void> PullPoints::synchronize(const std::string& device, std::uint64_t number, TimeNs now_ns, TimeNs utc_ns,
                                       Due& due) {
    const auto one = find(device, number, now_ns);
    if (!one) return std::unexpected(one.error());
    for (const auto& [property, state] : states_)
        if (hears(**one, property)) put(**one, {property, state.is_so, EventMessage::Kind::initialized, utc_ns});
    if (!(*one)->messages.empty()) answer(**one, due);
    return {};
}

void PullPoints::pull(const std::string& device, std::uint64_t number, TimeNs wait_ns, std::size_t limit, TimeNs now_ns,
                      Done done, Due& due) {
    const auto found = find(device, number, now_ns);
    if (!found) {
        due.emplace_back([done = std::move(done), fault = found.error()] { done(std::unexpected(fault)); });
        return;
    }
    Subscription& one = **found;
    // The pull that waits is most likely of a connection that broke: it gets nothing, so that nothing is lost.
    if (one.pull) {
        auto kept = std::exchange(one.messages, {});
        answer(one, due);
        one.messages = std::move(kept);
    }
    const TimeNs ends_ns = now_ns + std::clamp(wait_ns, TimeNs{0}, max_pull_ns);
    one.ends_ns = std::max(one.ends_ns, ends_ns + default_life_ns);
    one.pull = Pull{ends_ns, std::clamp<std::size_t>(limit, 1, max_messages), std::move(done)};
    if (!one.messages.empty() || ends_ns == now_ns) answer(one, due);
}

void PullPoints::put(Subscription& one, EventMessage message) const {
    if (one.messages.size() >= std::max(max_messages, states_.size())) one.messages.pop_front();
    one.messages.push_back(std::move(message));
}

void PullPoints::answer(Subscription& one, Due& due) {
    if (!one.pull) return;
    const auto count = static_cast<std::ptrdiff_t>(std::min(one.pull->limit, one.messages.size()));
    Pulled pulled{{one.messages.begin(), one.messages.begin() + count}, one.ends_ns};
    one.messages.erase(one.messages.begin(), one.messages.begin() + count);
    due.emplace_back([done = std::move(one.pull->done), pulled = std::move(pulled)] { done(pulled); });
    one.pull.reset();
}

bool PullPoints::hears(const Subscription& one, const EventProperty& property) {
    const bool is_about_it =
        one.device.empty() || property.topic == EventTopic::digital_input || property.source == one.device;
    return is_about_it && one.topics.test(static_cast<std::size_t>(property.topic));
}

void PullPoints::tell_all(const EventMessage& message, Due& due) {
    for (auto& [number, one] : subscriptions_) {
        if (!hears(one, message.property)) continue;
        put(one, message);
        answer(one, due);
    }
}

void PullPoints::tell(const EventProperty& property, bool state, TimeNs utc_ns, Due& due) {
    const auto [known, is_new] = states_.try_emplace(property, State{state, utc_ns});
    if (!is_new && known->second.is_so == state) return;
    known->second = {state, utc_ns};
    tell_all({property, state, is_new ? EventMessage::Kind::initialized : EventMessage::Kind::changed, utc_ns}, due);
}

void PullPoints::forget(const std::string& source, TimeNs utc_ns, Due& due) {
    for (auto one = states_.begin(); one != states_.end();) {
        if (one->first.source != source || one->first.topic == EventTopic::digital_input) {
            ++one;
            continue;
        }
        const EventMessage last{one->first, one->second.is_so, EventMessage::Kind::deleted, utc_ns};
        one = states_.erase(one);
        tell_all(last, due);
    }
}

void PullPoints::expire(TimeNs now_ns, Due& due) {
    for (auto it = subscriptions_.begin(); it != subscriptions_.end();) {
        Subscription& one = it->second;
        if (one.pull && std::min(one.pull->ends_ns, one.ends_ns) <= now_ns) answer(one, due);
        it = one.ends_ns <= now_ns ? subscriptions_.erase(it) : std::next(it);
    }
    forget_unheard();
}

void PullPoints::forget_unheard() {
    if (subscriptions_.empty()) return states_.clear();
    if (!hears_inputs())
        std::erase_if(states_, [](const auto& one) { return one.first.topic == EventTopic::digital_input; });
}

void PullPoints::end(Due& due) {
    for (auto& [number, one] : subscriptions_) {
        one.messages.clear();
        answer(one, due);
    }
    subscriptions_.clear();
}

TimeNs PullPoints::next_ns() const {
    TimeNs next = std::numeric_limits<TimeNs>::max();
    for (const auto& [number, one] : subscriptions_) {
        next = std::min(next, one.ends_ns);
        if (one.pull) next = std::min(next, one.pull->ends_ns);
    }
    return next;
}

EventTopics PullPoints::wanted(const std::string& source) const {
    EventTopics topics;
    for (const auto& [number, one] : subscriptions_)
        if (source.empty() || one.device.empty() || one.device == source) topics |= one.topics;
    return topics;
}

}  // namespace camrig::onvif

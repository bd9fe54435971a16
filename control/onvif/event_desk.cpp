#include "control/onvif/event_desk.h"

#include <algorithm>
#include <limits>
#include <system_error>
#include <utility>

#include <pthread.h>

#include "core/base/clock.h"

namespace camrig::onvif {
namespace {

constexpr TimeNs event_wait_ns = 10 * ns_per_s;

void call(PullPoints::Due due) {
    for (const auto& answer : due) answer();
}

}  // namespace

EventDesk::EventDesk(engine::CommandPort& commands, stream::FrameFetcher& frames)
    : commands_(commands), frames_(frames) {}

EventDesk::~EventDesk() {
    stop();
}

void EventDesk::stop() {
    PullPoints::Due due;
    {
        const std::lock_guard lock(mutex_);
        answers_->close();
        points_.end(due);
    }
    if (thread_.joinable()) thread_.join();
    call(std::move(due));
}

Answered<PullPoints::Subscribed> EventDesk::subscribe(const std::string& device, EventTopics topics, TimeNs life_ns) {
    const std::lock_guard lock(mutex_);
    if (answers_->is_closed()) return std::unexpected(Fault{false, "Action", {}, "the rig ends"});
    try {
        if (!thread_.joinable()) thread_ = std::thread([this] { run(); });
    } catch (const std::system_error& why) {
        return std::unexpected(Fault{false,
                                     "wsnt:SubscribeCreationFailedFault",
                                     {},
                                     std::string("no thread can be had to watch the rig: ") + why.what()});
    }
    auto made = points_.subscribe(device, topics, life_ns, monotonic_now_ns());
    next_look_ns_ = 0;
    answers_->wake();
    return made;
}

Answered<TimeNs> EventDesk::renew(const std::string& device, std::uint64_t number, TimeNs life_ns) {
    const std::lock_guard lock(mutex_);
    return points_.renew(device, number, life_ns, monotonic_now_ns());
}

Answered<void> EventDesk::unsubscribe(const std::string& device, std::uint64_t number) {
    PullPoints::Due due;
    Answered<void> done;
    {
        const std::lock_guard lock(mutex_);
        done = points_.unsubscribe(device, number, monotonic_now_ns(), due);
        if (!points_.hears_inputs()) rest();
    }
    answers_->wake();
    call(std::move(due));
    return done;
}

Answered<void> EventDesk::synchronize(const std::string& device, std::uint64_t number) {
    PullPoints::Due due;
    Answered<void> done;
    {
        const std::lock_guard lock(mutex_);
        done = points_.synchronize(device, number, monotonic_now_ns(), realtime_now_ns(), due);
    }
    call(std::move(due));
    return done;
}

void EventDesk::pull(const std::string& device, std::uint64_t number, TimeNs wait_ns, std::size_t limit,
                     PullPoints::Done done) {
    PullPoints::Due due;
    {
        const std::lock_guard lock(mutex_);
        points_.pull(device, number, wait_ns, limit, monotonic_now_ns(), std::move(done), due);
    }
    answers_->wake();
    call(std::move(due));
}

void EventDesk::run() {
    ::pthread_setname_np(::pthread_self(), "camrig-events");
    while (!answers_->is_closed()) {
        {
            const std::lock_guard lock(mutex_);
            points_.expire(monotonic_now_ns(), due_);
            if (!points_.hears_inputs()) rest();
            if ((points_.wanted({}) & picture_topics()).none()) forget_pictures();
            end_pulses(monotonic_now_ns());
        }
        while (const auto answer = answers_->take()) std::visit([this](const auto& what) { take(what); }, *answer);
        ask();
        PullPoints::Due due;
        TimeNs next = 0;
        {
            const std::lock_guard lock(mutex_);
            due.swap(due_);
            next = next_ns();
        }
        call(std::move(due));
        answers_->wait_until(next);
    }
}

TimeNs EventDesk::next_ns() const {
    if (points_.empty()) return std::numeric_limits<TimeNs>::max();
    TimeNs next = std::min(points_.next_ns(), next_look_ns_);
    for (const auto& [name, ends_ns] : pulses_)
        if (ends_ns != 0) next = std::min(next, ends_ns);
    return next;
}

void EventDesk::rest() {
    if (pulses_.empty() && !waits_ && !last_event_) return;
    pulses_.clear();
    last_event_.reset();
    waits_ = false;
    ++round_;
}

/// A picture of before is no measure of the next one, nor is what it told so any more.
void EventDesk::forget_pictures() {
    if (cameras_.empty()) return;
    for (const auto& [name, camera] : cameras_) points_.forget(name, realtime_now_ns(), due_);
    cameras_.clear();
    ++picture_round_;
}

void EventDesk::take(const Cameras& all) {
    const std::lock_guard lock(mutex_);
    lists_ = false;
    if (!all) return;
    std::map<std::string, Camera> wanted;
    for (const engine::CameraReply& one : *all) {
        const std::string& name = one.camera.spec()->name;
        if ((points_.wanted(name) & picture_topics()).none()) continue;
        auto known = cameras_.extract(name);
        Camera& camera = known ? wanted.insert(std::move(known)).position->second : wanted[name];
        camera.is_due = true;
    }
    for (const auto& [name, camera] : cameras_) points_.forget(name, realtime_now_ns(), due_);
    cameras_ = std::move(wanted);
}

void EventDesk::take(const Events& events) {
    const std::lock_guard lock(mutex_);
    if (events.round != round_) return;
    waits_ = false;
    next_wait_ns_ = events.log ? 0 : monotonic_now_ns() + period_ns;
    if (!events.log) return;
    for (const world::EventRecord& record : events.log->events) {
        if (pulses_.size() >= max_inputs && !pulses_.contains(record.event)) continue;
        pulses_[record.event] = monotonic_now_ns() + pulse_ns;
        points_.tell({EventTopic::digital_input, record.event}, true, realtime_now_ns(), due_);
    }
    last_event_ = events.log->last;
}

void EventDesk::end_pulses(TimeNs now_ns) {
    for (auto& [name, ends_ns] : pulses_) {
        if (ends_ns == 0 || ends_ns > now_ns) continue;
        ends_ns = 0;
        points_.tell({EventTopic::digital_input, name}, false, realtime_now_ns(), due_);
    }
}

void EventDesk::take(const Picture& picture) {
    // Only this thread touches cameras_ and what counts their pictures: measuring takes long, and holds nobody up.
    --fetches_;
    const auto found = cameras_.find(picture.camera);
    if (picture.round != picture_round_ || found == cameras_.end()) return;
    found->second.is_asked = false;
    if (!picture.made || !picture.made->frame) return;  // the next may be had
    const frame::Frame& frame = *picture.made->frame;
    const frame::FrameInfo& info = frame.info();
    const PictureFacts facts = found->second.watch.see(frame.bytes(), info.size, info.world_ns);
    const std::lock_guard lock(mutex_);
    const TimeNs utc_ns = realtime_now_ns();
    for (const auto& [topic, state] : {std::pair{EventTopic::motion, facts.motion},
                                       {EventTopic::cell_motion, facts.motion},
                                       {EventTopic::scene_change, facts.scene_change},
                                       {EventTopic::tamper, facts.scene_change},
                                       {EventTopic::too_dark, facts.too_dark},
                                       {EventTopic::too_bright, facts.too_bright},
                                       {EventTopic::too_blurry, facts.too_blurry}})
        points_.tell({topic, picture.camera}, state, utc_ns, due_);
}

void EventDesk::ask() {
    std::unique_lock lock(mutex_);
    if (points_.empty()) return;
    const TimeNs now_ns = monotonic_now_ns();
    const bool lists = !lists_ && now_ns >= next_look_ns_ && (points_.wanted({}) & picture_topics()).any();
    const bool waits = !waits_ && now_ns >= next_wait_ns_ && points_.hears_inputs();
    if (now_ns >= next_look_ns_) next_look_ns_ = now_ns + period_ns;
    lists_ |= lists;
    waits_ |= waits;
    // From the one after the last on: where pictures take long, each has its turn.
    std::vector<std::string> pictures;
    auto next = cameras_.upper_bound(last_asked_);
    for (std::size_t i = 0; i < cameras_.size() && fetches_ < max_fetches; ++i) {
        if (next == cameras_.end()) next = cameras_.begin();
        auto& [name, camera] = *next++;
        if (!camera.is_due || camera.is_asked) continue;
        camera.is_due = false;
        camera.is_asked = true;
        ++fetches_;
        pictures.push_back(last_asked_ = name);
    }
    // Events from the subscription on: the first question is where the log ends.
    const engine::WaitEvents events = last_event_ ? engine::WaitEvents{*last_event_, event_wait_ns}
                                                  : engine::WaitEvents{std::numeric_limits<std::uint64_t>::max(), 0};
    const std::uint64_t round = round_, picture_round = picture_round_;
    lock.unlock();
    if (lists)
        commands_.post(engine::Request<engine::ListCameras>{
            {}, [answers = answers_](Cameras made) { answers->put_beyond_limit(std::move(made)); }});
    if (waits)
        commands_.post(
            engine::Request<engine::WaitEvents>{events, [answers = answers_, round](Result<engine::EventLog> log) {
                                                    answers->put_beyond_limit(Events{std::move(log), round});
                                                }});
    for (const std::string& name : pictures)
        frames_.fetch({.camera = name, .format = {}},
                      [answers = answers_, name, picture_round](Result<stream::MediaUnit> made) {
                          answers->put_beyond_limit(Picture{name, std::move(made), picture_round});
                      });
}

}  // namespace camrig::onvif

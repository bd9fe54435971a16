#include "control/onvif/event_desk.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
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

struct EventDesk::Inbox {
    std::mutex mutex;
    std::condition_variable changed;
    struct Picture {
        std::string camera;
        Result<stream::MediaUnit> made;
        std::uint64_t round;
    };
    std::deque<Picture> pictures;  ///< max_fetches at most
    std::optional<Result<std::vector<engine::CameraReply>>> cameras;
    std::optional<std::pair<Result<engine::EventLog>, std::uint64_t>> events;

    template <typename Put>
    void post(Put put) {
        {
            const std::lock_guard lock(mutex);
            put(*this);
        }
        changed.notify_one();
    }
};

EventDesk::EventDesk(engine::CommandPort& commands, stream::FrameFetcher& frames)
    : commands_(commands), frames_(frames), inbox_(std::make_shared<Inbox>()) {}

EventDesk::~EventDesk() {
    stop();
}

void EventDesk::stop() {
    PullPoints::Due due;
    {
        const std::lock_guard lock(inbox_->mutex);
        is_stopped_ = true;
        points_.end(due);
    }
    inbox_->changed.notify_one();
    if (thread_.joinable()) thread_.join();
    call(std::move(due));
}

Answered<PullPoints::Subscribed> EventDesk::subscribe(const std::string& device, EventTopics topics, TimeNs life_ns) {
    const std::lock_guard lock(inbox_->mutex);
    if (is_stopped_) return std::unexpected(Fault{false, "Action", {}, "the rig ends"});
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
    inbox_->changed.notify_one();
    return made;
}

Answered<TimeNs> EventDesk::renew(const std::string& device, std::uint64_t number, TimeNs life_ns) {
    const std::lock_guard lock(inbox_->mutex);
    return points_.renew(device, number, life_ns, monotonic_now_ns());
}

Answered<void> EventDesk::unsubscribe(const std::string& device, std::uint64_t number) {
    PullPoints::Due due;
    Answered<void> done;
    {
        const std::lock_guard lock(inbox_->mutex);
        done = points_.unsubscribe(device, number, monotonic_now_ns(), due);
        if (points_.empty()) rest();
    }
    inbox_->changed.notify_one();
    call(std::move(due));
    return done;
}

Answered<void> EventDesk::synchronize(const std::string& device, std::uint64_t number) {
    PullPoints::Due due;
    Answered<void> done;
    {
        const std::lock_guard lock(inbox_->mutex);
        done = points_.synchronize(device, number, monotonic_now_ns(), realtime_now_ns(), due);
    }
    call(std::move(due));
    return done;
}

void EventDesk::pull(const std::string& device, std::uint64_t number, TimeNs wait_ns, std::size_t limit,
                     PullPoints::Done done) {
    PullPoints::Due due;
    {
        const std::lock_guard lock(inbox_->mutex);
        points_.pull(device, number, wait_ns, limit, monotonic_now_ns(), std::move(done), due);
    }
    inbox_->changed.notify_one();
    call(std::move(due));
}

void EventDesk::run() {
    ::pthread_setname_np(::pthread_self(), "camrig-events");
    std::unique_lock lock(inbox_->mutex);
    while (!is_stopped_) {
        points_.expire(monotonic_now_ns(), due_);
        if (points_.empty()) rest();
        if ((points_.wanted({}) & picture_topics()).none()) forget_pictures();
        if (const auto cameras = std::exchange(inbox_->cameras, {})) {
            lists_ = false;
            if (*cameras) take_cameras(**cameras);
        }
        if (auto events = std::exchange(inbox_->events, {}); events && events->second == round_) {
            waits_ = false;
            if (events->first) take_events(*events->first);
            next_wait_ns_ = events->first ? 0 : monotonic_now_ns() + period_ns;
        }
        end_pulses(monotonic_now_ns());
        for (auto pictures = std::exchange(inbox_->pictures, {}); const Inbox::Picture& one : pictures) {
            --fetches_;
            if (one.round != picture_round_) continue;
            lock.unlock();
            // Only this thread touches cameras_.
            take_picture(one.camera, one.made);
            lock.lock();
        }
        ask(lock);
        if (auto due = std::exchange(due_, {}); !due.empty()) {
            lock.unlock();
            call(std::move(due));
            lock.lock();
        }
        const auto is_woken = [this] {
            return is_stopped_ || inbox_->cameras || inbox_->events || !inbox_->pictures.empty();
        };
        const TimeNs rest_ns = next_ns() - monotonic_now_ns();
        if (is_woken() || rest_ns <= 0) continue;
        if (points_.empty())
            inbox_->changed.wait(lock);
        else
            inbox_->changed.wait_for(lock, std::chrono::nanoseconds(rest_ns));
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

void EventDesk::take_cameras(const std::vector<engine::CameraReply>& all) {
    std::map<std::string, Camera> wanted;
    for (const engine::CameraReply& one : all) {
        const std::string& name = one.camera.spec()->name;
        if ((points_.wanted(name) & picture_topics()).none()) continue;
        auto known = cameras_.extract(name);
        Camera& camera = known ? wanted.insert(std::move(known)).position->second : wanted[name];
        camera.is_due = true;
    }
    for (const auto& [name, camera] : cameras_) points_.forget(name, realtime_now_ns(), due_);
    cameras_ = std::move(wanted);
}

void EventDesk::take_events(const engine::EventLog& log) {
    for (const world::EventRecord& record : log.events) {
        if (pulses_.size() >= max_inputs && !pulses_.contains(record.event)) continue;
        pulses_[record.event] = monotonic_now_ns() + pulse_ns;
        points_.tell({EventTopic::digital_input, record.event}, true, realtime_now_ns(), due_);
    }
    last_event_ = log.last;
}

void EventDesk::end_pulses(TimeNs now_ns) {
    for (auto& [name, ends_ns] : pulses_) {
        if (ends_ns == 0 || ends_ns > now_ns) continue;
        ends_ns = 0;
        points_.tell({EventTopic::digital_input, name}, false, realtime_now_ns(), due_);
    }
}

void EventDesk::take_picture(const std::string& name, const Result<stream::MediaUnit>& picture) {
    const auto found = cameras_.find(name);
    if (found == cameras_.end()) return;
    found->second.is_asked = false;
    if (!picture || !picture->frame) return;  // the next may be had
    const frame::FrameInfo& info = picture->frame->info();
    const PictureFacts facts = found->second.watch.see(picture->frame->bytes(), info.size, info.world_ns);
    const std::lock_guard lock(inbox_->mutex);
    const TimeNs utc_ns = realtime_now_ns();
    for (const auto& [topic, state] : {std::pair{EventTopic::motion, facts.motion},
                                       {EventTopic::cell_motion, facts.motion},
                                       {EventTopic::scene_change, facts.scene_change},
                                       {EventTopic::tamper, facts.scene_change},
                                       {EventTopic::too_dark, facts.too_dark},
                                       {EventTopic::too_bright, facts.too_bright},
                                       {EventTopic::too_blurry, facts.too_blurry}})
        points_.tell({topic, name}, state, utc_ns, due_);
}

void EventDesk::ask(std::unique_lock<std::mutex>& lock) {
    if (points_.empty()) return;
    const TimeNs now_ns = monotonic_now_ns();
    const EventTopics wanted = points_.wanted({});
    const bool lists = !lists_ && now_ns >= next_look_ns_ && (wanted & picture_topics()).any();
    const bool waits =
        !waits_ && now_ns >= next_wait_ns_ && wanted.test(static_cast<std::size_t>(EventTopic::digital_input));
    if (now_ns >= next_look_ns_) next_look_ns_ = now_ns + period_ns;
    lists_ |= lists;
    waits_ |= waits;
    std::vector<std::string> pictures;
    for (auto& [name, camera] : cameras_) {
        if (fetches_ >= max_fetches) break;
        if (!camera.is_due || camera.is_asked) continue;
        camera.is_due = false;
        camera.is_asked = true;
        ++fetches_;
        pictures.push_back(name);
    }
    // Events from the subscription on: the first question is where the log ends.
    const engine::WaitEvents events = last_event_ ? engine::WaitEvents{*last_event_, event_wait_ns}
                                                  : engine::WaitEvents{std::numeric_limits<std::uint64_t>::max(), 0};
    const std::uint64_t round = round_;
    lock.unlock();
    if (lists)
        commands_.post(engine::Request<engine::ListCameras>{
            {}, [inbox = inbox_](Result<std::vector<engine::CameraReply>> made) {
                inbox->post([&](Inbox& to) { to.cameras.emplace(std::move(made)); });
            }});
    if (waits)
        commands_.post(
            engine::Request<engine::WaitEvents>{events, [inbox = inbox_, round](Result<engine::EventLog> log) {
                                                    inbox->post([&](Inbox& to) {
                                                        if (!to.events || to.events->second < round)
                                                            to.events.emplace(std::move(log), round);
                                                    });
                                                }});
    for (const std::string& name : pictures)
        frames_.fetch({.camera = name, .format = {}},
                      [inbox = inbox_, name, round = picture_round_](Result<stream::MediaUnit> made) {
                          inbox->post([&](Inbox& to) { to.pictures.push_back({name, std::move(made), round}); });
                      });
    lock.lock();
}

}  // namespace camrig::onvif

#pragma once

#include <memory>
#include <mutex>
#include <thread>
#include <variant>

#include "control/onvif/picture_watch.h"
#include "control/onvif/pull_points.h"
#include "core/base/bounded_queue.h"
#include "core/engine/command.h"
#include "core/stream/frame_bus.h"

namespace camrig::onvif {

/// Watches the rig for those who subscribed to events, and answers their pulls. While nobody has subscribed it asks the
/// rig for nothing, and its thread, which the first subscription starts, sleeps.
///
/// Every period_ns it takes the latest picture of each camera whose topics somebody wants, max_fetches at once, and
/// measures it (PictureWatch). Scene events are pulses of digital inputs of their names.
/// Any thread. Pulls are answered on the thread of the desk or on that of a call, and hold none.
class EventDesk {
public:
    static constexpr TimeNs period_ns = ns_per_s / 2;
    static constexpr std::size_t max_fetches = 4;  ///< each is a picture in memory
    static constexpr TimeNs pulse_ns = ns_per_s;
    static constexpr std::size_t max_inputs = 64;  ///< further scene events are not told of

    /// Both outlive stop().
    EventDesk(engine::CommandPort& commands, stream::FrameFetcher& frames);
    ~EventDesk();
    EventDesk(const EventDesk&) = delete;
    EventDesk& operator=(const EventDesk&) = delete;

    // As of PullPoints. Ends are of CLOCK_MONOTONIC.
    Answered<PullPoints::Subscribed> subscribe(const std::string& device, EventTopics topics, TimeNs life_ns);
    Answered<TimeNs> renew(const std::string& device, std::uint64_t number, TimeNs life_ns);
    Answered<void> unsubscribe(const std::string& device, std::uint64_t number);
    Answered<void> synchronize(const std::string& device, std::uint64_t number);
    void pull(const std::string& device, std::uint64_t number, TimeNs wait_ns, std::size_t limit,
              PullPoints::Done done);

    /// Answers every pull and ends the thread. Twice is fine.
    void stop();

private:
    /// What the rig has answered.
    using Cameras = Result<std::vector<engine::CameraReply>>;
    struct Events {
        Result<engine::EventLog> log;
        std::uint64_t round = 0;
    };
    struct Picture {
        std::string camera;
        Result<stream::MediaUnit> made;
        std::uint64_t round = 0;
    };
    using Answers = BoundedQueue<std::variant<Cameras, Events, Picture>>;
    struct Camera {
        PictureWatch watch;
        bool is_asked = false;
        bool is_due = false;
    };

    void run();
    void take(const Cameras& all);
    void take(const Events& events);
    void take(const Picture& picture);
    /// Asks for what is due.
    void ask();
    void end_pulses(TimeNs now_ns);
    void rest();
    void forget_pictures();
    TimeNs next_ns() const;

    engine::CommandPort& commands_;
    stream::FrameFetcher& frames_;
    /// Shared with the requests that the rig has yet to answer, which may outlive the desk. It has no limit: the desk
    /// bounds how much it asks.
    const std::shared_ptr<Answers> answers_ = std::make_shared<Answers>(0);
    std::mutex mutex_;  ///< of all that follows; it is never held in a call to others
    PullPoints points_;
    PullPoints::Due due_;
    std::map<std::string, Camera> cameras_;
    std::string last_asked_;                ///< of them
    std::map<std::string, TimeNs> pulses_;  ///< of inputs; when they end, or 0
    std::size_t fetches_ = 0;
    /// Counted up when the first client subscribes, and when pictures are wanted again: what the rig answers to
    /// questions of an earlier round is ignored.
    std::uint64_t round_ = 0, picture_round_ = 0;
    TimeNs next_look_ns_ = 0, next_wait_ns_ = 0;
    bool lists_ = false, waits_ = false;
    std::optional<std::uint64_t> last_event_;
    std::thread thread_;
};

}  // namespace camrig::onvif

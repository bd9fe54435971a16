#include <chrono>
#include <future>
#include <list>
#include <mutex>
#include <set>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pthread.h>

#include "control/onvif/event_desk.h"

namespace camrig::onvif {
namespace {

using testing::HasSubstr;
using Kind = EventMessage::Kind;

EventTopics only(EventTopic topic) {
    return EventTopics().set(static_cast<std::size_t>(topic));
}

Answered<EventTopics> filtered(const std::string& inside) {
    pugi::xml_document document;
    EXPECT_TRUE(parse_xml("<Filter>" + inside + "</Filter>", document));
    return read_filter(XmlElement(document).first_child());
}

Answered<EventTopics> named(const std::string& expression) {
    return filtered("<TopicExpression>" + expression + "</TopicExpression>");
}

TEST(OnvifTopics, ExpressionsNameTopicsSubtreesAndSeveral) {
    EXPECT_EQ(*filtered(""), EventTopics().set());
    EXPECT_EQ(*named("tns1:VideoSource/MotionAlarm"), only(EventTopic::motion));
    EXPECT_EQ(*named(" tns1:RuleEngine/tns1:TamperDetector/Tamper | x:Device//. "),
              only(EventTopic::tamper) | only(EventTopic::digital_input));
    EXPECT_EQ(named("tns1:VideoSource//.")->count(), 5U);
    EXPECT_EQ(*named("tns1:VideoSource/*"), only(EventTopic::motion)) << "the others are deeper";
    EXPECT_EQ(named("tns1:VideoSource").error().subcode, "wsnt:TopicNotSupportedFault") << "no topic itself";
    EXPECT_EQ(named("tns1:AudioAnalytics//.").error().subcode, "wsnt:TopicNotSupportedFault");
    EXPECT_EQ(named(std::string(1025, 'a')).error().subcode, "wsnt:InvalidTopicExpressionFault");
    EXPECT_EQ(filtered("<MessageContent/>").error().subcode, "wsnt:InvalidFilterFault");
    EXPECT_EQ(filtered("<TopicExpression Dialect='urn:x'>tns1:Device//.</TopicExpression>").error().subcode,
              "wsnt:TopicExpressionDialectUnknownFault");
}

class Points : public testing::Test {
protected:
    using Got = std::vector<std::pair<bool, Kind>>;
    static constexpr TimeNs second = ns_per_s;

    std::uint64_t subscribe(const std::string& device, EventTopics topics = EventTopics().set(),
                            TimeNs life_ns = 100 * second) {
        return points.subscribe(device, topics, life_ns, now)->number;
    }
    void tell(const std::string& source, bool state, EventTopic topic = EventTopic::motion) {
        points.tell({topic, source}, state, 0, due);
        call();
    }
    /// The answer is in `answers` when it comes.
    void pull(const std::string& device, std::uint64_t number, TimeNs wait_ns, std::size_t limit = 100) {
        points.pull(
            device, number, wait_ns, limit, now,
            [this](const Answered<PullPoints::Pulled>& pulled) { answers.push_back(pulled); }, due);
        call();
    }
    Got pulled(const std::string& device, std::uint64_t number, std::size_t limit = 100) {
        answers.clear();
        pull(device, number, 0, limit);
        Got got;
        for (const EventMessage& message : answers.at(0)->messages) got.emplace_back(message.state, message.kind);
        return got;
    }
    void pass(TimeNs ns) {
        now += ns;
        points.expire(now, due);
        call();
    }
    void call() {
        for (const auto& answer : std::exchange(due, {})) answer();
    }

    PullPoints points;
    PullPoints::Due due;
    TimeNs now = 1000 * second;
    std::vector<Answered<PullPoints::Pulled>> answers;
};

TEST_F(Points, WhatIsSoComesFirstAndThenOnlyChanges) {
    const auto early = subscribe("");
    tell("hall", false);
    tell("hall", false);
    tell("hall", true);
    EXPECT_EQ(pulled("", early), (Got{{false, Kind::initialized}, {true, Kind::changed}}));
    const auto late = subscribe("hall");
    EXPECT_EQ(pulled("hall", late), (Got{{true, Kind::initialized}}));
    EXPECT_EQ(pulled("hall", late), Got{});
    EXPECT_TRUE(points.synchronize("hall", late, now, 0, due));
    EXPECT_EQ(pulled("hall", late), (Got{{true, Kind::initialized}}));
    points.forget("hall", 0, due);
    EXPECT_EQ(pulled("hall", late), (Got{{true, Kind::deleted}}));
}

TEST_F(Points, ADeviceTellsOfItsCameraAndOfInputsAndWhatWasAskedFor) {
    const auto hall = subscribe("hall"), inputs = subscribe("", only(EventTopic::digital_input));
    tell("lobby", true);
    tell("alarm", true, EventTopic::digital_input);
    EXPECT_EQ(pulled("hall", hall).size(), 1U);
    tell("hall", true);
    EXPECT_EQ(pulled("hall", hall).size(), 1U);
    EXPECT_EQ(pulled("", inputs).size(), 1U);
    EXPECT_TRUE(points.wanted("lobby").test(static_cast<std::size_t>(EventTopic::digital_input)));
    EXPECT_FALSE(points.wanted("lobby").test(static_cast<std::size_t>(EventTopic::motion)));
    EXPECT_TRUE(points.wanted("hall").test(static_cast<std::size_t>(EventTopic::motion)));
}

TEST_F(Points, APullWaitsForAMessageOrItsTimeOrTheNextPull) {
    const auto number = subscribe("");
    pull("", number, 10 * second);
    pass(9 * second);
    EXPECT_TRUE(answers.empty());
    tell("hall", true);
    ASSERT_EQ(answers.size(), 1U);
    EXPECT_EQ(answers[0]->messages.size(), 1U);
    pull("", number, 10 * second);
    EXPECT_EQ(points.next_ns(), now + 10 * second);
    pass(10 * second);
    ASSERT_EQ(answers.size(), 2U);
    EXPECT_TRUE(answers[1]->messages.empty());
    pull("", number, 10 * second);
    pull("", number, 10 * second);
    ASSERT_EQ(answers.size(), 3U) << "that of a connection that broke";
    tell("hall", false);
    ASSERT_EQ(answers.size(), 4U);
    EXPECT_EQ(answers[3]->messages.size(), 1U);
    pull("", number, 3600 * second);
    EXPECT_EQ(points.next_ns(), now + PullPoints::max_pull_ns);
    points.end(due);
    call();
    EXPECT_EQ(answers.size(), 5U);
}

TEST_F(Points, APullWhoseSubscriptionEndsFirstIsAnswered) {
    const auto number = subscribe("");
    pull("", number, 60 * second);
    ASSERT_TRUE(points.renew("", number, 10 * second, now));
    pass(10 * second);
    EXPECT_EQ(answers.size(), 1U);
}

TEST_F(Points, WhatInputsWereIsForgottenWhenNobodyHearsThem) {
    subscribe("", picture_topics());
    const auto inputs = subscribe("", only(EventTopic::digital_input));
    tell("alarm", true, EventTopic::digital_input);
    EXPECT_TRUE(points.unsubscribe("", inputs, now, due));
    const auto again = subscribe("", only(EventTopic::digital_input));
    EXPECT_EQ(pulled("", again), Got{}) << "it may be otherwise by now";
}

TEST_F(Points, AnAnswerHasNoMoreMessagesThanAskedForAndTheRestWaits) {
    const auto number = subscribe("");
    for (const char* camera : {"a", "b", "c"}) tell(camera, true);
    EXPECT_EQ(pulled("", number, 2).size(), 2U);
    EXPECT_EQ(pulled("", number, 2).size(), 1U);
    for (std::size_t i = 0; i < PullPoints::max_messages + 10; ++i) tell("a", i % 2 == 1);
    EXPECT_EQ(pulled("", number, 10'000).size(), PullPoints::max_messages);
}

TEST_F(Points, SubscriptionsEndUnlessTheyAreRenewedOrPulled) {
    const auto number = subscribe("", EventTopics().set(), 10 * second);
    pass(9 * second);
    EXPECT_EQ(*points.renew("", number, 20 * second, now), now + 20 * second);
    EXPECT_FALSE(points.renew("hall", number, second, now)) << "of another device";
    pass(19 * second);
    EXPECT_EQ(pulled("", number), Got{});
    pass(PullPoints::default_life_ns - 1);
    EXPECT_FALSE(points.empty());
    tell("hall", true);
    pass(1);
    EXPECT_TRUE(points.empty());
    EXPECT_EQ(points.renew("", number, second, now).error().subcode, "wsrf-rw:ResourceUnknownFault");
    pull("", number, second);
    EXPECT_FALSE(answers.back());
    EXPECT_EQ(pulled("", subscribe("")), Got{}) << "what was so before nobody watched";
    EXPECT_LE(points.subscribe("", EventTopics().set(), 1000 * PullPoints::max_life_ns, now)->ends_ns,
              now + PullPoints::max_life_ns);
}

TEST_F(Points, TheyAreBoundedAndEndingOneMakesRoom) {
    std::uint64_t last = 0;
    for (std::size_t i = 0; i < PullPoints::max_per_device; ++i) last = subscribe("");
    EXPECT_FALSE(points.subscribe("", EventTopics().set(), second, now));
    EXPECT_TRUE(points.unsubscribe("hall", subscribe("hall"), now, due)) << "which has places of its own";
    pull("", last, 10 * second);
    EXPECT_TRUE(points.unsubscribe("", last, now, due));
    call();
    EXPECT_EQ(answers.size(), 1U) << "nobody waits for what is gone";
    EXPECT_FALSE(points.unsubscribe("", last, now, due));
    EXPECT_TRUE(points.subscribe("", EventTopics().set(), second, now));
}

TEST_F(Points, TheRigHasABoundBesideThatOfItsDevices) {
    for (std::size_t i = 0; i < PullPoints::max_subscriptions; ++i)
        subscribe("camera" + std::to_string(i / PullPoints::max_per_device));
    EXPECT_FALSE(points.subscribe("another", EventTopics().set(), second, now));
}

TEST_F(Points, AllThatIsSoFitsHoweverManyCamerasThereAre) {
    const auto early = subscribe("");
    const std::size_t cameras = 2 * PullPoints::max_messages;
    for (std::size_t i = 0; i < cameras; ++i) tell("camera" + std::to_string(i), true);
    const auto all = [&](std::uint64_t number) {
        std::size_t count = 0;
        for (std::size_t got = 1; got != 0; count += got) got = pulled("", number, 10'000).size();
        return count;
    };
    EXPECT_EQ(all(early), cameras);
    EXPECT_EQ(all(subscribe("")), cameras);
    EXPECT_TRUE(points.synchronize("", early, now, 0, due));
    EXPECT_EQ(all(early), cameras);
}

/// A picture of one grey, with a square of white at its left edge and stripes that give it edges.
class Watched : public testing::Test {
protected:
    static constexpr ImageSize size{128, 72};
    const PictureFacts& see(int grey, int square = 0, bool stripes = true, int left = 0) {
        std::vector<std::byte> rgba(static_cast<std::size_t>(size.width * size.height) * 4, std::byte{255});
        for (int y = 0; y < size.height; ++y)
            for (int x = 0; x < size.width; ++x) {
                const bool is_in = x >= left && x < left + square && y < square;
                const bool is_striped = stripes && y >= 60 && x % 8 == 0;
                const int level = is_in ? 255 : std::clamp(grey + (is_striped ? 20 : 0), 0, 255);
                for (std::size_t c = 0; c < 3; ++c)
                    rgba[static_cast<std::size_t>(y * size.width + x) * 4 + c] = static_cast<std::byte>(level);
            }
        now += ns_per_s / 2;
        return watch.see(rgba, size, now);
    }
    PictureWatch watch;
    TimeNs now = 0;
};

TEST_F(Watched, MotionIsAChangeOfCellsAndHeldForTwoSeconds) {
    EXPECT_EQ(see(100, 10), PictureFacts{});
    EXPECT_EQ(see(100, 10), PictureFacts{});
    EXPECT_TRUE(see(100, 10, true, 20).motion);
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(see(100, 10, true, 20).motion) << i;
    EXPECT_FALSE(see(100, 10, true, 20).motion);
    EXPECT_FALSE(see(104, 10, true, 20).motion) << "the light changes a little";
    EXPECT_FALSE(see(104, 1, true, 20).scene_change);
    now = 0;
    EXPECT_FALSE(see(200).motion) << "the world began anew";
}

TEST_F(Watched, APictureThatChangesAllOverIsAnotherScene) {
    see(100);
    EXPECT_TRUE(see(140).scene_change);
    EXPECT_FALSE(see(140, 30).too_bright);
    for (int i = 0; i < 3; ++i) see(140, 30);
    EXPECT_FALSE(see(140, 30).scene_change);
}

TEST_F(Watched, DarkBrightAndBlurryAreOfThePictureItself) {
    EXPECT_TRUE(see(10).too_dark);
    EXPECT_TRUE(see(26).too_dark) << "hysteresis";
    EXPECT_FALSE(see(40).too_dark);
    EXPECT_TRUE(see(245).too_bright);
    EXPECT_TRUE(see(226).too_bright) << "hysteresis";
    EXPECT_FALSE(see(200).too_bright);
    EXPECT_FALSE(see(100).too_blurry);
    EXPECT_TRUE(see(100, 0, false).too_blurry);
    EXPECT_FALSE(see(10, 0, false).too_blurry) << "nothing is said of what is too dark";
}

/// A rig of one camera whose picture turns white, and with an event for each that is waited for.
class WatchedRig final : public engine::CommandPort, public stream::FrameFetcher {
public:
    void post(engine::Command command) override {
        std::visit([this](auto& request) { answer(request); }, command);
    }
    void fetch(stream::FetchRequest request, std::function<void(Result<stream::MediaUnit>)> done) override {
        const int made = ++fetched;
        frame::FrameInfo info;
        info.camera = std::make_shared<const std::string>(request.camera);
        info.size = {64, 36};
        info.world_ns = made * ns_per_s;
        std::vector<std::byte> bytes(64 * 36 * 4, made == 1 ? std::byte{0} : std::byte{255});
        stream::MediaUnit unit;
        unit.info = info;
        unit.frame = std::make_shared<const frame::Frame>(info, std::move(bytes));
        done(std::move(unit));
    }
    std::atomic<int> fetched = 0, asked = 0, begun = 0;  ///< begun: asked where the log of events ends
    std::vector<std::string> cameras{"hall"};

private:
    void answer(engine::Request<engine::ListCameras>& request) {
        ++asked;
        std::vector<engine::CameraReply> all;
        for (const std::string& name : cameras) {
            world::CameraSpec spec;
            spec.name = name;
            all.emplace_back().camera = world::Camera(std::move(spec));
        }
        request.done(std::move(all));
    }
    void answer(engine::Request<engine::WaitEvents>& request) {
        ++asked;
        if (request.command.timeout_ns == 0) {
            ++begun;
            return request.done(engine::EventLog{{}, 7, 0});
        }
        if (request.command.since > 7) return;  // nothing more happens
        world::EventRecord record;
        record.sequence = 8;
        record.event = "door";
        request.done(engine::EventLog{{record}, 8, 0});
    }
    template <typename C>
    void answer(engine::Request<C>&) {
        ADD_FAILURE() << "nothing else is asked";
    }
};

class Desk : public testing::Test {
protected:
    /// Pulls until a message of this kind about this topic is so, or not.
    bool hears(std::uint64_t number, EventTopic topic, bool state) {
        for (int i = 0; i < 100; ++i) {
            std::promise<std::vector<EventMessage>> got;
            desk.pull("", number, 10 * ns_per_s, 100, [&](const Answered<PullPoints::Pulled>& pulled) {
                got.set_value(pulled ? pulled->messages : std::vector<EventMessage>());
            });
            for (const EventMessage& message : got.get_future().get())
                if (message.property.topic == topic && message.state == state) return true;
        }
        return false;
    }
    WatchedRig rig;
    EventDesk desk{rig, rig};
};

TEST_F(Desk, PicturesAndSceneEventsBecomeMessages) {
    const auto number = desk.subscribe("", EventTopics().set(), 60 * ns_per_s)->number;
    EXPECT_TRUE(hears(number, EventTopic::too_dark, true));
    EXPECT_TRUE(hears(number, EventTopic::too_dark, false));
    const auto again = desk.subscribe("", only(EventTopic::digital_input), 60 * ns_per_s)->number;
    EXPECT_TRUE(hears(again, EventTopic::digital_input, false)) << "the pulse of the first message ends";
}

TEST_F(Desk, NothingIsAskedOfTheRigWhileNobodySubscribes) {
    EXPECT_EQ(rig.asked, 0);
    const auto inputs = desk.subscribe("", only(EventTopic::digital_input), 60 * ns_per_s)->number;
    EXPECT_TRUE(hears(inputs, EventTopic::digital_input, true));
    EXPECT_EQ(rig.fetched, 0) << "nor a picture while nobody wants one";
    const auto motion = desk.subscribe("hall", only(EventTopic::motion), 60 * ns_per_s)->number;
    EXPECT_TRUE(desk.unsubscribe("", inputs));
    std::promise<void> told;
    desk.pull("hall", motion, 10 * ns_per_s, 1, [&](const auto&) { told.set_value(); });
    told.get_future().wait();
    EXPECT_TRUE(desk.unsubscribe("hall", motion));
    const int before = rig.fetched;
    const auto pulse = desk.subscribe("", only(EventTopic::digital_input), 60 * ns_per_s)->number;
    EXPECT_TRUE(hears(pulse, EventTopic::digital_input, false)) << "which takes a second";
    EXPECT_LE(rig.fetched, before + 1) << "one that was asked for already";
}

TEST_F(Desk, WhatAPictureSaidIsForgottenWhenNobodyWantsPictures) {
    const auto inputs = desk.subscribe("", only(EventTopic::digital_input), 60 * ns_per_s)->number;
    const auto pictures = desk.subscribe("", picture_topics(), 60 * ns_per_s)->number;
    EXPECT_TRUE(hears(pictures, EventTopic::too_dark, false)) << "the first is black, all others are white";
    EXPECT_TRUE(desk.unsubscribe("", pictures));
    EXPECT_TRUE(hears(inputs, EventTopic::digital_input, false)) << "which takes a second";
    rig.fetched = 0;  // the next is black again
    const auto again = desk.subscribe("", picture_topics(), 60 * ns_per_s)->number;
    std::promise<std::vector<EventMessage>> first;
    desk.pull("", again, 10 * ns_per_s, 100, [&](const auto& pulled) { first.set_value(pulled->messages); });
    for (const EventMessage& message : first.get_future().get()) {
        EXPECT_EQ(message.kind, EventMessage::Kind::initialized);
        EXPECT_EQ(message.state, message.property.topic == EventTopic::too_dark) << "of the picture of now";
    }
}

TEST_F(Desk, SceneEventsOfBeforeAreNotToldToWhoSubscribesLater) {
    desk.subscribe("", picture_topics(), 60 * ns_per_s);
    const auto inputs = desk.subscribe("", only(EventTopic::digital_input), 60 * ns_per_s)->number;
    EXPECT_TRUE(hears(inputs, EventTopic::digital_input, true));
    EXPECT_TRUE(desk.unsubscribe("", inputs));
    EXPECT_EQ(rig.begun, 1);
    desk.subscribe("", only(EventTopic::digital_input), 60 * ns_per_s);
    for (int i = 0; i < 1000 && rig.begun < 2; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_EQ(rig.begun, 2) << "from where the log ends then";
}

/// Pictures take long: each is there after most of a look's period.
class SlowPictures final : public stream::FrameFetcher {
public:
    explicit SlowPictures(WatchedRig& rig) : rig_(rig) {}
    void fetch(stream::FetchRequest request, std::function<void(Result<stream::MediaUnit>)> done) override {
        const std::lock_guard lock(mutex_);
        seen_.insert(request.camera);
        threads_.emplace_back([this, request = std::move(request), done = std::move(done)]() mutable {
            std::this_thread::sleep_for(std::chrono::milliseconds(400));
            rig_.fetch(std::move(request), std::move(done));
        });
    }
    std::size_t seen() {
        const std::lock_guard lock(mutex_);
        return seen_.size();
    }

private:
    WatchedRig& rig_;
    std::mutex mutex_;
    std::set<std::string> seen_;
    std::list<std::jthread> threads_;
};

TEST_F(Desk, EveryCameraHasItsTurnWherePicturesTakeLong) {
    rig.cameras.clear();
    for (char name = 'a'; name <= 'p'; ++name) rig.cameras.emplace_back(1, name);
    SlowPictures pictures(rig);
    EventDesk busy{rig, pictures};
    busy.subscribe("", picture_topics(), 60 * ns_per_s);
    for (int i = 0; i < 1000 && pictures.seen() < rig.cameras.size(); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_EQ(pictures.seen(), rig.cameras.size());
    busy.stop();
}

/// Answers the first question about events late, right after that of the next round.
class LateRig final : public engine::CommandPort {
public:
    explicit LateRig(WatchedRig& rig) : rig_(rig) {}
    void post(engine::Command command) override {
        auto* wait = std::get_if<engine::Request<engine::WaitEvents>>(&command);
        if (!wait || rounds > 1) return rig_.post(std::move(command));
        if (++rounds == 1) {
            late_ = std::move(wait->done);
            return asked.set_value();
        }
        rig_.post(std::move(command));
        late_(engine::EventLog{{}, 3, 0});
    }
    std::promise<void> asked;
    int rounds = 0;

private:
    WatchedRig& rig_;
    std::function<void(Result<engine::EventLog>)> late_;
};

TEST_F(Desk, AnAnswerOfAnEarlierRoundTakesNoPlaceOfALaterOne) {
    LateRig late(rig);
    EventDesk slow{late, rig};
    const EventTopics inputs = only(EventTopic::digital_input);
    const auto first = slow.subscribe("", inputs, 60 * ns_per_s)->number;
    late.asked.get_future().wait();
    EXPECT_TRUE(slow.unsubscribe("", first));
    const auto next = slow.subscribe("", inputs, 60 * ns_per_s)->number;
    std::promise<std::size_t> told;
    slow.pull("", next, 5 * ns_per_s, 1, [&](const auto& pulled) { told.set_value(pulled->messages.size()); });
    EXPECT_EQ(told.get_future().get(), 1U);
}

TEST_F(Desk, WithoutAThreadASubscriptionIsRefused) {
    pthread_attr_t before, huge;
    ASSERT_EQ(::pthread_getattr_default_np(&before), 0);
    ASSERT_EQ(::pthread_attr_init(&huge), 0);
    ASSERT_EQ(::pthread_attr_setstacksize(&huge, std::size_t{1} << 48), 0);
    ASSERT_EQ(::pthread_setattr_default_np(&huge), 0);
    const auto made = desk.subscribe("", EventTopics().set(), ns_per_s);
    EXPECT_EQ(::pthread_setattr_default_np(&before), 0);
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().subcode, "wsnt:SubscribeCreationFailedFault");
    EXPECT_TRUE(desk.subscribe("", EventTopics().set(), ns_per_s)) << "the next one may have it";
}

TEST_F(Desk, APullThatWaitsIsAnsweredWhenTheRigEnds) {
    const auto number = desk.subscribe("nowhere", only(EventTopic::motion), 60 * ns_per_s)->number;
    std::promise<bool> answered;
    desk.pull("nowhere", number, 60 * ns_per_s, 1,
              [&](const Answered<PullPoints::Pulled>& pulled) { answered.set_value(pulled.has_value()); });
    desk.stop();
    EXPECT_TRUE(answered.get_future().get());
    EXPECT_FALSE(desk.subscribe("", EventTopics().set(), ns_per_s));
}

}  // namespace
}  // namespace camrig::onvif

#include "control/onvif/onvif_output.h"

#include <deque>
#include <tuple>

#include <gtest/gtest.h>

#include "core/base/tcp_listener.h"
#include "core/stream/local_frame_bus.h"

namespace camrig::onvif {
namespace {

/// Doors that open and close when the test says so, in the order of the calls.
class OnvifPortsTest : public testing::Test {
protected:
    void show(const std::string& camera, const std::vector<std::uint16_t>& wished) {
        std::vector<OutputSpec> all;
        for (const std::uint16_t port : wished) all.push_back({.kind = "onvif", .options = {{"port", port}}});
        const stream::CameraStream stream{CameraId{camera == "one" ? 1U : 2U}, camera, {64, 48}, {}, all};
        bus.find(camera) ? bus.change_camera(stream) : bus.add_camera(stream);
    }
    void work() {
        for (; !waiting.empty(); waiting.pop_front()) waiting.front()();
    }

    using Told = std::vector<std::tuple<std::string, std::uint16_t, bool>>;
    bool can_open = true;
    std::set<std::pair<std::string, std::uint16_t>> open;
    std::deque<std::function<void()>> waiting;
    Told told;
    stream::LocalFrameBus bus{{1, std::make_shared<frame::FramePool>()}};
    std::shared_ptr<DevicePorts> ports = std::make_shared<DevicePorts>("127.0.0.1");
    OnvifPorts outputs{bus,
                       ports,
                       {.open =
                            [this](const std::string& camera, std::uint16_t port, OnvifPorts::Done done) {
                                waiting.push_back([=, this] {
                                    if (can_open) open.emplace(camera, port);
                                    done(can_open);
                                });
                            },
                        .close =
                            [this](const std::string& camera, std::uint16_t port, OnvifPorts::Done done) {
                                waiting.push_back([=, this] { done(open.erase({camera, port}) > 0); });
                            },
                        .tell = [this](const std::string& camera, std::uint16_t port,
                                       bool is_there) { told.emplace_back(camera, port, is_there); }}};
};

TEST_F(OnvifPortsTest, WhoGoesBeforeItsPortIsOpenIsToldOfAfterwardsAsGone) {
    show("one", {8081});
    show("one", {});
    EXPECT_TRUE(told.empty()) << "nothing has been done yet";
    work();
    EXPECT_EQ(told, (Told{{"one", 8081, true}, {"one", 8081, false}}));
    EXPECT_TRUE(open.empty());
}

TEST_F(OnvifPortsTest, APortThatCannotBeOpenedIsNeverToldOf) {
    can_open = false;
    show("one", {8081});
    show("one", {});
    work();
    EXPECT_TRUE(told.empty());
}

TEST_F(OnvifPortsTest, APortIsTheRigsFromTheWishToOpenItUntilItIsClosed) {
    const auto other = listen_tcp({.host = "127.0.0.1"});
    ASSERT_TRUE(other);
    const std::uint16_t port = other->port;
    EXPECT_FALSE(ports->check(port)) << "another program has it";
    show("one", {port});
    EXPECT_TRUE(ports->check(port)) << "as good as open";
    work();
    show("one", {});
    show("two", {port});
    EXPECT_TRUE(ports->check(port)) << "about to be closed";
    work();
    EXPECT_TRUE(ports->check(port)) << "the second camera's, although the first has closed it";
    show("two", {});
    work();
    EXPECT_FALSE(ports->check(port)) << "another program has it";

    can_open = false;
    show("one", {port});
    work();
    EXPECT_FALSE(ports->check(port)) << "it could not be opened";
}

}  // namespace
}  // namespace camrig::onvif

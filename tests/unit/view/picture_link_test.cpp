#include "tools/view/picture_link.h"

#include <camrig/client.h>
#include <gtest/gtest.h>

#include "core/codec/encoder.h"
#include "tests/unit/control/server_harness.h"
#include "tests/unit/frame/test_pictures.h"

namespace camrig::view {
namespace {

using control::eventually;

constexpr client::Size window{64, 48};

/// A rig whose cameras show noise.
struct Shown {
    Shown() {
        auto encoder = codec::create_jpeg_encoder(90).value();
        harness.rig.set_picture(*encoder->encode(frame::test::noise({window.width, window.height})).value());
    }
    client::Rig connect() { return client::connect({.control = harness.path, .token = {}}); }

    control::ServerHarness harness;
};

FlyCamera at(double x) {
    FlyCamera from;
    from.position.x = x;
    return from;
}

// A pause between a move and the instant that shows it: no picture comes, and the camera is still there.
TEST(PictureLink, AfterAPictureThatDidNotComeTheWorldIsShownAgain) {
    Shown shown;
    PictureLink link(shown.connect(), "eye", [] {});
    ASSERT_TRUE(eventually([&] { return link.take_world().has_value(); }));
    shown.harness.rig.miss_picture();
    link.look(at(5), window);
    std::optional<WorldPicture> world;
    ASSERT_TRUE(eventually([&] { return (world = link.take_world()).has_value(); }));
    EXPECT_EQ(world->pose.position.x, 5);
}

// An answer that was lost: the camera is made, and the window does not know.
TEST(PictureLink, ACameraThatIsThereAlreadyIsTakenAndMoved) {
    Shown shown;
    const client::Rig rig = shown.connect();
    rig.create_camera("eye", {.size = window});
    PictureLink link(shown.connect(), "eye", [] {});
    link.look(at(5), window);
    EXPECT_TRUE(eventually([&] { return rig.camera("eye").get().pose.position[0] == 5; }));
    EXPECT_TRUE(eventually([&] { return link.take_world().has_value(); }));
}

TEST(PictureLink, ACameraThatSomebodyDeletesIsMadeAgain) {
    Shown shown;
    const client::Rig rig = shown.connect();
    PictureLink link(shown.connect(), "eye", [] {});
    ASSERT_TRUE(eventually([&] { return link.take_world().has_value(); }));
    rig.camera("eye").remove();
    EXPECT_TRUE(eventually([&] { return rig.cameras().size() == 1; }));
    EXPECT_TRUE(eventually([&] { return link.take_world().has_value(); }));
}

}  // namespace
}  // namespace camrig::view

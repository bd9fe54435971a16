#include "rtsp_out/http/route.h"

#include <gtest/gtest.h>

namespace camrig::http {
namespace {

Result<StreamParams> stream_of(const std::string& query) {
    return stream_params(*parse_target("/s?" + query));
}

Result<LiveParams> live_of(const std::string& query) {
    return live_params(*parse_target("/live?" + query));
}

TEST(Route, LiveTakesCamerasAWidthARateAndAQuality) {
    const auto all = live_of("cameras=lobby,hall&width=320&fps=15&quality=70");
    ASSERT_TRUE(all);
    EXPECT_EQ(all->cameras, (std::vector<std::string>{"lobby", "hall"}));
    EXPECT_EQ(all->width, 320);
    EXPECT_EQ(*all->rate, *Rate::create(15, 1));
    EXPECT_EQ(all->quality, 70);
    EXPECT_EQ(live_of("cameras=lobby&t=1")->width, 0);
    for (const char* bad : {"", "cameras=", "cameras=a,", "cameras=a,a", "cameras=A", "cameras=a&width=321",
                            "cameras=a&width=0", "cameras=a&fps=0", "cameras=a&quality=101", "cameras=a&size=1"})
        EXPECT_EQ(live_of(bad).error().kind, ErrorKind::invalid_argument) << bad;
    std::string many = "cameras=c0";
    for (std::size_t i = 1; i < max_live_cameras; ++i) many += ",c" + std::to_string(i);
    EXPECT_TRUE(live_of(many));
    EXPECT_FALSE(live_of(many + ",one_more"));
}

TEST(Route, EveryPathOfTheContractIsKnown) {
    EXPECT_EQ(route_of("/")->kind, RouteKind::file);
    EXPECT_EQ(route_of("/cameras")->kind, RouteKind::cameras);
    EXPECT_EQ(route_of("/live")->kind, RouteKind::live);
    EXPECT_EQ(route_of("/rpc")->kind, RouteKind::rpc);
    EXPECT_EQ(route_of("/healthz")->kind, RouteKind::healthz);
    EXPECT_EQ(route_of("/metrics")->kind, RouteKind::metrics);
    EXPECT_EQ(route_of("/cameras/lobby/stream.mjpg")->kind, RouteKind::stream);
    EXPECT_EQ(route_of("/cameras/lobby/stream.mjpg")->camera, "lobby");
    EXPECT_EQ(route_of("/cameras/lobby/snapshot.jpg")->codec, codec::Codec::jpeg);
    EXPECT_EQ(route_of("/cameras/lobby/snapshot.png")->codec, codec::Codec::png);
    EXPECT_EQ(route_of("/cameras/lobby/depth.png")->frame, frame::FrameKind::depth);
    EXPECT_EQ(route_of("/cameras/lobby/depth.npy")->kind, RouteKind::floats);
    EXPECT_EQ(route_of("/cameras/lobby/instance.png")->frame, frame::FrameKind::instance);
    EXPECT_EQ(route_of("/cameras/lobby/truth")->kind, RouteKind::truth);
}

TEST(Route, AllButThePageAndItsCallsIsGuardedFromOtherPages) {
    for (const auto& paths : {rig_paths(), camera_paths()})
        for (const HttpPath& one : paths) {
            EXPECT_EQ(one.is_guarded, one.path != "/" && one.path != "/rpc") << one.path;
            EXPECT_EQ(one.takes_post, one.path == "/rpc") << one.path;
        }
    EXPECT_FALSE(route_of("/app.js")->is_guarded);
}

TEST(Route, OtherPathsBelowCamerasAreNotFoundAndTheErrorSaysWhatThereIs) {
    for (const char* path :
         {"/cameras/", "/cameras/lobby", "/cameras/lobby/", "/cameras//stream.mjpg", "/cameras/LOBBY/truth",
          "/cameras/lobby/stream.mjpg/", "/cameras/a/b/c", "/cameras/lobby/video"}) {
        const auto route = route_of(path);
        ASSERT_FALSE(route) << path;
        EXPECT_EQ(route.error().kind, ErrorKind::not_found);
    }
    EXPECT_NE(route_of("/cameras/lobby/video").error().message.find("stream.mjpg"), std::string::npos);
}

TEST(Route, StreamParametersAreChecked) {
    EXPECT_FALSE(stream_of("")->rate);
    EXPECT_FALSE(stream_of("")->quality);
    EXPECT_EQ(*stream_of("fps=30000/1001")->rate, *Rate::create(30000, 1001));
    EXPECT_EQ(*stream_of("fps=0.5&quality=1&token=x&t=123")->rate, *Rate::create(1, 2));
    for (const char* bad : {"fps=0", "fps=x", "fps=", "fps=2000", "fps=-1", "quality=0", "quality=101", "quality=5x",
                            "quality=", "width=3"})
        EXPECT_FALSE(stream_of(bad)) << bad;
    EXPECT_NE(stream_of("width=3").error().message.find("fps, quality"), std::string::npos);
}

TEST(Route, PicturesAskTheFetcherForTheRightThing) {
    const auto jpeg =
        fetch_request(*route_of("/cameras/a/snapshot.jpg"), *parse_target("/x?quality=40&min_ns=4000000000"));
    ASSERT_TRUE(jpeg);
    EXPECT_EQ(jpeg->camera, "a");
    EXPECT_EQ(jpeg->min_ns, 4'000'000'000);
    EXPECT_EQ(jpeg->format.codec, codec::Codec::jpeg);
    EXPECT_EQ(jpeg->format.quality, 40);
    const auto depth = fetch_request(*route_of("/cameras/a/depth.npy"), *parse_target("/x"));
    EXPECT_EQ(depth->kind, frame::FrameKind::depth);
    EXPECT_EQ(depth->format.codec, codec::Codec::raw);
    EXPECT_EQ(depth->format.pixels, frame::PixelFormat::depth32f);
    const auto png = fetch_request(*route_of("/cameras/a/instance.png"), *parse_target("/x"));
    EXPECT_EQ(png->kind, frame::FrameKind::instance);
    EXPECT_EQ(png->format.quality, 0);
    EXPECT_FALSE(fetch_request(*route_of("/cameras/a/snapshot.png"), *parse_target("/x?quality=40")));
    EXPECT_FALSE(fetch_request(*route_of("/cameras/a/snapshot.png"), *parse_target("/x?min_ns=-1")));
    EXPECT_FALSE(fetch_request(*route_of("/cameras/a/snapshot.png"), *parse_target("/x?min_ns=99999999999999999999")));
}

}  // namespace
}  // namespace camrig::http

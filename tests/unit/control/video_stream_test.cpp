#include "control/onvif/video_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/output_family.h"
#include "rtsp_out/rtsp/rtsp_output.h"

namespace camrig::onvif {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class StreamWishes : public testing::Test {
protected:
    StreamWishes() {
        camera_.name = "dome";
        camera_.size = {640, 480};
        camera_.rate = *Rate::create(30'000, 1001);
    }

    /// The options of the output that fulfils the wish, or what is wrong with it.
    json options(const StreamWish& wish, const VideoStream& stream, bool has_h265 = true) {
        auto output = output_for(camera_, stream, wish, has_h265);
        return output ? output->options : json(output.error().message);
    }
    VideoStream main() const { return {.size = camera_.size, .rate = camera_.rate, .bitrate_kbps = 1381}; }
    VideoStream sub() const {
        return {.ending = "sub", .size = {320, 240}, .rate = *Rate::create(15'000, 1001), .bitrate_kbps = 200};
    }

    world::CameraSpec camera_;
};

TEST_F(StreamWishes, WhatIsAsItWasIsNotWritten) {
    EXPECT_EQ(options({}, main()), json::object());
    EXPECT_EQ(options({}, sub()), json::parse(R"({"stream": "sub"})"));
    // As one service tells the rate, and as the other does.
    for (const double told : {15.0, 14.985015}) {
        const StreamWish same{.codec = "h264",
                              .size = ImageSize{320, 240},
                              .frame_rate = told,
                              .bitrate_kbps = 200,
                              .gov_length = 30,
                              .profile = "main",
                              .quality = 100,
                              .told_rate = told};
        EXPECT_EQ(options(same, sub()), json::parse(R"({"stream": "sub"})"));
    }
}

TEST_F(StreamWishes, ARateIsTheShareOfTheCamerasThatItIsNear) {
    EXPECT_EQ(options({.frame_rate = 14.985015, .told_rate = 29.97003}, main())["fps"], "15000/1001");
    EXPECT_EQ(options({.frame_rate = 10, .told_rate = 30}, main())["fps"], 10);
    EXPECT_EQ(options({.frame_rate = 29.97003, .told_rate = 15}, sub())["fps"], "30000/1001");
    EXPECT_THAT(options({.frame_rate = 31, .told_rate = 30}, main()).dump(), HasSubstr("at most 30000/1001"));
    EXPECT_TRUE(options({.frame_rate = 0, .told_rate = 30}, main()).is_string());
}

TEST_F(StreamWishes, GovLengthIsInPicturesOfTheNewRate) {
    const json made = options({.frame_rate = 10, .gov_length = 5, .told_rate = 30}, main());
    EXPECT_EQ(made["key_interval_s"], 0.5);
    EXPECT_THAT(options({.gov_length = 0}, main()).dump(), HasSubstr("GovLength is 1 to 1798"));
    EXPECT_TRUE(options({.gov_length = 1.5}, main()).is_string());
    EXPECT_NEAR(options({.gov_length = 1798}, main())["key_interval_s"].get<double>(), 60, 0.03);
}

TEST_F(StreamWishes, ABitrateStaysWhatWasAskedForWhateverElseIs) {
    const json made = options({.frame_rate = 10, .bitrate_kbps = 1381, .told_rate = 30}, main());
    EXPECT_EQ(made["bitrate_kbps"], 1381) << "by default it would follow the rate";
}

TEST_F(StreamWishes, OptionsOfTheCodecBeforeGoWithIt) {
    camera_.outputs = {{.kind = "rtsp",
                        .options = {{"stream", "sub"}, {"bitrate_kbps", 500}, {"profile", "high"}, {"preset", "fast"}}},
                       {.kind = "rtsp", .options = {{"bitrate_kbps", 3000}}}};
    EXPECT_EQ(options({.codec = "h265"}, sub()),
              json::parse(
                  R"({"stream": "sub", "codec": "h265", "bitrate_kbps": 500, "preset": "fast", "size": [320, 240]})"));
    EXPECT_EQ(options({.codec = "mjpeg", .quality = 40}, sub()),
              json::parse(R"({"stream": "sub", "codec": "mjpeg", "quality": 40, "size": [320, 240]})"));
    EXPECT_THAT(options({.codec = "h265"}, sub(), false).dump(), HasSubstr("no such encoding"));
    EXPECT_THAT(options({.codec = "mjpeg"}, main()).dump(), HasSubstr("no such encoding"));
}

TEST_F(StreamWishes, SizesAreThoseThatAreOffered) {
    EXPECT_THAT(sizes_for(camera_, main(), "h264"), testing::ElementsAre(ImageSize{640, 480}));
    for (const std::string codec : {"h264", "mjpeg"}) {
        for (const ImageSize size : sizes_for(camera_, sub(), codec))
            EXPECT_TRUE(options({.codec = codec, .size = size}, sub()).is_object()) << codec << size.to_string();
    }
    EXPECT_TRUE(options({.size = ImageSize{322, 240}}, sub()).is_string());
    // One that a user has chosen stays possible.
    VideoStream odd = sub();
    odd.size = {322, 240};
    EXPECT_TRUE(options({.size = ImageSize{322, 240}}, odd).is_object());
    EXPECT_THAT(sizes_for(camera_, odd, "mjpeg"), testing::Not(testing::Contains(ImageSize{322, 240})));
}

TEST_F(StreamWishes, SizesOfJpegAreThoseThatRtpCanCarry) {
    camera_.size = {4096, 2160};
    for (const ImageSize size : sizes_for(camera_, sub(), "mjpeg")) EXPECT_LE(size.width, 2040);
    EXPECT_THAT(sizes_for(camera_, sub(), "h264"), testing::Contains(camera_.size));
    EXPECT_TRUE(options({.codec = "mjpeg", .size = ImageSize{1024, 536}}, sub()).is_object());
    EXPECT_TRUE(options({.codec = "mjpeg", .size = ImageSize{2048, 1080}}, sub()).is_string());
    // A stream of a picture so long that none of its shares can be carried is not offered as JPEG.
    camera_.size = {8192, 16};
    VideoStream strip = sub();
    strip.size = {4096, 16};
    EXPECT_THAT(codecs_for(camera_, strip, true), testing::ElementsAre("h264", "h265"));
    EXPECT_THAT(options({.codec = "mjpeg"}, strip).dump(), HasSubstr("no such encoding"));
    camera_.size = {640, 480};
    EXPECT_THAT(codecs_for(camera_, sub(), true), testing::ElementsAre("h264", "h265", "mjpeg"));
}

TEST_F(StreamWishes, BitRatesBecomeTheNearestAndQualityIsOfJpegAlone) {
    EXPECT_EQ(options({.bitrate_kbps = 1e12}, main())["bitrate_kbps"], 200'000);
    EXPECT_EQ(options({.bitrate_kbps = -5}, main())["bitrate_kbps"], 16);
    EXPECT_EQ(options({.quality = 5}, main()), json::object());
    const VideoStream jpeg{.ending = "mjpeg", .codec = "mjpeg", .size = camera_.size, .rate = camera_.rate};
    EXPECT_EQ(options({.quality = 5}, jpeg), json::parse(R"({"codec": "mjpeg", "quality": 5})"));
    EXPECT_THAT(options({.quality = 101}, jpeg).dump(), HasSubstr("quality is 1 to 100"));
}

TEST(StreamTokens, ACamerasNameAndAnEnding) {
    EXPECT_EQ(camera_of_token("dome"), "dome");
    EXPECT_EQ(camera_of_token("dome-sub"), "dome");
    EXPECT_EQ(camera_of_token("dome-mjpeg"), "dome");
    EXPECT_EQ(stream_of_token("dome-sub"), "sub");
    EXPECT_EQ(camera_of_token("dome-other"), "dome-other");
    EXPECT_EQ(camera_of_token(""), "");
    EXPECT_EQ(camera_of_token("dome-"), "dome-");
}

}  // namespace
}  // namespace camrig::onvif

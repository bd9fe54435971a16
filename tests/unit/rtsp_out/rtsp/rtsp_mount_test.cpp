#include "rtsp_out/rtsp/rtsp_mount.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rtsp_out/rtsp/client_table.h"
#include "rtsp_out/rtsp/rtsp_access.h"

namespace camrig {
namespace {

using testing::HasSubstr;
using testing::Not;

class RtspMountPlan : public testing::Test {
protected:
    static void SetUpTestSuite() { gst_init(nullptr, nullptr); }

    Result<RtspMount::Plan> plan(RtspMount::Kind kind, ImageSize size = {640, 480},
                                 std::vector<OutputSpec> outputs = {}) {
        CameraStream camera{CameraId{1}, "lobby", size, *Rate::create(25, 1), std::move(outputs)};
        return RtspMount::plan(kind, camera, options_);
    }
    RtspOptions options_;
};

OutputSpec rtsp_output(std::string codec = "") {
    OutputSpec output;
    output.kind = "rtsp";
    output.codec = std::move(codec);
    return output;
}

TEST_F(RtspMountPlan, ACamerasOptionsReachItsEncoder) {
    OutputSpec wish = rtsp_output();
    wish.bitrate_kbps = 777;
    wish.key_interval_s = 0.4;
    wish.preset = "medium";
    wish.profile = "baseline";
    const auto made = plan(RtspMount::Kind::h264, {640, 480}, {rtsp_output("mjpeg"), wish});
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_THAT(made->launch, HasSubstr("bitrate=777 "));
    EXPECT_THAT(made->launch, HasSubstr("key-int-max=10 "));
    EXPECT_THAT(made->launch, HasSubstr("speed-preset=medium"));
    EXPECT_THAT(made->launch, HasSubstr("profile=constrained-baseline"));
    EXPECT_THAT(made->launch, HasSubstr("tune=zerolatency"));
}

TEST_F(RtspMountPlan, WithoutX264AnotherEncoderIsTaken) {
    options_.h264_elements = {"no_such_encoder", "openh264enc"};
    const auto made = plan(RtspMount::Kind::h264);
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_THAT(made->launch, HasSubstr("openh264enc"));
    EXPECT_THAT(made->launch, Not(HasSubstr("x264enc")));
}

TEST_F(RtspMountPlan, WithoutAnyEncoderTheErrorSaysWhatToInstall) {
    options_.h264_elements = {"no_such_encoder"};
    const auto made = plan(RtspMount::Kind::h264);
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().kind, ErrorKind::unsupported);
    EXPECT_THAT(made.error().message, HasSubstr("gstreamer1.0-plugins-ugly"));
}

TEST_F(RtspMountPlan, MjpegTakesTheQualityThatHttpHas) {
    const auto made = plan(RtspMount::Kind::mjpeg);
    ASSERT_TRUE(made);
    EXPECT_EQ(made->format.codec, Codec::jpeg);
    EXPECT_EQ(made->format.quality, default_jpeg_quality);
    OutputSpec wish = rtsp_output("mjpeg");
    wish.quality = 30;
    EXPECT_EQ(plan(RtspMount::Kind::mjpeg, {640, 480}, {wish})->format.quality, 30);
}

TEST_F(RtspMountPlan, MjpegOfASizeThatRtpCannotCarryIsRefusedWithAWayOut) {
    for (const ImageSize size : {ImageSize{2048, 480}, {640, 2048}, {644, 480}, {640, 481}}) {
        const auto made = plan(RtspMount::Kind::mjpeg, size);
        ASSERT_FALSE(made) << size.to_string();
        EXPECT_EQ(made.error().kind, ErrorKind::unsupported);
        EXPECT_THAT(made.error().message, HasSubstr(size.to_string()));
        EXPECT_THAT(made.error().message, HasSubstr("/cameras/lobby/stream.mjpg"));
        EXPECT_THAT(made.error().message, HasSubstr("H.264 at /lobby"));
    }
    for (const ImageSize size : {ImageSize{2040, 2040}, {16, 16}, {648, 488}})
        EXPECT_TRUE(plan(RtspMount::Kind::mjpeg, size)) << size.to_string();
}

TEST_F(RtspMountPlan, APoseDoesNotChangeAStreamButSizeRateAndOptionsDo) {
    const auto first = plan(RtspMount::Kind::h264);
    EXPECT_EQ(*first, *plan(RtspMount::Kind::h264));
    EXPECT_NE(*first, *plan(RtspMount::Kind::h264, {320, 240}));
    OutputSpec wish = rtsp_output();
    wish.bitrate_kbps = 500;
    EXPECT_NE(*first, *plan(RtspMount::Kind::h264, {640, 480}, {wish}));
}

TEST(RtspClientTable, ThePathOfAMountIsFoundInTheUrlsThatClientsUse) {
    EXPECT_EQ(mount_path_of("/lobby"), "/lobby");
    EXPECT_EQ(mount_path_of("/lobby/"), "/lobby");
    EXPECT_EQ(mount_path_of("/lobby/stream=0"), "/lobby");
    EXPECT_EQ(mount_path_of("/lobby/mjpeg/stream=0"), "/lobby/mjpeg");
    EXPECT_EQ(mount_path_of("/"), "/");
}

TEST(RtspAccess, OtherAddressesThanLoopbackNeedAToken) {
    RtspOptions options;
    for (const char* host : {"127.0.0.1", "127.9.9.9", "::1", "localhost"}) {
        options.host = host;
        EXPECT_TRUE(check_rtsp_host(options)) << host;
    }
    for (const char* host : {"0.0.0.0", "::", "192.168.1.2", "example.org"}) {
        options.host = host;
        EXPECT_FALSE(check_rtsp_host(options)) << host;
    }
    options.token = "secret-token";
    EXPECT_TRUE(check_rtsp_host(options));
}

TEST(RtspAccess, ACertificateThatIsNoneIsAnErrorThatNamesTheFile) {
    RtspOptions options;
    options.certificate = "/nonexistent/cert.pem";
    const auto certificate = load_rtsp_certificate(options);
    ASSERT_FALSE(certificate);
    EXPECT_THAT(certificate.error().message, HasSubstr("/nonexistent/cert.pem"));
    options = {};
    options.key = "key.pem";
    EXPECT_FALSE(load_rtsp_certificate(options));
    options = {};
    EXPECT_EQ(*load_rtsp_certificate(options), nullptr);
    EXPECT_EQ(create_rtsp_auth(options), nullptr);
}

}  // namespace
}  // namespace camrig

#include "rtsp_out/rtsp/rtsp_mount.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rtsp_out/rtsp/client_table.h"
#include "rtsp_out/rtsp/rtsp_access.h"

namespace camrig::rtsp {
namespace {

using testing::HasSubstr;
using testing::Not;

class RtspMountPlan : public testing::Test {
protected:
    static void SetUpTestSuite() { gst_init(nullptr, nullptr); }

    Result<RtspMount::Plan> plan(RtspCodec codec, ImageSize size = {640, 480}, std::vector<OutputSpec> outputs = {}) {
        stream::CameraStream camera{CameraId{1}, "lobby", size, *Rate::create(25, 1), std::move(outputs)};
        return RtspMount::plan(codec, camera, options_);
    }
    RtspOptions options_;
};

OutputSpec rtsp_output(nlohmann::json options) {
    return {.kind = "rtsp", .options = std::move(options)};
}

TEST_F(RtspMountPlan, ACamerasOptionsReachItsEncoder) {
    const OutputSpec output =
        rtsp_output({{"bitrate_kbps", 777}, {"key_interval_s", 0.4}, {"preset", "medium"}, {"profile", "baseline"}});
    const auto made = plan(RtspCodec::h264, {640, 480}, {rtsp_output({{"codec", "mjpeg"}}), output});
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_THAT(made->launch, HasSubstr("bitrate=777 "));
    EXPECT_THAT(made->launch, HasSubstr("key-int-max=10 "));
    EXPECT_THAT(made->launch, HasSubstr("speed-preset=medium"));
    EXPECT_THAT(made->launch, HasSubstr("profile=constrained-baseline"));
    EXPECT_THAT(made->launch, HasSubstr("tune=zerolatency"));
}

TEST_F(RtspMountPlan, WithoutX264AnotherEncoderIsTaken) {
    options_.h264_elements = {"no_such_encoder", "openh264enc"};
    const auto made = plan(RtspCodec::h264);
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_THAT(made->launch, HasSubstr("openh264enc"));
    EXPECT_THAT(made->launch, Not(HasSubstr("x264enc")));
}

TEST_F(RtspMountPlan, WithoutAnyEncoderTheErrorSaysWhatToInstall) {
    options_.h264_elements = {"no_such_encoder"};
    const auto made = plan(RtspCodec::h264);
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().kind, ErrorKind::unsupported);
    EXPECT_THAT(made.error().message, HasSubstr("gstreamer1.0-plugins-ugly"));
}

TEST_F(RtspMountPlan, MjpegTakesTheQualityThatHttpHas) {
    const auto made = plan(RtspCodec::mjpeg);
    ASSERT_TRUE(made);
    EXPECT_EQ(made->format.codec, codec::Codec::jpeg);
    EXPECT_EQ(made->format.quality, codec::default_jpeg_quality);
    const OutputSpec output = rtsp_output({{"codec", "mjpeg"}, {"quality", 30}});
    EXPECT_EQ(plan(RtspCodec::mjpeg, {640, 480}, {output})->format.quality, 30);
}

TEST_F(RtspMountPlan, MjpegOfASizeThatRtpCannotCarryIsRefusedWithAWayOut) {
    for (const ImageSize size : {ImageSize{2048, 480}, {640, 2048}, {644, 480}, {640, 481}}) {
        const auto made = plan(RtspCodec::mjpeg, size);
        ASSERT_FALSE(made) << size.to_string();
        EXPECT_EQ(made.error().kind, ErrorKind::unsupported);
        EXPECT_THAT(made.error().message, HasSubstr(size.to_string()));
        EXPECT_THAT(made.error().message, HasSubstr("/cameras/lobby/stream.mjpg"));
        EXPECT_THAT(made.error().message, HasSubstr("H.264 at /lobby"));
    }
    for (const ImageSize size : {ImageSize{2040, 2040}, {16, 16}, {648, 488}})
        EXPECT_TRUE(plan(RtspCodec::mjpeg, size)) << size.to_string();
}

TEST_F(RtspMountPlan, APoseDoesNotChangeAStreamButSizeRateAndOptionsDo) {
    const auto first = plan(RtspCodec::h264);
    EXPECT_EQ(*first, *plan(RtspCodec::h264));
    EXPECT_NE(*first, *plan(RtspCodec::h264, {320, 240}));
    EXPECT_NE(*first, *plan(RtspCodec::h264, {640, 480}, {rtsp_output({{"bitrate_kbps", 500}})}));
}

TEST(RtspClientTable, ThePathOfAMountIsFoundInTheUrlsThatClientsUse) {
    EXPECT_EQ(mount_path_of("/lobby"), "/lobby");
    EXPECT_EQ(mount_path_of("/lobby/"), "/lobby");
    EXPECT_EQ(mount_path_of("/lobby/stream=0"), "/lobby");
    EXPECT_EQ(mount_path_of("/lobby/mjpeg/stream=0"), "/lobby/mjpeg");
    EXPECT_EQ(mount_path_of("/"), "/");
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
}  // namespace camrig::rtsp

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

    /// Of the camera's stream with this ending of its path.
    Result<RtspMount::Plan> plan(std::string_view ending, ImageSize size = {640, 480},
                                 std::vector<OutputSpec> outputs = {}) {
        set_output_families({rtsp_family()});
        stream::CameraStream camera{CameraId{1}, "lobby", size, *Rate::create(25, 1), std::move(outputs)};
        for (const StreamSettings& stream : streams_of(camera.outputs, size, camera.rate))
            if (path_ending(stream.options) == ending) return RtspMount::plan(stream, camera, options_);
        return error(ErrorKind::not_found, "no such stream");
    }
    RtspOptions options_;
};

OutputSpec rtsp_output(nlohmann::json options) {
    return {.kind = "rtsp", .options = std::move(options)};
}

TEST_F(RtspMountPlan, ACamerasOptionsReachItsEncoder) {
    const OutputSpec output =
        rtsp_output({{"bitrate_kbps", 777}, {"key_interval_s", 0.4}, {"preset", "medium"}, {"profile", "baseline"}});
    const auto made = plan("", {640, 480}, {rtsp_output({{"codec", "mjpeg"}}), output});
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_THAT(made->launch, HasSubstr("bitrate=777 "));
    EXPECT_THAT(made->launch, HasSubstr("key-int-max=10 "));
    EXPECT_THAT(made->launch, HasSubstr("speed-preset=medium"));
    EXPECT_THAT(made->launch, HasSubstr("profile=constrained-baseline"));
    EXPECT_THAT(made->launch, HasSubstr("tune=zerolatency"));
}

TEST_F(RtspMountPlan, WithoutX264AnotherEncoderIsTaken) {
    options_.h264_elements = {"no_such_encoder", "openh264enc"};
    const auto made = plan("");
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_THAT(made->launch, HasSubstr("openh264enc"));
    EXPECT_THAT(made->launch, Not(HasSubstr("x264enc")));
}

TEST_F(RtspMountPlan, WithoutAnyEncoderTheErrorSaysWhatToInstall) {
    options_.h264_elements = {"no_such_encoder"};
    const auto made = plan("");
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().kind, ErrorKind::unsupported);
    EXPECT_THAT(made.error().message, HasSubstr("gstreamer1.0-plugins-ugly"));
}

TEST_F(RtspMountPlan, MjpegTakesTheQualityThatHttpHas) {
    const auto made = plan("/mjpeg");
    ASSERT_TRUE(made);
    EXPECT_EQ(made->format.codec, codec::Codec::jpeg);
    EXPECT_EQ(made->format.quality, codec::default_jpeg_quality);
    const OutputSpec output = rtsp_output({{"codec", "mjpeg"}, {"quality", 30}});
    EXPECT_EQ(plan("/mjpeg", {640, 480}, {output})->format.quality, 30);
}

TEST_F(RtspMountPlan, MjpegOfASizeThatRtpCannotCarryIsRefusedWithAWayOut) {
    for (const ImageSize size : {ImageSize{2048, 480}, {640, 2048}, {644, 480}, {640, 481}}) {
        const auto made = plan("/mjpeg", size);
        ASSERT_FALSE(made) << size.to_string();
        EXPECT_EQ(made.error().kind, ErrorKind::unsupported);
        EXPECT_THAT(made.error().message, HasSubstr(size.to_string()));
        EXPECT_THAT(made.error().message, HasSubstr("/cameras/lobby/stream.mjpg"));
        EXPECT_THAT(made.error().message, HasSubstr("H.264 at /lobby"));
    }
    for (const ImageSize size : {ImageSize{2040, 2040}, {16, 16}, {648, 488}})
        EXPECT_TRUE(plan("/mjpeg", size)) << size.to_string();
}

TEST_F(RtspMountPlan, APoseDoesNotChangeAStreamButSizeRateAndOptionsDo) {
    const auto first = plan("");
    EXPECT_EQ(*first, *plan(""));
    EXPECT_NE(*first, *plan("", {320, 240}));
    EXPECT_NE(*first, *plan("", {640, 480}, {rtsp_output({{"bitrate_kbps", 500}})}));
}

TEST_F(RtspMountPlan, TheSubStreamIsHalfAsLargeAndHalfAsFastUnlessToldOtherwise) {
    const auto made = plan("/sub", {641, 480});
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_EQ(made->path, "/lobby/sub");
    EXPECT_EQ(made->format.size, (ImageSize{320, 240}));
    EXPECT_EQ(made->settings.rate, *Rate::create(25, 2));
    EXPECT_THAT(made->launch, HasSubstr("x264enc"));
    EXPECT_THAT(made->launch, HasSubstr("bitrate=200 "));
    EXPECT_THAT(made->launch, HasSubstr("key-int-max=25 "));
    const OutputSpec output = rtsp_output({{"stream", "sub"}, {"size", {160, 96}}, {"fps", 5}, {"codec", "mjpeg"}});
    const auto told = plan("/sub", {640, 480}, {output});
    EXPECT_EQ(told->format.size, (ImageSize{160, 96}));
    EXPECT_EQ(told->format.codec, codec::Codec::jpeg);
    EXPECT_EQ(told->settings.rate, *Rate::create(5, 1));
    EXPECT_EQ(*plan(""), *plan("", {640, 480}, {output})) << "the main stream has nothing to do with it";
    // No smaller than a picture may be, and no faster than the camera.
    EXPECT_EQ(plan("/sub", {16, 20})->settings.size, (ImageSize{16, 16}));
    EXPECT_EQ(plan("/sub", {640, 480}, {rtsp_output({{"stream", "sub"}, {"fps", 100}})})->settings.rate,
              *Rate::create(25, 1));
}

TEST_F(RtspMountPlan, H265HasItsOwnEncoderAndPayload) {
    const auto made = plan("", {640, 480}, {rtsp_output({{"codec", "h265"}, {"key_interval_s", 1}})});
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_EQ(made->path, "/lobby");
    EXPECT_THAT(made->launch, HasSubstr("x265enc"));
    EXPECT_THAT(made->launch, HasSubstr("rtph265pay"));
    EXPECT_THAT(made->launch, HasSubstr("bitrate=1152 "));
    EXPECT_THAT(made->launch, HasSubstr("key-int-max=25 "));
    EXPECT_NE(*made, *plan(""));
}

TEST(RtspOutputs, TwoOfOneStreamAreOneTooManyAndASubStreamIsNoLargerThanItsCamera) {
    set_output_families({rtsp_family()});
    const auto problem = [](std::vector<nlohmann::json> all) {
        std::vector<OutputSpec> outputs;
        for (auto& options : all) outputs.push_back(rtsp_output(std::move(options)));
        const auto good = check_outputs(outputs, {640, 480});
        return good ? "" : good.error().message;
    };
    const nlohmann::json sub = {{"stream", "sub"}}, h265 = {{"codec", "h265"}}, mjpeg = {{"codec", "mjpeg"}};
    EXPECT_EQ(problem({nlohmann::json::object(), sub, mjpeg}), "");
    EXPECT_THAT(problem({nlohmann::json::object(), h265}), HasSubstr("is the same output as outputs[0]"));
    EXPECT_THAT(problem({sub, {{"stream", "sub"}, {"codec", "h265"}}}), HasSubstr("is the same output"));
    EXPECT_EQ(problem({{{"stream", "sub"}, {"size", {640, 480}}}}), "");
    EXPECT_THAT(problem({{{"stream", "sub"}, {"size", {642, 480}}}}), HasSubstr("642x480 is more than the camera's"));
}

TEST(RtspOutputs, ASubStreamOfJpegHasASizeThatRtpCanCarry) {
    set_output_families({rtsp_family()});
    const auto problem = [](nlohmann::json options, ImageSize camera) {
        options["stream"] = "sub";
        const auto good = check_outputs({rtsp_output(std::move(options))}, camera);
        return good ? "" : good.error().message;
    };
    const ImageSize large{8192, 4320};
    EXPECT_THAT(problem({{"codec", "mjpeg"}, {"size", {2048, 1080}}}, large), HasSubstr("multiples of 8 up to 2040"));
    EXPECT_THAT(problem({{"codec", "mjpeg"}, {"size", {324, 240}}}, large), HasSubstr("not 324x240"));
    EXPECT_THAT(problem({{"codec", "mjpeg"}}, large), HasSubstr("not 4096x2160")) << "half of the camera's";
    EXPECT_EQ(problem({{"codec", "mjpeg"}, {"size", {2040, 1080}}}, large), "");
    EXPECT_EQ(problem({{"codec", "mjpeg"}}, {1366, 766}), "") << "half of it, in steps that can be had";
    EXPECT_EQ(problem({{"size", {2048, 1082}}}, large), "") << "H.264 can";
}

TEST(RtspOutputs, OptionsOfAnotherStreamOrCodecAreRefused) {
    set_output_families({rtsp_family()});
    const auto problem = [](const char* text) {
        const auto value = nlohmann::json::parse(text);
        JsonReader reader(value, "outputs[0]");
        read_output(reader);
        const auto done = reader.finish();
        return done ? "" : done.error().message;
    };
    EXPECT_EQ(problem(R"({"kind": "rtsp", "stream": "sub", "size": [320, 240], "fps": "25/2", "codec": "h265"})"), "");
    EXPECT_THAT(problem(R"({"kind": "rtsp", "size": [320, 240]})"), HasSubstr("only the sub stream has one"));
    EXPECT_THAT(problem(R"({"kind": "rtsp", "stream": "sub", "size": [8, 240]})"), HasSubstr("16x16 to 8192x8192"));
    EXPECT_THAT(problem(R"({"kind": "rtsp", "stream": "sub", "fps": 0})"), HasSubstr("outputs[0].fps"));
    EXPECT_THAT(problem(R"({"kind": "rtsp", "codec": "h265", "profile": "main"})"), HasSubstr("codec h264"));
    EXPECT_THAT(problem(R"({"kind": "rtsp", "codec": "h266"})"), HasSubstr("h265"));
    EXPECT_THAT(problem(R"({"kind": "rtsp", "codec": "mjpeg", "bitrate_kbps": 100})"), HasSubstr("h264 or h265"));
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

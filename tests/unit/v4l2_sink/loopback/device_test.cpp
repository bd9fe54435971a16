#include "v4l2_sink/loopback/device.h"

#include <gmock/gmock.h>

#include "core/base/clock.h"
#include "tests/unit/v4l2_sink/loopback/fake_module.h"

namespace camrig::device {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

LoopbackFormat yuyv(int width = 64, int height = 48) {
    return {V4L2_PIX_FMT_YUYV, {width, height}, *Rate::create(25, 1)};
}

std::vector<std::byte> picture(std::byte value, const LoopbackFormat& format = yuyv()) {
    return std::vector<std::byte>(static_cast<std::size_t>(format.size.pixels() * 2), value);
}

/// Every generation of the module.
class LoopbackDeviceOf : public testing::TestWithParam<int> {
protected:
    LoopbackDeviceOf() { kernel_.plug(video_number); }
    Result<std::unique_ptr<LoopbackDevice>> open(const LoopbackFormat& format = yuyv()) {
        return LoopbackDevice::open(kernel_, *LoopbackModule(kernel_).features(), video_number, format);
    }
    FakeModule::Device& module_device() { return kernel_.devices.at(video_number); }
    bool streams() const { return GetParam() >= 14; }

    FakeModule kernel_{GetParam()};
};
INSTANTIATE_TEST_SUITE_P(Generations, LoopbackDeviceOf, testing::Values(12, 13, 14, 15));

TEST_P(LoopbackDeviceOf, OpensInTheOrderThatItsGenerationNeeds) {
    auto device = open();
    ASSERT_TRUE(device) << device.error().message;
    EXPECT_FALSE(module_device().keep_format);  // no program finds a camera without a picture
    ASSERT_TRUE((*device)->show(picture(std::byte{1}), 1));
    if (streams()) {
        EXPECT_THAT(kernel_.calls,
                    ElementsAre("keep_format=0", "S_FMT", "S_PARM", "REQBUFS 4", "STREAMON", "keep_format=1"));
    } else {
        EXPECT_THAT(kernel_.calls,
                    ElementsAre("keep_format=0", "S_FMT", "S_PARM", "write", "STREAMON", "keep_format=1"));
    }
    ASSERT_TRUE((*device)->show(picture(std::byte{2}), 2));
    EXPECT_EQ(kernel_.calls.size(), streams() ? 6u : 7u);
}

TEST_P(LoopbackDeviceOf, PicturesArriveWholeInOrderAndWithTheirStamps) {
    auto device = open();
    ASSERT_TRUE(device) << device.error().message;
    for (int i = 0; i < 10; ++i) ASSERT_TRUE((*device)->show(picture(static_cast<std::byte>(i)), 5'000'000 + i));
    const auto& pictures = module_device().pictures;
    ASSERT_EQ(pictures.size(), 10u);
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        EXPECT_EQ(pictures[i].bytes, picture(static_cast<std::byte>(i)));
        EXPECT_EQ(pictures[i].sequence, i);
        if (streams()) {
            EXPECT_EQ(pictures[i].stamp_us, 5'000'000 + static_cast<std::int64_t>(i));
            EXPECT_EQ(pictures[i].index, i % 4);  // never the buffer that readers look at
        }
    }
}

TEST_P(LoopbackDeviceOf, TellsReadersTheCamerasRateAndColours) {
    ASSERT_TRUE(open());
    EXPECT_EQ(module_device().interval.numerator, 1u);
    EXPECT_EQ(module_device().interval.denominator, 25u);
    const v4l2_pix_format& pix = module_device().pix;
    EXPECT_EQ(pix.colorspace, V4L2_COLORSPACE_SRGB);
    EXPECT_EQ(pix.xfer_func, V4L2_XFER_FUNC_SRGB);
    EXPECT_EQ(pix.ycbcr_enc, V4L2_YCBCR_ENC_601);
    EXPECT_EQ(pix.quantization, V4L2_QUANTIZATION_LIM_RANGE);
    EXPECT_EQ(pix.priv, V4L2_PIX_FMT_PRIV_MAGIC);
    EXPECT_EQ(pix.field, V4L2_FIELD_NONE);
}

TEST_P(LoopbackDeviceOf, ADeviceLeftByAKilledRigIsTakenUpAgain) {
    {
        auto device = open();
        ASSERT_TRUE((*device)->show(picture(std::byte{1}), 1));
        kernel_.reader_comes(video_number);
    }
    EXPECT_TRUE(module_device().keep_format);
    auto device = open();
    ASSERT_TRUE(device) << device.error().message;
    EXPECT_TRUE((*device)->format().same_pictures(yuyv()));
    ASSERT_TRUE((*device)->show(picture(std::byte{2}), 2));
    EXPECT_EQ(module_device().pictures.back().bytes, picture(std::byte{2}));
}

TEST_P(LoopbackDeviceOf, AnOldFormatThatNobodyHoldsIsReplaced) {
    {
        auto device = open();
        ASSERT_TRUE((*device)->show(picture(std::byte{1}), 1));
    }
    auto device = open(yuyv(32, 32));
    ASSERT_TRUE(device) << device.error().message;
    EXPECT_EQ((*device)->format().size, (ImageSize{32, 32}));
}

TEST_P(LoopbackDeviceOf, AFormatThatAReaderHoldsIsKept) {
    {
        auto device = open();
        ASSERT_TRUE((*device)->show(picture(std::byte{1}), 1));
        kernel_.reader_comes(video_number);
    }
    auto device = open(yuyv(32, 32));
    ASSERT_TRUE(device) << device.error().message;
    EXPECT_TRUE((*device)->format().same_pictures(yuyv()));
}

TEST_P(LoopbackDeviceOf, AHeldFormatThatIsNoneOfOursIsAnError) {
    module_device().pix = pix_format_of({V4L2_PIX_FMT_GREY, {64, 48}, Rate()});
    module_device().has_format = module_device().is_held = true;
    const auto device = open();
    ASSERT_FALSE(device);
    EXPECT_EQ(device.error().kind, ErrorKind::unsupported);
    EXPECT_THAT(device.error().message, HasSubstr("GREY 64x48"));
}

TEST_P(LoopbackDeviceOf, AnotherWriterIsToldOf) {
    auto first = open();
    ASSERT_TRUE((*first)->show(picture(std::byte{1}), 1));
    const auto second = open();
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().kind, ErrorKind::already_exists);
    EXPECT_THAT(second.error().message, HasSubstr("another program writes to it"));
    EXPECT_TRUE(module_device().keep_format);  // as the first one asked
}

TEST_P(LoopbackDeviceOf, AnotherDriversDeviceIsRefused) {
    module_device().driver = "uvcvideo";
    const auto device = open();
    ASSERT_FALSE(device);
    EXPECT_EQ(device.error().kind, ErrorKind::already_exists);
    EXPECT_THAT(device.error().message, HasSubstr("driver 'uvcvideo'"));
    EXPECT_TRUE(kernel_.calls.empty());
    EXPECT_EQ(kernel_.open_descriptors(), 0u);
}

TEST_P(LoopbackDeviceOf, WithoutPermissionItSaysHowToGetIt) {
    kernel_.open_problem = EACCES;
    const auto device = open();
    ASSERT_FALSE(device);
    EXPECT_EQ(device.error().kind, ErrorKind::unauthorized);
    EXPECT_THAT(device.error().message, HasSubstr("usermod -aG video"));
}

TEST_P(LoopbackDeviceOf, ARateThatAReaderSetIsPutBack) {
    auto device = open();
    EXPECT_FALSE((*device)->restore_rate());
    module_device().interval = {1, 30};
    EXPECT_TRUE((*device)->restore_rate());
    EXPECT_EQ(module_device().interval.denominator, 25u);
    module_device().interval = {40, 1000};  // the same rate in other words
    EXPECT_FALSE((*device)->restore_rate());
}

TEST_P(LoopbackDeviceOf, TellsWhetherSomebodyReads) {
    auto device = open();
    if (GetParam() == 12) {
        EXPECT_EQ(*(*device)->has_readers(), std::nullopt);
        EXPECT_EQ((*device)->readers_fd(), -1);
        return;
    }
    EXPECT_GE((*device)->readers_fd(), 0);
    EXPECT_EQ(*(*device)->has_readers(), false);
    kernel_.reader_comes(video_number);
    EXPECT_EQ(*(*device)->has_readers(), true);
    EXPECT_EQ(*(*device)->has_readers(), true);
    kernel_.reader_leaves(video_number);
    EXPECT_EQ(*(*device)->has_readers(), false);
}

TEST_P(LoopbackDeviceOf, FewerThanFourBuffersAreTold) {
    module_device().max_buffers = 2;
    auto device = open();
    ASSERT_TRUE(device) << device.error().message;
    EXPECT_EQ((*device)->buffers(), 2);
    ASSERT_TRUE((*device)->show(picture(std::byte{1}), 1));
    ASSERT_TRUE((*device)->show(picture(std::byte{2}), 2));
    ASSERT_TRUE((*device)->show(picture(std::byte{3}), 3));
    EXPECT_EQ(module_device().pictures.back().bytes, picture(std::byte{3}));
}

TEST_P(LoopbackDeviceOf, FailedPictureNamesTheCallAndTheDevice) {
    auto device = open();
    kernel_.write_problem = ENODEV;
    const auto shown = (*device)->show(picture(std::byte{1}), 1);
    ASSERT_FALSE(shown);
    EXPECT_THAT(shown.error().message, HasSubstr("/dev/video10: "));
    EXPECT_THAT(shown.error().message, HasSubstr("No such device"));
    EXPECT_FALSE(module_device().keep_format);
}

TEST(LoopbackFormat, EachNameHasItsPictures) {
    stream::CameraStream camera;
    camera.size = {64, 48};
    const auto format_of = [&](const char* name) { return loopback_format_of(camera, {.number = 1, .format = name}); };
    EXPECT_EQ(media_format_of(format_of("YUYV"))->pixels, frame::PixelFormat::yuyv);
    EXPECT_EQ(media_format_of(format_of("YU12"))->pixels, frame::PixelFormat::i420);
    EXPECT_EQ(media_format_of(format_of("BGR3"))->pixels, frame::PixelFormat::bgr24);
    EXPECT_EQ(media_format_of(format_of("MJPG"))->codec, codec::Codec::jpeg);
    EXPECT_EQ(pix_format_of(format_of("MJPG")).colorspace, V4L2_COLORSPACE_JPEG);
    EXPECT_EQ(pix_format_of(format_of("MJPG")).quantization, V4L2_QUANTIZATION_FULL_RANGE);
}

}  // namespace
}  // namespace camrig::device

#include <array>
#include <string>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/codec/encoder.h"
#include "core/frame/convert.h"
#include "tests/unit/frame/test_pictures.h"

// What is compressed of a frame that says which rows of it changed, and that nobody can tell.
namespace camrig::codec {
namespace {

constexpr std::array samplings = {ChromaSampling::yuv420, ChromaSampling::yuv422};
constexpr std::array formats = {frame::PixelFormat::rgba8, frame::PixelFormat::bgr24, frame::PixelFormat::gray8,
                                frame::PixelFormat::jpeg_i420};

/// A camera's frames, each the last one but for some rows.
class Film {
public:
    explicit Film(ImageSize size) : frame_(std::make_shared<const frame::Frame>(frame::test::smooth(size))) {}

    const frame::FrameRef& frame() const { return frame_; }
    /// Goes on by one frame, with new pixels in some of rows first_row <= y < end_row.
    void change(int first_row, int end_row) {
        frame::FrameInfo info = frame_->info();
        std::vector<std::byte> bytes(frame_->bytes().begin(), frame_->bytes().end());
        info.damage = frame::Damage::since(info.sequence++);
        info.damage.add(first_row, end_row);
        const auto row_bytes = static_cast<std::size_t>(info.size.width) * 4;
        const auto from = static_cast<std::size_t>(first_row) * row_bytes;
        const auto to = static_cast<std::size_t>(std::min(end_row, info.size.height)) * row_bytes;
        for (std::size_t i = from; i < to; i += 3) {
            const auto bits = random_bits(2, static_cast<std::uint64_t>(info.sequence), i);
            bytes[i] = static_cast<std::byte>(bits >> (bits % 8));
        }
        frame_ = std::make_shared<const frame::Frame>(std::move(info), std::move(bytes));
    }
    /// The same with a few bands anywhere, none and all among them.
    void change_somewhere(std::uint64_t seed) {
        const int height = frame_->info().size.height;
        const auto draw = [&](std::uint64_t n, int below) {
            return static_cast<int>(random_bits(3, seed, n) % static_cast<unsigned>(below));
        };
        const frame::FrameInfo before = frame_->info();
        frame::Damage damage = frame::Damage::since(before.sequence);
        const int bands = draw(0, 5);
        for (int i = 0; i < bands; ++i) {
            const int first = draw(1 + 2 * static_cast<unsigned>(i), height);
            const int end = std::min(height, first + 1 + draw(2 + 2 * static_cast<unsigned>(i), height));
            change(first, end);
            damage.add(first, end);
        }
        if (bands == 0) change(0, 0);
        frame::FrameInfo info = frame_->info();
        info.sequence = before.sequence + 1;
        info.damage = damage;
        frame_ =
            std::make_shared<const frame::Frame>(info, std::vector(frame_->bytes().begin(), frame_->bytes().end()));
    }
    frame::FrameRef as(frame::PixelFormat format) { return converted(pool_, frame_, format, {}).value(); }

private:
    frame::FrameRef frame_;
    frame::FramePool pool_;
};

frame::Frame without_memory(const frame::Frame& frame) {
    frame::FrameInfo info = frame.info();
    info.damage = {};
    return frame::Frame(info, {frame.bytes().begin(), frame.bytes().end()});
}

std::vector<std::byte> whole(const frame::Frame& frame, int quality = 90,
                             ChromaSampling sampling = ChromaSampling::yuv420) {
    return *create_jpeg_encoder(quality, sampling).value()->encode(without_memory(frame)).value();
}

std::vector<std::byte> encoded(Encoder& encoder, const frame::Frame& frame) {
    return *encoder.encode(frame).value();
}

/// Spoils a row of the frame (of Y where there are planes) and says nothing of it.
frame::Frame spoilt(const frame::Frame& frame, int row) {
    const frame::PixelFormat format =
        frame.info().format == frame::PixelFormat::jpeg_i420 ? frame::PixelFormat::gray8 : frame.info().format;
    const std::size_t row_bytes = bytes_of(format, {frame.info().size.width, 1});
    std::vector<std::byte> bytes(frame.bytes().begin(), frame.bytes().end());
    std::fill_n(&bytes[static_cast<std::size_t>(row) * row_bytes], row_bytes, std::byte{0});
    return frame::Frame(frame.info(), std::move(bytes));
}

TEST(JpegStrips, AreTheBytesOfTheWholePictureWhateverChanged) {
    for (const ImageSize size : {ImageSize{320, 240}, {641, 479}, {97, 151}, {160, 200}, {16, 16}, {33, 7}}) {
        for (const frame::PixelFormat format : formats) {
            for (const ChromaSampling sampling : samplings) {
                Film film(size);
                auto encoder = create_jpeg_encoder(90, sampling).value();
                for (std::uint64_t n = 0; n < 12; ++n, film.change_somewhere(n)) {
                    const frame::FrameRef frame = film.as(format);
                    ASSERT_TRUE(encoded(*encoder, *frame) == whole(*frame, 90, sampling))
                        << size.to_string() << " " << to_string(format) << " " << to_string(sampling) << ", frame "
                        << n;
                }
            }
        }
    }
}

TEST(JpegStrips, OnlyWhatChangedIsCompressed) {
    for (const frame::PixelFormat format : formats) {
        for (const ChromaSampling sampling : samplings) {
            SCOPED_TRACE(std::string(to_string(format)) + " " + std::string(to_string(sampling)));
            Film film({320, 240});
            auto encoder = create_jpeg_encoder(90, sampling).value();
            std::ignore = encoded(*encoder, *film.as(format));
            film.change(100, 120);
            const frame::FrameRef frame = film.as(format);
            // Row 50 is not looked at, and the changed bands are 96 to 127.
            EXPECT_TRUE(encoded(*encoder, spoilt(*frame, 50)) == whole(*frame, 90, sampling));
            film.change(0, 0);
            EXPECT_TRUE(encoded(*encoder, spoilt(*film.as(format), 110)) == whole(*frame, 90, sampling));
            film.change(100, 120);
            EXPECT_FALSE(encoded(*encoder, spoilt(*film.as(format), 97)) == whole(*film.as(format), 90, sampling));
        }
    }
}

TEST(JpegStrips, AnUnchangedFrameIsTheSameJpegWithoutACopy) {
    Film film({320, 240});
    auto encoder = create_jpeg_encoder(90).value();
    const BytesRef first = encoder->encode(*film.frame()).value();
    film.change(0, 0);
    EXPECT_EQ(encoder->encode(*film.frame()).value(), first);
    film.change(0, 0);
    EXPECT_EQ(encoder->encode(*film.frame()).value(), first);
}

TEST(JpegStrips, AFrameThatFollowsAnotherIsCompressedInFull) {
    const auto sees_spoilt_row = [](auto&& tell) {
        Film film({320, 240});
        auto encoder = create_jpeg_encoder(90).value();
        std::ignore = encoded(*encoder, *film.frame());
        film.change(100, 120);
        frame::FrameInfo info = film.frame()->info();
        const frame::FrameRef frame = tell(film, *encoder, info);
        const frame::Frame other = spoilt(frame::Frame(info, {frame->bytes().begin(), frame->bytes().end()}), 50);
        return encoded(*encoder, other) == whole(other);
    };
    EXPECT_FALSE(sees_spoilt_row([](Film& film, Encoder&, frame::FrameInfo&) { return film.frame(); }))
        << "it does follow";
    EXPECT_TRUE(sees_spoilt_row([](Film& film, Encoder&, frame::FrameInfo& info) {
        info.damage = {};
        return film.frame();
    })) << "not known";
    EXPECT_TRUE(sees_spoilt_row([](Film& film, Encoder&, frame::FrameInfo& info) {
        film.change(30, 40);
        info = film.frame()->info();
        return film.frame();
    })) << "a frame between was skipped";
    EXPECT_TRUE(sees_spoilt_row([](Film& film, Encoder&, frame::FrameInfo& info) {
        info.camera_id = CameraId{8};
        return film.frame();
    })) << "of another camera";
    EXPECT_TRUE(sees_spoilt_row([](Film& film, Encoder& encoder, frame::FrameInfo& info) {
        Film small({320, 224});
        small.change(0, 0);
        std::ignore = encoded(encoder, *small.frame());
        info.damage = frame::Damage::since(small.frame()->info().sequence);
        return film.frame();
    })) << "of another size";
    EXPECT_TRUE(sees_spoilt_row([](Film& film, Encoder&, frame::FrameInfo& info) {
        info.format = frame::PixelFormat::jpeg_i420;
        return film.as(frame::PixelFormat::jpeg_i420);
    })) << "of another layout";
}

TEST(JpegStrips, QualityIsTheEncodersOwn) {
    Film film({320, 240});
    auto fine = create_jpeg_encoder(95).value(), coarse = create_jpeg_encoder(30).value();
    for (std::uint64_t n = 0; n < 5; ++n, film.change_somewhere(n)) {
        EXPECT_TRUE(encoded(*fine, *film.frame()) == whole(*film.frame(), 95));
        EXPECT_TRUE(encoded(*coarse, *film.frame()) == whole(*film.frame(), 30));
    }
}

TEST(JpegStrips, GoOnAfterAFrameThatCannotBe) {
    Film film({320, 240});
    auto encoder = create_jpeg_encoder(90).value();
    std::ignore = encoded(*encoder, *film.frame());
    EXPECT_FALSE(encoder->encode(frame::test::noise({16, 16}, frame::PixelFormat::depth32f)).has_value());
    film.change(100, 120);
    EXPECT_TRUE(encoded(*encoder, *film.frame()) == whole(*film.frame()));
}

}  // namespace
}  // namespace camrig::codec

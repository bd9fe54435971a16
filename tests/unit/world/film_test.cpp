#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <turbojpeg.h>

#include "core/world/backdrop/backdrop.h"
#include "core/world/backdrop/film_player.h"
#include "tests/temporary_folder.h"

namespace camrig::world::film_test {
namespace {

using testing::HasSubstr;

constexpr ImageSize size{32, 16};
constexpr int pictures = 300;

/// Of 300 gray pictures, of which picture n has the code of(n).
int code_of(std::int64_t n) {
    return 20 + static_cast<int>(n % 7) * 30;
}

/// A JPEG of one colour, gray or with chroma.
std::vector<unsigned char> jpeg_of(std::uint8_t code, bool has_chroma) {
    const std::vector<std::uint8_t> pixels(static_cast<std::size_t>(size.pixels()) * 3, code);
    unsigned char* made = nullptr;
    unsigned long bytes = 0;
    const tjhandle jpeg = tjInitCompress();
    EXPECT_EQ(tjCompress2(jpeg, pixels.data(), size.width, 0, size.height, TJPF_RGB, &made, &bytes,
                          has_chroma ? TJSAMP_420 : TJSAMP_GRAY, 95, 0),
              0);
    const std::vector<unsigned char> file(made, made + bytes);
    tjFree(made);
    tjDestroy(jpeg);
    return file;
}

/// A film of plain JPEGs, which is removed.
class Film : public testing::Test {
protected:
    void SetUp() override {
        std::ofstream out(path_, std::ios::binary);
        tjhandle jpeg = tjInitCompress();
        for (int n = 0; n < pictures; ++n) {
            const std::vector<std::uint8_t> gray(static_cast<std::size_t>(size.pixels()),
                                                 static_cast<std::uint8_t>(code_of(n)));
            unsigned char* made = nullptr;
            unsigned long bytes = 0;
            ASSERT_EQ(tjCompress2(jpeg, gray.data(), size.width, 0, size.height, TJPF_GRAY, &made, &bytes, TJSAMP_GRAY,
                                  95, 0),
                      0);
            out.write(reinterpret_cast<const char*>(made), static_cast<std::streamsize>(bytes));
            if (n == 0) first_bytes_ = bytes;
            tjFree(made);
        }
        tjDestroy(jpeg);
        out.close();
        auto film = read_film(path_);
        ASSERT_TRUE(film) << film.error().message;
        film_ = *film;
    }

    int code(const std::shared_ptr<const Image>& picture) { return picture->rgba[4 * 37]; }

    const TemporaryFolder folder_;
    const std::filesystem::path path_ = folder_ / "film.mjpeg";
    std::uintmax_t first_bytes_ = 0;  ///< of the first picture
    std::shared_ptr<const FilmFile> film_;
};

TEST(MixedFilm, PicturesWithoutChromaMayFollowOthersAndTheOtherWayRound) {
    const TemporaryFolder folder;
    const auto path = folder / "night.mjpeg";
    {
        std::ofstream out(path, std::ios::binary);
        for (int n = 0; n < 4; ++n) {
            const auto file = jpeg_of(static_cast<std::uint8_t>(50 * (n + 1)), n == 1 || n == 2);
            out.write(reinterpret_cast<const char*>(file.data()), static_cast<std::streamsize>(file.size()));
        }
    }
    const auto film = read_film(path);
    ASSERT_TRUE(film) << film.error().message;
    const Rate rate = Rate::create(25, 1).value();
    FilmPlayer player(*film, rate, size);
    for (const int n : {0, 1, 2, 3, 1, 0, 3}) {
        const auto picture = player.picture_of(player.at(rate.time_of_frame(n), true));
        for (std::size_t i = 0; i < picture->rgba.size(); ++i)
            ASSERT_NEAR(picture->rgba[i], i % 4 == 3 ? 255 : 50 * (n + 1), 2) << n << " at " << i;
    }
}

TEST_F(Film, ShowsThePictureOfItsTimeInWholeNumbersAfterAnyJump) {
    ASSERT_EQ(film_->index.times.size(), std::size_t{pictures});
    ASSERT_EQ(film_->index.size, size);
    for (const Rate rate :
         {Rate::create(25, 1).value(), Rate::create(30000, 1001).value(), Rate::create(7, 3).value()}) {
        FilmPlayer player(film_, rate, size);
        // In step, slower and faster than the film, back, and after years.
        std::vector<TimeNs> times{0, 1, 39'999'999, 40'000'000, 33'366'666, 33'366'667, 5'000'000'000, 12'000'000'000};
        for (int i = 0; i < 30; ++i) times.push_back(13'000'000'000 + i * TimeNs{7'000'000});
        for (int i = 0; i < 30; ++i) times.push_back(14'000'000'000 + i * TimeNs{200'000'000});
        times.insert(times.end(), {3'000'000'000, 100'000'000'000'000'000, 100'000'000'040'000'000, 0});
        for (const TimeNs time : times) {
            const std::int64_t frame = rate.frames_until(time) - 1;
            const FilmShot shot = player.at(time, true);
            ASSERT_EQ(shot.frame, frame % pictures) << time;
            ASSERT_EQ(shot.late, 0);
            ASSERT_NEAR(code(player.picture_of(shot)), code_of(frame % pictures), 1) << time;
        }
    }
}

TEST_F(Film, ThatIsLateShowsItsLastPictureAndCounts) {
    FilmPlayer player(film_, Rate::create(25, 1).value(), size);
    const FilmShot first = player.at(0, false);
    EXPECT_EQ(first.picture, nullptr) << "the first is waited for, by who draws it";
    const auto shown = player.picture_of(first);
    EXPECT_EQ(player.at(0, false).picture, shown);
    // Far ahead of all that is decoded.
    const FilmShot late = player.at(6'000'000'000, false);
    EXPECT_EQ(late.frame, 0);
    EXPECT_EQ(late.picture, shown);
    EXPECT_EQ(late.late, 1);
    EXPECT_EQ(player.at(6'000'000'000, false).late, 1) << "an instant counts once";
    // By then it is there.
    const auto there = player.picture_of({.frame = 150, .late = 0, .picture = nullptr});
    const FilmShot next = player.at(6'000'000'001, false);
    EXPECT_EQ(next.frame, 150);
    EXPECT_EQ(next.late, 1);
    EXPECT_NEAR(code(next.picture), code_of(150), 1);
    EXPECT_EQ(player.at(6'000'000'000, false).frame, 0) << "the same for who asks again";
    EXPECT_NE(there, nullptr);
}

TEST_F(Film, IsBroughtToTheSizeOfTheCamera) {
    FilmPlayer player(film_, Rate::create(25, 1).value(), {16, 8});
    const auto picture = player.picture_of(player.at(80'000'000, true));
    EXPECT_EQ(picture->size, (ImageSize{16, 8}));
    EXPECT_NEAR(code(picture), code_of(2), 1);
}

TEST_F(Film, WhatIsGoneShowsThePictureBefore) {
    FilmPlayer player(film_, Rate::create(25, 1).value(), size);
    const auto first = player.picture_of(player.at(0, true));
    std::filesystem::resize_file(path_, std::filesystem::file_size(path_) / 2);
    EXPECT_EQ(player.picture_of(player.at(11'000'000'000, true))->size, size) << "nobody waits for ever";
    EXPECT_NE(first, nullptr);
}

TEST_F(Film, WhatIsNoFilmIsSaidSo) {
    const auto message = [&](const std::string& text) {
        std::ofstream(path_, std::ios::binary | std::ios::trunc) << text;
        const auto film = read_film(path_);
        return film ? std::string() : film.error().message;
    };
    EXPECT_THAT(message("no film at all"), HasSubstr("no film that is read here"));
    EXPECT_THAT(message(""), HasSubstr("no film that is read here"));
    EXPECT_THAT(message("#EXTM3U\n#EXTINF:1,\nfile:///etc/passwd\n"), HasSubstr("no film that is read here"));
    EXPECT_THAT(message("ffconcat version 1.0\nfile /etc/passwd\n"), HasSubstr("no film that is read here"));
    std::filesystem::remove(path_);
    EXPECT_THAT(read_film(path_).error().message, HasSubstr("no such file"));
    ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);  // which nobody writes into
    EXPECT_THAT(read_film(path_).error().message, HasSubstr("is not a regular file"));
}

/// What takes time is done by who reads the file, not by who makes the camera.
TEST_F(Film, APlateIsScaledWhereItIsRead) {
    std::filesystem::resize_file(path_, first_bytes_);
    CameraPatch patch;
    patch.size = ImageSize{64, 32};
    patch.backdrop.emplace(BackdropSpec{});
    BackdropSpec& spec = **patch.backdrop;
    spec.file = path_.string();
    spec.proxies.ground.emplace().polygon_m = {{1, -9}, {30, -9}, {30, 9}};
    const auto loaded = load_backdrop(patch, {});
    ASSERT_TRUE(loaded) << loaded.error().message;
    ASSERT_NE(spec.files->scaled, nullptr);
    EXPECT_EQ(spec.files->scaled->size, *patch.size);
    CameraSpec base;
    base.name = "gate";
    base.pose.position.z = 3.0;
    const auto camera = patch_camera_spec(base, patch);
    ASSERT_TRUE(camera) << camera.error().message;
    EXPECT_EQ(camera->backdrop_here->picture({}), spec.files->scaled);
    CameraPatch larger;
    larger.size = ImageSize{128, 64};
    EXPECT_EQ(patch_camera_spec(*camera, larger).value().backdrop_here->picture({})->size, *larger.size);
}

}  // namespace
}  // namespace camrig::world::film_test

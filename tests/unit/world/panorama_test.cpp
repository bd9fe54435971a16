#include "core/world/backdrop/panorama.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/field_of.h"
#include "core/world/backdrop/backdrop.h"
#include "core/world/camera_json.h"

namespace camrig::world::panorama_test {
namespace {

using testing::StartsWith;

Image gray(ImageSize size, std::uint8_t code = 128) {
    return {.size = size, .rgba = std::vector<std::uint8_t>(static_cast<std::size_t>(size.pixels()) * 4, code)};
}

TEST(Panorama, DetailsAreBoundedInMemoryAndByTheirSphere) {
    auto maker = PanoramaMaker::create(gray({64, 32}), 16).value();
    const auto said = [&](int scale, glm::ivec2 at, ImageSize size, std::size_t most = std::size_t{8} << 20) {
        const auto done = maker.reserve({.file = {}, .scale = scale, .at_px = at}, size, most);
        return done ? std::string() : done.error().message;
    };
    EXPECT_EQ(said(16, {1000, 500}, {24, 12}), "");
    EXPECT_EQ(said(16, {1000, 500}, {24, 12}), "") << "what is there already takes nothing";
    EXPECT_EQ(said(16, {1000, 0}, {1000, 10}), "") << "around the back";
    EXPECT_EQ(said(16, {1024, 0}, {10, 10}).substr(0, 6), "at_px:");
    EXPECT_EQ(said(16, {0, 503}, {10, 10}).substr(0, 6), "at_px:");
    EXPECT_EQ(said(4, {0, 0}, {257, 10}).substr(0, 6), "at_px:");
    EXPECT_EQ(said(16, {0, 0}, {1024, 512}, std::size_t{1} << 20).substr(0, 5), "file:");
    EXPECT_NE(said(16, {0, 0}, {1024, 512}, std::size_t{1} << 20).find("take over 1 MiB of memory"), std::string::npos);
    EXPECT_EQ(PanoramaMaker::scale_problem(64, 8192), "");
    EXPECT_EQ(PanoramaMaker::scale_problem(6, 64), "must be 2, 4, 8, 16, 32 or 64");
    EXPECT_EQ(PanoramaMaker::scale_problem(64, 8194).substr(0, 9), "times the");
}

TEST(SparsePicture, IsThereWhereSomethingWasPut) {
    SparsePicture picture({600, 300});
    EXPECT_EQ(picture.at(599, 299), nullptr);
    const PixelRect rect{250, 10, 262, 20};
    EXPECT_EQ(picture.bytes_of(rect), 2 * SparsePicture::block_bytes);
    picture.reserve(rect);
    EXPECT_EQ(picture.bytes_of(rect), 0u);
    EXPECT_EQ(picture.at(255, 15), nullptr) << "what is reserved alone is not there";
    Image part = gray({20, 10}, 255);
    for (int i = 0; i < 200; ++i) part.rgba[static_cast<std::size_t>(4 * i)] = static_cast<std::uint8_t>(i % 20);
    // A pixel that is not wholly opaque.
    part.rgba[static_cast<std::size_t>(4 * (20 * 3 + 8) + 3)] = 254;
    picture.put(part, 5, rect);
    for (int y = 0; y < 30; ++y) {
        for (int x = 240; x < 280; ++x) {
            const bool is_there = x >= rect.x0 && x < rect.x1 && y >= rect.y0 && y < rect.y1 && !(x == 253 && y == 13);
            const std::uint8_t* const pixel = picture.at(x, y);
            ASSERT_EQ(pixel != nullptr, is_there) << x << ", " << y;
            if (is_there) {
                EXPECT_EQ(pixel[0], x - 245);
            }
        }
    }
}

/// A half is there where all four of its pixels are, and what was there before stays.
TEST(SparsePicture, HalvesAreMeansOfFourInLinearLight) {
    SparsePicture large({1024, 512}), half({512, 256});
    Image part = gray({5, 4}, 255);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 5; ++x) part.rgba[static_cast<std::size_t>(4 * (5 * y + x))] = (x + y) % 2 == 0 ? 0 : 255;
    const PixelRect rect{509, 100, 514, 104};
    large.reserve(rect);
    large.put(part, 0, rect);
    half.reserve({254, 50, 257, 52});
    half.put(gray({1, 1}, 255), 0, {256, 51, 257, 52});
    half.fill_from(large);
    EXPECT_EQ(half.at(254, 50), nullptr) << "of its four two are there";
    for (const int x : {255, 256}) {
        ASSERT_NE(half.at(x, 50), nullptr);
        EXPECT_EQ(half.at(x, 50)[0], 188);
        EXPECT_EQ(half.at(x, 50)[1], 255);
    }
    EXPECT_EQ(half.at(255, 51)[0], 188);
    EXPECT_EQ(half.at(256, 51)[0], 255);
}

TEST(Panorama, DetailsAreReadAndToldAsTheyWereGiven) {
    const auto json = parse_json(R"({"backdrop": {"kind": "panorama", "file": "/a.png", "details": [
        {"file": "/b.png", "scale": 16, "at_px": [4000, 12]}, {"file": "/c.jpg", "scale": 2, "at_px": [0, 0]}]}})",
                                 10000)
                          .value();
    JsonReader reader(json, "");
    const CameraPatch patch = read_camera_patch(reader);
    ASSERT_TRUE(reader.finish());
    const BackdropSpec& spec = **patch.backdrop;
    ASSERT_EQ(spec.details.size(), 2u);
    EXPECT_EQ(spec.details[0], (PanoramaDetail{.file = "/b.png", .scale = 16, .at_px = {4000, 12}}));
    EXPECT_EQ(json_of(spec)["details"], json["backdrop"]["details"]);
}

TEST(Panorama, WhatIsWrongWithADetailIsToldWithItsPlace) {
    const auto said = [](const std::string& detail, const std::string& kind = "panorama") {
        const auto json = parse_json(R"({"backdrop": {"kind": ")" + kind +
                                         R"(", "file": "/nowhere/a.png", "details": [)" + detail + "]}}",
                                     10000)
                              .value();
        JsonReader reader(json, "");
        CameraPatch patch = read_camera_patch(reader);
        if (auto done = reader.finish(); !done) return done.error().message;
        const auto loaded = load_backdrop(patch, "");
        return loaded ? std::string() : loaded.error().message;
    };
    const std::string good = R"({"file": "/nowhere/b.png", "scale": 4, "at_px": [0, 0]})";
    EXPECT_THAT(said(good, "plate"), StartsWith("backdrop.details: are those of a panorama"));
    EXPECT_THAT(said(R"({"file": "b.png", "scale": 4, "at_px": [0, 0]})"),
                StartsWith("backdrop.details[0].file: must be an absolute path"));
    EXPECT_THAT(said(good), StartsWith("backdrop.file: /nowhere/a.png: "));
    EXPECT_THAT(said(good + R"(, {"file": "/b.png", "scale": 65, "at_px": [0, 0]})"),
                StartsWith("backdrop.details[1].scale: "));
    EXPECT_THAT(said(R"({"file": "/b.png", "scale": 4, "at_px": [0.5, 0]})"),
                StartsWith("backdrop.details[0].at_px: must be whole numbers"));
    EXPECT_THAT(said(R"({"file": "/b.png", "scale": 4, "at_px": [-1, 0]})"), StartsWith("backdrop.details[0].at_px: "));
    EXPECT_THAT(said(R"({"file": "/b.png", "scale": 4})"), StartsWith("backdrop.details[0].at_px: is missing"));
}

}  // namespace
}  // namespace camrig::world::panorama_test

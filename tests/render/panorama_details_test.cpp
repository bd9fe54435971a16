#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/world/backdrop/panorama.h"
#include "tests/render/support/backdrop_scenes.h"

// Finer parts of panoramas: they are cut from a large one, which shows what is right.
namespace camrig::render::panorama_details_test {
namespace {

/// A tile of a larger panorama.
struct Tile {
    world::PanoramaDetail place;
    world::Image picture;
};

/// What of the panorama, `scale` times as large as the one it is put into, lies in the rectangle; beyond its right edge
/// it goes on at the left.
Tile tile_of(const world::Image& panorama, int scale, const PixelRect& rect) {
    Tile tile{{.file = {}, .scale = scale, .at_px = {rect.x0, rect.y0}},
              {.size = {rect.width(), rect.height()}, .rgba = {}}};
    for (int y = rect.y0; y < rect.y1; ++y) {
        for (int x = rect.x0; x < rect.x1; ++x) {
            const int column = x % panorama.size.width;
            const auto from = panorama.rgba.begin() + std::ptrdiff_t{4} * (y * panorama.size.width + column);
            tile.picture.rgba.insert(tile.picture.rgba.end(), from, from + 4);
        }
    }
    return tile;
}

std::shared_ptr<const world::Panorama> put_together(world::Image whole, const std::vector<Tile>& tiles) {
    int finest = 1;
    for (const Tile& tile : tiles) finest = std::max(finest, tile.place.scale);
    auto maker = world::PanoramaMaker::create(std::move(whole), finest).value();
    for (const Tile& tile : tiles) {
        EXPECT_TRUE(maker.reserve(tile.place, tile.picture.size));
        maker.put(tile.place, tile.picture);
    }
    return maker.finish();
}

/// A large panorama, and the levels of it: [3] has an eighth of its columns.
struct Levels {
    static constexpr int scale = 8;
    std::vector<world::Image> of = world::make_pyramid(noise({1024, 512})).levels;
    const world::Image& fine() const { return of[0]; }
    const world::Image& whole() const { return of[3]; }

    /// All of it in tiles whose sides are no multiples of anything, one of which goes on around the back.
    std::vector<Tile> all() const {
        std::vector<Tile> tiles;
        const int columns[] = {37, 290, 411, 700, 1024 + 37}, rows[] = {0, 101, 263, 300, 512};
        for (int i = 0; i < 4; ++i)
            for (int k = 0; k < 4; ++k)
                tiles.push_back(tile_of(fine(), scale, {columns[i], rows[k], columns[i + 1], rows[k + 1]}));
        return tiles;
    }
};

View looking(double pan_deg, double tilt_deg, double focal_px, const camera::Lens& lens = {}) {
    TestCamera camera{.eye = {3.0, -2.0, 1.6},
                      .size = {163, 121},
                      .focal_px = focal_px,
                      .lens = lens,
                      .quality = world::Quality::simple};
    View view = camera.view();
    view.pose = camera::pose_from_angles(camera.eye,
                                         {.pan = glm::radians(pan_deg), .tilt = glm::radians(tilt_deg), .roll = 0.1})
                    .value();
    return view;
}

frame::FrameRef picture_before(const View& view, std::shared_ptr<const world::Panorama> panorama) {
    const auto by = drawer(2);
    return drawn(*by, TestWorld{}.snapshot(), with_panorama(view, std::move(panorama), 77.0)).front();
}

/// Seams of tiles and of the back show nowhere, from a view that is far too coarse to one that enlarges them.
TEST(PanoramaDetails, ShowThePanoramaThatTheyWereCutFrom) {
    const Levels levels;
    const auto one = world::PanoramaMaker::create(levels.fine(), 1).value().finish();
    const auto tiles = put_together(levels.whole(), levels.all());
    for (const Looking& through : lenses()) {
        for (const double zoom : {0.25, 0.5, 1.0, 1.4, 2.0, 4.0, 25.0}) {
            // The back of it, a corner of tiles, a pole.
            for (const glm::dvec2 turned : {glm::dvec2(-103, 5), glm::dvec2(30, -20), glm::dvec2(0, 88)}) {
                const View view = looking(turned.x, turned.y, zoom * through.focal_px, through.lens);
                const auto expected = picture_before(view, one), got = picture_before(view, tiles);
                int off = 0, far = 0;
                for (std::size_t i = 0; i < got->bytes().size(); ++i) {
                    const int by =
                        std::abs(std::to_integer<int>(expected->bytes()[i]) - std::to_integer<int>(got->bytes()[i]));
                    off += by > 1;
                    far = std::max(far, by);
                }
                // Where a pixel is nearly as large as one of the whole in one direction and larger in the other, at a
                // pole and at the rim of a wide lens, the whole is sampled once for each of both, not along one of
                // them.
                const bool is_plain = turned.y < 80 && zoom > 1.0;
                EXPECT_LE(off, is_plain ? 0 : 163 * 121 * 3 / 100)
                    << through.name << ", zoom " << zoom << ", " << turned.x << ", " << turned.y << ", by " << far;
                EXPECT_LE(far, 6) << through.name << ", zoom " << zoom;
            }
        }
    }
}

/// Half of the sphere has details: where they are is the large panorama, elsewhere the small one, byte for byte, and
/// over the border one goes over into the other.
TEST(PanoramaDetails, EndWithoutATraceBesideThem) {
    world::Image fine{.size = {1024, 512}, .rgba = {}};
    // Smooth, so that both show the same.
    for (int y = 0; y < 512; ++y) {
        for (int x = 0; x < 1024; ++x) {
            const double a = 2.0 * std::numbers::pi * (x + 0.5) / 1024, b = std::numbers::pi * (y + 0.5) / 512;
            for (const double light : {0.5 + 0.4 * std::cos(a) * std::sin(b), 0.5 + 0.4 * std::sin(a) * std::sin(b),
                                       0.5 + 0.4 * std::cos(b)})
                fine.rgba.push_back(static_cast<std::uint8_t>(srgb_code(static_cast<float>(light))));
            fine.rgba.push_back(255);
        }
    }
    const world::Image whole = world::make_pyramid(fine).levels[3];
    const auto tiles = put_together(whole, {tile_of(fine, 8, {300, 140, 560, 345})});
    const auto one = world::PanoramaMaker::create(fine, 1).value().finish(),
               small = world::PanoramaMaker::create(whole, 1).value().finish();
    for (const double focal_px : {110.0, 300.0, 2000.0}) {
        for (const double pan_deg : {77.0, 77.0 + 74.0, 77.0 - 16.0}) {
            const View view = looking(pan_deg, 0.0, focal_px);
            const auto got = picture_before(view, tiles), expected = picture_before(view, one);
            EXPECT_LE(largest_difference(*got, *expected), 3) << focal_px << ", " << pan_deg;
        }
        // Away from them the bytes are those of the panorama alone.
        for (const glm::dvec2 turned : {glm::dvec2(-90, 0), glm::dvec2(77, 80)}) {
            const View view = looking(turned.x, turned.y, std::max(focal_px, 300.0));
            EXPECT_EQ(largest_difference(*picture_before(view, tiles), *picture_before(view, small)), 0) << focal_px;
        }
    }
}

TEST(PanoramaDetails, OfSeveralScalesShowTheFinestThereIs) {
    const Levels levels;
    const Tile eight = tile_of(levels.fine(), 8, {480, 230, 560, 290});
    // The same place and more of it in a quarter of the pixels, in another colour.
    Tile two = tile_of(levels.of[2], 2, {90, 40, 170, 90});
    for (std::size_t i = 0; i < two.picture.rgba.size(); i += 4) two.picture.rgba[i] = 0;
    const auto panorama = put_together(levels.whole(), {eight, two});
    const double pixel_rad = 2.0 * std::numbers::pi / 1024;
    // Pixels as large as the finest.
    const auto near = picture_before(looking(77.0, 0.0, 1.05 / pixel_rad), panorama);
    const auto red_at = [](const frame::FrameRef& frame, int x, int y) {
        return std::to_integer<int>(frame->bytes()[static_cast<std::size_t>(4 * (y * 163 + x))]);
    };
    int reds = 0;
    for (int x = 60; x < 100; ++x) reds += red_at(near, x, 60);
    EXPECT_GT(reds, 40 * 60) << "the finest is not shown";
    EXPECT_EQ(red_at(near, 5, 60), 0) << "beside it is the next";
    // Pixels as large as those of scale 2: its own picture, not what was made of the finest.
    const auto far = picture_before(looking(77.0, 0.0, 0.25 / pixel_rad), panorama);
    EXPECT_LT(red_at(far, 81, 60), 10);
}

TEST(PanoramaDetails, AreTheMeanOfWhatLiesInAPixelWhereTheyAreFiner) {
    world::Image fine{.size = {4096, 2048}, .rgba = {}};
    for (int y = 0; y < 2048; ++y)
        for (int x = 0; x < 4096; ++x) fine.rgba.insert(fine.rgba.end(), {0, 0, 0, 255});
    for (int y = 0; y < 2048; ++y)
        for (int x = 0; x < 4096; ++x)
            std::memset(fine.rgba.data() + 4 * static_cast<std::size_t>(y * 4096 + x), (x + y) % 2 == 0 ? 255 : 0, 3);
    const auto panorama =
        put_together(world::make_pyramid(fine).levels[4], {tile_of(fine, 16, {1000, 500, 3000, 1500})});
    for (const double focal_px : {60.0, 150.0, 240.0, 300.0}) {
        const auto frame = picture_before(looking(77.0, 0.0, focal_px), panorama);
        for (int y = 40; y < 80; ++y) {
            for (int x = 40; x < 120; ++x) {
                const auto at = static_cast<std::size_t>(4 * (y * 163 + x));
                ASSERT_NEAR(std::to_integer<int>(frame->bytes()[at]), srgb_code(0.5), 2) << focal_px << ": " << x << y;
            }
        }
    }
}

}  // namespace
}  // namespace camrig::render::panorama_details_test

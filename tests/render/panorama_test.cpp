
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "tests/render/support/backdrop_scenes.h"

// Panoramas: what each pixel shows is known from its direction, which is worked out here once more.
namespace camrig::render::panorama_test {
namespace {

/// Of a panorama, bilinear in linear light, what shows in that direction of the world.
glm::dvec3 light_towards(const world::Image& panorama, const glm::dvec3& d, double yaw_deg) {
    const auto [width, height] = panorama.size;
    const double pi = std::numbers::pi;
    const double azimuth = std::atan2(d.y, d.x) - glm::radians(yaw_deg);
    const double u = (0.5 - azimuth / (2.0 * pi)) * width - 0.5;
    const double v = (0.5 - std::atan2(d.z, std::hypot(d.x, d.y)) / pi) * height - 0.5;
    const int x = static_cast<int>(std::floor(u)), y = static_cast<int>(std::floor(v));
    const auto at = [&](int column, int row) {
        // Beyond a pole is what lies half around.
        if (row < 0 || row >= height) column += width / 2;
        row = row < 0 ? 0 : std::min(row, height - 1);
        return light_at(panorama, ((column % width) + width) % width, row);
    };
    const double a = u - x, b = v - y;
    return (1 - b) * ((1 - a) * at(x, y) + a * at(x + 1, y)) + b * ((1 - a) * at(x, y + 1) + a * at(x + 1, y + 1));
}

/// The largest angle between the pixel's ray and those of the pixels beside it; infinite where one sees nothing.
double step_at(const camera::CameraModel& model, int x, int y) {
    const auto ray = model.ray({x, y});
    double most = 0.0;
    for (const glm::ivec2 by : {glm::ivec2(1, 0), glm::ivec2(-1, 0), glm::ivec2(0, 1), glm::ivec2(0, -1)}) {
        const auto next = model.ray({x + by.x, y + by.y});
        if (!next) return std::numeric_limits<double>::infinity();
        most = std::max(most, std::acos(std::min(1.0, glm::dot(glm::normalize(*ray), glm::normalize(*next)))));
    }
    return most;
}

TEST(Panorama, ShowsInEachPixelWhatLiesInItsDirection) {
    const world::Image picture = noise({64, 32});
    const double pixel_rad = 2.0 * std::numbers::pi / picture.size.width;
    const world::SnapshotRef empty = TestWorld{}.snapshot();
    for (const Looking& looking : lenses()) {
        for (const double zoom : {1.0, 4.0, 25.0}) {
            for (const glm::dvec2 turned :
                 {glm::dvec2(0, 0), glm::dvec2(175, 20), glm::dvec2(-100, -89), glm::dvec2(33, 88)}) {
                TestCamera camera{.eye = {3.0, -2.0, 1.6},
                                  .size = {163, 121},
                                  .focal_px = looking.focal_px * zoom,
                                  .lens = looking.lens,
                                  .quality = world::Quality::simple};
                View view = camera.view();
                view.pose =
                    camera::pose_from_angles(
                        camera.eye, {.pan = glm::radians(turned.x), .tilt = glm::radians(turned.y), .roll = 0.1})
                        .value();
                for (const double yaw : {0.0, 77.0}) {
                    const View seen = with_panorama(view, picture, yaw);
                    const glm::dmat3 turn = camera::world_from_optical_rotation(view.pose);
                    const auto by = drawer(2);
                    const camera::CameraModel model = camera.model();
                    int most = 0, compared = 0;
                    glm::ivec2 where(0);
                    frame::FrameRef last;
                    for (int n = 0; n < 3; ++n) {
                        const auto frame = drawn(*by, empty, seen).front();
                        if (last) {
                            ASSERT_TRUE(std::ranges::equal(last->bytes(), frame->bytes()));
                        }
                        last = frame;
                    }
                    for (int y = 0; y < 121; ++y) {
                        for (int x = 0; x < 163; ++x) {
                            const auto* const got =
                                reinterpret_cast<const std::uint8_t*>(last->bytes().data()) + 4 * (y * 163 + x);
                            const auto ray = model.ray({x, y});
                            if (!ray) {
                                ASSERT_EQ(got[0] + got[1] + got[2], 0) << "the lens sees nothing";
                                continue;
                            }
                            const glm::dvec3 towards = glm::normalize(turn * *ray);
                            // Where pixels of the panorama are smaller than the view's the mean is shown: near a
                            // pole, and at the rim of a lens.
                            if (const double step = step_at(model, x, y);
                                step > 0.9 * pixel_rad || std::hypot(towards.x, towards.y) < 2.0 * step / pixel_rad)
                                continue;
                            const glm::dvec3 light = light_towards(picture, towards, yaw);
                            ++compared;
                            for (int c = 0; c < 3; ++c) {
                                const int off = std::abs(got[c] - srgb_code(light[c]));
                                if (off > most) where = {x, y};
                                most = std::max(most, off);
                            }
                            ASSERT_EQ(got[3], 255);
                        }
                    }
                    EXPECT_GT(compared, 5000);
                    EXPECT_LE(most, 1) << looking.name << " at zoom " << zoom << ", pan " << turned.x << ", yaw " << yaw
                                       << ", at " << where.x << ", " << where.y;
                }
            }
        }
    }
}

/// Nothing of a pattern is left that is finer than the pixels: the mean of its light is.
TEST(Panorama, IsTheMeanOfWhatLiesInAPixelWhereItIsFiner) {
    world::Image picture{.size = {4096, 2048}, .rgba = {}};
    for (int y = 0; y < 2048; ++y)
        for (int x = 0; x < 4096; ++x) picture.rgba.insert(picture.rgba.end(), 4, (x + y) % 2 == 0 ? 255 : 0);
    const TestCamera camera{.eye = {0, 0, 1.6}, .size = {96, 64}, .focal_px = 60.0};
    const auto by = drawer();
    const auto frame = drawn(*by, TestWorld{}.snapshot(), with_panorama(camera.view(), picture, 0.0)).front();
    int low = 255, high = 0;
    for (std::size_t i = 0; i < frame->bytes().size(); i += 4) {
        low = std::min(low, std::to_integer<int>(frame->bytes()[i]));
        high = std::max(high, std::to_integer<int>(frame->bytes()[i]));
    }
    EXPECT_GE(low, srgb_code(0.5) - 2);
    EXPECT_LE(high, srgb_code(0.5) + 2);
}

TEST(Panorama, HasPeopleWithTruthBeforeItHoweverTheHeadIsTurned) {
    const world::Image picture = noise({64, 32});
    for (const world::Quality quality : qualities) {
        const auto by = drawer(2), bare = drawer(1, 0), full = drawer();
        for (int n = 0; n < 6; ++n) {
            TestCamera camera{.eye = {0, 0, 1.6}, .size = {163, 121}, .focal_px = 120.0, .quality = quality};
            View view = camera.view();
            // Turned between the pictures, but for the last three.
            view.pose =
                camera::pose_from_angles(camera.eye, {.pan = 0.1 * std::min(n, 3) - 0.2, .tilt = -0.1, .roll = 0})
                    .value();
            TestWorld world;
            world.lights = yard().lights;
            world.movers = walked({}, -1.0 + 0.3 * n).movers;
            const View seen = all_kinds(with_panorama(view, picture, 10.0));
            const auto moment = world.snapshot();
            const auto a = drawn(*by, moment, seen), b = drawn(*bare, moment, seen);
            for (std::size_t k = 0; k < a.size(); ++k)
                EXPECT_TRUE(std::ranges::equal(a[k]->bytes(), b[k]->bytes())) << to_string(quality) << n;
            // Ids and classes are those of a view of the same people and nothing else.
            const auto alone = drawn(*full, moment, all_kinds(view));
            EXPECT_TRUE(std::ranges::equal(a[2]->bytes(), alone[2]->bytes()));
            const auto is_person = [&](std::size_t i) {
                std::uint32_t id = 0;
                std::memcpy(&id, a[2]->bytes().data() + 4 * i, 4);
                return id == person_id;
            };
            int people = 0;
            for (std::size_t i = 0; i < 163 * 121; ++i) people += is_person(i);
            EXPECT_GT(people, 300);
        }
    }
}

}  // namespace
}  // namespace camrig::render::panorama_test

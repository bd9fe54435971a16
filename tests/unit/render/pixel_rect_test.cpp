#include "core/render/pixel_rect.h"

#include <gmock/gmock.h>

#include "core/base/random.h"

namespace camrig::render {
namespace {

const ViewTransform seen_from = make_view_transform({}, {640, 480}, {500.0, 510.0, 319.5, 239.5}, 0.05, 0.0);

glm::dmat4 at(glm::dvec3 position) {
    glm::dmat4 result(1.0);
    result[3] = glm::dvec4(position, 1.0);
    return result;
}

TEST(ScreenBounds, HoldEveryPointOfTheBox) {
    const glm::vec3 low(-0.4f, -0.2f, -0.7f), high(0.3f, 0.6f, 0.5f);
    for (const glm::dvec3& place : {glm::dvec3(0, 0, 4), {1.5, -1, 3}, {-2.2, 0.4, 3.5}, {0.1, 0.1, 0.8}}) {
        const auto rect = screen_bounds(seen_from, at(place), low, high);
        ASSERT_TRUE(rect);
        for (int i = 0; i <= 10; ++i) {
            for (int j = 0; j <= 10; ++j) {
                for (int k = 0; k <= 10; ++k) {
                    const glm::dvec3 p = place + glm::dvec3(low) + glm::dvec3(high - low) * glm::dvec3(i, j, k) / 10.0;
                    const glm::dvec2 pixel(500.0 * p.x / p.z + 319.5, 510.0 * p.y / p.z + 239.5);
                    if (pixel.x < 0 || pixel.x >= 639.5 || pixel.y < 0 || pixel.y >= 479.5) continue;
                    EXPECT_GE(pixel.x, rect->x0 + (rect->x0 > 0));
                    EXPECT_LE(pixel.x, rect->x1 - 2 + (rect->x1 == 640) * 2);
                    EXPECT_GE(pixel.y, rect->y0 + (rect->y0 > 0));
                    EXPECT_LE(pixel.y, rect->y1 - 2 + (rect->y1 == 480) * 2);
                }
            }
        }
    }
}

TEST(ScreenBounds, AreThePictureAtTheNearPlaneAndNothingBesideIt) {
    const glm::vec3 low(-0.5f), high(0.5f);
    EXPECT_EQ(screen_bounds(seen_from, at({0.0, 0.0, 0.5}), low, high), (PixelRect{0, 0, 640, 480}));
    EXPECT_EQ(screen_bounds(seen_from, at({0.0, 0.0, -5.0}), low, high), (PixelRect{0, 0, 640, 480}));
    EXPECT_EQ(screen_bounds(seen_from, at({30.0, 0.0, 5.0}), low, high), std::nullopt);
    EXPECT_EQ(screen_bounds(seen_from, at({0.0, -1e12, 5.0}), low, high), std::nullopt);
}

TEST(DisjointCover, HoldsEveryRectangleInExactlyOneOfAFew) {
    for (const std::size_t count : {0u, 1u, 2u, 9u, 40u, 200u}) {
        std::vector<PixelRect> rects;
        for (std::uint32_t i = 0; i < count; ++i) {
            const auto draw = [&](std::uint32_t what, int limit) {
                return static_cast<int>(random_unit(7, what, i) * limit);
            };
            const int x = draw(0, 600), y = draw(1, 440);
            rects.push_back({x, y, x + 1 + draw(2, 40), y + 1 + draw(3, 40)});
        }
        const auto cover = disjoint_cover(rects, 8);
        EXPECT_LE(cover.size(), 8u);
        for (const PixelRect& rect : rects) {
            int holds = 0, touches = 0;
            for (const PixelRect& each : cover) {
                holds += each.x0 <= rect.x0 && each.y0 <= rect.y0 && each.x1 >= rect.x1 && each.y1 >= rect.y1;
                touches += each.intersects(rect);
            }
            EXPECT_EQ(holds, 1);
            EXPECT_EQ(touches, 1);
        }
    }
}

}  // namespace
}  // namespace camrig::render

#include "core/truth/edge_piece.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/unit/camera/random_lens.h"

namespace camrig::truth {
namespace {

/// Up to 180 deg from the axis, many of them nearly along it or against it.
glm::dvec3 random_point(camera::Draw& draw, bool is_plane) {
    const double across = std::pow(10.0, draw.uniform(-6, 1)), turn = draw.uniform(-4, 4);
    const double ahead = is_plane || draw.uniform(0, 1) < 0.5 ? 1.0 : -1.0;
    return draw.uniform(0.5, 20) * glm::dvec3(across * std::cos(turn), across * std::sin(turn), ahead);
}

/// Whether every picture of a part of the edge lies in the rectangle of one of its pieces; the pieces are halved so
/// often before. Returns how many points were looked at.
int check_pieces(const camera::CameraModel& camera, const glm::dvec3& a, const glm::dvec3& b, int halvings) {
    EdgeTracer tracer(camera);
    std::vector<EdgePiece> pieces;
    for (const EdgePiece& piece : tracer.trace(a, b)) pieces.push_back(piece);
    for (int i = 0; i < halvings; ++i) {
        std::vector<EdgePiece> halves;
        for (const EdgePiece& piece : pieces) {
            const auto [first, second] = tracer.halves(piece);
            halves.insert(halves.end(), {first, second});
        }
        pieces.swap(halves);
    }
    int looked_at = 0;
    for (int i = 1; i < 400; ++i) {
        const glm::dvec3 point = glm::mix(a, b, i / 400.0);
        // The last 1e-5 rad before exactly backwards and the last 1e-9 of a field are left out by contract.
        const double angle = std::atan2(std::hypot(point.x, point.y), point.z);
        if (angle > 3.14158 || angle > camera.lens().valid_angle() - 1e-7) continue;
        const auto pixel = camera.project(point);
        if (!pixel) continue;
        const glm::dvec2 slack = 1e-9 * (glm::abs(*pixel) + 1.0);
        EXPECT_TRUE(std::ranges::any_of(pieces,
                                        [&](const EdgePiece& piece) {
                                            return glm::all(glm::lessThanEqual(piece.min - slack, *pixel)) &&
                                                   glm::all(glm::lessThanEqual(*pixel, piece.max + slack));
                                        }))
            << "point " << i << " at " << pixel->x << ", " << pixel->y << ", " << angle << " rad";
        ++looked_at;
    }
    return looked_at;
}

TEST(EdgePiece, HoldsThePictureOfTheEdgeThroughManyLenses) {
    int looked_at = 0;
    for (std::uint64_t n = 0; n < 150; ++n) {
        const auto camera = camera::CameraModel::create({640, 480}, {300, 320, 319.5, 239.5}, camera::random_lens(n));
        if (!camera) continue;
        camera::Draw draw(9000 + n);
        const bool is_plane = camera->lens().lens().model != camera::LensModel::equidistant;
        for (int i = 0; i < 12; ++i) {
            const glm::dvec3 a = random_point(draw, is_plane), b = random_point(draw, is_plane);
            SCOPED_TRACE(testing::Message() << "lens " << n << " edge " << i);
            looked_at += check_pieces(*camera, a, b, i % 4);
        }
    }
    EXPECT_GT(looked_at, 100'000);
}

TEST(EdgePiece, ShrinksOntoTheEdgeWithTheSquareOfItsLength) {
    const auto camera =
        camera::CameraModel::create({640, 480}, {300, 300, 319.5, 239.5}, {camera::LensModel::plumb_bob, {-0.25, 0.05}})
            .value();
    EdgeTracer tracer(camera);
    // Its picture bulges to the right: the extreme is in the middle.
    const auto pieces = tracer.trace({1, -0.7, 2}, {1, 0.75, 2});
    ASSERT_EQ(pieces.size(), 1u);
    const double exact = camera.project({1, 0, 2})->x;
    EdgePiece piece = pieces.front();
    for (double squares = 1.0; squares < 1e8; squares *= 4.0) {
        const double excess = piece.max.x - exact;
        EXPECT_GE(excess, -1e-9);
        EXPECT_LT(excess, 300.0 / squares);
        const auto [first, second] = tracer.halves(piece);
        piece = first.max.x > second.max.x ? first : second;
    }
}

TEST(EdgePiece, AnEdgeBehindAFisheyeIsSeenAtBothEndsOnly) {
    const auto camera =
        camera::CameraModel::create({640, 480}, {120, 120, 319.5, 239.5}, {camera::LensModel::equidistant, {-0.05}})
            .value();
    ASSERT_GT(camera.lens().valid_angle(), 1.6);
    const double out = camera.lens().valid_angle() - 0.1;
    const glm::dvec3 left(-std::sin(out), 0.01, std::cos(out)), right(std::sin(out), 0.01, std::cos(out));
    EdgeTracer tracer(camera);
    EXPECT_EQ(tracer.trace(left, right).size(), 2u);
    EXPECT_EQ(tracer.trace({-0.1, 0.01, -1}, {0.1, 0.01, -1}).size(), 0u);
    EXPECT_EQ(tracer.trace({-0.1, 0.01, 1}, {0.1, 0.01, 1}).size(), 1u);
}

}  // namespace
}  // namespace camrig::truth

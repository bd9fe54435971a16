#include "core/render/software/shadow_lookup.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"

// What bounds of tiles spare a look-up, and that it is none the worse for it.
namespace camrig::render::software {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr std::size_t tiles_of(int side) {
    return static_cast<std::size_t>(shadow_tiles(side)) * static_cast<std::size_t>(shadow_tiles(side));
}

// The filter lies in the map wherever it begins, and movers are noted as far around as it reaches.
static_assert(shadow_pad - 2 - shadow_filter_before >= 0);
static_assert(2 + shadow_filter_behind < shadow_pad);
static_assert(std::max(shadow_filter_before, shadow_filter_behind) <= shadow_filter_texels);

class NumbersOfMaps {
public:
    float uniform(double low, double high) {
        return static_cast<float>(low + (high - low) * random_unit(11, 0, counter_++));
    }

private:
    std::uint64_t counter_ = 0;
};

/// A map whose points are its texels: x and y are column and row, z the depth. Of plains and steps, empty around.
struct TestedMap {
    int side;
    std::vector<float> texels;
    std::vector<std::int32_t> movers;
    std::vector<ShadowBounds> bounds;

    ShadowInView seen() const {
        ShadowInView made;
        made.side = side;
        const std::array<glm::dvec4, 4> rows{glm::dvec4(1, 0, 0, 0), glm::dvec4(0, 1, 0, 0), glm::dvec4(0, 0, 1, 0),
                                             glm::dvec4(0, 0, 0, 1)};
        std::ranges::transform(rows, made.rows.begin(), [](const glm::dvec4& row) { return glm::vec4(row); });
        made.planes = plane_rows(rows);
        made.texels = texels.data();
        made.movers = movers.data();
        made.bounds = bounds.data();
        return made;
    }
};
TestedMap made_shadow_map(NumbersOfMaps& numbers, int side) {
    const int stride = shadow_stride(side), tiles = shadow_tiles(side);
    TestedMap map{.side = side,
                  .texels = std::vector<float>(2 * shadow_texels_of_map(side), -infinity),
                  .movers = std::vector<std::int32_t>(tiles_of(side), 0),
                  .bounds = {}};
    for (int i = 0; i < side * side / 1024; ++i) {
        const int x0 = static_cast<int>(numbers.uniform(shadow_pad, shadow_pad + side - 90));
        const int y0 = static_cast<int>(numbers.uniform(shadow_pad, shadow_pad + side - 90));
        const int width = static_cast<int>(numbers.uniform(1, 90));
        const float depth = numbers.uniform(0.0, 1.0);
        for (int y = y0; y < y0 + width; ++y)
            std::fill_n(map.texels.begin() + std::ptrdiff_t{y} * stride + x0, width, depth);
    }
    // Of movers, in every seventh tile, something else everywhere.
    const auto behind = static_cast<std::int32_t>(shadow_texels_of_map(side));
    std::fill(map.texels.begin() + behind, map.texels.end(), 0.4f);
    for (std::size_t tile = 0; tile < tiles_of(side); tile += 7) map.movers[tile] = behind;
    for (int row = 0; row < tiles; ++row) {
        for (int column = 0; column < tiles; ++column) {
            ShadowBounds& made = map.bounds.emplace_back(infinity, -infinity);
            for (int y = row * shadow_tile - 2; y < (row + 1) * shadow_tile + 2; ++y) {
                for (int x = column * shadow_tile - 2; x < (column + 1) * shadow_tile + 2; ++x) {
                    if (x < 0 || y < 0 || x >= stride || y >= stride) continue;
                    const float texel = map.texels[static_cast<std::size_t>(y * stride + x)];
                    made = {std::min(made.least, texel), std::max(made.most, texel)};
                }
            }
        }
    }
    return map;
}

class ShadowLookup : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Sides, ShadowLookup, testing::Values(shadow_map_side, fine_shadow_map_side),
                         testing::PrintToStringParamName());

TEST_P(ShadowLookup, HasTheSameBitsWhetherTilesAreBoundedOrNot) {
    const int side = GetParam();
    NumbersOfMaps numbers;
    const TestedMap map = made_shadow_map(numbers, side);
    const std::vector<ShadowBounds> none(tiles_of(side), {-infinity, infinity});
    ShadowInView bounded = map.seen(), unbounded = map.seen();
    unbounded.bounds = none.data();
    int lit = 0, dark = 0, between = 0;
    for (int i = 0; i < 40000; ++i) {
        Lanes3 at;
        for (int k = 0; k < lane_count; ++k) {
            at.x[k] = numbers.uniform(-20.0, shadow_stride(side) + 20.0);
            at.y[k] = numbers.uniform(-20.0, shadow_stride(side) + 20.0);
            at.z[k] = numbers.uniform(-0.1, 1.1);
        }
        // What no number is has some light, and the same.
        if (i % 1000 == 0) at.z[3] = std::numeric_limits<float>::quiet_NaN();
        if (i % 1000 == 1) at.x[5] = std::numeric_limits<float>::quiet_NaN();
        if (i % 1000 == 2) at.z[1] = infinity;
        // Depth is in thousandths of a texel: what leans by so much falls by 0.01 a texel.
        const float lean = i % 3 == 0 ? 0.0f : numbers.uniform(-0.01, 0.01);
        const Lanes3 n{lanes(lean), lanes(-0.5f * lean), lanes(1.0f)};
        const Lanes3 towards{lanes(0.0f), lanes(0.0f), lanes(1.0f)};
        const bool has_movers = i % 2 == 0;
        const Lanes some = share_in_map<PlainIsa>(bounded, has_movers, at, n, towards);
        const Lanes same = share_in_map<PlainIsa>(unbounded, has_movers, at, n, towards);
        for (int k = 0; k < lane_count; ++k) {
            ASSERT_EQ(some[k], same[k]) << at.x[k] << " " << at.y[k] << " " << at.z[k];
            ++(some[k] > 0.999f ? lit : some[k] == 0.0f ? dark : between);
        }
    }
    EXPECT_GT(lit, 10000);
    EXPECT_GT(dark, 10000);
    EXPECT_GT(between, 1000);
}

/// A plane that a texel's step to the right makes deeper by `right`, and one down by `down`, as a map has it: from its
/// texels' middles.
TestedMap plane_map(int side, float right, float down) {
    const int stride = shadow_stride(side);
    TestedMap map{.side = side,
                  .texels = std::vector<float>(2 * shadow_texels_of_map(side)),
                  .movers = std::vector<std::int32_t>(tiles_of(side), 0),
                  .bounds = std::vector<ShadowBounds>(tiles_of(side), {-infinity, infinity})};
    for (int y = 0; y < stride; ++y)
        for (int x = 0; x < stride; ++x)
            map.texels[static_cast<std::size_t>(y * stride + x)] =
                right * (static_cast<float>(x) + 0.5f) + down * (static_cast<float>(y) + 0.5f);
    return map;
}

/// Without any offset: what is compared is the plane itself.
TEST_P(ShadowLookup, APlaneLiesOnItselfHoweverItLeans) {
    const int side = GetParam();
    NumbersOfMaps numbers;
    for (const glm::vec2 slope :
         {glm::vec2(0.0f), glm::vec2(0.5f, 0.0f), glm::vec2(0.0f, -2.0f), glm::vec2(3.0f, -4.0f)}) {
        const TestedMap map = plane_map(side, slope.x, slope.y);
        for (int i = 0; i < 2000; ++i) {
            const float x = numbers.uniform(20.0, side), y = numbers.uniform(20.0, side);
            const Lanes3 n{lanes(-slope.x), lanes(-slope.y), lanes(1.0f)},
                towards{lanes(0.0f), lanes(0.0f), lanes(1.0f)};
            const auto share = [&](float over) {
                return share_in_map<PlainIsa>(
                    map.seen(), false, {lanes(x), lanes(y), lanes(slope.x * x + slope.y * y + over)}, n, towards)[0];
            };
            // Depth is reversed: over it is more. Floats are as fine as 0.001 here.
            ASSERT_EQ(share(0.01f), 1.0f) << x << " " << y << ", slope " << slope.x << " " << slope.y;
            ASSERT_EQ(share(-0.01f), 0.0f) << x << " " << y << ", slope " << slope.x << " " << slope.y;
        }
    }
}

/// Of any projection: a step to the right or down in the map along a plane.
TEST(ShadowPlanes, PlaneRowsTellTheSlopeOfEveryPlaneInEveryMap) {
    NumbersOfMaps numbers;
    const auto number = [&] { return double{numbers.uniform(-1.0, 1.0)}; };
    for (int i = 0; i < 200; ++i) {
        std::array<glm::dvec4, 4> rows;
        for (glm::dvec4& row : rows) row = {number(), number(), number(), number()};
        rows[3].w += 6.0;  // whatever is looked at lies before it
        const glm::dvec3 n(number(), number(), number()), p(number(), number(), number());
        const auto place = [&](const glm::dvec3& q) {
            const glm::dvec4 at(q, 1.0);
            return glm::dvec3(glm::dot(rows[0], at), glm::dot(rows[1], at), glm::dot(rows[2], at)) /
                   glm::dot(rows[3], at);
        };
        const auto planes = plane_rows(rows);
        const glm::dvec4 plane(n, -glm::dot(n, p));
        const double a = glm::dot(glm::dvec4(planes[0]), plane), b = glm::dot(glm::dvec4(planes[1]), plane);
        const double c = glm::dot(glm::dvec4(planes[2]), plane);
        const glm::dvec3 along = glm::cross(n, glm::dvec3(number(), number(), number()));
        const glm::dvec3 step = place(p + along) - place(p);
        EXPECT_NEAR(c * step.z, -a * step.x - b * step.y, 1e-5 * glm::length(glm::dvec3(a, b, c))) << i;
    }
}

}  // namespace
}  // namespace camrig::render::software

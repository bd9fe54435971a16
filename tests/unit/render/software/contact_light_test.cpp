#include "core/render/software/contact_light.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/base/random.h"

// What a capsule hides, against rays.
namespace camrig::render::software {
namespace {

class Numbers {
public:
    float uniform(double low, double high) {
        return static_cast<float>(low + (high - low) * random_unit(7, 0, counter_++));
    }

private:
    std::uint64_t counter_ = 0;
};

scene::CapsuleInView capsule(glm::vec3 from, glm::vec3 to, float radius) {
    return {.from = from, .radius = radius, .along = to - from, .length = glm::length(to - from)};
}

CAMRIG_LANES Lanes3 all(const glm::vec3& v) {
    return PointGroup::vector(v);
}
float hidden(const scene::CapsuleInView& by, const glm::vec3& at, const glm::vec3& n) {
    return hidden_share(by, all(at), all(n))[0];
}
/// What the reach takes away.
float fade(const scene::CapsuleInView& by, const glm::vec3& at) {
    const float reach = reach_of(by);
    const float left = std::max(0.0f, 1.0f - place_at(by, all(at)).distance2[0] / (reach * reach));
    return left * left;
}

/// Whether a ray from the origin meets a capsule: its distance to the line, by steps along it.
bool meets(const glm::dvec3& ray, const glm::dvec3& from, const glm::dvec3& to, double radius) {
    for (int i = 0; i <= 200; ++i) {
        const glm::dvec3 at = from + (to - from) * (i / 200.0);
        const double along = glm::dot(at, ray);
        if (along > 0.0 && glm::dot(at, at) - along * along < radius * radius) return true;
    }
    return false;
}
/// The share of light of an even sky over a horizontal place at the origin, by rays of equal weight.
double counted(const scene::CapsuleInView& by) {
    constexpr int side = 160;
    int met = 0;
    for (int i = 0; i < side; ++i)
        for (int j = 0; j < side; ++j) {
            const double up = std::sqrt((i + 0.5) / side), level = std::sqrt(1.0 - up * up);
            const double pan = 2.0 * std::numbers::pi * (j + 0.5) / side;
            met += meets({level * std::cos(pan), level * std::sin(pan), up}, glm::dvec3(by.from),
                         glm::dvec3(by.from + by.along), by.radius);
        }
    return met / double(side * side);
}

TEST(ContactLight, OfCapsulesIsWhatRaysCount) {
    struct Case {
        glm::vec3 from, to;
        float radius;
    };
    for (const Case& of :
         {Case{{0.15f, 0, 0.08f}, {0.15f, 0, 0.5f}, 0.06f}, Case{{0.3f, 0, 0.08f}, {0.3f, 0, 0.5f}, 0.06f},
          Case{{0.0f, 0, 0.2f}, {0.0f, 0, 0.6f}, 0.08f}, Case{{-0.1f, 0.1f, 0.05f}, {0.1f, 0.1f, 0.05f}, 0.045f},
          Case{{-0.1f, 0, 0.3f}, {0.1f, 0.1f, 0.35f}, 0.1f}}) {
        const scene::CapsuleInView by = capsule(of.from, of.to, of.radius);
        const double rays = counted(by), formula = hidden(by, {}, {0, 0, 1}) / fade(by, {});
        EXPECT_NEAR(formula, rays, 0.2 * rays + 0.003) << of.from.x << " " << of.from.z;
        EXPECT_GT(rays, 0.01);
    }
}

TEST(ContactLight, BehindTheHorizonOrOutOfReachIsNothing) {
    const scene::CapsuleInView by = capsule({0.2f, 0, -0.5f}, {0.2f, 0, -0.1f}, 0.05f);
    EXPECT_EQ(hidden(by, {}, {0, 0, 1}), 0.0f);
    EXPECT_GT(hidden(by, {}, {0, 0, -1}), 0.0f);
    EXPECT_EQ(hidden(by, {2.0f, 0, -1}, {-1, 0, 0}), 0.0f);
    const scene::CapsuleInView ball = capsule({0, 0, 0.1f}, {0, 0, 0.1f}, 0.1f);
    EXPECT_NEAR(hidden(ball, {}, {0, 0, 1}) / fade(ball, {}), 1.0f, 1e-5f) << "it lies on the place";
    EXPECT_NEAR(hidden(ball, {0.2f, 0, 0}, {0, 0, 1}) / fade(ball, {0.2f, 0, 0}), 1.0 / std::pow(5.0, 1.5), 1e-5)
        << "a ball that is all above the horizon: the exact form factor";
}

TEST(ContactLight, IsAShareWhateverThePlace) {
    Numbers random;
    for (int i = 0; i < 20000; ++i) {
        const auto vector = [&](double size) {
            return glm::vec3{random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
        };
        const glm::vec3 from = vector(0.4), n = glm::normalize(vector(1.0) + glm::vec3(1e-3f));
        const float share = hidden(capsule(from, i % 7 == 0 ? from : vector(0.4), 0.1f), vector(0.4), n);
        ASSERT_GE(share, 0.0f);
        ASSERT_LE(share, 1.0f);
    }
}

TEST(ContactLight, OfPlacesThatMoversMayDarkenIsAllThatTheyDo) {
    Numbers random;
    scene::BodiesInView bodies;
    bodies.capsules = {capsule({0, 0, 2}, {0, 0.4f, 2}, 0.1f)};
    bodies.bodies = {{.middle = {0, 0.2f, 2}, .radius2 = 1.0f, .object = ObjectId{3}, .count = 1, .is_moving = 1}};
    int darkened = 0;
    for (int i = 0; i < 5000; ++i) {
        const glm::vec3 at{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(1, 3)};
        const glm::vec3 n = glm::normalize(glm::vec3{random.uniform(-1, 1), random.uniform(-1, 1), 1e-3f});
        const float open = open_share<PlainIsa>(bodies, ObjectId{1}, true, all(at), all(n))[0];
        EXPECT_EQ(open_share<PlainIsa>(bodies, ObjectId{1}, false, all(at), all(n))[0], 1.0f);
        EXPECT_EQ(open_share<PlainIsa>(bodies, ObjectId{3}, true, all(at), all(n))[0], 1.0f) << "its own";
        if (open == 1.0f) continue;
        ++darkened;
        ASSERT_NE(may_be_darkened<PlainIsa>(bodies, all(at))[0], 0);
    }
    EXPECT_GT(darkened, 100);
}

}  // namespace
}  // namespace camrig::render::software

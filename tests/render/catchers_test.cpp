#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include <gtest/gtest.h>

#include "tests/render/support/backdrop_scenes.h"

// Shadows on what a picture shows, where their place and their depth are known exactly; shapes that only catch them, or
// only hide.
namespace camrig::render::catchers_test {
namespace {

using world::ProxyRole;

std::uint32_t word(const frame::Frame& frame, std::size_t pixel) {
    std::uint32_t value = 0;
    std::memcpy(&value, frame.bytes().data() + 4 * pixel, sizeof value);
    return value;
}
int code(const frame::Frame& frame, std::size_t pixel, std::size_t channel) {
    return std::to_integer<int>(frame.bytes()[4 * pixel + channel]);
}
world::Image plain(ImageSize size, const glm::ivec3& codes) {
    world::Image image{.size = size, .rgba = {}};
    for (std::int64_t i = 0; i < size.pixels(); ++i)
        for (const int c : {codes.r, codes.g, codes.b, 255}) image.rgba.push_back(static_cast<std::uint8_t>(c));
    return image;
}

/// Light of these colours from around and from suns, on level ground that is the camera's own shape.
struct Ground {
    glm::vec3 around{0.12f, 0.2f, 0.34f};
    struct Sun {
        glm::vec3 color;
        glm::dvec3 from;  ///< towards it
    };
    std::vector<Sun> suns;
    glm::ivec3 codes{150, 120, 200};
    TestCamera camera{.size = {640, 480}, .focal_px = 400.0, .quality = world::Quality::beautiful};
    camera::Pose pose;

    frame::FrameRef with(world::Instance mover) const {
        TestWorld world;
        world.environment = {.background = glm::vec3(0.0f), .ambient_sky = around, .ambient_ground = around};
        for (const Sun& sun : suns) {
            world.lights.push_back(light_of(world::LightType::directional, 1.0f, {}, -glm::normalize(sun.from)));
            world.lights.back().color = sun.color;
        }
        world.movers = {std::move(mover)};
        world::ProxiesSpec proxies;
        proxies.ground.emplace().polygon_m = {{-1, -8}, {12, -8}, {12, 8}, {-1, 8}};
        View view = camera.view();
        view.pose = pose;
        const auto by = drawer();
        return drawn(*by, world.snapshot(), with_plate(view, plain(camera.size, codes), proxies)).front();
    }
    /// Where the picture has this point of the ground.
    std::size_t pixel(const glm::dvec2& place) const {
        const glm::dmat3 optical_from_world = glm::transpose(camera::world_from_optical_rotation(pose));
        const glm::dvec2 at =
            camera.model().project(optical_from_world * (glm::dvec3(place, 0.0) - pose.position)).value();
        return static_cast<std::size_t>(std::lround(at.y) * camera.size.width + std::lround(at.x));
    }
    /// What is left of the light where it is only of these suns, in each channel.
    glm::ivec3 codes_in(const std::vector<bool>& shines) const {
        glm::ivec3 made;
        for (int c = 0; c < 3; ++c) {
            double all = around[c], left = around[c];
            for (std::size_t i = 0; i < suns.size(); ++i) {
                const double light = suns[i].color[c] * glm::normalize(suns[i].from).z;
                all += light;
                left += shines[i] ? light : 0.0;
            }
            made[c] = srgb_code(left / all * linear_of(codes[c]));
        }
        return made;
    }
    void expect_codes(const frame::FrameRef& frame, const glm::dvec2& place, const glm::ivec3& expected,
                      const char* what) const {
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(code(*frame, pixel(place), static_cast<std::size_t>(c)), expected[c], 1)
                << what << ", channel " << c;
    }
};

world::Instance box_at(const glm::vec3& half, const glm::dvec3& middle) {
    return instance_of(model_of(box(half), colored(glm::vec3(0.4f))), middle, person_id);
}

TEST(Catcher, APolesShadowEndsWhereTheSunPutsItAndHasItsShareOfLightInEachChannel) {
    Ground ground;
    ground.pose = camera::pose_look_at({5.0, 0.0, 9.0}, {5.0, 0.0, 0.0}).value();
    const double height = 2.0;
    for (const double elevation_deg : {35.0, 50.0, 70.0}) {
        const double e = glm::radians(elevation_deg);
        // Coloured: what is left in the shadow is that of the sky, another share in each channel.
        ground.suns = {{{1.1f, 0.8f, 0.45f}, {-std::cos(e), 0.0, std::sin(e)}}};
        const auto frame = ground.with(box_at({0.08f, 0.3f, 0.5f * static_cast<float>(height)}, {4.0, 0.0, 1.0}));
        const glm::ivec3 shaded = ground.codes_in({false});
        EXPECT_GT(std::abs(shaded.r * 200 - shaded.b * 150), 1000) << "the shares of red and blue are the same";
        const double tip = 4.08 + height / std::tan(e);
        ground.expect_codes(frame, {4.0 + 0.7 * (tip - 4.0), 0.0}, shaded, "in the shadow");
        ground.expect_codes(frame, {4.2 + 0.1 * (tip - 4.2), 0.2}, shaded, "at its foot");
        for (const glm::dvec2 lit : {glm::dvec2(tip + 0.15, 0.0), {4.6, 0.45}, {3.5, 0.0}})
            for (int c = 0; c < 3; ++c)
                EXPECT_EQ(code(*frame, ground.pixel(lit), static_cast<std::size_t>(c)), ground.codes[c]);
        // Its end is where half of the sun is left, between the two.
        double end = 4.3;
        while (code(*frame, ground.pixel({end, 0.0}), 0) < (ground.codes.r + shaded.r) / 2 && end < 9.0) end += 0.005;
        EXPECT_NEAR(end, tip, 0.05) << elevation_deg;
    }
}

TEST(Catcher, TwoSunsLeaveThreeShares) {
    Ground ground;
    ground.suns = {{{0.5f, 0.4f, 0.2f}, {0.0, 1.0, 1.0}}, {{0.1f, 0.3f, 0.6f}, {0.0, -1.0, 1.0}}};
    // From below the slab, whose shadows lie a metre to either side.
    ground.pose = camera::pose_look_at({-4.0, 0.0, 0.9}, {3.0, 0.0, 0.0}).value();
    const auto frame = ground.with(box_at({1.0f, 1.5f, 0.01f}, {3.0, 0.0, 1.0}));
    ground.expect_codes(frame, {3.0, 0.0}, ground.codes_in({false, false}), "in both");
    ground.expect_codes(frame, {3.0, -1.6}, ground.codes_in({false, true}), "in that of the first");
    ground.expect_codes(frame, {3.0, 1.6}, ground.codes_in({true, false}), "in that of the second");
    ground.expect_codes(frame, {3.0, -3.0}, ground.codes, "in none");
}

/// Ground, a wall and a pole of the camera's own, in these roles.
world::ProxiesSpec shapes(ProxyRole ground, ProxyRole others) {
    world::ProxiesSpec proxies;
    proxies.scene = SceneInBackdrop::hidden;
    proxies.ground.emplace().polygon_m = {{1, -9}, {30, -9}, {30, 9}, {1, 9}};
    proxies.ground->role = ground;
    proxies.boxes = {{.position = {9.0, 1.0, 0.0}, .size = {0.4, 6.0, 2.0}, .role = others},
                     {.position = {4.0, 0.9, 0.0}, .size = {0.3, 0.3, 2.4}, .role = others}};
    return proxies;
}

/// The yard's light and who moves in it, before a camera's own shapes.
class Roles {
public:
    Roles(const Looking& looking, world::Antialias antialias)
        : camera_(camera_through(looking, world::Quality::beautiful)), picture_(noise(camera_.size)) {
        camera_.antialias = antialias;
        TestWorld world = yard();
        world.objects.clear();
        // One before the wall and partly behind the pole, one behind the wall.
        world.movers = {box_at({0.2f, 0.25f, 0.875f}, {5.0, 0.7, 0.875}),
                        box_at({0.2f, 0.25f, 0.875f}, {11.0, -0.5, 0.875})};
        moment_ = world.snapshot();
    }
    std::vector<frame::FrameRef> draw(const world::ProxiesSpec& proxies) const {
        const auto by = drawer();
        return drawn(*by, moment_, all_kinds(with_plate(camera_.view(), picture_, proxies)));
    }
    std::size_t pixels() const { return static_cast<std::size_t>(camera_.size.pixels()); }
    bool shows_picture(const std::vector<frame::FrameRef>& frames, std::size_t pixel) const {
        return std::memcmp(frames[0]->bytes().data() + 4 * pixel, picture_.rgba.data() + 4 * pixel, 4) == 0;
    }
    /// The pixel and those about it have nobody in both.
    bool is_away(const std::vector<frame::FrameRef>& a, const std::vector<frame::FrameRef>& b,
                 std::size_t pixel) const {
        const auto width = static_cast<std::size_t>(camera_.size.width);
        if (pixel < 2 * width + 2 || pixel + 2 * width + 2 >= pixels()) return false;
        for (const std::size_t row : {pixel - 2 * width, pixel - width, pixel, pixel + width, pixel + 2 * width})
            for (std::size_t at = row - 2; at <= row + 2; ++at)
                if (word(*a[2], at) != 0 || word(*b[2], at) != 0) return false;
        return true;
    }

private:
    TestCamera camera_;
    world::Image picture_;
    std::shared_ptr<const world::Snapshot> moment_;
};

TEST(Catcher, ShapesThatOnlyCatchHideNobodyAndAreAsDark) {
    for (const world::Antialias antialias : {world::Antialias::none, world::Antialias::coverage}) {
        for (const Looking& looking : lenses()) {
            const Roles roles(looking, antialias);
            const auto both = roles.draw(shapes(ProxyRole::both, ProxyRole::both)),
                       caught = roles.draw(shapes(ProxyRole::catcher, ProxyRole::catcher));
            world::ProxiesSpec far;
            far.scene = SceneInBackdrop::hidden;
            far.boxes = {{.position = {300.0, 0.0, 0.0}, .size = {1, 1, 1}}};
            const auto nothing = roles.draw(far);
            EXPECT_TRUE(std::ranges::equal(caught[2]->bytes(), nothing[2]->bytes())) << looking.name << ": ids";
            EXPECT_FALSE(std::ranges::equal(both[2]->bytes(), nothing[2]->bytes())) << "nobody is hidden by a shape";
            int dark = 0;
            for (std::size_t i = 0; i < roles.pixels(); ++i) {
                if (word(*caught[2], i) == 0) {
                    EXPECT_EQ(std::bit_cast<float>(word(*caught[1], i)), std::numeric_limits<float>::infinity());
                }
                if (!roles.is_away(both, caught, i)) continue;
                ASSERT_EQ(word(*caught[0], i), word(*both[0], i))
                    << looking.name << ", " << to_string(antialias) << ", pixel " << i;
                dark += !roles.shows_picture(caught, i);
            }
            EXPECT_GT(dark, 40) << looking.name << ", " << to_string(antialias);
        }
    }
}

TEST(Catcher, ShapesThatOnlyHideAreNotDarkened) {
    for (const world::Antialias antialias : {world::Antialias::none, world::Antialias::coverage}) {
        for (const Looking& looking : lenses()) {
            const Roles roles(looking, antialias);
            const auto both = roles.draw(shapes(ProxyRole::both, ProxyRole::both)),
                       held = roles.draw(shapes(ProxyRole::holdout, ProxyRole::holdout)),
                       mixed = roles.draw(shapes(ProxyRole::catcher, ProxyRole::holdout));
            for (const std::size_t kind : {std::size_t{1}, std::size_t{2}, std::size_t{4}})
                EXPECT_TRUE(std::ranges::equal(held[kind]->bytes(), both[kind]->bytes()))
                    << looking.name << ", kind " << kind;
            EXPECT_TRUE(std::ranges::equal(mixed[2]->bytes(), both[2]->bytes())) << "boxes hide, and ground does not";
            int on_ground = 0, on_boxes = 0, others = 0;
            for (std::size_t i = 0; i < roles.pixels(); ++i) {
                if (!roles.is_away(both, both, i)) continue;
                EXPECT_TRUE(roles.shows_picture(held, i)) << looking.name << ", pixel " << i;
                // Depth where only boxes are known is theirs.
                if (std::isinf(std::bit_cast<float>(word(*mixed[1], i)))) {
                    for (int shift = 0; shift < 32; shift += 8) {
                        const auto code = [&](const auto& from) {
                            return static_cast<int>(word(*from[0], i) >> shift & 0xFF);
                        };
                        // Of one pixel a texel of the map may fall to the other side by rounding.
                        ASSERT_NEAR(code(mixed), code(both), 16) << looking.name << ", ground at " << i;
                        others += std::abs(code(mixed) - code(both)) > 1;
                    }
                    on_ground += !roles.shows_picture(mixed, i);
                } else {
                    ASSERT_TRUE(roles.shows_picture(mixed, i)) << looking.name << ", a box at " << i;
                    on_boxes += !roles.shows_picture(both, i);
                }
            }
            EXPECT_GT(on_ground, 20) << looking.name;
            EXPECT_LE(others, 3) << looking.name << ": channels, of " << on_ground << " pixels";
            RecordProperty(std::string("dark_on_boxes_") + looking.name, on_boxes);
        }
    }
}

/// What is drawn into the picture stands before and behind what only catches, and is never darkened for it.
TEST(Catcher, WhatIsDrawnIsShadedByItselfBehindWhatOnlyCatches) {
    const TestCamera camera = camera_through(lenses()[0], world::Quality::beautiful);
    const world::Image picture = noise(camera.size);
    auto moment = walked(yard(), -0.2).snapshot();
    world::ProxiesSpec curtain = shapes(ProxyRole::catcher, ProxyRole::catcher), none = curtain;
    // Before everything, and as wide.
    curtain.boxes = {{.position = {1.5, 0.0, -2.0}, .size = {0.1, 9.0, 9.0}, .role = ProxyRole::catcher}};
    none.boxes.clear();
    curtain.scene = none.scene = SceneInBackdrop::drawn;
    const auto a = drawer(), b = drawer();
    for (int n = 0; n < 3; ++n) {
        const auto with = drawn(*a, moment, all_kinds(with_plate(camera.view(1), picture, curtain))),
                   without = drawn(*b, moment, all_kinds(with_plate(camera.view(2), picture, none)));
        for (std::size_t kind = 1; kind < with.size(); ++kind)
            EXPECT_TRUE(std::ranges::equal(with[kind]->bytes(), without[kind]->bytes())) << kind;
        for (std::size_t i = 0; i < static_cast<std::size_t>(camera.size.pixels()); ++i) {
            if (word(*with[2], i) == 0) continue;
            ASSERT_EQ(word(*with[0], i), word(*without[0], i)) << i;
        }
    }
}

/// However it is drawn.
TEST(Catcher, HasTheSameBytesWithAndWithoutLayersThreadsAndWideLanes) {
    const auto statics = yard().snapshot()->statics;
    for (const SceneInBackdrop scene : {SceneInBackdrop::hidden, SceneInBackdrop::drawn, SceneInBackdrop::proxies}) {
        for (const Looking& looking : {lenses()[0], lenses()[3]}) {
            for (const world::Quality quality : {world::Quality::simple, world::Quality::beautiful}) {
                for (const world::Antialias antialias : {world::Antialias::none, world::Antialias::coverage}) {
                    TestCamera camera = camera_through(looking, quality);
                    camera.antialias = antialias;
                    world::ProxiesSpec proxies = shapes(ProxyRole::catcher, ProxyRole::holdout);
                    proxies.scene = scene;
                    const View view = all_kinds(with_plate(camera.view(), noise(camera.size), proxies));
                    const auto kept = drawer(3), bare = drawer(1, 0);
                    software::SoftwareDrawer narrow(
                        {.pool = std::make_shared<frame::FramePool>(), .wide_lanes = false});
                    for (int n = 0; n < 4; ++n) {
                        auto moment = std::make_shared<world::Snapshot>(*walked(yard(), -1.5 + n).snapshot());
                        moment->statics = statics;
                        const auto a = drawn(*kept, moment, view), b = drawn(*bare, moment, view),
                                   c = drawn(narrow, moment, view);
                        for (std::size_t k = 0; k < a.size(); ++k) {
                            EXPECT_TRUE(std::ranges::equal(a[k]->bytes(), b[k]->bytes()))
                                << looking.name << ", " << to_string(quality) << ", " << to_string(antialias)
                                << ", layers, kind " << k << ", picture " << n;
                            EXPECT_TRUE(std::ranges::equal(b[k]->bytes(), c[k]->bytes())) << looking.name << ", lanes";
                        }
                    }
                }
            }
        }
    }
}

}  // namespace
}  // namespace camrig::render::catchers_test

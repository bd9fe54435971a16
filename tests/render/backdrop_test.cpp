#include "core/world/backdrop/backdrop.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/render/software/software_drawer.h"
#include "core/world/backdrop/mask_pieces.h"
#include "tests/render/support/backdrop_scenes.h"

// Plates: a picture that people walk in. What is known exactly: the picture's own bytes where nothing is in front, and
// what a scene looks like whose empty picture is the plate.
namespace camrig::render {
namespace {

TEST(Plate, WithoutMoversIsThePictureByteForByte) {
    const world::SnapshotRef empty = yard().snapshot();
    for (const Looking& looking : lenses()) {
        for (const world::Quality quality : qualities) {
            for (const world::Antialias antialias : {world::Antialias::none, world::Antialias::coverage}) {
                TestCamera camera = camera_through(looking, quality);
                camera.antialias = antialias;
                const world::Image picture = noise(camera.size);
                const View view = all_kinds(with_plate(camera.view(), picture, scene_is(SceneInBackdrop::proxies)));
                for (const int threads : {1, 2, 3}) {
                    const auto by = drawer(threads);
                    // The first is drawn, the second kept, the third put together of what was kept.
                    for (int n = 0; n < 3; ++n)
                        EXPECT_TRUE(has_bytes_of(*drawn(*by, empty, view).front(), picture))
                            << looking.name << ", " << to_string(quality) << ", " << to_string(antialias) << ", "
                            << threads << " threads, picture " << n;
                }
            }
        }
    }
}

TEST(Plate, OfASceneIsTheSceneWithWhoMovesInIt) {
    for (const Looking& looking : lenses()) {
        for (const world::Quality quality : qualities) {
            const TestCamera camera = camera_through(looking, quality);
            const auto full = drawer(), plate = drawer(2);
            const View scene_view = camera.view();
            const TestWorld empty = yard();
            const world::Image picture = picture_of(*drawn(*full, empty.snapshot(), scene_view).front());
            const View seen = all_kinds(scene_view);
            const View on_plate = all_kinds(with_plate(scene_view, picture, scene_is(SceneInBackdrop::proxies)));
            const auto statics = empty.snapshot()->statics;
            for (int n = 0; n < 5; ++n) {
                const std::string what = std::string(looking.name) + ", " + std::string(to_string(quality)) +
                                         ", picture " + std::to_string(n);
                auto moment = std::make_shared<world::Snapshot>(*walked(empty, -1.6 + 0.7 * n).snapshot());
                moment->statics = statics;
                const auto expected = drawn(*full, moment, seen), got = drawn(*plate, moment, on_plate);
                ASSERT_EQ(expected.size(), got.size());
                // Codes of light are what the picture knows: one that is multiplied may be rounded to the next.
                EXPECT_LE(largest_difference(*expected[0], *got[0]), quality == world::Quality::beautiful ? 1 : 0)
                    << what;
                EXPECT_FALSE(has_bytes_of(*got[0], picture)) << what << ": nobody is there";
                for (std::size_t k = 1; k < got.size(); ++k)
                    EXPECT_TRUE(std::ranges::equal(expected[k]->bytes(), got[k]->bytes()))
                        << what << ", " << to_string(got[k]->info().kind);
            }
        }
    }
}

TEST(Plate, HasTheSameBytesWithAndWithoutLayersAndWideLanes) {
    world::ProxiesSpec own;
    own.ground.emplace().polygon_m = {{1, -9}, {30, -9}, {30, 9}, {1, 9}};
    const auto statics = yard().snapshot()->statics;
    for (const world::ProxiesSpec& proxies : {scene_is(SceneInBackdrop::proxies), own}) {
        for (const Looking& looking : lenses()) {
            for (const auto& [quality, antialias] :
                 {std::pair(world::Quality::fast, world::Antialias::none),
                  std::pair(world::Quality::simple, world::Antialias::coverage),
                  std::pair(world::Quality::beautiful, world::Antialias::none),
                  std::pair(world::Quality::beautiful, world::Antialias::coverage)}) {
                TestCamera camera = camera_through(looking, quality);
                camera.antialias = antialias;
                const View view = all_kinds(with_plate(camera.view(), noise(camera.size), proxies));
                const auto kept = drawer(2), bare = drawer(1, 0);
                software::SoftwareDrawer narrow({.pool = std::make_shared<frame::FramePool>(), .wide_lanes = false});
                for (int n = 0; n < 4; ++n) {
                    auto moment = std::make_shared<world::Snapshot>(*walked(yard(), -1.5 + n).snapshot());
                    moment->statics = statics;
                    const auto a = drawn(*kept, moment, view), b = drawn(*bare, moment, view),
                               c = drawn(narrow, moment, view);
                    for (std::size_t k = 0; k < a.size(); ++k) {
                        const std::string what = std::string(looking.name) + ", " + std::string(to_string(quality)) +
                                                 ", " + std::string(to_string(antialias)) + ", picture " +
                                                 std::to_string(n);
                        EXPECT_TRUE(std::ranges::equal(a[k]->bytes(), b[k]->bytes())) << what << ", layers";
                        EXPECT_TRUE(std::ranges::equal(b[k]->bytes(), c[k]->bytes())) << what << ", lanes";
                    }
                }
            }
        }
    }
}

/// Where somebody goes behind an edge that the picture has mixed already, it is wrong by c(1 - c) of the contrast;
/// where a shadow falls on one side of such an edge, by as much as the other side's half of the pixel.
TEST(Plate, ByCoverageIsTheSceneButForMixedEdgesOfWhatHidesSomebody) {
    for (const world::Quality quality : qualities) {
        TestCamera camera = camera_through(lenses()[0], quality);
        camera.antialias = world::Antialias::coverage;
        const auto full = drawer(), plate = drawer();
        const View seen = camera.view();
        const auto statics = yard().snapshot()->statics;
        const world::Image picture = picture_of(*drawn(*full, yard().snapshot(), seen).front());
        const View on_plate = with_plate(seen, picture, scene_is(SceneInBackdrop::proxies));
        int wrong = 0;
        for (int n = 0; n < 5; ++n) {
            auto moment = std::make_shared<world::Snapshot>(*walked(yard(), -1.6 + 0.7 * n).snapshot());
            moment->statics = statics;
            const world::Image expected = picture_of(*drawn(*full, moment, seen).front()),
                               got = picture_of(*drawn(*plate, moment, on_plate).front());
            for (int y = 1; y + 1 < camera.size.height; ++y) {
                for (int x = 1; x + 1 < camera.size.width; ++x) {
                    const std::size_t at = 4 * static_cast<std::size_t>(y * camera.size.width + x);
                    int codes = 0;
                    for (std::size_t c = 0; c < 3; ++c)
                        codes = std::max(codes, std::abs(expected.rgba[at + c] - got.rgba[at + c]));
                    if (codes <= 1) continue;
                    ++wrong;
                    // What lies around the pixel is what it has mixed.
                    glm::dvec3 least(1.0), most(0.0);
                    for (int dy = -1; dy <= 1; ++dy) {
                        for (int dx = -1; dx <= 1; ++dx) {
                            least = glm::min(least, light_at(picture, x + dx, y + dy));
                            most = glm::max(most, light_at(picture, x + dx, y + dy));
                        }
                    }
                    const glm::dvec3 off = glm::abs(light_at(expected, x, y) - light_at(got, x, y));
                    const double shaded = quality == world::Quality::beautiful ? 0.5 : 0.0;
                    for (int c = 0; c < 3; ++c)
                        EXPECT_LE(off[c], 0.25 * (most[c] - least[c]) + shaded * most[c] + 0.01)
                            << to_string(quality) << ", " << x << ", " << y << ", picture " << n;
                }
            }
        }
        RecordProperty("pixels_" + std::string(to_string(quality)), wrong);
        // Of five pictures with some 400 pixels of somebody's outline each.
        EXPECT_LT(wrong, 300) << to_string(quality);
    }
}

/// A person-sized box, and the rows that it shows in.
TEST(Plate, SomebodyIsAsHighAsHeadAndFeetAreApart) {
    for (const Looking& looking : lenses()) {
        TestCamera camera = camera_through(looking, world::Quality::fast);
        camera.size = {640, 480};
        camera.focal_px = looking.focal_px * 4;
        world::ProxiesSpec proxies;
        proxies.ground.emplace().polygon_m = {{1, -9}, {30, -9}, {30, 9}, {1, 9}};
        const View view = with_plate(camera.view(), noise(camera.size), proxies);
        View ids = view;
        std::ranges::fill(ids.kinds, false);
        ids.kinds[static_cast<int>(frame::FrameKind::instance)] = true;
        for (const double ahead : {5.0, 9.0, 20.0}) {
            TestWorld world;
            // Thin, so that head and feet are points.
            world.movers = {instance_of(model_of(box({0.001f, 0.15f, 0.875f}), colored(glm::vec3(0.4f))),
                                        {ahead, 0.3, 0.875}, person_id)};
            const auto by = drawer();
            const auto frame = drawn(*by, world.snapshot(), ids).front();
            int top = camera.size.height, bottom = -1;
            for (int y = 0; y < camera.size.height; ++y) {
                for (int x = 0; x < camera.size.width; ++x) {
                    std::uint32_t id = 0;
                    std::memcpy(
                        &id,
                        frame->bytes().data() + 4 * (static_cast<std::size_t>(y) * 640 + static_cast<std::size_t>(x)),
                        4);
                    if (id != person_id) continue;
                    top = std::min(top, y);
                    bottom = std::max(bottom, y);
                }
            }
            const auto row_of = [&](double z) {
                return camera.model().project({0.0, camera.eye.z - z, ahead}).value().y;
            };
            EXPECT_NEAR(bottom + 1 - top, row_of(0.0) - row_of(1.75), 1.0) << looking.name << ", " << ahead << " m";
        }
    }
}

TEST(Plate, CutoutHidesWhoGoesBehindItAndNotWhoIsInFront) {
    const TestCamera camera{.eye = {0, 0, 1.6}, .size = {160, 120}, .focal_px = 120.0};
    world::ProxiesSpec proxies;
    // A pole whose foot is 8 m away: 1.6 m below the eye are 24 pixels.
    proxies.cutouts = {{.polygon_px = {{70, 84}, {90, 84}, {90, 20}, {70, 20}}, .mask = {}, .foot_px = {79.5, 83.5}}};
    const world::Image picture = noise(camera.size);
    const View view = all_kinds(with_plate(camera.view(), picture, proxies));
    const auto at = [&](double ahead) {
        TestWorld world;
        world.movers = {
            instance_of(model_of(box({0.1f, 0.6f, 0.875f}), colored(glm::vec3(0.4f))), {ahead, 0, 0.875}, person_id)};
        const auto by = drawer();
        return drawn(*by, world.snapshot(), view);
    };
    const auto id = [&](const frame::Frame& frame, int x, int y) {
        std::uint32_t value = 0;
        std::memcpy(&value, frame.bytes().data() + 4 * static_cast<std::size_t>(y * 160 + x), 4);
        return value;
    };
    const auto behind = at(9.0), before = at(7.0);
    EXPECT_EQ(id(*behind[2], 80, 70), 0u);
    EXPECT_EQ(id(*behind[2], 88, 70), 0u);
    EXPECT_EQ(id(*before[2], 80, 70), person_id);
    const std::size_t pixel = 4 * (70 * 160 + 80);
    EXPECT_TRUE(std::equal(behind[0]->bytes().begin() + pixel, behind[0]->bytes().begin() + pixel + 4,
                           std::as_bytes(std::span(picture.rgba)).begin() + pixel));
    float depth = 0.0f;
    std::memcpy(&depth, behind[1]->bytes().data() + pixel, 4);
    EXPECT_NEAR(depth, 8.0, 1e-4);
}

/// A mask of single pixels, runs and large pieces: pixel by pixel somebody is there or behind it.
TEST(Plate, MaskHidesExactlyWhatItMarks) {
    for (const Looking& looking : lenses()) {
        const TestCamera camera = camera_through(looking, world::Quality::fast);
        world::Image mask = noise(camera.size);
        const auto is_marked = [&](int x, int y) {
            // Below the camera's horizon nothing stands upright at a foot 4 m away and is seen all around a fisheye.
            return x > 40 && x < 120 && y > 30 && y < 90 &&
                   ((x / 20 + y / 20) % 2 == 0 ||
                    mask.rgba[4 * static_cast<std::size_t>(y * camera.size.width + x)] > 200);
        };
        world::Image marks = mask;
        for (int y = 0; y < camera.size.height; ++y)
            for (int x = 0; x < camera.size.width; ++x)
                marks.rgba[4 * static_cast<std::size_t>(y * camera.size.width + x) + 3] = is_marked(x, y) ? 255 : 0;
        world::ProxiesSpec proxies;
        proxies.cutouts = {{.polygon_px = {}, .mask = "mask.png", .foot_px = {80.0, 95.0}}};
        const world::Image picture = noise(camera.size);
        const View view = with_plate(camera.view(), picture, proxies, [&](world::BackdropSpec& backdrop) {
            auto files = std::make_shared<world::BackdropFiles>(*backdrop.files);
            files->masks = {world::mask_pieces(marks).value()};
            backdrop.files = files;
        });
        TestWorld world;
        // A wall far behind, before all that the camera sees.
        world.movers = {instance_of(model_of(box({0.1f, 300.0f, 300.0f}), colored({0.9f, 0.1f, 0.9f})),
                                    {40.0, 0.0, 0.0}, person_id)};
        const auto by = drawer();
        const world::Image got = picture_of(*drawn(*by, world.snapshot(), view).front());
        int hidden = 0;
        for (int y = 31; y < 90; ++y) {
            for (int x = 41; x < 120; ++x) {
                const std::size_t at = 4 * static_cast<std::size_t>(y * camera.size.width + x);
                const bool shows_picture = std::equal(&got.rgba[at], &got.rgba[at] + 3, &picture.rgba[at]);
                EXPECT_EQ(shows_picture, is_marked(x, y)) << looking.name << ", " << x << ", " << y;
                hidden += shows_picture;
            }
        }
        EXPECT_GT(hidden, 1000) << looking.name;
    }
}

/// Of the sun that a proxy keeps from the picture already, nobody can keep any more.
TEST(Plate, NoShadowIsThereTwice) {
    TestWorld world;
    world.environment = {
        .background = glm::vec3(0.0f), .ambient_sky = glm::vec3(0.2f), .ambient_ground = glm::vec3(0.2f)};
    world.lights = {light_of(world::LightType::directional, 0.5f, {}, glm::normalize(glm::dvec3(0.0, 1.0, -1.0)))};
    world::Material paint = colored(glm::vec3(0.5f));
    paint.roughness = 1.0f;
    world.objects = {instance_of(model_of(rectangle({5, 0, 0}, {5, 0, 0}, {0, 8, 0}), paint), {}, 1),
                     // From x = 4 to 6 its shadow reaches from y = -1 to 1.
                     instance_of(model_of(box({1.0f, 0.05f, 1.0f}), paint), {5.0, -1.0, 1.0}, 2)};
    const TestCamera camera{
        .eye = {5.0, 0.0, 9.0}, .size = {160, 120}, .focal_px = 100.0, .quality = world::Quality::beautiful};
    View looking = camera.view();
    looking.pose = camera::pose_look_at({5.0, 0.0, 9.0}, {5.0, 0.0, 0.0}).value();
    const world::Image picture = {.size = camera.size, .rgba = std::vector<std::uint8_t>(160 * 120 * 4, 150)};
    const View view = with_plate(looking, picture, scene_is(SceneInBackdrop::proxies));
    // In its shadow, and the same beside it, in the sun.
    const auto code = [&](double x, double y) {
        TestWorld now = world;
        now.movers = {instance_of(model_of(box({0.2f, 0.2f, 0.3f}), paint), {x, y, 0.3}, person_id)};
        const auto by = drawer();
        const auto frame = drawn(*by, now.snapshot(), view).front();
        // Half a metre behind it, as the sun sees it. The top of the picture is +x, its left +y.
        const int column = static_cast<int>(std::lround(79.5 - 100.0 * (y + 0.45) / 9.0)),
                  row = static_cast<int>(std::lround(59.5 - 100.0 * (x - 5.0) / 9.0));
        return std::to_integer<int>(frame->bytes()[static_cast<std::size_t>(4 * (row * 160 + column))]);
    };
    EXPECT_EQ(code(5.0, -0.3), 150) << "in the shadow of the wall";
    // Of the sun's 0.5 cos 45 deg and 0.2 from all around, the latter is left.
    const double share = 0.2 / (0.2 + 0.5 * std::sqrt(0.5));
    EXPECT_NEAR(code(5.0, 2.0), srgb_code(share * linear_of(150)), 3) << "in the sun";
}

TEST(Plate, ObjectsOfTheSceneAreDrawnIntoItOrNotThere) {
    const TestCamera camera = camera_through(lenses()[0], world::Quality::simple);
    const world::Image picture = noise(camera.size);
    world::ProxiesSpec proxies;
    proxies.ground = {.polygon_m = {{1, -9}, {30, -9}, {30, 9}, {1, 9}}, .polygon_px = {}, .z = -0.5};
    const world::SnapshotRef empty = yard().snapshot();
    const auto by = drawer();
    proxies.scene = SceneInBackdrop::hidden;
    const View without = all_kinds(with_plate(camera.view(1), picture, proxies));
    proxies.scene = SceneInBackdrop::drawn;
    const View with = all_kinds(with_plate(camera.view(2), picture, proxies));
    const auto full = drawn(*by, empty, all_kinds(camera.view(3)));
    for (int n = 0; n < 3; ++n) {
        const auto hidden = drawn(*by, empty, without), there = drawn(*by, empty, with);
        EXPECT_TRUE(has_bytes_of(*hidden[0], picture));
        EXPECT_TRUE(std::ranges::all_of(hidden[2]->bytes(), [](std::byte b) { return b == std::byte{0}; }));
        EXPECT_TRUE(std::ranges::equal(there[2]->bytes(), full[2]->bytes()));
        const std::vector<ObjectId> pillar{ObjectId{3}};
        EXPECT_FALSE(by->silhouettes(with, pillar)[0].empty());
        EXPECT_TRUE(by->silhouettes(without, pillar)[0].empty());
    }
}

/// Somebody alone before the yard's plate, and which pixels show it.
struct Matched {
    TestCamera camera{.eye = {0.0, 0.3, 1.6}, .size = {163, 121}, .focal_px = 110.0};
    world::Image picture = noise(camera.size);
    std::shared_ptr<world::Snapshot> moment;

    explicit Matched(world::Quality quality = world::Quality::simple) {
        camera.quality = quality;
        TestWorld world = walked(yard(), -0.4);
        world.movers.resize(1);
        moment = std::make_shared<world::Snapshot>(*world.snapshot());
    }
    View view(const std::function<void(world::BackdropSpec&)>& change = {}) const {
        return all_kinds(with_plate(camera.view(), picture, scene_is(SceneInBackdrop::proxies), change));
    }
    std::vector<frame::FrameRef> draw(const std::function<void(world::BackdropSpec&)>& change = {}) const {
        const auto by = drawer();
        return drawn(*by, moment, view(change));
    }
    static bool shows(const std::vector<frame::FrameRef>& frames, std::size_t pixel) {
        std::uint32_t id = 0;
        std::memcpy(&id, frames[2]->bytes().data() + 4 * pixel, 4);
        return id == person_id;
    }
    std::size_t pixels() const { return static_cast<std::size_t>(camera.size.pixels()); }
    static int code(const frame::FrameRef& frame, std::size_t pixel, std::size_t channel) {
        return std::to_integer<int>(frame->bytes()[4 * pixel + channel]);
    }
};

/// The same bytes with any number of threads, with and without what is kept.
void expect_same_always(const Matched& matched, const std::function<void(world::BackdropSpec&)>& change) {
    const auto expected = matched.draw(change);
    const View view = matched.view(change);
    const auto a = drawer(2), b = drawer(3), c = drawer(1, 0);
    for (int n = 0; n < 4; ++n)
        for (software::SoftwareDrawer* const by : {a.get(), b.get(), c.get()})
            EXPECT_TRUE(std::ranges::equal(drawn(*by, matched.moment, view)[0]->bytes(), expected[0]->bytes())) << n;
}

TEST(Plate, HasNoShadowsWhereNoneAreWanted) {
    const Matched matched(world::Quality::beautiful);
    const auto changed_beside = [&](world::BackdropShadow shadow) {
        const auto frames = matched.draw([&](world::BackdropSpec& spec) { spec.shadow = shadow; });
        int changed = 0;
        for (std::size_t i = 0; i < matched.pixels(); ++i)
            changed += !Matched::shows(frames, i) &&
                       std::memcmp(frames[0]->bytes().data() + 4 * i, matched.picture.rgba.data() + 4 * i, 4) != 0;
        return changed;
    };
    EXPECT_GT(changed_beside(world::BackdropShadow::mapped), 100);
    EXPECT_EQ(changed_beside(world::BackdropShadow::none), 0);
}

// Shadow maps take as long as many such pictures do.
TEST(Plate, WithoutMappedShadowsDoesNotPayForShadowMaps) {
    const TestCamera camera{
        .eye = {0.0, 0.3, 1.6}, .size = {32, 24}, .focal_px = 26.0, .quality = world::Quality::beautiful};
    const View shadowed = camera.view(1);
    const View plate = with_plate(camera.view(2), noise(camera.size), scene_is(SceneInBackdrop::proxies),
                                  [](world::BackdropSpec& spec) { spec.shadow = world::BackdropShadow::blob; });
    const auto by = drawer();
    std::vector<frame::FrameRef> frames;
    // Where others take the processor meanwhile a picture may look dear; one that pays does so each time.
    bool is_cheap = false;
    for (int i = 0; i < 10 && !is_cheap; ++i) {
        by->begin_instant(walked(yard(), 0.3 + 0.1 * i).snapshot());
        by->draw(std::vector{&shadowed, &plate}, 0, frames);
        is_cheap = 2 * by->cost_ns()[1] < by->cost_ns()[0];
    }
    EXPECT_TRUE(is_cheap);
}

TEST(Plate, GainIsAFactorOnTheLightOfWhatMoves) {
    for (const world::Quality quality : qualities) {
        const Matched matched(quality);
        const glm::dvec3 gain(0.5, 1.25, 2.0);
        const auto plain = matched.draw(),
                   gained = matched.draw([&](world::BackdropSpec& spec) { spec.plate_gain = gain; });
        int people = 0;
        for (std::size_t i = 0; i < matched.pixels(); ++i) {
            for (std::size_t c = 0; c < 3; ++c) {
                const int before = Matched::code(plain[0], i, c), after = Matched::code(gained[0], i, c);
                if (!Matched::shows(plain, i)) {
                    EXPECT_NEAR(before, after, quality == world::Quality::beautiful ? 1 : 0)
                        << "the ratio of light stays";
                } else if (before > 20) {
                    // Half a code of what is dark is more of what is bright.
                    EXPECT_NEAR(after, srgb_code(std::min(1.0, gain[static_cast<int>(c)] * linear_of(before))), 2);
                    ++people;
                }
            }
        }
        EXPECT_GT(people, 500);
    }
}

TEST(Plate, NoiseIsOnWhatMovesAlone) {
    const Matched matched;
    const auto noisy = [](world::BackdropSpec& spec) { spec.noise = world::PlateNoise{.k = 0.05, .read = 3.0}; };
    expect_same_always(matched, noisy);
    const auto plain = matched.draw();
    double sum = 0.0, sum_of_squares = 0.0, expected = 0.0;
    int count = 0;
    std::vector<std::vector<frame::FrameRef>> instants;
    Matched later = matched;
    for (int n = 0; n < 20; ++n) {
        later.moment = std::make_shared<world::Snapshot>(*matched.moment);
        later.moment->world_ns = n * 40'000'000;
        instants.push_back(later.draw(noisy));
        for (std::size_t i = 0; i < matched.pixels(); ++i) {
            for (std::size_t c = 0; c < 3; ++c) {
                const int level = Matched::code(plain[0], i, c), off = Matched::code(instants.back()[0], i, c) - level;
                if (!Matched::shows(plain, i)) {
                    ASSERT_EQ(off, 0);
                } else if (level > 20 && level < 235) {
                    sum += off;
                    sum_of_squares += off * off;
                    // Rounding has a variance of its own.
                    expected += 3.0 * 3.0 + 0.05 * level + 1.0 / 12.0;
                    ++count;
                }
            }
        }
    }
    ASSERT_GT(count, 10000);
    EXPECT_NEAR(sum / count, 0.0, 5.0 * std::sqrt(expected / count / count));
    EXPECT_NEAR(sum_of_squares / expected, 1.0, 0.03);
    EXPECT_FALSE(std::ranges::equal(instants[0][0]->bytes(), instants[1][0]->bytes())) << "each picture has its own";
}

TEST(Plate, WhatMovesIsAsSoftAsTold) {
    const Matched matched;
    const auto plain = matched.draw();
    const int width = matched.camera.size.width, height = matched.camera.size.height;
    for (const double sigma : {0.5, 0.8, 2.0}) {
        const auto soft = [&](world::BackdropSpec& spec) { spec.edge_px = sigma; };
        expect_same_always(matched, soft);
        const auto got = matched.draw(soft);
        for (std::size_t k = 1; k < got.size(); ++k)
            EXPECT_TRUE(std::ranges::equal(got[k]->bytes(), plain[k]->bytes())) << "truth is sharp";
        const int reach = static_cast<int>(std::ceil(3.0 * sigma));
        double whole = 0.0;
        for (int i = -reach; i <= reach; ++i) whole += std::exp(-0.5 * i * i / (sigma * sigma));
        int most = 0, changed = 0;
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) {
                glm::dvec3 light(0.0);
                double cover = 0.0;
                for (int j = std::max(-reach, -y); j <= std::min(reach, height - 1 - y); ++j) {
                    for (int i = std::max(-reach, -x); i <= std::min(reach, width - 1 - x); ++i) {
                        const auto at = static_cast<std::size_t>((y + j) * width + x + i);
                        if (!Matched::shows(plain, at)) continue;
                        const double weight = std::exp(-0.5 * (i * i + j * j) / (sigma * sigma)) / (whole * whole);
                        cover += weight;
                        for (int c = 0; c < 3; ++c)
                            light[c] += weight * linear_of(Matched::code(plain[0], at, static_cast<std::size_t>(c)));
                    }
                }
                const auto here = static_cast<std::size_t>(y * width + x);
                if (cover == 0.0) {
                    ASSERT_EQ(std::memcmp(got[0]->bytes().data() + 4 * here, plain[0]->bytes().data() + 4 * here, 4),
                              0);
                    continue;
                }
                ++changed;
                light += std::max(0.0, 1.0 - cover) * light_at(matched.picture, x, y);
                for (int c = 0; c < 3; ++c)
                    most = std::max(most, std::abs(srgb_code(std::min(1.0, light[c])) -
                                                   Matched::code(got[0], here, static_cast<std::size_t>(c))));
            }
        }
        EXPECT_LE(most, 1) << sigma;
        EXPECT_GT(changed, 500);
    }
}
}  // namespace
}  // namespace camrig::render

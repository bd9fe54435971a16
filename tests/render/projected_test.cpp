#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include <gtest/gtest.h>

#include "tests/render/support/backdrop_scenes.h"

// Projected pictures: what the picture has of each pixel's point, which is worked out here once more, in double.
namespace camrig::render::projected_test {
namespace {

constexpr glm::dvec3 taken_at{0.0, 0.3, 1.6};

/// The view before this picture, which `taker` took, along +x.
View with_projected(View view, world::Image picture, const TestCamera& taker, const world::ProxiesSpec& proxies,
                    const std::function<void(world::BackdropSpec&)>& change = {}) {
    auto spec = std::make_shared<world::CameraSpec>(*view.spec);
    spec->pose = view.pose;
    auto files = std::make_shared<world::BackdropFiles>();
    files->projected = std::make_shared<const world::PicturePyramid>(world::make_pyramid(std::move(picture)));
    world::BackdropSpec& backdrop = spec->backdrop.emplace();
    backdrop.kind = world::BackdropKind::projected;
    backdrop.taken_from = camera::Pose{.position = taker.eye};
    backdrop.intrinsics = taker.model().intrinsics();
    backdrop.lens = taker.lens;
    backdrop.proxies = proxies;
    backdrop.files = files;
    if (change) change(backdrop);
    auto made = make_backdrop(*spec);
    if (!made) throw std::runtime_error(made.error().message);
    spec->backdrop_here = *made;
    view.spec = spec;
    view.spec_revision += 2'000'000;
    return view;
}

std::uint8_t code(const frame::Frame& frame, int x, int y, int channel) {
    const auto at = static_cast<std::size_t>(4 * (y * frame.info().size.width + x) + channel);
    return std::to_integer<std::uint8_t>(frame.bytes()[at]);
}

TEST(Projected, FromThePicturesOwnPlaceIsThePlate) {
    for (const Looking& looking : lenses()) {
        for (const world::Quality quality : qualities) {
            const TestCamera camera = camera_through(looking, quality);
            const world::Image picture = noise(camera.size);
            const View plate = all_kinds(with_plate(camera.view(), picture, scene_is(SceneInBackdrop::proxies)));
            const View projected =
                all_kinds(with_projected(camera.view(), picture, camera, scene_is(SceneInBackdrop::proxies)));
            const auto a = drawer(), b = drawer(2);
            const camera::CameraModel model = camera.model();
            const auto statics = yard().snapshot()->statics;
            for (int n = 0; n < 3; ++n) {
                auto moment = std::make_shared<world::Snapshot>(*walked(yard(), -0.9 + 0.7 * n).snapshot());
                moment->statics = statics;
                const auto expected = drawn(*a, moment, plate), got = drawn(*b, moment, projected);
                ASSERT_EQ(expected.size(), got.size());
                for (std::size_t k = 1; k < got.size(); ++k)
                    EXPECT_TRUE(std::ranges::equal(expected[k]->bytes(), got[k]->bytes()))
                        << looking.name << ", kind " << k;
                int most = 0, others = 0;
                for (int y = 0; y < camera.size.height; ++y) {
                    for (int x = 0; x < camera.size.width; ++x) {
                        // Where the lens sees nothing a plate shows its picture.
                        if (!model.ray({x, y})) continue;
                        for (int c = 0; c < 3; ++c) {
                            const int off = std::abs(code(*expected[0], x, y, c) - code(*got[0], x, y, c));
                            most = std::max(most, off);
                            others += off > 0;
                        }
                    }
                }
                EXPECT_LE(most, 1) << looking.name << ", " << to_string(quality);
                // Rays of lenses are floats: rounding goes the other way in few pixels.
                EXPECT_LT(others, 163 * 121 * 3 / 100) << looking.name << ", " << to_string(quality);
            }
        }
    }
}

/// Ground at height 0 and one box, as rays meet them.
struct Place {
    glm::dvec2 low{1.0, -9.0}, high{30.0, 9.0};
    glm::dvec3 box_low{5.5, 0.0, 0.0}, box_high{6.5, 2.0, 1.5};

    world::ProxiesSpec proxies() const {
        world::ProxiesSpec spec;
        spec.scene = SceneInBackdrop::hidden;
        spec.ground.emplace().polygon_m = {{low.x, low.y}, {high.x, low.y}, {high.x, high.y}, {low.x, high.y}};
        spec.boxes = {{.position = {6.0, 1.0, 0.0}, .size = {1.0, 2.0, 1.5}}};
        return spec;
    }
    struct Hit {
        double times = std::numeric_limits<double>::infinity();
        int what = 0;  ///< 0: nothing; 1: the ground; 2 to 7: a face of the box
    };
    Hit hit(const glm::dvec3& eye, const glm::dvec3& d) const {
        Hit found;
        if (const double t = -eye.z / d.z; t > 0.0) {
            const glm::dvec2 p = glm::dvec2(eye + t * d);
            if (p.x > low.x && p.x < high.x && p.y > low.y && p.y < high.y) found = {t, 1};
        }
        double enter = 0.0, leave = std::numeric_limits<double>::infinity();
        int face = 0;
        for (int i = 0; i < 3; ++i) {
            const double a = (box_low[i] - eye[i]) / d[i], b = (box_high[i] - eye[i]) / d[i];
            if (std::min(a, b) > enter) {
                enter = std::min(a, b);
                face = 2 + 2 * i + (a > b);
            }
            leave = std::min(leave, std::max(a, b));
        }
        if (face != 0 && enter < leave && enter < found.times) found = {enter, face};
        return found;
    }
};

/// Bilinear in linear light; beyond the edges as at the edge.
glm::dvec3 looked_up(const world::Image& picture, const glm::dvec2& at) {
    const int x = static_cast<int>(std::floor(at.x)), y = static_cast<int>(std::floor(at.y));
    const double a = at.x - x, b = at.y - y;
    const auto texel = [&](int column, int row) {
        return light_at(picture, std::clamp(column, 0, picture.size.width - 1),
                        std::clamp(row, 0, picture.size.height - 1));
    };
    return (1 - b) * ((1 - a) * texel(x, y) + a * texel(x + 1, y)) +
           b * ((1 - a) * texel(x, y + 1) + a * texel(x + 1, y + 1));
}

struct Move {
    const char* name;
    glm::dvec3 by;
    double pan_deg, tilt_deg;
};

TEST(Projected, EachPixelShowsWhatThePictureHasOfItsPoint) {
    const Place place;
    const world::SnapshotRef empty = TestWorld{}.snapshot();
    const Move moves[] = {{"aside", {0.0, 0.4, 0.0}, 0.0, 0.0},
                          {"ahead and up", {0.6, -0.2, 0.3}, 3.0, -4.0},
                          {"turned only", {0.0, 0.0, 0.0}, -5.0, 2.0}};
    const auto all = lenses();
    for (const Looking& took : all) {
        for (const Looking& sees : all) {
            const TestCamera taker = camera_through(took, world::Quality::simple);
            const world::Image picture = noise(taker.size);
            TestCamera camera = camera_through(sees, world::Quality::simple);
            // Finer than the picture, so that one pixel is looked up.
            camera.size = {323, 201};
            camera.focal_px = sees.focal_px * 4.0;
            const camera::CameraModel of_taker = taker.model(), of_camera = camera.model();
            const glm::dmat3 taker_from_world =
                glm::transpose(camera::world_from_optical_rotation({.position = taken_at}));
            for (const Move& move : moves) {
                View view = camera.view();
                view.pose = camera::pose_from_angles(
                                taken_at + move.by,
                                {.pan = glm::radians(move.pan_deg), .tilt = glm::radians(move.tilt_deg), .roll = 0.0})
                                .value();
                const auto by = drawer();
                const auto frame = drawn(*by, empty, with_projected(view, picture, taker, place.proxies())).front();
                const glm::dmat3 turn = camera::world_from_optical_rotation(view.pose);
                const auto point_of = [&](int x, int y) -> std::optional<std::pair<glm::dvec3, int>> {
                    const auto ray = of_camera.ray({x, y});
                    if (!ray) return std::nullopt;
                    const glm::dvec3 d = turn * *ray;
                    const auto [times, what] = place.hit(view.pose.position, d);
                    if (what == 0) return std::pair(taker_from_world * d, what);
                    return std::pair(taker_from_world * (view.pose.position + times * d - taken_at), what);
                };
                int most = 0, compared = 0, of_box = 0, of_sky = 0;
                glm::ivec2 where(0);
                for (int y = 1; y + 1 < camera.size.height; ++y) {
                    for (int x = 1; x + 1 < camera.size.width; ++x) {
                        const auto here = point_of(x, y);
                        const auto seen = here ? of_taker.project(here->first) : std::nullopt;
                        if (!seen) continue;
                        const glm::dvec2 at = *seen;
                        bool is_plain = true;
                        double step = 0.0;
                        for (const glm::ivec2 next : {glm::ivec2(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
                            const auto beside = point_of(x + next.x, y + next.y);
                            is_plain = is_plain && beside && beside->second == here->second;
                            const auto there = is_plain ? of_taker.project(beside->first) : std::nullopt;
                            is_plain = is_plain && there;
                            if (is_plain) step = std::max(step, glm::length(*there - at));
                        }
                        // Where the view is coarser than the picture, more than one pixel is looked up.
                        if (!is_plain || step > 0.98) continue;
                        const glm::dvec3 light = looked_up(picture, at);
                        ++compared;
                        of_box += here->second > 1;
                        of_sky += here->second == 0;
                        for (int c = 0; c < 3; ++c) {
                            const int off = std::abs(code(*frame, x, y, c) - srgb_code(light[c]));
                            if (off > most) where = {x, y};
                            most = std::max(most, off);
                        }
                    }
                }
                EXPECT_GT(compared, 10000) << took.name << " by " << sees.name << ", " << move.name;
                EXPECT_GT(of_box, 300);
                EXPECT_GT(of_sky, 2000);
                EXPECT_LE(most, 1) << took.name << " by " << sees.name << ", " << move.name << ", at " << where.x
                                   << ", " << where.y;
            }
        }
    }
}

/// The yard as a photo from one place, seen from another with somebody in it: what both see has the same light, in the
/// shadow of who is there too.
TEST(Projected, OfASceneIsNearlyTheSceneFromBeside) {
    for (const world::Quality quality : {world::Quality::simple, world::Quality::beautiful}) {
        const TestCamera taker{.eye = taken_at, .size = {652, 484}, .focal_px = 440.0, .quality = quality};
        const TestCamera camera{
            .eye = taken_at + glm::dvec3(0.1, 0.2, 0.1), .size = {326, 242}, .focal_px = 220.0, .quality = quality};
        const TestWorld empty = yard();
        const auto full = drawer(), by = drawer();
        const auto statics = empty.snapshot()->statics;
        const world::Image picture = picture_of(*drawn(*full, empty.snapshot(), taker.view(1)).front());
        auto moment = std::make_shared<world::Snapshot>(*walked(empty, 0.3).snapshot());
        moment->statics = statics;
        const auto expected = drawn(*full, moment, all_kinds(camera.view(2)));
        const auto got = drawn(
            *by, moment, all_kinds(with_projected(camera.view(2), picture, taker, scene_is(SceneInBackdrop::proxies))));
        // Who hides whom, and what truth is made of, is that of the scene itself.
        for (const std::size_t kind : {std::size_t{1}, std::size_t{2}, std::size_t{3}, std::size_t{4}})
            EXPECT_TRUE(std::ranges::equal(expected[kind]->bytes(), got[kind]->bytes())) << kind;
        int far = 0, unlike_plate = 0;
        const auto plate = drawn(*by, moment, with_plate(camera.view(3), picture, scene_is(SceneInBackdrop::proxies)));
        for (int y = 0; y < 242; ++y) {
            for (int x = 0; x < 326; ++x) {
                int off = 0, off_plate = 0;
                for (int c = 0; c < 3; ++c) {
                    off = std::max(off, std::abs(code(*expected[0], x, y, c) - code(*got[0], x, y, c)));
                    off_plate = std::max(off_plate, std::abs(code(*expected[0], x, y, c) - code(*plate[0], x, y, c)));
                }
                far += off > 2;
                unlike_plate += off_plate > 2;
            }
        }
        RecordProperty("pixels_off_" + std::string(to_string(quality)), far);
        RecordProperty("pixels_off_of_a_plate_" + std::string(to_string(quality)), unlike_plate);
        // Edges, and what pillars hid from the photo.
        EXPECT_LT(far, 326 * 242 / 20) << to_string(quality);
        EXPECT_GT(unlike_plate, 2 * far) << to_string(quality) << ": a plate would do as well";
    }
}

TEST(Projected, GoesOnAsAtItsEdgeAndIsBlackWhereItsCameraCannotSee) {
    const TestCamera taker{.eye = taken_at, .size = {64, 48}, .focal_px = 64.0};
    world::Image picture{.size = taker.size, .rgba = {}};
    for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 64; ++x)
            for (const int c : {x == 63 ? 200 : 40, y, 90, 255}) picture.rgba.push_back(static_cast<std::uint8_t>(c));
    const TestCamera camera{.eye = taken_at, .size = {64, 48}, .focal_px = 128.0};
    const world::SnapshotRef empty = TestWorld{}.snapshot();
    const auto by = drawer();
    const auto turned = [&](double pan_deg) {
        View view = camera.view();
        view.pose =
            camera::pose_from_angles(taken_at, {.pan = glm::radians(pan_deg), .tilt = 0.0, .roll = 0.0}).value();
        return drawn(*by, empty, with_projected(view, picture, taker, Place{}.proxies())).front();
    };
    const auto right = turned(-45.0), behind = turned(180.0);
    EXPECT_EQ(code(*right, 32, 10, 0), 200);
    EXPECT_EQ(code(*behind, 32, 10, 0) + code(*behind, 32, 10, 1) + code(*behind, 32, 10, 2), 0);
    EXPECT_EQ(code(*behind, 32, 10, 3), 255);
}

/// Moved between the pictures and then standing: the same bytes however it is drawn, also where who walks by is made as
/// soft and noisy as the photo.
TEST(Projected, HasTheSameBytesWithAndWithoutLayersAndThreads) {
    for (const world::Quality quality : qualities) {
        for (const bool is_matched : {false, true}) {
            const TestCamera taker = camera_through(lenses()[1], quality);
            const auto a = drawer(1, 0), b = drawer(3), c = drawer(2);
            const auto statics = yard().snapshot()->statics;
            const auto change = [&](world::BackdropSpec& spec) {
                if (is_matched) spec.edge_px = 0.8;
                if (is_matched) spec.noise = world::PlateNoise{.k = 0.1, .read = 1.0};
            };
            for (int n = 0; n < 6; ++n) {
                TestCamera camera = taker;
                camera.eye += glm::dvec3(0.0, 0.05 * std::min(n, 2), 0.0);
                const View view = all_kinds(with_projected(camera.view(), noise(taker.size), taker,
                                                           scene_is(SceneInBackdrop::proxies), change));
                auto moment = std::make_shared<world::Snapshot>(*walked(yard(), -0.9 + 0.3 * n).snapshot());
                moment->statics = statics;
                const auto expected = drawn(*a, moment, view);
                for (software::SoftwareDrawer* const other : {b.get(), c.get()}) {
                    const auto got = drawn(*other, moment, view);
                    for (std::size_t k = 0; k < got.size(); ++k)
                        EXPECT_TRUE(std::ranges::equal(expected[k]->bytes(), got[k]->bytes()))
                            << to_string(quality) << ", picture " << n << ", kind " << k;
                }
            }
        }
    }
}

/// Nothing of a pattern is left that is finer than the pixels: the mean of its light is.
TEST(Projected, IsTheMeanOfWhatLiesInAPixelWhereItIsFiner) {
    const TestCamera taker{.eye = taken_at, .size = {1024, 768}, .focal_px = 800.0};
    world::Image picture{.size = taker.size, .rgba = {}};
    for (int y = 0; y < 768; ++y)
        for (int x = 0; x < 1024; ++x) picture.rgba.insert(picture.rgba.end(), 4, (x + y) % 2 == 0 ? 255 : 0);
    const TestCamera camera{.eye = taken_at + glm::dvec3(0.0, 0.1, 0.0), .size = {96, 64}, .focal_px = 100.0};
    const auto by = drawer();
    const auto frame =
        drawn(*by, TestWorld{}.snapshot(), with_projected(camera.view(), picture, taker, Place{}.proxies())).front();
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 96; ++x) EXPECT_NEAR(code(*frame, x, y, 0), srgb_code(0.5), 3) << x << ", " << y;
}

}  // namespace
}  // namespace camrig::render::projected_test

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/render/support/gallery.h"
#include "tests/render/support/two_rasterisers.h"

// camrig's rasteriser against Mesa's, which draws with the shaders of GPUs. Both are right within their rounding:
// colours within 3 codes; where an edge passes, which of two neighbouring colours a pixel has may differ.
namespace camrig::render {
namespace {

constexpr int tolerance = 3;

struct Difference {
    int pixels = 0;
    int differing = 0;    ///< a channel is more than the tolerance away
    int unexplained = 0;  ///< and from the colours of all nine pixels around, too

    double share() const { return static_cast<double>(differing) / pixels; }
    double unexplained_share() const { return static_cast<double>(unexplained) / pixels; }
    Difference& operator+=(const Difference& other) {
        pixels += other.pixels;
        differing += other.differing;
        unexplained += other.unexplained;
        return *this;
    }
};

Difference between(const Picture& ours, const Picture& theirs) {
    Difference result;
    const ImageSize size = ours.frame->info().size;
    for (int y = 0; y < size.height; ++y) {
        for (int x = 0; x < size.width; ++x) {
            const auto a = ours.at(x, y), b = theirs.at(x, y);
            std::array<int, 4> least = b, most = b;
            for (int v = std::max(0, y - 1); v <= std::min(size.height - 1, y + 1); ++v) {
                for (int u = std::max(0, x - 1); u <= std::min(size.width - 1, x + 1); ++u) {
                    const auto c = theirs.at(u, v);
                    for (std::size_t k = 0; k < 4; ++k) {
                        least[k] = std::min(least[k], c[k]);
                        most[k] = std::max(most[k], c[k]);
                    }
                }
            }
            bool differs = false, is_unexplained = false;
            for (std::size_t k = 0; k < 4; ++k) {
                differs |= std::abs(a[k] - b[k]) > tolerance;
                is_unexplained |= a[k] < least[k] - tolerance || a[k] > most[k] + tolerance;
            }
            ++result.pixels;
            result.differing += differs;
            result.unexplained += is_unexplained;
        }
    }
    return result;
}

Difference compare(const world::SnapshotRef& snapshot, const View& view) {
    return between({drawn_by("cpu", snapshot, view)}, {drawn_by("llvmpipe", snapshot, view)});
}

void expect_alike(const Difference& difference, double share, const std::string& what) {
    EXPECT_LE(difference.share(), share) << what << ": " << difference.differing << " of " << difference.pixels;
    EXPECT_LE(difference.unexplained_share(), share / 5) << what << ": " << difference.unexplained << " unexplained";
}

TEST(TwoRasterisers, AreTwo) {
    EXPECT_TRUE(renderer_of("cpu").description().starts_with("camrig's rasteriser"));
    EXPECT_TRUE(renderer_of("llvmpipe").description().starts_with("llvmpipe"));
}

/// Nine walls, one for each pair of wraps, turned and leaning away, textures larger and smaller than their pixels.
TestWorld walls(const world::Sampler& filters, int variant) {
    constexpr std::array images{ImageSize{64, 64}, ImageSize{37, 20}, ImageSize{1, 3}};
    constexpr std::array repeats{0.6f, 2.7f, 9.0f};
    TestWorld world;
    int n = 0;
    for (const world::Wrap s : {world::Wrap::repeat, world::Wrap::clamp_to_edge, world::Wrap::mirrored_repeat}) {
        for (const world::Wrap t : {world::Wrap::repeat, world::Wrap::clamp_to_edge, world::Wrap::mirrored_repeat}) {
            const glm::vec3 middle(3.0f, 1.3f * static_cast<float>(n % 3 - 1), 1.0f * static_cast<float>(n / 3 - 1));
            auto model =
                model_of(rectangle(middle, {0.5f, -0.55f, 0.1f}, {0.2f, 0.1f, 0.4f}), colored(glm::vec3(1.0f), true));
            const auto pick = [&](int of) { return static_cast<std::size_t>((of + variant) % 3); };
            for (glm::vec2& at : model->meshes[0].primitives[0].texcoords[0]) at = (at - 0.3f) * repeats[pick(n)];
            model->images.push_back(patterned(images[pick(n / 3 + n)]));
            world::Sampler sampler = filters;
            sampler.wrap_s = s;
            sampler.wrap_t = t;
            model->textures.push_back({.image = 0, .sampler = sampler});
            model->materials[0].base_color_texture.texture = 0;
            world.objects.push_back(instance_of(model, {}, static_cast<std::uint32_t>(++n)));
        }
    }
    return world;
}

TEST(TwoRasterisers, SampleTexturesAlike) {
    for (const world::Filter magnify : {world::Filter::nearest, world::Filter::linear}) {
        for (const world::Filter minify : {world::Filter::nearest, world::Filter::linear}) {
            for (const bool mipmaps : {false, true}) {
                Difference sum;
                for (int variant = 0; variant < 3; ++variant) {
                    const world::Sampler sampler{.magnify = magnify, .minify = minify, .mipmaps = mipmaps};
                    const View view = TestCamera{.size = {200, 150}, .focal_px = 130.0}.view();
                    sum += compare(walls(sampler, variant).snapshot(), view);
                }
                // OpenGL 4.5, 8.14.3: linear magnification goes on for half a level where minification is nearest of
                // the nearest level. Mesa's does not do that.
                const bool is_known = magnify == world::Filter::linear && minify == world::Filter::nearest && mipmaps;
                expect_alike(sum, is_known ? 0.05 : 0.01,
                             std::string(magnify == world::Filter::linear ? "linear" : "nearest") + " and " +
                                 (minify == world::Filter::linear ? "linear" : "nearest") +
                                 (mipmaps ? ", mip levels" : ""));
            }
        }
    }
}

TEST(TwoRasterisers, DrawEverySortOfSurfaceAlike) {
    const world::SnapshotRef snapshot = gallery().snapshot();
    for (const world::Quality quality : {world::Quality::fast, world::Quality::simple}) {
        for (const ImageSize size : {ImageSize{641, 479}, ImageSize{320, 240}, ImageSize{7, 5}, ImageSize{1, 1}}) {
            for (const bool is_aside : {false, true}) {
                TestCamera camera{.size = size, .focal_px = 0.7 * size.width, .quality = quality};
                if (is_aside) {
                    camera.far_m = 4.2;
                    camera.intrinsics =
                        camera::Intrinsics{0.8 * size.width, 0.7 * size.width, 0.2 * size.width, 0.7 * size.height};
                }
                const Difference difference = compare(snapshot, camera.view());
                const std::string what = std::string(to_string(quality)) + " " + size.to_string() +
                                         (is_aside ? ", principal point aside, far plane" : "");
                if (size.width > 100) {
                    expect_alike(difference, 0.01, what);
                } else {
                    EXPECT_LE(difference.differing, 2) << what;
                }
            }
        }
    }
}

TEST(TwoRasterisers, DrawPeopleAlike) {
    Film film("hall");
    {
        const world::SnapshotRef snapshot = film.at(7 * ns_per_s);
        for (const world::Quality quality : {world::Quality::fast, world::Quality::simple, world::Quality::beautiful}) {
            View view = film.view("lobby", {640, 360}, 1);
            auto spec = std::make_shared<world::CameraSpec>(*view.spec);
            spec->antialias = world::Antialias::none;
            view.spec = spec;
            view.quality = quality;
            expect_alike(compare(snapshot, view), 0.01, std::string(to_string(quality)) + " hall");
        }
    }
}

TEST(TwoRasterisers, DrawWhatGoesThroughTheImagePlaneAlike) {
    // Through the camera, around it, and far beyond all sides.
    const world::Material white = colored(glm::vec3(0.8f));
    world::Material both = white;
    both.double_sided = true;
    world::Primitive huge = triangles({{-3e4f, 2e4f, -3e4f}, {5e4f, -4e4f, 1e3f}, {2e4f, 3e4f, 4e4f}});
    world::Primitive near = triangles({{-1.0f, 0.2f, -0.3f},
                                       {2.0f, -0.6f, -0.1f},
                                       {0.04f, 0.5f, 0.4f},
                                       {-0.5f, -0.3f, 0.3f},
                                       {0.3f, 0.2f, 0.2f},
                                       {4.0f, -3.0f, 0.5f}});
    near.colors = {{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}, {1, 1, 0, 1}, {0, 1, 1, 1}, {1, 0, 1, 1}};
    TestWorld world;
    world.lights = {light_of(world::LightType::point, 2.0f, {1, 0.5, 0.5})};
    world.environment.ambient_sky = glm::vec3(0.1f);
    for (const auto& [primitive, material] : {std::pair(huge, both), std::pair(near, both),
                                              std::pair(ball(1.5f, 9), both), std::pair(ball(1.5f, 9), white)}) {
        for (const world::Quality quality : {world::Quality::fast, world::Quality::simple, world::Quality::beautiful}) {
            world.objects = {instance_of(model_of(primitive, material))};
            for (const double near_m : {0.05, 0.7})
                expect_alike(
                    compare(
                        world.snapshot(),
                        TestCamera{.size = {321, 243}, .focal_px = 200.0, .near_m = near_m, .quality = quality}.view()),
                    0.01, "near");
        }
    }
}

TEST(TwoRasterisers, HaveTheSameSilhouettes) {
    // Colour by camrig's rasteriser, ids by Mesa's: what detection data is made of. Nothing here is magenta but
    // nothing.
    TestWorld world;
    world.environment.background = {1.0f, 0.0f, 1.0f};
    std::uint32_t id = 1;
    for (int i = 0; i < 60; ++i) {
        const glm::dvec3 place(4.0 + 0.3 * i, 0.13 * i * std::cos(2.4 * i), 0.1 * i * std::sin(2.4 * i));
        world.objects.push_back(instance_of(model_of(ball(0.25f, 7), colored({0.1f, 0.8f, 0.1f}, true)), place, id++));
    }
    const world::SnapshotRef snapshot = world.snapshot();
    View view = TestCamera{.size = {640, 480}, .focal_px = 500.0}.view();
    const Picture color{drawn_by("cpu", snapshot, view)};
    std::ranges::fill(view.kinds, false);
    view.kinds[static_cast<int>(frame::FrameKind::instance)] = true;
    const frame::FrameRef ids = drawn_by("llvmpipe", snapshot, view);
    const auto* const id_of = reinterpret_cast<const std::uint32_t*>(ids->bytes().data());
    int border = 0, differing = 0;
    for (int y = 0; y < 480; ++y) {
        for (int x = 0; x < 640; ++x) {
            const bool is_object = id_of[640 * y + x] != 0;
            border += x > 0 && is_object != (id_of[640 * y + x - 1] != 0);
            border += y > 0 && is_object != (id_of[640 * (y - 1) + x] != 0);
            differing += is_object != (color.at(x, y)[2] < 128);
        }
    }
    EXPECT_GT(border, 3000);
    EXPECT_LE(differing, border / 100) << "of " << border << " places where a silhouette passes";
}

}  // namespace
}  // namespace camrig::render

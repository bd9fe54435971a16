#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/render/software/software_drawer.h"
#include "tests/render/support/gallery.h"

// Depth, ids, classes and normals by camrig's rasteriser: those of Mesa's, and the same bytes however the work is done.
namespace camrig::render {
namespace {

constexpr std::array other_kinds{frame::FrameKind::depth, frame::FrameKind::instance, frame::FrameKind::semantic,
                                 frame::FrameKind::normal};

Renderer& renderer_of(const std::string& device) {
    static std::map<std::string, std::unique_ptr<Renderer>> renderers;
    auto& renderer = renderers[device];
    if (renderer == nullptr)
        renderer = std::move(create_renderer({.device = device, .pool = std::make_shared<frame::FramePool>()}).value());
    return *renderer;
}

View of_kinds(View view, std::span<const frame::FrameKind> kinds) {
    for (int k = 0; k < frame::scene_kind_count; ++k)
        view.kinds[k] = std::ranges::find(kinds, static_cast<frame::FrameKind>(k)) != kinds.end();
    return view;
}

/// All pictures of a view but colour.
struct Seen {
    std::vector<float> depth, normal;
    std::vector<std::uint32_t> instance, semantic;
};

template <typename T>
std::vector<T> pixels_of(const frame::Frame& frame) {
    std::vector<T> pixels(frame.bytes().size() / sizeof(T));
    std::memcpy(pixels.data(), frame.bytes().data(), frame.bytes().size());
    return pixels;
}

Seen seen_by(const std::string& device, const world::SnapshotRef& snapshot, const View& view) {
    const View asked = of_kinds(view, other_kinds);
    const auto finished = renderer_of(device).draw(snapshot, 0, {&asked, 1}).value();
    Seen seen;
    for (const frame::FrameRef& frame : finished.set.frames) {
        if (frame->info().kind == frame::FrameKind::depth) seen.depth = pixels_of<float>(*frame);
        if (frame->info().kind == frame::FrameKind::normal) seen.normal = pixels_of<float>(*frame);
        if (frame->info().kind == frame::FrameKind::instance) seen.instance = pixels_of<std::uint32_t>(*frame);
        if (frame->info().kind == frame::FrameKind::semantic) seen.semantic = pixels_of<std::uint32_t>(*frame);
    }
    return seen;
}

struct Difference {
    int pixels = 0, other_id = 0, unexplained = 0, other_class = 0, other_depth = 0, other_normal = 0;
    float depth = 0.0f, degrees = 0.0f;  ///< the largest that is no other surface's

    void print(const std::string& what) const {
        std::printf(
            "%s: of %d pixels %d with another id (%d not at an edge), %d with another depth, %d with another "
            "normal; else depth within %.1e, normals within %.4f deg\n",
            what.c_str(), pixels, other_id, unexplained, other_depth, other_normal, depth, degrees);
    }
};

/// What is more than this away is another surface: where an edge passes.
constexpr float surface_share = 1e-4f, surface_degrees = 0.5f;

Difference between(const Seen& ours, const Seen& theirs, ImageSize size) {
    Difference result;
    for (int y = 0; y < size.height; ++y) {
        for (int x = 0; x < size.width; ++x) {
            const auto i =
                static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width) + static_cast<std::size_t>(x);
            ++result.pixels;
            if (ours.instance[i] != theirs.instance[i]) {
                ++result.other_id;
                bool is_beside = false;
                for (int v = std::max(0, y - 1); v <= std::min(size.height - 1, y + 1); ++v)
                    for (int u = std::max(0, x - 1); u <= std::min(size.width - 1, x + 1); ++u)
                        is_beside |= theirs.instance[static_cast<std::size_t>(v * size.width + u)] == ours.instance[i];
                result.unexplained += !is_beside;
                continue;
            }
            result.other_class += ours.semantic[i] != theirs.semantic[i];
            const float a = ours.depth[i], b = theirs.depth[i];
            EXPECT_EQ(std::isinf(a), ours.instance[i] == 0);
            if (std::isinf(a)) continue;
            const float apart = std::abs(a - b) / b;
            if (apart > surface_share) {
                ++result.other_depth;
                continue;
            }
            result.depth = std::max(result.depth, apart);
            const glm::vec3 n(ours.normal[3 * i], ours.normal[3 * i + 1], ours.normal[3 * i + 2]);
            const glm::vec3 m(theirs.normal[3 * i], theirs.normal[3 * i + 1], theirs.normal[3 * i + 2]);
            EXPECT_NEAR(glm::length(n), 1.0f, 1e-6f);
            const float degrees = glm::degrees(std::asin(std::min(1.0f, glm::length(glm::cross(n, m)))));
            if (degrees > surface_degrees || glm::dot(n, m) < 0.0f) {
                ++result.other_normal;
            } else {
                result.degrees = std::max(result.degrees, degrees);
            }
        }
    }
    return result;
}

void expect_alike(const world::SnapshotRef& snapshot, const View& view, const std::string& what) {
    const Difference difference =
        between(seen_by("cpu", snapshot, view), seen_by("llvmpipe", snapshot, view), view.spec->size);
    difference.print(what);
    EXPECT_LE(difference.other_id, difference.pixels / 1000) << what;
    EXPECT_EQ(difference.unexplained, 0) << what;
    EXPECT_EQ(difference.other_class, 0) << what;
    EXPECT_LE(difference.other_depth, difference.pixels / 1000) << what;
    EXPECT_LE(difference.other_normal, difference.pixels / 200) << what;
}

TEST(Channels, OfEverySortOfSurfaceAreMesasButWhereEdgesPass) {
    const world::SnapshotRef snapshot = gallery().snapshot();
    for (const world::Quality quality : {world::Quality::simple, world::Quality::beautiful}) {
        for (const bool is_aside : {false, true}) {
            TestCamera camera{.size = {641, 479}, .focal_px = 450.0, .quality = quality};
            if (is_aside) {
                camera.far_m = 4.2;
                camera.intrinsics = camera::Intrinsics{513.0, 449.0, 128.0, 335.0};
                camera.antialias = world::Antialias::msaa4;
            }
            expect_alike(snapshot, camera.view(),
                         std::string("gallery, ") + std::string(to_string(quality)) +
                             (is_aside ? ", principal point aside, far plane" : ""));
        }
    }
}

TEST(Channels, OfShippedScenesAreMesasButWhereEdgesPass) {
    for (const char* name : {"hall", "street", "crowd"}) {
        Film film(name);
        const world::SnapshotRef snapshot = film.at(7 * ns_per_s);
        for (std::size_t i = 0; i < 2; ++i)
            expect_alike(snapshot, film.view(film.camera(i), {480, 360}, 1), std::string(name) + ", " + film.camera(i));
    }
}

TEST(Channels, OfObjectsAloneAreMesas) {
    const world::SnapshotRef snapshot = gallery().snapshot();
    View view = TestCamera{.size = {320, 240}, .focal_px = 220.0}.view();
    int shown = 0;
    for (const auto* instances : {&snapshot->statics->objects, &snapshot->movers}) {
        for (const world::Instance& instance : *instances) {
            view.only_objects = {instance.info->id};
            const Seen ours = seen_by("cpu", snapshot, view), theirs = seen_by("llvmpipe", snapshot, view);
            EXPECT_EQ(between(ours, theirs, view.spec->size).unexplained, 0) << instance.info->name;
            for (const std::uint32_t id : ours.instance) {
                EXPECT_TRUE(id == 0 || id == static_cast<std::uint32_t>(instance.info->id));
                shown += id != 0;
            }
        }
    }
    EXPECT_GT(shown, 10000);
}

TEST(Channels, AreDrawnWithoutMesaWhateverColourTakes) {
    auto options = RendererOptions{.device = "cpu", .pool = std::make_shared<frame::FramePool>()};
    const auto renderer = create_renderer(options).value();
    View view =
        TestCamera{.size = {64, 48}, .antialias = world::Antialias::msaa4, .quality = world::Quality::beautiful}.view();
    view = of_kinds(view, other_kinds);
    const auto finished = renderer->draw(gallery().snapshot(), 0, {&view, 1}).value();
    EXPECT_EQ(finished.set.frames.size(), other_kinds.size());
    EXPECT_EQ(renderer->description().find("llvmpipe"), std::string::npos) << renderer->description();
}

/// Snapshots of the gallery whose movers go through the picture. The statics are the same ones.
world::SnapshotRef moment(const world::SnapshotRef& first, int n) {
    auto snapshot = std::make_shared<world::Snapshot>(*first);
    snapshot->movers[0].position = {4.0, -1.6 + 0.23 * n, -0.5};
    snapshot->movers[1].position = {2.6 + 0.1 * n, 0.9 - 0.17 * n, -0.2 + 0.05 * n};
    return snapshot;
}

std::vector<frame::FrameRef> drawn(software::SoftwareDrawer& by, const world::SnapshotRef& snapshot,
                                   const std::vector<View>& views) {
    if (by.snapshot() != snapshot) by.begin_instant(snapshot);
    std::vector<const View*> asked;
    for (const View& view : views) asked.push_back(&view);
    std::vector<frame::FrameRef> frames;
    by.draw(asked, 0, frames);
    return frames;
}

TEST(Channels, AreTheSameBytesWhateverElseIsAskedForAndHoweverTheyAreDrawn) {
    const auto made = [](std::int64_t layer_bytes, int threads, bool wide) {
        software::SoftwareDrawer::Options options{
            .pool = std::make_shared<frame::FramePool>(), .static_layer_bytes = layer_bytes, .threads = threads};
        options.wide_lanes = options.wide_lanes && wide;
        return std::make_unique<software::SoftwareDrawer>(options);
    };
    // Room for all layers; for those of a camera without its normals; none.
    const auto kept = made(std::int64_t{64} << 20, 2, true), tight = made(168 * 100 * 4 * 6, 1, true),
               full = made(0, 3, false);
    const world::SnapshotRef first = gallery().snapshot();
    std::vector<View> views{TestCamera{.size = {161, 100}, .focal_px = 110.0}.view(1),
                            TestCamera{.eye = {0.0, 0.3, 0.0}, .size = {160, 90}, .focal_px = 110.0}.view(2)};
    std::vector<frame::FrameRef> held;
    int reused = 0;
    for (int n = 0; n < 120; ++n) {
        const world::SnapshotRef snapshot = moment(first, n % 17);
        if (n == 50) views[0].pose.position.z += 0.1;
        if (n == 80) kept->forget(views[1].camera);
        for (std::size_t i = 0; i < views.size(); ++i) {
            views[i].sequence = n;
            views[i].only_objects.clear();
            bool is_any = false;
            for (int k = 0; k < frame::scene_kind_count; ++k) {
                // For some while few kinds, then more of them.
                const double likely = n < 20 ? 0.3 : n < 40 && k > 0 ? 0.0 : 0.7;
                views[i].kinds[k] = random_unit(6, static_cast<std::uint64_t>(5 * n + k), i) < likely;
                is_any |= views[i].kinds[k];
            }
            if (!is_any) views[i].kinds[2] = true;
            if (n % 11 == 10 && !views[i].kinds[0]) views[i].only_objects = {ObjectId{3}, ObjectId{5}};
        }
        const auto a = drawn(*kept, snapshot, views), b = drawn(*tight, snapshot, views);
        std::vector<frame::FrameRef> c;
        for (const View& view : views) {
            for (int k = 0; k < frame::scene_kind_count; ++k) {
                if (!view.kinds[k]) continue;
                const std::array alone{static_cast<frame::FrameKind>(k)};
                full->forget(view.camera);
                c.push_back(drawn(*full, snapshot, {of_kinds(view, alone)}).at(0));
            }
        }
        ASSERT_EQ(a.size(), c.size());
        ASSERT_EQ(b.size(), c.size());
        for (std::size_t i = 0; i < a.size(); ++i) {
            const std::string what = "instant " + std::to_string(n) + ", camera " + *a[i]->info().camera + ", kind " +
                                     std::to_string(static_cast<int>(a[i]->info().kind));
            ASSERT_EQ(a[i]->info().kind, c[i]->info().kind) << what;
            ASSERT_TRUE(std::ranges::equal(a[i]->bytes(), c[i]->bytes())) << what << ", with layers";
            ASSERT_TRUE(std::ranges::equal(b[i]->bytes(), c[i]->bytes())) << what << ", with little room";
            reused += a[i]->held_before() != 0;
            if (random_unit(7, static_cast<std::uint64_t>(n), i) < 0.4) held.push_back(a[i]);
        }
        while (held.size() > 9) held.erase(held.begin());
    }
    EXPECT_GT(reused, 100);
    EXPECT_GT(kept->counters().layers_reused, 100u);
    EXPECT_LE(kept->counters().layers_drawn, 4u) << "a layer gets what is asked for later, and stays";
}

TEST(Channels, OfOneInstantAreDrawnTogetherForWhoTookSeveralOfTheLast) {
    software::SoftwareDrawer by(
        {.pool = std::make_shared<frame::FramePool>(), .static_layer_bytes = std::int64_t{64} << 20});
    const world::SnapshotRef first = gallery().snapshot();
    View view = TestCamera{.size = {160, 100}, .focal_px = 110.0}.view();
    const std::array taken{frame::FrameKind::color, frame::FrameKind::depth, frame::FrameKind::instance};
    std::uint64_t before = 0;
    for (int n = 0; n < 5; ++n) {
        view.sequence = n;
        const world::SnapshotRef snapshot = moment(first, n);
        for (const frame::FrameKind kind : taken) {
            software::SoftwareDrawer other({.pool = std::make_shared<frame::FramePool>()});
            const View one = of_kinds(view, std::array{kind});
            const auto together = drawn(by, snapshot, {one}), alone = drawn(other, snapshot, {one});
            ASSERT_EQ(together.size(), 1u);
            EXPECT_EQ(together[0]->info().sequence, n);
            EXPECT_TRUE(std::ranges::equal(together[0]->bytes(), alone[0]->bytes()));
        }
        EXPECT_EQ(by.counters().views - before, n == 0 ? 3u : 1u) << n;
        before = by.counters().views;
        if (n != 3) continue;
        // The camera is turned while the world stands: nothing of before is shown.
        view.pose.position.z += 0.1;
        ++view.spec_revision;
        software::SoftwareDrawer other({.pool = std::make_shared<frame::FramePool>()});
        const View one = of_kinds(view, std::array{frame::FrameKind::depth});
        EXPECT_TRUE(
            std::ranges::equal(drawn(by, snapshot, {one})[0]->bytes(), drawn(other, snapshot, {one})[0]->bytes()));
        before = by.counters().views;
    }
}

/// Pictures of a camera whose colour is drawn by coverage, from a drawer that keeps layers in so much memory: some of
/// one sort only, then colour and all other kinds together. Gives the memory that its layer takes in the end.
std::int64_t expect_same_beside_coverage(bool is_color_first, std::int64_t layer_bytes, const std::string& what) {
    software::SoftwareDrawer kept(
        {.pool = std::make_shared<frame::FramePool>(), .static_layer_bytes = layer_bytes, .threads = 2}),
        full({.pool = std::make_shared<frame::FramePool>(), .threads = 3});
    const world::SnapshotRef first = gallery().snapshot();
    const TestCamera at_middles{.size = {161, 100}, .focal_px = 110.0};
    TestCamera by_areas = at_middles;
    by_areas.antialias = world::Antialias::coverage;
    View view = by_areas.view();
    for (int n = 0; n < 8; ++n) {
        const world::SnapshotRef snapshot = moment(first, 2 * n);
        view.sequence = n;
        for (int k = 0; k < frame::scene_kind_count; ++k) view.kinds[k] = n >= 3 || (k == 0) == is_color_first;
        for (const frame::FrameRef& frame : drawn(kept, snapshot, {view})) {
            const frame::FrameKind kind = frame->info().kind;
            const View alone =
                of_kinds((kind == frame::FrameKind::color ? by_areas : at_middles).view(), std::array{kind});
            full.forget(alone.camera);
            EXPECT_TRUE(std::ranges::equal(frame->bytes(), drawn(full, snapshot, {alone}).at(0)->bytes()))
                << what << ", instant " << n << ", kind " << static_cast<int>(kind);
        }
    }
    return kept.counters().layer_bytes;
}

TEST(Channels, BesideColourByCoverageAreThoseOfPixelsMiddles) {
    // A layer takes as much whatever was asked for first, and is given up where only the edges of areas find no room.
    const std::int64_t room = std::int64_t{64} << 20, taken = expect_same_beside_coverage(true, room, "colour first");
    EXPECT_EQ(expect_same_beside_coverage(false, room, "colour later"), taken);
    EXPECT_LT(expect_same_beside_coverage(true, taken - 1, "colour first, little room"), taken);
    EXPECT_EQ(expect_same_beside_coverage(false, taken - 1, "colour later, little room"), 0);
    EXPECT_EQ(expect_same_beside_coverage(true, 0, "no layers"), 0);
}

TEST(Silhouettes, AreThePixelsThatAnObjectShowsAloneWithAndWithoutALayer) {
    software::SoftwareDrawer by(
        {.pool = std::make_shared<frame::FramePool>(), .static_layer_bytes = std::int64_t{64} << 20, .threads = 2});
    const world::SnapshotRef first = gallery().snapshot();
    std::vector<ObjectId> all{ObjectId{999}};  // not there
    for (const auto* instances : {&first->statics->objects, &first->movers})
        for (const world::Instance& instance : *instances) all.push_back(instance.info->id);
    const std::array<frame::FrameKind, 1> ids{frame::FrameKind::instance};
    const View view = of_kinds(TestCamera{.size = {161, 100}, .focal_px = 110.0}.view(), ids);
    for (int n = 0; n < 6; ++n) {
        const world::SnapshotRef snapshot = moment(first, 3 * n);
        drawn(by, snapshot, {view});
        const std::vector<frame::Silhouette> silhouettes = by.silhouettes(view, all);
        ASSERT_EQ(silhouettes.size(), all.size());
        for (std::size_t i = 0; i < all.size(); ++i) {
            View alone = view;
            alone.only_objects = {all[i]};
            auto shown = pixels_of<std::uint32_t>(*drawn(by, snapshot, {alone}).at(0));
            for (const frame::PixelRun& run : silhouettes[i]) {
                for (int x = run.x0; x < run.x1; ++x) {
                    std::uint32_t& id = shown.at(static_cast<std::size_t>(161 * run.y + x));
                    EXPECT_EQ(id, static_cast<std::uint32_t>(all[i]));
                    id = 0;
                }
            }
            EXPECT_TRUE(std::ranges::all_of(shown, [](std::uint32_t id) { return id == 0; }))
                << "object " << static_cast<std::uint32_t>(all[i]) << ", instant " << n;
        }
    }
}

/// Lines between, or points at, random places around the camera and behind it, each an object.
TestWorld strokes(world::Topology topology, bool is_steep) {
    TestWorld world;
    std::uint64_t n = 0;
    const auto random = [&] { return static_cast<float>(random_unit(9, static_cast<std::uint64_t>(topology), n++)); };
    for (std::uint32_t id = 1; id <= 300; ++id) {
        world::Primitive p;
        p.topology = topology;
        // In this order with every compiler: arguments of a call have none.
        const float up = 4.0f * random() - 2.0f, aside = 6.0f * random() - 3.0f, ahead = 6.0f * random() - 1.0f;
        const glm::vec3 from(ahead, aside, up);
        p.positions = {from};
        if (topology == world::Topology::lines) {
            const float z = random(), y = random(), x = random();
            const glm::vec3 by = is_steep ? glm::vec3(x, y, 4.0f * z) : glm::vec3(2.0f * x, 3.0f * y - 1.5f, z);
            p.positions.push_back(from + by - glm::vec3(0.5f));
        }
        for (std::uint32_t i = 0; i < p.positions.size(); ++i) p.indices.push_back(i);
        p.bounds = {glm::vec3(-20.0f), glm::vec3(20.0f)};
        world.objects.push_back(instance_of(model_of(p, colored({random(), random(), random()}, true)), {}, id));
    }
    return world;
}

TEST(Strokes, ArePixelsOfPointsAndLinesAsMesaDrawsThem) {
    for (const auto& [topology, is_steep] :
         {std::pair(world::Topology::points, false), std::pair(world::Topology::lines, false),
          std::pair(world::Topology::lines, true)}) {
        const world::SnapshotRef snapshot = strokes(topology, is_steep).snapshot();
        const View view = TestCamera{.size = {320, 240}, .focal_px = 200.0}.view();
        const Seen ours = seen_by("cpu", snapshot, view), theirs = seen_by("llvmpipe", snapshot, view);
        int shown = 0, other = 0, unexplained = 0, other_depth = 0;
        for (std::size_t i = 0; i < ours.instance.size(); ++i) {
            shown += theirs.instance[i] != 0;
            if (ours.instance[i] == theirs.instance[i]) {
                if (theirs.instance[i] != 0)
                    other_depth += std::abs(ours.depth[i] - theirs.depth[i]) > 5e-3f * theirs.depth[i];
                continue;
            }
            ++other;
            bool is_beside = false;
            for (const int offset : {-321, -320, -319, -1, 0, 1, 319, 320, 321}) {
                const auto beside = static_cast<std::size_t>(static_cast<int>(i) + offset);
                is_beside |= beside < theirs.instance.size() && theirs.instance[beside] == ours.instance[i];
            }
            unexplained += !is_beside;
        }
        std::printf("%d pixels, %d other ids (%d not beside), %d other depths\n", shown, other, unexplained,
                    other_depth);
        EXPECT_GT(shown, topology == world::Topology::points ? 100 : 5000);
        // Mesa rounds to its own parts of a pixel: two points here, and where a line goes over to the next row.
        EXPECT_LE(other, std::max(6, shown / 50));
        EXPECT_LE(unexplained, shown / 1000);
        EXPECT_LE(other_depth, shown / 100);
        View colored = view;
        const frame::FrameRef color = renderer_of("cpu").draw(snapshot, 0, {&colored, 1}).value().set.frames.at(0);
        const auto pixels = pixels_of<std::uint32_t>(*color);
        for (std::size_t i = 0; i < pixels.size(); ++i)
            ASSERT_EQ((pixels[i] & 0xFFFFFF) != 0, ours.instance[i] != 0) << i;
    }
    EXPECT_EQ(renderer_of("cpu").description().find("llvmpipe"), std::string::npos);
}

TEST(Strokes, ByCoverageAreAPixelWideWhereverTheyLie) {
    const auto light_of = [](world::Topology topology, glm::vec3 from, glm::vec3 to) {
        world::Primitive p;
        p.topology = topology;
        p.positions = {from, to};
        p.indices = {0, 1};
        p.bounds = {glm::vec3(-20.0f), glm::vec3(20.0f)};
        TestWorld world;
        world.objects = {instance_of(model_of(p, colored(glm::vec3(1.0f), true)))};
        software::SoftwareDrawer by({.pool = std::make_shared<frame::FramePool>()});
        const View view =
            TestCamera{.size = {64, 48}, .focal_px = 64.0, .antialias = world::Antialias::coverage}.view();
        double light = 0.0;
        for (const std::uint32_t pixel : pixels_of<std::uint32_t>(*drawn(by, world.snapshot(), {view}).at(0)))
            light += linear_of(static_cast<int>(pixel & 0xFF));
        return light;
    };
    // At a distance of 4 m a pixel is 1/16 m.
    for (std::uint64_t n = 0; n < 20; ++n) {
        const auto at = [&](std::uint64_t i) { return 0.5f * static_cast<float>(random_unit(12, n, i)); };
        const glm::vec3 left(4.0f, 1.0f + at(0), at(1)), right(4.0f, -1.0f - at(2), at(3));
        EXPECT_NEAR(light_of(world::Topology::points, left, right), 2.0, 0.06) << n;
        EXPECT_NEAR(light_of(world::Topology::lines, left, right), 16.0 * static_cast<double>(left.y - right.y), 1.2)
            << n;
    }
}

}  // namespace
}  // namespace camrig::render

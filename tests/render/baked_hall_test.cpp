#include <gtest/gtest.h>

#include "tests/render/support/gallery.h"
#include "tests/render/support/two_rasterisers.h"

// The hall in its baked light at quality beautiful: by OpenGL as by camrig's rasteriser.
namespace camrig::render {
namespace {

constexpr int tolerance = 3;          ///< codes
constexpr double most_of = 0.99;      ///< of a picture: where an edge passes, either of two colours is right
constexpr double most_of_one = 0.97;  ///< of one object, which has more edges for its size

View lobby(const Film& film) {
    View view = film.view("lobby", {320, 240}, 71);
    auto spec = std::make_shared<world::CameraSpec>(*view.spec);
    spec->antialias = world::Antialias::none;
    view.spec = spec;
    view.quality = world::Quality::beautiful;
    return view;
}

frame::FrameRef ids_of(const world::SnapshotRef& snapshot, View view) {
    view.camera = CameraId{static_cast<std::uint32_t>(view.camera) + 1000};
    view.kinds[static_cast<int>(frame::FrameKind::color)] = false;
    view.kinds[static_cast<int>(frame::FrameKind::instance)] = true;
    return drawn_by("cpu", snapshot, view);
}

void expect_alike(const world::SnapshotRef& snapshot, const View& view, const std::string& what) {
    const Alike whole = alike(drawn_by("cpu", snapshot, view), drawn_by("llvmpipe", snapshot, view), tolerance);
    EXPECT_GE(whole.share(), most_of) << what;
    testing::Test::RecordProperty(what, std::to_string(whole.share()));
}

void expect_objects_alike(const world::SnapshotRef& snapshot, const View& view, const std::vector<std::uint32_t>& ids,
                          const std::string& what) {
    const Alike some = alike(drawn_by("cpu", snapshot, view), drawn_by("llvmpipe", snapshot, view), tolerance, ids,
                             ids_of(snapshot, view));
    ASSERT_GE(some.pixels, 200) << what;
    EXPECT_GE(some.share(), most_of_one) << what << ": of " << some.pixels;
    testing::Test::RecordProperty(what, std::to_string(some.share()));
}

TEST(BakedHall, StandsInTheSameLight) {
    Film film("hall", true), without("hall");
    const auto snapshot = film.at(4 * ns_per_s);
    const View view = lobby(film);
    expect_alike(snapshot, view, "hall");
    View other = view;
    other.camera = CameraId{72};
    EXPECT_LT(
        alike(drawn_by("llvmpipe", snapshot, view), drawn_by("llvmpipe", without.at(4 * ns_per_s), other), tolerance)
            .share(),
        0.5)
        << "baked light is not seen at all";
}

TEST(BakedHall, OnlyBeautifulLooksAtIt) {
    Film film("hall", true), without("hall");
    const auto snapshot = film.at(4 * ns_per_s), plain = without.at(4 * ns_per_s);
    for (const world::Quality quality : {world::Quality::fast, world::Quality::simple}) {
        View with = lobby(film), other = lobby(film);
        with.quality = other.quality = quality;
        other.camera = CameraId{72};
        const auto a = drawn_by("llvmpipe", snapshot, with), b = drawn_by("llvmpipe", plain, other);
        EXPECT_TRUE(std::ranges::equal(a->bytes(), b->bytes())) << to_string(quality);
    }
}

TEST(BakedHall, PeopleTakeTheLightOfProbes) {
    Film film("hall", true);
    const auto snapshot = film.at(4 * ns_per_s);
    std::vector<std::uint32_t> people;
    for (const world::Instance& mover : snapshot->movers) people.push_back(static_cast<std::uint32_t>(mover.info->id));
    expect_objects_alike(snapshot, lobby(film), people, "people");
}

TEST(BakedHall, WhatWasMovedTakesTheLightOfProbes) {
    Film film("hall", true);
    const auto stands = film.at(4 * ns_per_s);
    auto statics = std::make_shared<world::StaticSet>(*stands->statics);
    // The hall is one object of them, and what stands in it are others: all are moved a little.
    std::vector<std::uint32_t> moved_ids;
    for (world::Instance& object : statics->objects) {
        if (object.info->name == "hall") continue;
        object.position.x += 0.05;
        moved_ids.push_back(static_cast<std::uint32_t>(object.info->id));
    }
    auto moved = std::make_shared<world::Snapshot>(*stands);
    moved->statics = statics;
    expect_alike(moved, lobby(film), "hall with moved things");
    expect_objects_alike(moved, lobby(film), moved_ids, "moved things");
}

TEST(BakedHall, AnotherSkyIsSeenAtOnceByACameraThatStands) {
    Film film("hall", true);
    const auto day = film.at(4 * ns_per_s);
    const View view = lobby(film);
    for (int i = 0; i < 3; ++i) drawn_by("llvmpipe", day, view);  // what stands still is kept by now
    auto statics = std::make_shared<world::StaticSet>(*day->statics);
    statics->environment.ambient_sky *= glm::vec3(0.25f, 0.3f, 0.4f);
    auto dusk = std::make_shared<world::Snapshot>(*day);
    dusk->statics = statics;
    const auto kept = drawn_by("llvmpipe", dusk, view);
    expect_alike(dusk, view, "dusk");
    renderer_of("llvmpipe").forget(view.camera);
    EXPECT_TRUE(std::ranges::equal(kept->bytes(), drawn_by("llvmpipe", dusk, view)->bytes()));
}

TEST(BakedHall, ExposureOfTheCameraCounts) {
    Film film("hall", true);
    View view = lobby(film);
    auto spec = std::make_shared<world::CameraSpec>(*view.spec);
    spec->exposure_ev = -1.5;
    view.spec = spec;
    ++view.spec_revision;
    expect_alike(film.at(4 * ns_per_s), view, "darker");
}

}  // namespace
}  // namespace camrig::render

#include <gtest/gtest.h>

#include "tests/render/support/gallery.h"
#include "tests/render/support/two_rasterisers.h"

// The hall in its baked light at quality beautiful: by OpenGL as by camrig's rasteriser.
namespace camrig::render {
namespace {

View seen_from(const Film& film, const std::string& camera) {
    View view = film.view(camera, {320, 240}, 71);
    auto spec = std::make_shared<world::CameraSpec>(*view.spec);
    spec->antialias = world::Antialias::none;
    view.spec = spec;
    view.quality = world::Quality::beautiful;
    return view;
}
View lobby(const Film& film) {
    return seen_from(film, "lobby");
}

TEST(BakedHall, StandsInTheSameLight) {
    Film film("hall", true), without("hall");
    const auto snapshot = film.at(4 * ns_per_s);
    const View view = lobby(film);
    expect_alike(snapshot, view, "hall");
    View other = view;
    other.camera = CameraId{72};
    EXPECT_LT(
        alike(drawn_by("llvmpipe", snapshot, view), drawn_by("llvmpipe", without.at(4 * ns_per_s), other)).share(), 0.5)
        << "baked light is not seen at all";
}

TEST(BakedHall, StandsInTheSameLightFromTheGallery) {
    Film film("hall", true);
    const auto snapshot = film.at(4 * ns_per_s);
    EXPECT_FALSE(snapshot->statics->baked_light->reflection_probes.places.empty());
    expect_alike(snapshot, seen_from(film, "gallery"), "gallery");
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
    expect_alike(snapshot, lobby(film), "people", people);
}

TEST(BakedHall, WhatWasMovedTakesTheLightOfProbes) {
    Film film("hall", true);
    const auto stands = film.at(4 * ns_per_s), moved = with_moved_objects(stands, {0.0, 0.0, -0.002});
    const View view = lobby(film);
    expect_alike(moved, view, "moved");
    // Each of its surfaces has one light, of the place in its middle.
    EXPECT_LT(alike(drawn_by("llvmpipe", stands, view), drawn_by("llvmpipe", moved, view)).share(), 0.5);
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

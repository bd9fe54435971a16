#include <gtest/gtest.h>

#include "core/world/world.h"
#include "tests/render/support/two_rasterisers.h"
#include "tests/unit/bake/scenes.h"

// What mirrors show by reflection probes, and glass: by OpenGL as by camrig's rasteriser.
namespace camrig::render {
namespace {

constexpr float mirror = 0.05f;

void change(world::Scene& scene, const std::string& name, const auto& how) {
    auto model = std::make_shared<world::Model>(*scene.models.at(name).model);
    for (world::Material& material : model->materials) how(material);
    scene.models.at(name).model = model;
}

/// A room with a mirror for a floor, a bright panel on its east wall, and before that wall a pane of glass, in which a
/// lamp on the west wall is mirrored.
world::Scene mirror_room() {
    std::vector<bake::TestBox> boxes = bake::room({6, 6, 3}, 0.6);
    boxes.push_back({"panel", {3.0, -0.8, 1.0}, {0.2, 1.0, 1.0}, 0.0});
    boxes.push_back({"lamp", {-3.0, 2.2, 1.6}, {0.2, 0.8, 0.8}, 0.0});
    boxes.push_back({"pane", {0.5, 1.8, 0.8}, {0.02, 1.8, 1.6}, 0.9});
    world::Scene scene(*bake::scene_of(boxes, R"(,
        "environment": {"ambient": {"sky": [0.2, 0.2, 0.25], "ground": [0.1, 0.1, 0.1]}},
        "lights": [{"name": "bulb", "type": "point", "color": [1, 0.9, 0.7], "intensity": 1.0, "position": [0.2, 0.2, 2.6]}],
        "events": [{"name": "late", "when": {"at_s": 1}, "do": [{"action": "light", "light": "bulb", "intensity": 0.2}]}])"));
    change(scene, "floor", [](world::Material& material) {
        material.roughness = mirror;
        material.metallic = 1.0f;
    });
    change(scene, "panel", [](world::Material& material) { material.emissive = {0.8f, 0.5f, 0.2f}; });
    change(scene, "lamp", [](world::Material& material) { material.emissive = {10.0f, 9.0f, 7.0f}; });
    change(scene, "pane", [](world::Material& material) {
        material.transmission = 0.9f;
        material.alpha_mode = world::AlphaMode::blend;
        material.base_color.a = 0.12f;
        material.tint = {0.6f, 1.05f, 0.9f};
        material.roughness = 0.02f;
    });
    return scene;
}

const world::BakedLight& light_of_room() {
    static const world::BakedLight light = bake::baked(std::make_shared<const world::Scene>(mirror_room()),
                                                       {.texels_per_m = 4.0, .rays = 64, .reflections = 6});
    return light;
}

/// The room at some instants, with a floor that is as rough.
class Room {
public:
    explicit Room(float roughness = mirror, bool has_probes = true) {
        auto scene = std::make_shared<world::Scene>(mirror_room());
        change(*scene, "floor", [&](world::Material& material) { material.roughness = roughness; });
        auto light = std::make_shared<world::BakedLight>(light_of_room());
        if (!has_probes) light->reflection_probes = {};
        use_baked_light(*scene, light);
        world_ = std::move(*world::World::create(scene, 1));
    }
    world::SnapshotRef at(TimeNs world_ns) {
        world_->advance_to(world_ns);
        return world_->snapshot(world_ns);
    }

private:
    std::unique_ptr<world::World> world_;
};

View view_from(const glm::dvec3& eye, std::uint32_t number) {
    TestCamera camera{.eye = eye, .size = {160, 120}, .focal_px = 90.0};
    camera.quality = world::Quality::beautiful;
    return camera.view(number);
}
View over_the_floor(std::uint32_t number = 91) {
    return view_from({-2.8, -0.5, 1.6}, number);
}
View before_the_pane(std::uint32_t number = 92) {
    return view_from({-2.5, 1.5, 1.6}, number);
}

std::vector<std::uint32_t> id_of(const world::SnapshotRef& snapshot, const std::string& name) {
    for (const world::Instance& object : snapshot->statics->objects)
        if (object.info->name == name) return {static_cast<std::uint32_t>(object.info->id)};
    throw std::runtime_error("nothing is called " + name);
}

/// How much of an object looks as if nothing were mirrored in it.
double unchanged(const View& view, const world::SnapshotRef& with, const world::SnapshotRef& without,
                 const std::string& name) {
    View other = view;
    other.camera = CameraId{static_cast<std::uint32_t>(view.camera) + 500};
    return alike(drawn_by("llvmpipe", with, view), drawn_by("llvmpipe", without, other), id_of(with, name),
                 ids_of(with, view))
        .share();
}

TEST(BakedMirrors, HaveSomethingToShow) {
    EXPECT_GE(light_of_room().reflection_probes.places.size(), 2u);
}

TEST(BakedMirrors, AMirrorShowsTheRoom) {
    Room room, without(mirror, false);
    const auto snapshot = room.at(0);
    const View view = over_the_floor();
    expect_alike(snapshot, view, "mirror room");
    expect_alike(snapshot, view, "its floor", id_of(snapshot, "floor"));
    EXPECT_LT(unchanged(view, snapshot, without.at(0), "floor"), 0.5);
}

TEST(BakedMirrors, ARoughFloorShowsItBlurred) {
    Room room(0.35f), without(0.35f, false), smooth;
    const auto snapshot = room.at(0);
    const View view = over_the_floor();
    expect_alike(snapshot, view, "rough floor", id_of(snapshot, "floor"));
    EXPECT_LT(unchanged(view, snapshot, without.at(0), "floor"), 0.5);
    EXPECT_LT(unchanged(view, snapshot, smooth.at(0), "floor"), 0.9);
}

TEST(BakedMirrors, ImagesFadeAndEndWhereSurfacesAreRoughest) {
    const View view = over_the_floor();
    for (const float roughness : {0.55f, 0.7f}) {
        Room room(roughness), without(roughness, false);
        const auto snapshot = room.at(0);
        expect_alike(snapshot, view, "floor of " + std::to_string(roughness), id_of(snapshot, "floor"));
        if (roughness > 0.6f) {
            EXPECT_EQ(unchanged(view, snapshot, without.at(0), "floor"), 1.0);
        }
    }
}

TEST(BakedMirrors, GlassShowsALampAndWhatIsBehindIt) {
    // The floor mirrors nothing, so what is another picture without reflections is the pane; what is blended has no id.
    Room room(0.7f), without(0.7f, false);
    const auto snapshot = room.at(0);
    const View view = before_the_pane();
    expect_alike(snapshot, view, "room with a pane");
    View other = view;
    other.camera = CameraId{static_cast<std::uint32_t>(view.camera) + 500};
    const Alike kept = alike(drawn_by("llvmpipe", snapshot, view), drawn_by("llvmpipe", without.at(0), other));
    std::printf("without reflections: %.2f %% as before\n", 100.0 * kept.share());
    EXPECT_LT(kept.share(), 0.97);
}

TEST(BakedMirrors, ExposureOfTheCameraCounts) {
    Room room;
    const auto snapshot = room.at(0);
    View view = over_the_floor();
    auto spec = std::make_shared<world::CameraSpec>(*view.spec);
    spec->exposure_ev = -1.5;
    view.spec = spec;
    ++view.spec_revision;
    expect_alike(snapshot, view, "darker floor", id_of(snapshot, "floor"));
}

TEST(BakedMirrors, ALampThatIsDimmedIsDimmedInThem) {
    Room room;
    const auto before = room.at(0);
    const View view = over_the_floor();
    for (int i = 0; i < 3; ++i) drawn_by("llvmpipe", before, view);  // what stands still is kept by now
    const auto after = room.at(2 * ns_per_s);
    EXPECT_LT(unchanged(view, before, after, "floor"), 0.5);
    expect_alike(after, view, "dimmed floor", id_of(after, "floor"));
}

TEST(BakedMirrors, AreGoneWithTheirSceneAndBackWithIt) {
    Room room, without(mirror, false);
    const auto with = room.at(0), plain = without.at(0);
    const View view = over_the_floor();
    expect_alike(with, view, "with probes");
    expect_alike(plain, view, "without");
    expect_alike(with, view, "and with them again");
}

}  // namespace
}  // namespace camrig::render

#include "core/truth/view_cone.h"

#include <array>

#include <gtest/gtest.h>

#include "core/truth/posed_object.h"
#include "core/world/world.h"

namespace camrig::truth {
namespace {

struct Camera {
    glm::dvec3 eye, target;
    camera::Lens lens;
    double focal_px;
};

/// Whether any vertex, or middle of an edge, of the object has a place within a pixel of the picture.
bool touches_picture(const PosedObject& object, const camera::CameraModel& camera,
                     const glm::dmat3& optical_from_object, const glm::dvec3& origin) {
    const auto is_near = [&](const glm::dvec3& p) {
        const auto pixel = camera.project(optical_from_object * p + origin);
        return pixel && pixel->x > -1.5 && pixel->y > -1.5 && pixel->x < camera.size().width + 0.5 &&
               pixel->y < camera.size().height + 0.5;
    };
    for (const PosedObject::Part& part : object.parts()) {
        const auto& indices = part.primitive->indices;
        for (std::size_t i = 0; i < indices.size(); ++i) {
            const glm::dvec3 &a = part.points[indices[i]], &b = part.points[indices[(i + 1) % indices.size()]];
            if (is_near(a) || is_near(0.5 * (a + b))) return true;
        }
    }
    return false;
}

TEST(ViewCone, WhatItLeavesOutOfTheShippedScenesShowsNowhere) {
    const std::array<Camera, 4> cameras{{
        {{2.0, 3.0, 4.0}, {14.0, 8.0, 0.0}, {}, 400.0},
        {{9.0, 5.0, 1.6}, {3.0, 5.5, 1.5}, {camera::LensModel::plumb_bob, {-0.28, 0.07, 0.0005, -0.0008}}, 300.0},
        {{6.0, 4.0, 3.0}, {6.5, 4.0, 0.0}, {camera::LensModel::equidistant, {-0.01, 0.002}}, 180.0},
        {{1.0, 9.0, 2.0}, {12.0, 3.0, 1.0}, {}, 3000.0},
    }};
    for (const char* file : {"scenes/hall.json", "scenes/street.json"}) {
        const auto scene = world::load_scene(file);
        ASSERT_TRUE(scene) << scene.error().message;
        const auto world = world::World::create(*scene, (*scene)->seed).value();
        world->advance_to(2 * ns_per_s);
        const world::SnapshotRef snapshot = world->snapshot(2 * ns_per_s);
        int left_out = 0, looked_at = 0;
        PosedObject object;
        for (const Camera& c : cameras) {
            const auto camera =
                camera::CameraModel::create({640, 480}, {c.focal_px, c.focal_px, 319.5, 239.5}, c.lens).value();
            const ViewCone cone(camera);
            const camera::Pose pose = camera::pose_look_at(c.eye, c.target).value();
            const glm::dmat3 optical_from_world = glm::transpose(world_from_optical_rotation(pose));
            for (const auto* instances : {&snapshot->statics->objects, &snapshot->movers}) {
                for (const world::Instance& instance : *instances) {
                    ++looked_at;
                    object.pose(instance);
                    const glm::dmat3 optical_from_object = optical_from_world * glm::mat3_cast(object.orientation());
                    const glm::dvec3 origin = optical_from_world * (object.position() - pose.position);
                    const auto reach = object.reach();
                    if (!reach || cone.may_meet(optical_from_object * reach->center + origin, reach->radius)) continue;
                    ++left_out;
                    object.place_vertices();
                    EXPECT_FALSE(touches_picture(object, camera, optical_from_object, origin))
                        << file << ": " << instance.info->name;
                }
            }
        }
        EXPECT_GT(left_out, looked_at / 4) << file;
    }
}

TEST(ViewCone, TheBallHoldsEveryVertexOfPosedPeople) {
    const auto scene = world::load_scene("scenes/hall.json");
    ASSERT_TRUE(scene) << scene.error().message;
    const auto world = world::World::create(*scene, (*scene)->seed).value();
    world->advance_to(3 * ns_per_s);
    const world::SnapshotRef snapshot = world->snapshot(3 * ns_per_s);
    PosedObject object;
    int vertices = 0;
    for (const world::Instance& mover : snapshot->movers) {
        object.pose(mover);
        const auto reach = object.reach();
        if (!reach) continue;
        object.place_vertices();
        for (const PosedObject::Part& part : object.parts()) {
            for (const std::uint32_t index : part.primitive->indices) {
                ASSERT_LE(glm::distance(part.points[index], reach->center), reach->radius + 1e-4) << mover.info->name;
                ++vertices;
            }
        }
    }
    EXPECT_GT(vertices, 10'000);
}

}  // namespace
}  // namespace camrig::truth

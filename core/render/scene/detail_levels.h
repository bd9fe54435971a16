#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/render/view_transform.h"
#include "core/world/model.h"

namespace camrig::render::scene {

/// Fewer triangles over the same vertices.
struct DetailLevel {
    std::vector<std::uint32_t> indices;
    float error = 0.0f;  ///< how far its surface may be from the full one, in the units of the positions
};

/// Coarser and coarser versions of a skinned triangle mesh, made once when it is loaded; empty for any other, and where
/// nothing is gained. People are where triangles are small and many; rigid surfaces are always drawn as they are, so
/// what is measured on them (depth, markers) is exact. The error is the quadric estimate of meshoptimizer's simplifier,
/// in the bind pose.
std::vector<DetailLevel> make_detail_levels(const world::Primitive& primitive);

/// What errors of a mesh are multiplied with where it is drawn: the skeleton may scale what it carries, so they grow as
/// its bounds do, and with its place in the world.
double detail_error_scale(const world::Box& bind, const world::Box& bounds, const glm::dmat4& world_from_local);

/// Length in pixels that `error` metres have at most, anywhere in a box in front of the camera; infinite where the box
/// reaches behind the image plane.
double detail_error_px(const ViewTransform& view, const glm::dmat4& optical_from_local, const world::Box& box,
                       double error);

}  // namespace camrig::render::scene

#include "core/render/scene/body_capsules.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <glm/gtc/matrix_transform.hpp>

#include "core/render/scene/scene_view.h"
#include "core/world/look.h"

namespace camrig::render::scene {
namespace {

/// Fingers and buttons darken nothing.
constexpr double least_radius_m = 0.02;
constexpr std::size_t least_vertices = 6;

using JointPoints = std::map<int, std::vector<glm::dvec3>>;

/// Each vertex goes to the joint that moves it most.
void add_points(const world::Skin& skin, const world::Primitive& primitive, JointPoints& to) {
    for (std::size_t v = 0; v < primitive.joints.size(); ++v) {
        glm::length_t strongest = 0;
        for (glm::length_t k = 1; k < 4; ++k)
            if (primitive.weights[v][k] > primitive.weights[v][strongest]) strongest = k;
        const std::size_t joint = primitive.joints[v][strongest];
        to[skin.joints[joint]].emplace_back(skin.inverse_bind[joint] * glm::dvec4(primitive.positions[v], 1.0));
    }
}

/// The direction in which points lie farthest apart, by the power method.
glm::dvec3 longest_axis(std::span<const glm::dvec3> points, const glm::dvec3& mean) {
    glm::dmat3 spread(0.0);
    for (const glm::dvec3& point : points) spread += glm::outerProduct(point - mean, point - mean);
    glm::dvec3 axis(spread[0][0], spread[1][1], spread[2][2]);
    for (int i = 0; i < 32; ++i) {
        const glm::dvec3 next = spread * axis;
        const double length = glm::length(next);
        if (!(length > 0.0)) return {0.0, 0.0, 1.0};
        axis = next / length;
    }
    return axis;
}

Capsule capsule_around(std::span<const glm::dvec3> points) {
    glm::dvec3 mean(0.0);
    for (const glm::dvec3& point : points) mean += point / static_cast<double>(points.size());
    const glm::dvec3 axis = longest_axis(points, mean);
    double first = 0.0, last = 0.0, beside2 = 0.0;
    for (const glm::dvec3& point : points) {
        const double along = glm::dot(point - mean, axis);
        first = std::min(first, along);
        last = std::max(last, along);
        beside2 += glm::dot(point - mean, point - mean) - along * along;
    }
    const double radius = std::sqrt(std::max(beside2, 0.0) / static_cast<double>(points.size()));
    const double middle = 0.5 * (first + last), half = std::max(0.5 * (last - first) - radius, 0.0);
    return {mean + axis * (middle - half), mean + axis * (middle + half), radius};
}

double surface_of(const Capsule& capsule) {
    return capsule.radius_m * (glm::distance(capsule.from, capsule.to) + 2.0 * capsule.radius_m);
}

}  // namespace

std::vector<JointCapsule> body_of(const world::Model& model) {
    JointPoints points;
    const world::Look look = world::look_of(model, {});
    for (const int index : model.order) {
        const world::Node& node = model.nodes[static_cast<std::size_t>(index)];
        if (node.mesh < 0 || node.skin < 0) continue;
        for (const world::Primitive& primitive : model.meshes[static_cast<std::size_t>(node.mesh)].primitives) {
            // A bag that is not worn hides nothing.
            if (!look.empty() && primitive.material >= 0 &&
                look[static_cast<std::size_t>(primitive.material)].is_hidden)
                continue;
            add_points(model.skins[static_cast<std::size_t>(node.skin)], primitive, points);
        }
    }
    std::vector<JointCapsule> body;
    for (const auto& [node, of_joint] : points) {
        if (of_joint.size() < least_vertices) continue;
        const JointCapsule made{node, capsule_around(of_joint)};
        if (made.capsule.radius_m >= least_radius_m) body.push_back(made);
    }
    std::ranges::stable_sort(body, std::greater{}, [](const JointCapsule& of) { return surface_of(of.capsule); });
    if (body.size() > max_capsules_per_body) body.resize(max_capsules_per_body);
    return body;
}

void PlacedBodies::clear() {
    bodies_.clear();
    capsules_.clear();
}

void PlacedBodies::add(ObjectId object, std::span<const JointCapsule> body, const world::PosedModel& pose,
                       const glm::dmat4& world_from_model) {
    if (body.empty()) return;
    Body& made = bodies_.emplace_back();
    made.object = object;
    made.first = capsules_.size();
    made.count = body.size();
    for (const JointCapsule& part : body) {
        const glm::dmat4 world = world_from_model * pose.model_from_node[static_cast<std::size_t>(part.node)];
        const Capsule placed{glm::dvec3(world * glm::dvec4(part.capsule.from, 1.0)),
                             glm::dvec3(world * glm::dvec4(part.capsule.to, 1.0)),
                             part.capsule.radius_m * std::cbrt(std::abs(glm::determinant(glm::dmat3(world))))};
        const double reach = placed.radius_m + contact_reach_m;
        const glm::dvec3 min = glm::min(placed.from, placed.to) - reach, max = glm::max(placed.from, placed.to) + reach;
        const bool is_first = capsules_.size() == made.first;
        made.min = is_first ? min : glm::min(made.min, min);
        made.max = is_first ? max : glm::max(made.max, max);
        capsules_.push_back(placed);
    }
}

void BodiesInView::clear() {
    bodies.clear();
    capsules.clear();
    moving_rects.clear();
}

void BodiesInView::see(const SceneView& view, const PlacedBodies& statics, const PlacedBodies& movers) {
    clear();
    for (const PlacedBodies* const placed : {&statics, &movers}) {
        for (const PlacedBodies::Body& body : placed->bodies()) {
            const glm::dvec3 middle = 0.5 * (body.min + body.max), half = 0.5 * (body.max - body.min);
            const world::Box box{glm::vec3(-half), glm::vec3(half)};
            const glm::dmat4 optical_from_box = view.transform.optical_from(glm::translate(glm::dmat4(1.0), middle));
            if (!view.may_see(optical_from_box, box)) continue;
            const auto pixels = view.pixels_of(optical_from_box, box);
            if (!pixels) continue;
            if (placed == &movers) moving_rects.push_back(*pixels);
            BodyInView& made = bodies.emplace_back();
            made.middle = glm::vec3(glm::dvec3(optical_from_box[3]));
            made.radius2 = static_cast<float>(glm::dot(half, half));
            made.object = body.object;
            made.first = static_cast<std::uint32_t>(capsules.size());
            made.count = static_cast<std::uint32_t>(body.count);
            made.is_moving = placed == &movers ? 1 : 0;
            for (const Capsule& capsule : placed->capsules().subspan(body.first, body.count)) {
                const glm::dmat3& turn = view.transform.optical_from_world;
                const glm::dvec3 along = turn * (capsule.to - capsule.from);
                capsules.push_back({glm::vec3(turn * (capsule.from - view.transform.eye)),
                                    static_cast<float>(capsule.radius_m), glm::vec3(along),
                                    static_cast<float>(glm::length(along))});
            }
        }
    }
}

}  // namespace camrig::render::scene

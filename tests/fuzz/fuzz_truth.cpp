// Full boxes of a small fixed scene through any lens, from any place: bounded work, and what is sampled of an edge lies
// in the box. An input is up to 22 numbers of three bytes: a 16-bit mantissa and a decimal exponent.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include <glm/gtc/quaternion.hpp>

#include "core/truth/projected_box.h"

namespace {

using namespace camrig;

class Numbers {
public:
    explicit Numbers(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
    /// Any sign, up to 10^most.
    double next(int most) {
        if (bytes_.size() < 3) return 0.0;
        const auto mantissa = static_cast<std::int16_t>(bytes_[0] | bytes_[1] << 8);
        const int exponent = most - bytes_[2] % 16;
        bytes_ = bytes_.subspan(3);
        return mantissa / 32768.0 * std::pow(10.0, exponent);
    }

private:
    std::span<const std::uint8_t> bytes_;
};

/// A room of 8 x 6 x 3 m with a diagonal line through it.
const std::vector<glm::dvec3>& room() {
    static const std::vector<glm::dvec3> points{{-4, -3, 0}, {4, -3, 0}, {4, 3, 0}, {-4, 3, 0},
                                                {-4, -3, 3}, {4, -3, 3}, {4, 3, 3}, {-4, 3, 3}};
    return points;
}
world::Primitive walls() {
    world::Primitive p;
    p.indices = {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                 1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7};
    return p;
}
world::Primitive diagonal() {
    world::Primitive p;
    p.topology = world::Topology::lines;
    p.indices = {0, 6};
    return p;
}

void require(bool holds) {
    if (!holds) std::abort();
}

/// Points of the edges, where neither the end of the field nor rounding leaves room for doubt.
void check_edges(const camera::CameraModel& camera, std::span<const glm::dvec3> points,
                 const world::Primitive& primitive, double near_m, double far_m, const truth::ProjectedBox& box) {
    const camera::LensMap& lens = camera.lens();
    const bool has_planes = lens.lens().model != camera::LensModel::equidistant;
    if (std::ranges::any_of(lens.lens().coefficients, [](double k) { return std::abs(k) > 100.0; })) return;
    const double radius = std::min(lens.valid_radius() * (1.0 - 1e-6), has_planes ? 1e5 : 3.1415);
    // Neighbours in the list: of walls() every other pair of corners of one wall.
    for (std::size_t i = 0; i + 1 < primitive.indices.size(); ++i) {
        for (int step = 0; step <= 8; ++step) {
            const glm::dvec3 p = glm::mix(points[primitive.indices[i]], points[primitive.indices[i + 1]], step / 8.0);
            if (has_planes && (p.z < near_m * (1 + 1e-9) || (far_m > 0 && p.z > far_m * (1 - 1e-9)))) continue;
            const auto ideal = lens.ideal_from_direction(p);
            if (!ideal || glm::length(*ideal) > radius) continue;
            const auto pixel = camera.project(p);
            if (!pixel) continue;
            const glm::dvec2 slack = glm::max(glm::dvec2(1.01 * truth::BoxProjector::tolerance_px),
                                              1.01 * truth::BoxProjector::tolerance_share * (box.max - box.min)) +
                                     1e-7 * glm::abs(*pixel);
            require(glm::all(glm::greaterThanEqual(*pixel, box.min - slack)) &&
                    glm::all(glm::lessThanEqual(*pixel, box.max + slack)));
        }
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size < 1) return 0;
    camera::Lens lens{static_cast<camera::LensModel>(data[0] % 4), {}};
    Numbers numbers({data + 1, size - 1});
    for (int i = 0; i < coefficient_count(lens.model); ++i)
        lens.coefficients[static_cast<std::size_t>(i)] = numbers.next(9);
    const camera::Intrinsics k{std::abs(numbers.next(7)), std::abs(numbers.next(7)), numbers.next(4), numbers.next(4)};
    const auto camera = camera::CameraModel::create({64, 48}, k, lens);
    if (!camera) return 0;
    const double near_m = std::max(1e-4, std::abs(numbers.next(1))), far_m = std::abs(numbers.next(7));
    const glm::dvec3 eye{numbers.next(8), numbers.next(8), numbers.next(8)};
    glm::dquat turn{1.0 + numbers.next(0), numbers.next(0), numbers.next(0), numbers.next(0)};
    if (!(glm::length(turn) > 1e-3)) return 0;
    turn = glm::normalize(turn);

    std::vector<glm::dvec3> points;
    for (const glm::dvec3& p : room()) points.push_back(turn * (p - eye));
    truth::BoxProjector projector(*camera, near_m, far_m > near_m ? far_m : 0.0);
    for (const world::Primitive& primitive : {walls(), diagonal()}) {
        truth::ProjectedBox box;
        const auto added = projector.add(points, primitive, box);
        require(projector.halvings() <= truth::BoxProjector::max_halvings);
        require(added || projector.halvings() == truth::BoxProjector::max_halvings);
        require(!std::isnan(box.min.x) && !std::isnan(box.min.y) && !std::isnan(box.max.x) && !std::isnan(box.max.y));
        if (added) check_edges(*camera, points, primitive, near_m, far_m > near_m ? far_m : 0.0, box);
    }
    return 0;
}

#pragma once

#include <array>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/camera/camera_model.h"
#include "core/world/backdrop/backdrop.h"

namespace camrig::world {

inline Error refused(std::string message) {
    return {ErrorKind::invalid_argument, std::move(message)};
}
/// The error of a part, whose message goes on where the path of the whole ends: ".z: ..." or ": ...".
inline std::unexpected<Error> under(std::string_view place, Error inner) {
    inner.message.insert(0, place);
    return std::unexpected(std::move(inner));
}

/// Makes models of the shapes that a backdrop has of its own, about the eye of the camera that took its picture:
/// what is given in pixels is carried into the world through that camera's lens. Messages of errors go on where the
/// path of the shape ends: ".z: ..." or ": ...".
class ProxyMaker {
public:
    ProxyMaker(const CameraSpec& spec, const camera::CameraModel& camera)
        : spec_(spec), camera_(camera), world_from_optical_(world_from_optical_rotation(spec.pose)) {}

    /// From the eye.
    Result<std::vector<glm::dvec3>> corners_of(const LevelGround& ground) const;
    Result<void> add(const GroundProxy& ground);
    Result<void> add(const BoxProxy& box);
    Result<void> add(const CutoutProxy& cutout, std::span<const PixelRect> mask);
    Result<void> add(const DepthProxy& depth, std::span<const DepthPiece> pieces);
    /// All that hide, of which holdouts have no light to lose; null: none.
    ModelRef hiding() { return model_of({ProxyRole::both, ProxyRole::holdout}); }
    /// All that catch shadows only; null: none.
    ModelRef catching() { return model_of({ProxyRole::catcher}); }
    std::vector<glm::dvec2> in_camera(std::vector<glm::dvec2> pixels) const {
        for (glm::dvec2& pixel : pixels) pixel = in_camera(pixel);
        return pixels;
    }

private:
    const glm::dvec3& eye() const { return spec_.pose.position; }
    glm::dvec2 in_camera(const glm::dvec2& pixel) const {
        const ImageSize from = spec_.backdrop->files->size(), to = spec_.size;
        return (pixel + 0.5) * glm::dvec2(to.width, to.height) / glm::dvec2(from.width, from.height) - 0.5;
    }
    /// From the eye, of a pixel of the picture.
    std::optional<glm::dvec3> direction(const glm::dvec2& pixel) const {
        const auto ray = camera_.ray(in_camera(pixel));
        return ray ? std::optional(world_from_optical_ * *ray) : std::nullopt;
    }
    /// Where the ground of that height shows in a pixel, from the eye.
    Result<glm::dvec3> on_ground(const glm::dvec2& pixel, double z) const;
    std::vector<glm::dvec2> with_short_sides(const std::vector<glm::dvec2>& polygon) const;
    bool is_ahead(const std::vector<glm::dvec3>& corners) const;
    Primitive& primitive() { return primitives_[static_cast<std::size_t>(role_)]; }
    ModelRef model_of(std::initializer_list<ProxyRole> roles);
    void begin(const glm::dvec3& normal);
    void corner(const glm::dvec3& place);
    template <typename Triangles>
    void close(const Triangles& triangles) {
        for (const auto& triangle : triangles)
            for (const std::uint32_t index : triangle) primitive().indices.push_back(first_ + index);
    }

    const CameraSpec& spec_;
    const camera::CameraModel& camera_;
    glm::dmat3 world_from_optical_;
    std::array<Primitive, 3> primitives_;  ///< by role
    ProxyRole role_ = ProxyRole::both;     ///< of the shape in work
    glm::vec3 normal_{0.0f};
    std::uint32_t first_ = 0;
};

}  // namespace camrig::world

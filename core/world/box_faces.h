#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <glm/glm.hpp>

namespace camrig::world {

/// A face of the box from -1 to 1 on each axis: what is drawn and what hides is made of the same six.
struct BoxFace {
    glm::dvec3 normal;                  ///< outwards
    std::array<glm::dvec3, 4> corners;  ///< counter-clockwise as seen from outside
};

/// Of one face's corners.
inline constexpr std::array<glm::dvec2, 4> box_face_sides{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
inline constexpr std::array<std::array<std::uint32_t, 3>, 2> box_face_triangles{{{0, 1, 2}, {0, 2, 3}}};

inline std::array<BoxFace, 6> box_faces() {
    std::array<BoxFace, 6> faces{};
    for (std::size_t i = 0; i < faces.size(); ++i) {
        const int axis = static_cast<int>(i / 2);
        const double sign = i % 2 == 0 ? -1.0 : 1.0;
        glm::dvec3 out(0.0), right(0.0), up(0.0);
        out[axis] = sign;
        right[(axis + 1) % 3] = sign;
        up[(axis + 2) % 3] = 1.0;
        faces[i].normal = out;
        for (std::size_t c = 0; c < box_face_sides.size(); ++c)
            faces[i].corners[c] = out + box_face_sides[c].x * right + box_face_sides[c].y * up;
    }
    return faces;
}

}  // namespace camrig::world

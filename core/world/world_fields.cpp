#include "core/world/world_fields.h"

#include <array>
#include <cmath>

#include "core/camera/pose.h"
#include "core/world/turn.h"

namespace camrig::world {

std::string item_path(std::string_view list, std::size_t index) {
    return std::string(list) + "[" + std::to_string(index) + "]";
}

bool is_scene_name(std::string_view name) {
    bool good = !name.empty() && name.size() <= max_scene_name_bytes;
    for (const char c : name) good = good && static_cast<unsigned char>(c) >= 0x20 && c != 0x7f;
    return good;
}

void read_name(JsonReader& reader, std::string_view key, std::string& out) {
    reader.required(key, out);
    if (reader.ok(key) && !is_scene_name(out)) reader.fail(key, "expected 1 to 64 printable characters");
}

void read_color(JsonReader& reader, std::string_view key, glm::vec3& out) {
    std::array<double, 3> rgb{};
    reader.required(key, std::span<double>(rgb));
    for (const double part : rgb)
        if (reader.ok(key) && (part < 0.0 || part > 1e4)) reader.fail(key, "expected linear [r, g, b] from 0");
    out = {rgb[0], rgb[1], rgb[2]};
}

void read_vector(JsonReader& reader, std::string_view key, glm::dvec3& out) {
    std::array<double, 3> v{};
    reader.required(key, std::span<double>(v));
    for (const double part : v) {
        if (reader.ok(key) && std::abs(part) > camera::max_coordinate_m)
            reader.fail(key, "expected coordinates within 1e10 m of the origin");
    }
    out = {v[0], v[1], v[2]};
}

bool read_orientation(JsonReader& reader, glm::dquat& out) {
    const bool quaternion = reader.has("orientation"), yaw = reader.has("yaw_deg");
    if (quaternion && yaw) reader.fail("yaw_deg", "give only one of yaw_deg and orientation");
    double yaw_deg = 0.0;
    reader.optional("yaw_deg", yaw_deg);
    if (yaw) out = turned_to(glm::radians(yaw_deg));
    if (quaternion) {
        std::array<double, 4> q{};
        reader.required("orientation", std::span<double>(q));
        auto pose = camera::pose_from_quaternion(glm::dvec3(0.0), glm::dquat(q[3], q[0], q[1], q[2]));
        if (pose)
            out = pose->orientation;
        else
            reader.fail_inside(pose.error());
    }
    return quaternion || yaw;
}

}  // namespace camrig::world

#include "moves.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace dummy {

using camrig::client::CameraOptions;
using camrig::client::CameraState;

namespace {

constexpr double step_m = 0.5;
constexpr double turn_deg = 5;
constexpr double zoom_factor = 1.1;
constexpr double radians = 3.14159265358979323846 / 180;

/// Along the ground as the camera looks, to its left, and up.
void go(const CameraState& now, CameraOptions& change, double ahead_m, double left_m, double up_m) {
    const double pan = now.pose.pan_deg * radians;
    auto position = now.pose.position;
    position[0] += ahead_m * std::cos(pan) - left_m * std::sin(pan);
    position[1] += ahead_m * std::sin(pan) + left_m * std::cos(pan);
    position[2] += up_m;
    change.position = position;
    change.orientation = now.pose.orientation;
}

void turn(const CameraState& now, CameraOptions& change, double pan_deg, double tilt_deg) {
    change.position = now.pose.position;
    change.pan_deg = now.pose.pan_deg + pan_deg;
    change.tilt_deg = std::clamp(now.pose.tilt_deg + tilt_deg, -90.0, 90.0);
    change.roll_deg = now.pose.roll_deg;
}

void widen(const CameraState& now, CameraOptions& change, double factor) {
    change.vfov_deg = std::clamp(now.vfov_deg * factor, 5.0, 120.0);
}

}  // namespace

const std::vector<Move>& moves() {
    static const std::vector<Move> all{
        {'w', "ahead", [](const CameraState& now, CameraOptions& change) { go(now, change, step_m, 0, 0); }},
        {'s', "back", [](const CameraState& now, CameraOptions& change) { go(now, change, -step_m, 0, 0); }},
        {'a', "left", [](const CameraState& now, CameraOptions& change) { go(now, change, 0, step_m, 0); }},
        {'d', "right", [](const CameraState& now, CameraOptions& change) { go(now, change, 0, -step_m, 0); }},
        {'r', "up", [](const CameraState& now, CameraOptions& change) { go(now, change, 0, 0, step_m); }},
        {'f', "down", [](const CameraState& now, CameraOptions& change) { go(now, change, 0, 0, -step_m); }},
        {'j', "turn left", [](const CameraState& now, CameraOptions& change) { turn(now, change, turn_deg, 0); }},
        {'l', "turn right", [](const CameraState& now, CameraOptions& change) { turn(now, change, -turn_deg, 0); }},
        {'i', "look up", [](const CameraState& now, CameraOptions& change) { turn(now, change, 0, turn_deg); }},
        {'k', "look down", [](const CameraState& now, CameraOptions& change) { turn(now, change, 0, -turn_deg); }},
        {'+', "closer", [](const CameraState& now, CameraOptions& change) { widen(now, change, 1 / zoom_factor); }},
        {'-', "wider", [](const CameraState& now, CameraOptions& change) { widen(now, change, zoom_factor); }},
    };
    return all;
}

bool do_move(const camrig::client::Camera& camera, char key) {
    const auto found = std::find_if(moves().begin(), moves().end(), [&](const Move& move) { return move.key == key; });
    if (found == moves().end()) return false;
    CameraOptions change;
    found->apply(camera.get(), change);
    camera.set(change);
    return true;
}

std::string describe(const CameraState& state) {
    const auto& pose = state.pose;
    char text[200];
    std::snprintf(text, sizeof text, "position %.2f %.2f %.2f m, pan %.1f tilt %.1f deg, field of view %.1f deg",
                  pose.position[0], pose.position[1], pose.position[2], pose.pan_deg, pose.tilt_deg, state.vfov_deg);
    return text;
}

}  // namespace dummy

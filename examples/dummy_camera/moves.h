#pragma once

#include <string>
#include <vector>

#include <camrig/client.h>

namespace dummy {

/// One way to change a camera: a key of the menu and the window, a button, and what it does.
struct Move {
    char key;
    std::string label;
    void (*apply)(const camrig::client::CameraState& now, camrig::client::CameraOptions& change);
};

/// All of them, in the order of the buttons.
const std::vector<Move>& moves();

/// Does the move with this key; false when there is none. Throws camrig::client::Error.
bool do_move(const camrig::client::Camera& camera, char key);

/// "position 2.00 3.00 2.80 m, pan 31.0 tilt -8.8 deg, field of view 60.0 deg"
std::string describe(const camrig::client::CameraState& state);

}  // namespace dummy

// Places a camera by buttons and keys:
//     dummy_camera NAME              console menu
//     dummy_camera NAME --window     a window with the live picture and buttons
// Takes the camera NAME of the rig at $CAMRIG_CONTROL; makes it when there is none, and deletes it at the end then.
#include <cstring>
#include <iostream>

#include "menu.h"
#include "window.h"

namespace {

/// The camera, and whether it is ours to delete.
std::pair<camrig::client::Camera, bool> find_or_make(const camrig::client::Rig& rig, const std::string& name) {
    try {
        return {rig.camera(name), false};
    } catch (const camrig::client::Error& why) {
        if (why.kind() != "not_found") throw;
    }
    camrig::client::CameraOptions options;
    options.size = {640, 480};
    options.position = {0, 0, 1.7};
    return {rig.create_camera(name, options), true};
}

}  // namespace

int main(int argc, char** argv) {
    const bool in_window = argc == 3 && std::strcmp(argv[2], "--window") == 0;
    if (argc != 2 && !in_window) {
        std::cerr << "usage: dummy_camera NAME [--window]\n";
        return 2;
    }
    try {
        const auto rig = camrig::client::connect();
        const auto [camera, is_ours] = find_or_make(rig, argv[1]);
        try {
            in_window ? dummy::run_window(camera) : dummy::run_menu(rig, camera, std::cin, std::cout);
        } catch (const std::exception&) {
            if (is_ours) camera.remove();
            throw;
        }
        if (is_ours) camera.remove();
        return 0;
    } catch (const std::exception& problem) {
        std::cerr << "dummy_camera: " << problem.what() << "\n";
        return 1;
    }
}

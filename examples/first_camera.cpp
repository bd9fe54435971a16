// A camera in a running rig, from C++:
//     first_camera [PICTURE.png]        the rig is found as the command line finds it: $CAMRIG_CONTROL, ...
#include <iostream>
#include <stdexcept>
#include <string>

#include <camrig/client.h>
#include <camrig/opencv.h>
#include <opencv2/imgcodecs.hpp>

int main(int argc, char** argv) try {
    const auto rig = camrig::client::connect();

    camrig::client::CameraOptions options;
    options.size = {640, 480};
    options.fps = 25;
    options.vfov_deg = 60;
    options.position = {2, 3, 2.8};
    options.look_at = {12, 9, 1};
    const auto camera = rig.create_camera("first", options);

    const auto frame = camera.frame();
    const auto objects = camera.truth()["objects"];
    camera.remove();

    const cv::Mat picture = to_mat(frame);  // BGR
    const std::string file = argc > 1 ? argv[1] : "first.png";
    if (!cv::imwrite(file, picture)) throw std::runtime_error("cannot write " + file);
    std::cout << "frame " << frame.sequence << " shows " << frame.time_ns / 1e9 << " s, " << picture.cols << "x"
              << picture.rows << ", " << objects.size() << " objects\n";
    return 0;
} catch (const std::exception& problem) {
    std::cerr << "first_camera: " << problem.what() << "\n";
    return 1;
}

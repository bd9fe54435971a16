// A camera in a running rig, from C++:
//     first_camera [PICTURE.png]        the rig is found as the command line finds it: $CAMRIG_CONTROL, ...
#include <iostream>

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
    const cv::Mat picture = to_mat(frame);  // BGR
    cv::imwrite(argc > 1 ? argv[1] : "first.png", picture);
    std::cout << "frame " << frame.sequence << " shows " << frame.time_ns / 1e9 << " s, " << picture.cols << "x"
              << picture.rows << ", " << camera.truth()["objects"].size() << " objects\n";
    camera.remove();
    return 0;
} catch (const std::exception& problem) {
    std::cerr << "first_camera: " << problem.what() << "\n";
    return 1;
}

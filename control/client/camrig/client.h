#pragma once

/// The C++ client of camrig:
///
///     auto rig = camrig::client::connect();
///     auto cam = rig.create_camera("lobby", options);
///     auto frame = cam.frame();
///
/// C++17. All of it is here but pictures as cv::Mat, which are in <camrig/opencv.h>.
#include <camrig/rig.h>

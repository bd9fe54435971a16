#pragma once

namespace camrig::camera {

/// Written by ROS camera_calibration (image_pipeline).
inline constexpr const char* ros_sample = R"(image_width: 640
image_height: 480
camera_name: head_camera
camera_matrix:
  rows: 3
  cols: 3
  data: [438.783367, 0.000000, 305.593336, 0.000000, 437.302876, 243.738352, 0.000000, 0.000000, 1.000000]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.361976, 0.110510, 0.001014, 0.000505, 0.000000]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
projection_matrix:
  rows: 3
  cols: 4
  data: [393.653800, 0.000000, 305.500500, 0.000000, 0.000000, 393.653800, 243.738352, 0.0, 0.0, 0.0, 1.0, 0.0]
)";

/// Written by cv2.FileStorage (OpenCV 4).
inline constexpr const char* opencv_yaml_sample = R"(%YAML:1.0
---
image_width: 1920
image_height: 1080
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 1050.25, 0., 961.29999999999995, 0., 1048.5,
       537.79999999999995, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ -0.28000000000000003, 0.080000000000000002,
       0.00080000000000000004, -0.00050000000000000001,
       -0.0050000000000000001 ]
avg_reprojection_error: 0.20999999999999999
)";

inline constexpr const char* opencv_json_sample = R"({
    "image_width": 1920,
    "image_height": 1080,
    "camera_matrix": {
        "type_id": "opencv-matrix",
        "rows": 3,
        "cols": 3,
        "dt": "d",
        "data": [ 1050.25, 0.0, 961.29999999999995, 0.0, 1048.5,
            537.79999999999995, 0.0, 0.0, 1.0 ]
    },
    "distortion_coefficients": {
        "type_id": "opencv-matrix",
        "rows": 5,
        "cols": 1,
        "dt": "d",
        "data": [ -0.28000000000000003, 0.080000000000000002,
            0.00080000000000000004, -0.00050000000000000001,
            -0.0050000000000000001 ]
    },
    "avg_reprojection_error": 0.20999999999999999
}
)";

/// As Kalibr's calibrate_cameras writes a stereo rig, one camera of each lens it shares with us.
inline constexpr const char* kalibr_sample = R"(cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.2831, 0.0739, 0.00019, 1.76e-05]
  distortion_model: radtan
  intrinsics: [458.654, 457.296, 367.215, 248.375]
  resolution: [752, 480]
  rostopic: /cam0/image_raw
cam1:
  T_cn_cnm1:
  - [0.9999, 0.0023, 0.0001, -0.1100]
  - [-0.0023, 0.9998, 0.0141, 0.0004]
  - [-0.0001, -0.0141, 0.9999, -0.0008]
  - [0.0, 0.0, 0.0, 1.0]
  cam_overlaps: [0]
  camera_model: pinhole
  distortion_coeffs: [0.0034, 0.0007, -0.0020, 0.0002]
  distortion_model: equidistant
  intrinsics: [190.97847715128717, 190.9733070521226, 254.93170605935475, 256.8974428996504]
  resolution: [512, 512]
  rostopic: /cam1/image_raw
)";

}  // namespace camrig::camera

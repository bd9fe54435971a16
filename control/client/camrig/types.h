#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/// The values that a camera is made of. Units are SI; degrees where a name ends in _deg. The world is right-handed, z
/// up, in metres; a camera's body frame has x forward, y left, z up. The rig checks all values, not this library.
namespace camrig::client {

using Vector3 = std::array<double, 3>;

/// In pixels.
struct Size {
    int width = 0;
    int height = 0;
    friend bool operator==(Size a, Size b) { return a.width == b.width && a.height == b.height; }
    friend bool operator!=(Size a, Size b) { return !(a == b); }
};

/// Frames per second as an exact fraction. A number is taken as the decimal it is written as: 29.97 is 2997/100.
struct Rate {
    std::int64_t num = 25;
    std::int64_t den = 1;

    Rate() = default;
    Rate(std::int64_t numerator, std::int64_t denominator) : num(numerator), den(denominator) {}
    Rate(int hertz) : num(hertz) {}
    /// Error invalid_argument unless 1/10 to 1000.
    Rate(double hertz);
    double hertz() const { return static_cast<double>(num) / static_cast<double>(den); }
    friend bool operator==(Rate a, Rate b) { return a.num == b.num && a.den == b.den; }
    friend bool operator!=(Rate a, Rate b) { return !(a == b); }
};

/// The pinhole camera in pixels. Pixel centres are at integer coordinates (OpenCV): cx = (width - 1) / 2 is the middle.
struct Intrinsics {
    double fx = 0;
    double fy = 0;
    double cx = 0;
    double cy = 0;
};

/// Models and coefficients as in OpenCV and ROS: pinhole (none), plumb_bob (k1 k2 p1 p2 k3), rational_polynomial
/// (k1 k2 p1 p2 k3 k4 k5 k6), equidistant (k1 k2 k3 k4).
struct Lens {
    std::string model = "pinhole";
    std::vector<double> coefficients = {};
    std::string method = "auto";  ///< what the picture is resampled from: warp, cube or auto
    std::string filter = "auto";  ///< bilinear, bicubic or auto
    int oversample = 1;           ///< 1 to 4: source pixels per pixel along a side
};

/// Where a camera is and how it is turned; orientation is the quaternion x, y, z, w of the body frame, and says the
/// same as the angles: pan about world z, counter-clockwise from above, 0 along +x; tilt up; roll clockwise seen from
/// behind.
struct Pose {
    Vector3 position = {0, 0, 0};
    std::array<double, 4> orientation = {0, 0, 0, 1};
    double pan_deg = 0;
    double tilt_deg = 0;
    double roll_deg = 0;
};

/// An actor that a camera is fixed to, and optionally a node of its model. An empty actor takes the camera off.
struct Mount {
    std::string actor = {};
    std::string node = {};
};

/// What the camera's electronics do to the finished picture. What is not given stays.
struct Controls {
    std::optional<bool> auto_exposure = {};
    std::optional<double> exposure_ev = {};  ///< -6 to 6
    std::optional<double> gain_db = {};      ///< 0 to 24
    std::optional<bool> auto_white_balance = {};
    std::optional<double> white_balance_k = {};  ///< 2800 to 10000
    std::optional<double> brightness = {};       ///< -1 to 1
    std::optional<double> contrast = {};         ///< 0 to 2
    std::optional<double> saturation = {};       ///< 0 to 2
};

/// Where pictures go beside HTTP, which every camera has. Members that a kind does not know must be left out.
struct Output {
    std::string kind = {};                        ///< v4l2, device, rtsp or mjpeg
    std::optional<int> number = {};               ///< v4l2 and device: N of /dev/videoN
    std::optional<std::string> format = {};       ///< v4l2: YUYV, YU12, MJPG or BGR3
    std::optional<std::string> subsampling = {};  ///< device, and v4l2 with format MJPG: 4:2:2 or 4:2:0
    std::optional<std::string> codec = {};        ///< rtsp: h264 or mjpeg
    std::optional<int> quality = {};              ///< mjpeg: 1 to 100
    std::optional<int> bitrate_kbps = {};         ///< rtsp h264
    std::optional<double> key_interval_s = {};    ///< rtsp h264
    std::optional<std::string> preset = {};       ///< rtsp h264
    std::optional<std::string> profile = {};      ///< rtsp h264
};

/// What a camera can be given. What is left out has the rig's default in create_camera and stays as it is in
/// Camera::set.
struct CameraOptions {
    std::optional<std::string> place = {};  ///< create_camera only: a place of the scene; gives pose and field of view
    std::optional<Size> size = {};          ///< 16x16 to 8192x8192
    std::optional<Rate> fps = {};           ///< 1/10 to 1000
    std::optional<double> vfov_deg = {};    ///< at most one of vfov_deg, hfov_deg and intrinsics
    std::optional<double> hfov_deg = {};
    std::optional<Intrinsics> intrinsics = {};
    std::optional<double> zoom = {};  ///< 1 to 10
    std::optional<Vector3> position = {};
    std::optional<Vector3> look_at = {};  ///< at most one of look_at, the three angles and orientation
    std::optional<double> pan_deg = {};
    std::optional<double> tilt_deg = {};
    std::optional<double> roll_deg = {};
    std::optional<std::array<double, 4>> orientation = {};
    std::optional<Mount> mount = {};  ///< the pose is then in the frame of the mount
    std::optional<Lens> lens = {};
    std::optional<std::string> antialias = {};  ///< auto, none, msaa4, ssaa2, ssaa3 or ssaa4
    std::optional<double> near = {};            ///< m
    std::optional<double> far = {};             ///< m; 0: no limit
    std::optional<std::string> quality = {};    ///< fast, simple or beautiful; empty: the rig's
    std::optional<Controls> controls = {};
    std::optional<bool> code_strip = {};
    std::optional<std::vector<Output>> outputs = {};  ///< all of them: replaces those that are there
};

/// Everything about a camera at one time.
struct CameraState {
    std::string name = {};
    Size size = {};
    Rate fps = {};
    double vfov_deg = 0;
    double hfov_deg = 0;
    Intrinsics intrinsics = {};  ///< as they follow from field of view and zoom
    double zoom = 1;
    Pose pose = {};  ///< in the frame of its mount, if it has one
    std::optional<Mount> mount = {};
    Pose world_pose = {};  ///< of a mounted camera, at its latest due frame
    Lens lens = {};
    std::string antialias = {};
    double near = 0;           ///< m
    double far = 0;            ///< m; 0: no limit
    std::string quality = {};  ///< empty: the rig's
    Controls controls = {};
    bool code_strip = false;
    std::vector<Output> outputs = {};
    std::int64_t id = 0;          ///< one life of a camera; never used again
    std::int64_t sequence = 0;    ///< number of its latest due frame
    int readers = 0;              ///< how many watch it now
    std::int64_t applied_ns = 0;  ///< world time from which this state shows

    /// Makes the same camera again, without its outputs: a device number can be had once.
    CameraOptions options() const;
};

/// What the world is doing. Times are ns since the scene was loaded.
struct WorldStatus {
    std::string scene = {};
    std::string scene_file = {};
    std::string mode = {};      ///< realtime or lockstep
    std::string overload = {};  ///< drop or slow
    std::string quality = {};
    bool paused = false;
    std::int64_t world_ns = 0;
    std::int64_t step_ns = 0;  ///< the world's own step
    std::uint64_t seed = 0;
    std::int64_t state_ns = 0;
    std::string state_hash = {};
    int objects = 0;
    int actors = 0;
    int cameras = 0;
    std::vector<std::string> places = {};
    std::int64_t applied_ns = 0;
};

}  // namespace camrig::client

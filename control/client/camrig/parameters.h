#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <camrig/values.h>
#include <nlohmann/json.hpp>

// Made from the rig's own tables by: camrig methods --write . -- changes here are lost.
// clang-format off

/// What a camera is made of, and what the world and the things in it do. Units are SI; degrees where a name ends in
/// _deg. The world is right-handed, z up, in metres; a camera's body frame has x forward, y left, z up. The rig checks
/// all values, not this library. each_member calls visit("name", member). Null is asked for by an inner optional that
/// is empty: options.mount.emplace(). What comes in kinds with keys of their own (behaviours, triggers, actions, params
/// of faults) is JSON.
namespace camrig::client {

/// Of a camera: intrinsics.
struct Intrinsics {
    double fx = 0;  ///< px; over 0: focal length
    double fy = 0;  ///< px; over 0: focal length
    double cx = 0;  ///< px; -1e6 to 1e6: principal point
    double cy = 0;  ///< px; -1e6 to 1e6: principal point

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("fx", self.fx);
        visit("fy", self.fy);
        visit("cx", self.cx);
        visit("cy", self.cy);
    }
};

/// Of a camera: pose.
struct Pose {
    Vector3 position = {};  ///< m; where it is
    double pan_deg = 0;  ///< deg; about world z, counter-clockwise from above; 0 looks along +x
    double tilt_deg = 0;  ///< deg; positive looks up
    double roll_deg = 0;  ///< deg; about the viewing direction, clockwise seen from behind the camera
    Quaternion orientation = {0, 0, 0, 1};  ///< quaternion of the body frame: x forward, y left, z up

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("position", self.position);
        visit("pan_deg", self.pan_deg);
        visit("tilt_deg", self.tilt_deg);
        visit("roll_deg", self.roll_deg);
        visit("orientation", self.orientation);
    }
};

/// Of a camera: mount.
struct Mount {
    std::string actor = {};  ///< its name
    std::string node = {};  ///< a node of its model: the frame is at the node and turns as the node does in its clips; at rest, one without a turn of its own has the axes of the actor. Empty: the actor's own frame, at its origin

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("actor", self.actor);
        visit("node", self.node);
    }
};

/// Of a camera: ptz.
struct Ptz {
    std::optional<std::string> preset = {};  ///< `ideal`, `dome` or `cheap`: figures of a kind of head; what is given beside it counts
    std::optional<std::vector<double>> pan_limits_deg = {};  ///< deg; [low, high] from `pose`, positive to the left; null: it turns without end, here empty
    std::optional<std::vector<double>> tilt_limits_deg = {};  ///< deg; [low, high] from `pose`, positive upwards
    std::optional<double> zoom_max = {};  ///< 1 to 100: focal length at the long end, of that at the wide end
    std::optional<double> speed_deg_s = {};  ///< deg/s; 0.01 to 10000: of pan and of tilt, at most
    std::optional<double> acceleration_deg_s2 = {};  ///< deg/s2; 0.01 to 1e6: of both
    std::optional<double> zoom_s = {};  ///< s; 0.01 to 60: from one end of the zoom to the other
    std::optional<double> latency_s = {};  ///< s; 0 to 10: from a command to the begin of its motion
    std::optional<double> stop_latency_s = {};  ///< s; 0 to 10: from a stop to the begin of braking
    std::optional<double> quantum_deg = {};  ///< deg; 0 to 10: of the angles that it tells
    std::optional<double> repeatability_deg = {};  ///< deg; 0 to 10: it stops at most so far from where it believes to be
    std::optional<double> backlash_deg = {};  ///< deg; 0 to 10: play of its gears: where it stops depends on where it comes from
    std::optional<bool> proportional = {};  ///< relative and continuous moves are slower by the zoom
    std::optional<bool> flip = {};  ///< past straight up or down the picture is turned over and relative and continuous tilt with it
    std::optional<std::uint64_t> seed = {};  ///< at least 0: of where it stops

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("preset", self.preset);
        visit("pan_limits_deg", self.pan_limits_deg);
        visit("tilt_limits_deg", self.tilt_limits_deg);
        visit("zoom_max", self.zoom_max);
        visit("speed_deg_s", self.speed_deg_s);
        visit("acceleration_deg_s2", self.acceleration_deg_s2);
        visit("zoom_s", self.zoom_s);
        visit("latency_s", self.latency_s);
        visit("stop_latency_s", self.stop_latency_s);
        visit("quantum_deg", self.quantum_deg);
        visit("repeatability_deg", self.repeatability_deg);
        visit("backlash_deg", self.backlash_deg);
        visit("proportional", self.proportional);
        visit("flip", self.flip);
        visit("seed", self.seed);
    }
};

/// Of a camera: clock.
struct Clock {
    std::optional<std::string> state = {};  ///< `free`, `ntp`, `ptp`, `ptp_lost` or `tai`: what keeps it right: nothing, a server by NTP, a master by PTP, no longer a master; tai: a master by PTP whose TAI it takes for UTC
    std::optional<std::int64_t> offset_ns = {};  ///< ns; -2e18 to 2e18: it says so much more than the true time
    std::optional<int> drift_ppb = {};  ///< ppb; -1e6 to 1e6: so many billionths faster, from world time 0 on; of state free
    std::optional<int> walk_ns = {};  ///< ns; 0 to 1e6: standard deviation of its random walk after a second; grows with the root of the time; of state free
    std::optional<std::int64_t> jitter_ns = {};  ///< ns; 0 to 1e9: standard deviation of each stamp on its own; at most 3.5 of it
    std::optional<std::int64_t> step_ns = {};  ///< ns; -2e18 to 2e18: somebody sets it: so much is added from step_at_ns on
    std::optional<std::int64_t> step_at_ns = {};  ///< ns; 0 to 4.6e18: world time of that
    std::optional<std::int64_t> phase_ns = {};  ///< ns; 0 to 1e10: the camera exposes so much later than cameras of its rate do
    std::optional<int> rate_ppb = {};  ///< ppb; -1e6 to 1e6: it exposes so many billionths more often than `fps` says
    std::optional<std::int64_t> trigger_jitter_ns = {};  ///< ns; 0 to 1e9: each exposure is late by 0 to this, at most half a period
    std::optional<std::uint64_t> seed = {};  ///< at least 0: of all that is random in it

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("state", self.state);
        visit("offset_ns", self.offset_ns);
        visit("drift_ppb", self.drift_ppb);
        visit("walk_ns", self.walk_ns);
        visit("jitter_ns", self.jitter_ns);
        visit("step_ns", self.step_ns);
        visit("step_at_ns", self.step_at_ns);
        visit("phase_ns", self.phase_ns);
        visit("rate_ppb", self.rate_ppb);
        visit("trigger_jitter_ns", self.trigger_jitter_ns);
        visit("seed", self.seed);
    }
};

/// Of a camera: sensor.
struct Sensor {
    std::optional<std::string> preset = {};  ///< `ideal`, `imx219`, `imx477`, `imx290`, `ov9281`, `imx249` or `webcam`: figures of a sensor; what is given beside it counts
    std::optional<std::string> filter = {};  ///< `mono`, `rgb`, `rggb`, `grbg`, `gbrg` or `bggr`: of colours: none (mono), three photosites at each place (rgb), or a mosaic of Bayer
    std::optional<NumberOrAuto> exposure_s = {};  ///< s; 1e-6 to 10: how long it counts
    std::optional<double> gain_db = {};  ///< dB; 0 to 48: electrons are multiplied by 10^(dB/20) before they become numbers
    std::optional<double> lux = {};  ///< lx; 0.0001 to 1e6: illuminance of the scene where white is drawn as white; null: white fills the wells in 10 ms, here empty
    std::optional<double> full_well_e = {};  ///< e; 100 to 1e6: what a photosite holds
    std::optional<double> read_noise_e = {};  ///< e; 0 to 1000: standard deviation
    std::optional<double> dark_e_per_s = {};  ///< e/s; 0 to 100000: dark current
    std::optional<double> quantum_efficiency = {};  ///< 0 to 1: electrons a photon; counts where lux is given
    std::optional<double> response_red = {};  ///< 0.05 to 2: of a mosaic: electrons of white light under red, of those under green
    std::optional<double> response_blue = {};  ///< 0.05 to 2: the same of blue
    std::optional<double> prnu = {};  ///< 0 to 0.2: standard deviation of sensitivity between photosites
    std::optional<double> dsnu_e = {};  ///< e; 0 to 1000: standard deviation of the offset between photosites
    std::optional<double> row_noise_e = {};  ///< e; 0 to 1000: standard deviation of the offset of a row in a picture
    std::optional<double> hot_pixels_ppm = {};  ///< 0 to 10000: hot photosites of a million
    std::optional<double> hot_e_per_s = {};  ///< e/s; 0 to 1e6: their mean dark current
    std::optional<int> bits = {};  ///< 8 to 16: of the converter
    std::optional<double> black_level = {};  ///< 0 to 16384: the number of no electrons, at most a quarter of the range; null: 1/16 of the range; 0 without noise, here empty
    std::optional<double> f_number = {};  ///< 0.5 to 64: counts where lux or focus_m is given
    std::optional<double> focus_m = {};  ///< m; 0.01 to 1e6: what is so far along the optical axis is sharp, what is nearer or farther less; null: all is sharp, here empty
    std::optional<double> pixel_pitch_m = {};  ///< m; 1e-7 to 0.001: of the picture's pixels; counts where lux or focus_m is given
    std::optional<double> vignetting = {};  ///< 0 to 4: 1 is the natural falloff of a lens, cos^4 of the angle
    std::optional<NumberOrAuto> white_balance = {};  ///< K; 2000 to 12000: the light that is taken for white
    std::optional<double> flicker_hz = {};  ///< Hz; 0 to 400: of the mains: automatic exposures last whole periods of its lamps; 0: any
    std::optional<double> least_highlights = {};  ///< 0 to 1: of automatic exposure: mean of the brightest 2 %, where the largest number is 1, that counts more than the mean of all; 0: none does
    std::optional<double> readout_s = {};  ///< s; 0 to 0.2: rows begin one after the other in this time (rolling shutter); 0: all at once
    std::optional<bool> blur = {};  ///< what moves while a row counts is smeared; false: sharp, as in the middle of it
    std::optional<bool> dynamic_framerate = {};  ///< exposures may last longer than the camera's period, and its rate falls; automatic ones up to 0.2 s
    std::optional<std::uint64_t> seed = {};  ///< at least 0: of all that is random

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("preset", self.preset);
        visit("filter", self.filter);
        visit("exposure_s", self.exposure_s);
        visit("gain_db", self.gain_db);
        visit("lux", self.lux);
        visit("full_well_e", self.full_well_e);
        visit("read_noise_e", self.read_noise_e);
        visit("dark_e_per_s", self.dark_e_per_s);
        visit("quantum_efficiency", self.quantum_efficiency);
        visit("response_red", self.response_red);
        visit("response_blue", self.response_blue);
        visit("prnu", self.prnu);
        visit("dsnu_e", self.dsnu_e);
        visit("row_noise_e", self.row_noise_e);
        visit("hot_pixels_ppm", self.hot_pixels_ppm);
        visit("hot_e_per_s", self.hot_e_per_s);
        visit("bits", self.bits);
        visit("black_level", self.black_level);
        visit("f_number", self.f_number);
        visit("focus_m", self.focus_m);
        visit("pixel_pitch_m", self.pixel_pitch_m);
        visit("vignetting", self.vignetting);
        visit("white_balance", self.white_balance);
        visit("flicker_hz", self.flicker_hz);
        visit("least_highlights", self.least_highlights);
        visit("readout_s", self.readout_s);
        visit("blur", self.blur);
        visit("dynamic_framerate", self.dynamic_framerate);
        visit("seed", self.seed);
    }
};

/// Of a camera: details.
struct PanoramaDetail {
    std::string file = {};  ///< PNG or JPEG, beside `file` of the panorama; what is not wholly opaque is left out
    int scale = 0;  ///< 2 to 64: 2, 4, 8, 16, 32 or 64: its pixels are those of a panorama with so many times the columns, 524288 of them at most
    Vector2 at_px = {};  ///< px; its upper left pixel in that larger panorama

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("file", self.file);
        visit("scale", self.scale);
        visit("at_px", self.at_px);
    }
};

/// Of a camera: lens.
struct PictureLens {
    std::string model = "pinhole";  ///< `pinhole`, `plumb_bob`, `rational_polynomial` or `equidistant`: with k1 k2 p1 p2 k3 of plumb_bob, k1 k2 p1 p2 k3 k4 k5 k6 of rational_polynomial, k1 k2 k3 k4 of equidistant
    std::vector<double> coefficients = {};  ///< as many as the model has; pinhole has none

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("model", self.model);
        visit("coefficients", self.coefficients);
    }
};

/// Of a camera: ground.
struct GroundProxy {
    std::vector<Vector2> polygon_m = {};  ///< m; its corners in the world
    std::vector<Vector2> polygon_px = {};  ///< px; instead: its corners in the picture, below the horizon
    double z = 0;  ///< m; -1e10 to 1e10: height of the ground
    std::string role = "both";  ///< `both`, `catcher` or `holdout`: both: it hides who goes behind it, and shadows fall on it; catcher: only shadows fall on it; holdout: it only hides

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("polygon_m", self.polygon_m);
        visit("polygon_px", self.polygon_px);
        visit("z", self.z);
        visit("role", self.role);
    }
};

/// Of a camera: boxes.
struct BoxProxy {
    Vector3 position = {};  ///< m; the middle of its bottom
    Vector3 size = {};  ///< m; along its x, y and z
    double yaw_deg = 0;  ///< deg; -360 to 360: about z, counter-clockwise
    std::string role = "both";  ///< `both`, `catcher` or `holdout`: both: it hides who goes behind it, and shadows fall on it; catcher: only shadows fall on it; holdout: it only hides

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("position", self.position);
        visit("size", self.size);
        visit("yaw_deg", self.yaw_deg);
        visit("role", self.role);
    }
};

/// Of a camera: cutouts.
struct CutoutProxy {
    std::vector<Vector2> polygon_px = {};  ///< px; its outline in the picture
    std::string mask = {};  ///< instead: PNG of the picture's size, beside it; what is opaque or, if all of it is, light is cut out. Empty: none
    Vector2 foot_px = {};  ///< px; where it stands on the ground, below the horizon
    double z = 0;  ///< m; -1e10 to 1e10: height of the ground
    std::string role = "both";  ///< `both`, `catcher` or `holdout`: both: it hides who goes behind it, and shadows fall on it; catcher: only shadows fall on it; holdout: it only hides

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("polygon_px", self.polygon_px);
        visit("mask", self.mask);
        visit("foot_px", self.foot_px);
        visit("z", self.z);
        visit("role", self.role);
    }
};

/// Of a camera: depth.
struct DepthProxy {
    std::string file = {};  ///< PNG of 16-bit gray of the picture's size, beside it; 0 where nothing is known or there
    double unit_m = 0.001;  ///< m; 1e-6 to 1000: of its numbers
    std::string measure = "z";  ///< `z` or `range`: what they tell. z: along the camera's axis; range: from its eye
    std::string role = "both";  ///< `both`, `catcher` or `holdout`: both: it hides who goes behind it, and shadows fall on it; catcher: only shadows fall on it; holdout: it only hides

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("file", self.file);
        visit("unit_m", self.unit_m);
        visit("measure", self.measure);
        visit("role", self.role);
    }
};

/// Of a camera: walkable.
struct WalkableGround {
    std::vector<Vector2> polygon_m = {};  ///< m; its corners in the world
    std::vector<Vector2> polygon_px = {};  ///< px; instead: its corners in the picture, below the horizon
    double z = 0;  ///< m; -1e10 to 1e10: height of the ground

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("polygon_m", self.polygon_m);
        visit("polygon_px", self.polygon_px);
        visit("z", self.z);
    }
};

/// Of a camera: proxies.
struct Proxies {
    std::string file = {};  ///< .glb or .gltf, placed in the world as it is; beside `file` of the picture. Its nodes may say by extras.camrig_proxy what they are: ground, obstacle, wall, catcher, holdout or walkable. Empty: none
    std::optional<GroundProxy> ground = {};  ///< a piece of level ground, by one of the polygons; null: none
    std::vector<BoxProxy> boxes = {};  ///< at most 200: that stand in the place
    std::vector<CutoutProxy> cutouts = {};  ///< at most 200: parts of the picture that stand upright where their foot is, and face the camera: trees, poles, fences
    std::optional<DepthProxy> depth = {};  ///< how far away each pixel of the picture is; null: not known
    std::vector<WalkableGround> walkable = {};  ///< at most 200: pieces of level ground where people may go, as ground is given; routes and areas of the scene file that leave those of all cameras are errors. Empty: anywhere
    std::string scene = "drawn";  ///< `drawn`, `proxies` or `hidden`: what the scene's objects that stand still are. drawn: they are drawn into the picture; proxies: the picture shows them already; hidden: they are not in it

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("file", self.file);
        visit("ground", self.ground);
        visit("boxes", self.boxes);
        visit("cutouts", self.cutouts);
        visit("depth", self.depth);
        visit("walkable", self.walkable);
        visit("scene", self.scene);
    }
};

/// Of a camera: noise.
struct PlateNoise {
    double k = 0;  ///< 0 to 10: how its variance grows with the level
    double read = 0;  ///< 0 to 50: standard deviation at level 0, in codes of 255

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("k", self.k);
        visit("read", self.read);
    }
};

/// Of a camera: ignore.
struct IgnoredRegion {
    std::vector<Vector2> polygon_px = {};  ///< px; its outline in the picture
    std::string object_class = "person";  ///< of 1 to 64 characters: of what the picture shows there

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("polygon_px", self.polygon_px);
        visit("object_class", self.object_class);
    }
};

/// Of a camera: backdrop.
struct Backdrop {
    std::string kind = "plate";  ///< `plate`, `film`, `panorama` or `projected`: plate: one picture of a camera that stands still; film: a film of one, which is shown in step with world time, over and over; panorama: equirectangular, what is all around a camera that may turn and zoom; projected: one picture, laid on the proxies from where it was taken, for a camera that moves a little
    std::string file = {};  ///< PNG or JPEG, or a film (MP4, Matroska, WebM, AVI, MPEG-TS, MJPEG), upright, of the camera's size or of one with the same sides, a panorama of any size twice as wide as high, a projected picture of any size; relative to the scene file, in its folder or below, or, of commands, an absolute path
    Size picture_size = {};  ///< px; of the picture: that of all pixels here; 0 of a panorama
    Rate fps = {};  ///< 1/s; of a film: how many of its pictures are shown in a second, 1/10 to 1000; null: as the film says, here empty
    double yaw_deg = 0;  ///< deg; -360 to 360: of a panorama: which way its middle looks, about z, counter-clockwise from +x
    std::vector<PanoramaDetail> details = {};  ///< at most 200: of a panorama: parts of it in finer pixels, for long lenses
    std::optional<Intrinsics> intrinsics = {};  ///< px; of the picture's own pixels, see intrinsics; they take the place of the camera's, whatever its size (of a projected picture they are needed, and the camera has its own); null: the camera's are those of its size
    std::optional<Pose> taken_from = {};  ///< of a projected picture: the pose of its camera, see pose; null: the kind is another one
    std::optional<PictureLens> lens = {};  ///< of a projected picture: that of the camera that took it, see lens; null: the camera's own
    Proxies proxies = {};  ///< shapes of what the picture shows: they hide what goes behind them
    std::string shadow = "mapped";  ///< `none`, `blob` or `mapped`: of what moves, on what the picture shows. none; blob: about feet; mapped: of the scene's lights at quality beautiful, at simple as blob
    Vector3 plate_gain = {};  ///< factors on the light of what is drawn, red, green and blue, so that white is that of the picture
    double edge_px = 0;  ///< px; 0 to 3: what is drawn is made as soft as the picture: standard deviation of a Gaussian
    std::optional<PlateNoise> noise = {};  ///< noise on what is drawn, as that of the picture: its standard deviation at a level of 0 to 255 is sqrt(read^2 + k * level); null: none
    std::vector<IgnoredRegion> ignore = {};  ///< at most 200: where the picture shows people or vehicles of its own, which truth does not know

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("kind", self.kind);
        visit("file", self.file);
        visit("picture_size", self.picture_size);
        visit("fps", self.fps);
        visit("yaw_deg", self.yaw_deg);
        visit("details", self.details);
        visit("intrinsics", self.intrinsics);
        visit("taken_from", self.taken_from);
        visit("lens", self.lens);
        visit("proxies", self.proxies);
        visit("shadow", self.shadow);
        visit("plate_gain", self.plate_gain);
        visit("edge_px", self.edge_px);
        visit("noise", self.noise);
        visit("ignore", self.ignore);
    }
};

/// Of a camera: lens.
struct Lens {
    std::string model = "pinhole";  ///< `pinhole`, `plumb_bob`, `rational_polynomial` or `equidistant`: with k1 k2 p1 p2 k3 of plumb_bob, k1 k2 p1 p2 k3 k4 k5 k6 of rational_polynomial, k1 k2 k3 k4 of equidistant
    std::vector<double> coefficients = {};  ///< as many as the model has; pinhole has none
    std::string method = "auto";  ///< `auto`, `warp` or `cube`: what the picture is resampled from; warp: one larger pinhole picture, cube: the faces of a cube, auto: what needs fewer pixels
    std::string filter = "auto";  ///< `auto`, `bilinear` or `bicubic`: bicubic (Catmull-Rom) keeps more contrast; auto: bicubic at quality beautiful; ssaa always takes bilinear samples

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("model", self.model);
        visit("coefficients", self.coefficients);
        visit("method", self.method);
        visit("filter", self.filter);
    }
};

/// Of a camera: controls.
struct Controls {
    std::optional<bool> auto_exposure = {};  ///< the scene's exposure; off when exposure_ev is given
    std::optional<double> exposure_ev = {};  ///< EV; -6 to 6: light is multiplied by 2^ev
    std::optional<double> gain_db = {};  ///< dB; 0 to 24: light is multiplied by 10^(dB/20)
    std::optional<bool> auto_white_balance = {};  ///< neutral; off when white_balance_k is given
    std::optional<double> white_balance_k = {};  ///< K; 2800 to 10000: the light that is taken for white; lower makes bluer pictures
    std::optional<double> brightness = {};  ///< -1 to 1: added to the sRGB codes (1: from black to white)
    std::optional<double> contrast = {};  ///< 0 to 2: about the middle code
    std::optional<double> saturation = {};  ///< 0 to 2: 0 is grey

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("auto_exposure", self.auto_exposure);
        visit("exposure_ev", self.exposure_ev);
        visit("gain_db", self.gain_db);
        visit("auto_white_balance", self.auto_white_balance);
        visit("white_balance_k", self.white_balance_k);
        visit("brightness", self.brightness);
        visit("contrast", self.contrast);
        visit("saturation", self.saturation);
    }
};

/// Of a camera: outputs.
struct Output {
    std::string kind = {};  ///< `v4l2`, `device`, `rtsp`, `mjpeg` or `onvif`
    std::optional<int> number = {};  ///< 0 to 255: of v4l2 and device: N of /dev/videoN
    std::optional<std::string> format = {};  ///< `YUYV`, `YU12`, `MJPG` or `BGR3`: of v4l2
    std::optional<std::string> subsampling = {};  ///< `4:2:2` or `4:2:0`: of v4l2 and device: chroma of MJPG
    std::optional<bool> error_controls = {};  ///< of device: it has V4L2 controls by which programs let it fail, with the names and numbers of the kernel's vivid (docs/faults.md)
    std::optional<std::string> codec = {};  ///< `h264`, `h265` or `mjpeg`: of rtsp: main with mjpeg is a stream beside that of h264 or h265
    std::optional<std::string> stream = {};  ///< `main` or `sub`: of rtsp
    std::optional<Size> size = {};  ///< px; of rtsp: with stream sub, at most the camera's; by default half of it
    std::optional<Rate> fps = {};  ///< 1/s; of rtsp: 1/10 to 1000, at most the camera's; by default the camera's, of sub half of it
    std::optional<int> quality = {};  ///< 1 to 100: of rtsp and mjpeg: JPEG quality
    std::optional<int> bitrate_kbps = {};  ///< kbit/s; 16 to 200000: of rtsp: with h264 and h265; by default 0.15 bits per pixel
    std::optional<double> key_interval_s = {};  ///< s; 0.01 to 60: of rtsp: with h264 and h265: a key frame at least so often
    std::optional<std::string> preset = {};  ///< `ultrafast`, `superfast`, `veryfast`, `faster`, `fast`, `medium` or `slow`: of rtsp: with h264 and h265
    std::optional<std::string> profile = {};  ///< `baseline`, `main` or `high`: of rtsp: with h264
    std::optional<int> port = {};  ///< 1 to 65535: of onvif: TCP port of the device, on the host of HTTP
    std::optional<std::string> move_status = {};  ///< `told`, `none` or `stuck`: of onvif: whether the head moves is told as it is, not at all, or as MOVING for ever after the first move
    std::optional<bool> relative_fov = {};  ///< of onvif: offers moves by field of view, which trackers need and many devices lack

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("kind", self.kind);
        visit("number", self.number);
        visit("format", self.format);
        visit("subsampling", self.subsampling);
        visit("error_controls", self.error_controls);
        visit("codec", self.codec);
        visit("stream", self.stream);
        visit("size", self.size);
        visit("fps", self.fps);
        visit("quality", self.quality);
        visit("bitrate_kbps", self.bitrate_kbps);
        visit("key_interval_s", self.key_interval_s);
        visit("preset", self.preset);
        visit("profile", self.profile);
        visit("port", self.port);
        visit("move_status", self.move_status);
        visit("relative_fov", self.relative_fov);
    }
};

/// What a camera can be given. What is left out has the rig's default in create_camera and stays as it is in Camera::set.
struct CameraOptions {
    std::optional<std::string> place = {};  ///< a place of the scene: its pose and field of view, unless given
    std::optional<Size> size = {};  ///< px; 16x16 to 8192x8192
    std::optional<Rate> fps = {};  ///< 1/s; 1/10 to 1000
    std::optional<double> vfov_deg = {};  ///< deg; over 0.01 and below 179.9: vertical field of view, edge to edge; give hfov_deg or intrinsics instead
    std::optional<double> hfov_deg = {};  ///< deg; over 0.01 and below 179.9: horizontal field of view, edge to edge
    std::optional<Intrinsics> intrinsics = {};  ///< px; see intrinsics; in an answer, as they follow from the above and zoom
    std::optional<double> zoom = {};  ///< 1 to 10: scales the focal length; optics are given as they are at the zoom given with them, else at 1
    std::optional<Vector3> position = {};  ///< m; where it is
    std::optional<Vector3> look_at = {};  ///< m; the point in the middle of the picture; the horizon stays level
    std::optional<double> pan_deg = {};  ///< deg; about world z, counter-clockwise from above; 0 looks along +x
    std::optional<double> tilt_deg = {};  ///< deg; positive looks up
    std::optional<double> roll_deg = {};  ///< deg; about the viewing direction, clockwise seen from behind the camera
    std::optional<Quaternion> orientation = {};  ///< quaternion of the body frame: x forward, y left, z up
    std::optional<std::optional<Mount>> mount = {};  ///< see mount; null: on nothing, where `pose` is in the world
    std::optional<std::optional<Ptz>> ptz = {};  ///< the head that turns and zooms it, see ptz; `pose` is where it looks at pan and tilt 0; null: no head
    std::optional<std::optional<Clock>> clock = {};  ///< its own clock, see clock: what its stamps say and when it exposes, each wrong on its own; null: none, it is right
    std::optional<std::optional<Sensor>> sensor = {};  ///< counts electrons as a real camera does, see sensor: exposure, noise, saturation, raw numbers; null: none: light of 1 is white
    std::optional<std::optional<Backdrop>> backdrop = {};  ///< a picture of a real place that people walk in, see backdrop; null: the scene's own objects are what it sees
    std::optional<Lens> lens = {};  ///< see lens
    std::optional<std::string> antialias = {};  ///< `none`, `coverage`, `msaa4`, `ssaa2`, `ssaa3`, `ssaa4` or `auto`: samples of a pixel of the colour picture; coverage: each surface by how much of the pixel it covers, of 64 places, shaded once (as msaa4 on a GPU), msaa4: four coverage samples, ssaa2 to ssaa4: 2x2 to 4x4 full samples, auto: coverage at quality beautiful up to 4 megapixels, else none
    std::optional<double> near = {};  ///< m; over 0 and at most 1e6: nearest distance drawn
    std::optional<double> far = {};  ///< m; at least 0: farthest distance drawn, over near; 0: no limit
    std::optional<std::string> quality = {};  ///< `fast`, `simple` or `beautiful`; null: the rig's, here empty
    std::optional<double> exposure_ev = {};  ///< EV; -20 to 20: stops by which it is exposed more than the scene's `exposure` has it, before anything is cut at white; of cameras without sensor and backdrop
    std::optional<Controls> controls = {};  ///< see controls; what is not given in it stays
    std::optional<bool> code_strip = {};  ///< draws camera number, sequence and world time into the picture; needs 128x32 pixels
    std::optional<bool> clock_text = {};  ///< burns days, hours, minutes and seconds of world time as its clock has it into the lower left corner of the picture; needs 128x32 pixels
    std::optional<std::string> description = {};  ///< of at most 200 characters: free text of yours: where it hangs, what it is for
    std::optional<std::string> group = {};  ///< of at most 24 characters: a name of yours: of cameras with the same (a stereo pair) the pictures of an instant are all drawn or all dropped
    std::optional<std::vector<Output>> outputs = {};  ///< at most 16, no two the same, all of them given; see outputs

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("place", self.place);
        visit("size", self.size);
        visit("fps", self.fps);
        visit("vfov_deg", self.vfov_deg);
        visit("hfov_deg", self.hfov_deg);
        visit("intrinsics", self.intrinsics);
        visit("zoom", self.zoom);
        visit("position", self.position);
        visit("look_at", self.look_at);
        visit("pan_deg", self.pan_deg);
        visit("tilt_deg", self.tilt_deg);
        visit("roll_deg", self.roll_deg);
        visit("orientation", self.orientation);
        visit("mount", self.mount);
        visit("ptz", self.ptz);
        visit("clock", self.clock);
        visit("sensor", self.sensor);
        visit("backdrop", self.backdrop);
        visit("lens", self.lens);
        visit("antialias", self.antialias);
        visit("near", self.near);
        visit("far", self.far);
        visit("quality", self.quality);
        visit("exposure_ev", self.exposure_ev);
        visit("controls", self.controls);
        visit("code_strip", self.code_strip);
        visit("clock_text", self.clock_text);
        visit("description", self.description);
        visit("group", self.group);
        visit("outputs", self.outputs);
    }
};

/// Everything about a camera at one time.
struct CameraState {
    std::string name = {};  ///< `[a-z0-9_]{1,24}`
    Size size = {};  ///< px; 16x16 to 8192x8192
    Rate fps = {};  ///< 1/s; 1/10 to 1000
    double vfov_deg = 60;  ///< deg; over 0.01 and below 179.9: vertical field of view, edge to edge; give hfov_deg or intrinsics instead
    double hfov_deg = 0;  ///< deg; over 0.01 and below 179.9: horizontal field of view, edge to edge
    Intrinsics intrinsics = {};  ///< px; see intrinsics; in an answer, as they follow from the above and zoom
    double zoom = 1;  ///< 1 to 10: scales the focal length; optics are given as they are at the zoom given with them, else at 1
    Pose pose = {};  ///< see pose; in the frame of its mount, if it has one. A camera without it and without a `place` is at the origin and looks along +x
    std::optional<Mount> mount = {};  ///< see mount; null: on nothing, where `pose` is in the world
    std::optional<Ptz> ptz = {};  ///< the head that turns and zooms it, see ptz; `pose` is where it looks at pan and tilt 0; null: no head
    std::optional<Clock> clock = {};  ///< its own clock, see clock: what its stamps say and when it exposes, each wrong on its own; null: none, it is right
    std::optional<Sensor> sensor = {};  ///< counts electrons as a real camera does, see sensor: exposure, noise, saturation, raw numbers; null: none: light of 1 is white
    std::optional<Backdrop> backdrop = {};  ///< a picture of a real place that people walk in, see backdrop; null: the scene's own objects are what it sees
    Lens lens = {};  ///< see lens
    std::string antialias = {};  ///< `none`, `coverage`, `msaa4`, `ssaa2`, `ssaa3`, `ssaa4` or `auto`: samples of a pixel of the colour picture; coverage: each surface by how much of the pixel it covers, of 64 places, shaded once (as msaa4 on a GPU), msaa4: four coverage samples, ssaa2 to ssaa4: 2x2 to 4x4 full samples, auto: coverage at quality beautiful up to 4 megapixels, else none
    double near = 0.05;  ///< m; over 0 and at most 1e6: nearest distance drawn
    double far = 0;  ///< m; at least 0: farthest distance drawn, over near; 0: no limit
    std::string quality = {};  ///< `fast`, `simple` or `beautiful`; null: the rig's, here empty
    double exposure_ev = 0;  ///< EV; -20 to 20: stops by which it is exposed more than the scene's `exposure` has it, before anything is cut at white; of cameras without sensor and backdrop
    Controls controls = {};  ///< see controls; what is not given in it stays
    bool code_strip = {};  ///< draws camera number, sequence and world time into the picture; needs 128x32 pixels
    bool clock_text = {};  ///< burns days, hours, minutes and seconds of world time as its clock has it into the lower left corner of the picture; needs 128x32 pixels
    std::string description = {};  ///< of at most 200 characters: free text of yours: where it hangs, what it is for
    std::string group = {};  ///< of at most 24 characters: a name of yours: of cameras with the same (a stereo pair) the pictures of an instant are all drawn or all dropped
    std::vector<Output> outputs = {};  ///< at most 16, no two the same, all of them given; see outputs
    Pose world_pose = {};  ///< where it is in the world, as pose; of a mounted camera, at its latest due frame
    Intrinsics shown_intrinsics = {};  ///< px; intrinsics of its picture now, with what its head zooms
    std::int64_t id = 0;  ///< one life of a camera; never used again
    std::int64_t sequence = 0;  ///< number of its latest due frame
    std::int64_t readers = 0;  ///< how many watch it now
    std::int64_t applied_ns = 0;  ///< ns; world time from which this state shows
    std::int64_t arrives_ns = 0;  ///< ns; world time from which it is where its last command sent it

    /// The rig tells all of them.
    static constexpr bool is_answer = true;

    /// Makes the same camera again, without its outputs: a device number can be had once.
    CameraOptions options() const;

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("name", self.name);
        visit("size", self.size);
        visit("fps", self.fps);
        visit("vfov_deg", self.vfov_deg);
        visit("hfov_deg", self.hfov_deg);
        visit("intrinsics", self.intrinsics);
        visit("zoom", self.zoom);
        visit("pose", self.pose);
        visit("mount", self.mount);
        visit("ptz", self.ptz);
        visit("clock", self.clock);
        visit("sensor", self.sensor);
        visit("backdrop", self.backdrop);
        visit("lens", self.lens);
        visit("antialias", self.antialias);
        visit("near", self.near);
        visit("far", self.far);
        visit("quality", self.quality);
        visit("exposure_ev", self.exposure_ev);
        visit("controls", self.controls);
        visit("code_strip", self.code_strip);
        visit("clock_text", self.clock_text);
        visit("description", self.description);
        visit("group", self.group);
        visit("outputs", self.outputs);
        visit("world_pose", self.world_pose);
        visit("shown_intrinsics", self.shown_intrinsics);
        visit("id", self.id);
        visit("sequence", self.sequence);
        visit("readers", self.readers);
        visit("applied_ns", self.applied_ns);
        visit("arrives_ns", self.arrives_ns);
    }
};

/// What the world is doing. Times are since the scene was loaded.
struct WorldStatus {
    std::string scene = {};  ///< name of the scene
    std::string scene_file = {};  ///< the file it came from
    std::string mode = {};  ///< `realtime` or `lockstep`
    std::string overload = {};  ///< `drop` or `slow`
    std::string quality = {};  ///< `fast`, `simple` or `beautiful`: the rig's own
    bool paused = {};  ///< world time stands still (realtime)
    std::int64_t world_ns = 0;  ///< ns; world time
    std::int64_t step_ns = 0;  ///< ns; the world's own step
    std::uint64_t seed = {};  ///< at least 0: seed of all chance in the world
    std::int64_t state_ns = 0;  ///< ns; world time of the last step
    std::string state_hash = {};  ///< of all that decides the world's future, at state_ns: equal states have equal hashes
    std::int64_t objects = 0;  ///< objects of the scene
    std::int64_t actors = 0;  ///< actors that are there now
    std::int64_t cameras = 0;  ///< cameras of the rig
    std::vector<std::string> places = {};  ///< named camera places of the scene
    std::int64_t applied_ns = 0;  ///< ns; world time from which this state holds

    /// The rig tells all of them.
    static constexpr bool is_answer = true;

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("scene", self.scene);
        visit("scene_file", self.scene_file);
        visit("mode", self.mode);
        visit("overload", self.overload);
        visit("quality", self.quality);
        visit("paused", self.paused);
        visit("world_ns", self.world_ns);
        visit("step_ns", self.step_ns);
        visit("seed", self.seed);
        visit("state_ns", self.state_ns);
        visit("state_hash", self.state_hash);
        visit("objects", self.objects);
        visit("actors", self.actors);
        visit("cameras", self.cameras);
        visit("places", self.places);
        visit("applied_ns", self.applied_ns);
    }
};

/// Of an actor: attach.
struct Attachment {
    std::string actor = {};  ///< that carries it
    std::optional<std::string> node = {};  ///< of its model; none: its origin
    std::optional<Vector3> position = {};  ///< m; from there
    std::optional<double> yaw_deg = {};  ///< deg; turn about z of the node
    std::optional<Quaternion> orientation = {};  ///< instead of yaw_deg

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("actor", self.actor);
        visit("node", self.node);
        visit("position", self.position);
        visit("yaw_deg", self.yaw_deg);
        visit("orientation", self.orientation);
    }
};

/// Of an object: box.
struct Box {
    Vector3 min = {};
    Vector3 max = {};

    /// The rig tells all of them.
    static constexpr bool is_answer = true;

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("min", self.min);
        visit("max", self.max);
    }
};

/// Of a log: events.
struct FiredEvent {
    std::int64_t sequence = 0;  ///< its number
    std::string event = {};  ///< its name
    std::int64_t world_ns = 0;  ///< ns; world time at which it fired
    std::string actor = {};  ///< who entered, left, met or arrived; else empty
    nlohmann::json data = {};  ///< of its user actions
    std::vector<std::string> errors = {};  ///< actions that could not be done

    /// The rig tells all of them.
    static constexpr bool is_answer = true;

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("sequence", self.sequence);
        visit("event", self.event);
        visit("world_ns", self.world_ns);
        visit("actor", self.actor);
        visit("data", self.data);
        visit("errors", self.errors);
    }
};

/// What Rig::spawn_actor takes.
struct ActorOptions {
    std::optional<std::string> object_class = {};  ///< what ground truth calls it, as `person`
    std::optional<Vector3> position = {};  ///< m; of its origin; where a route does not place it
    std::optional<double> yaw_deg = {};  ///< deg; where its front looks, counter-clockwise from +x; or orientation
    std::optional<Quaternion> orientation = {};  ///< instead of yaw_deg
    std::optional<double> scale = {};  ///< 1e-6 to 1e6: of the model
    std::optional<std::uint64_t> variant = {};  ///< at least 0: which of the looks of its model: colors and what it wears follow from this number
    std::optional<double> radius_m = {};  ///< m; 0 to 100: of its body, for those who walk round it
    std::optional<Attachment> attach = {};  ///< hangs it on a node of another actor: {actor, node, position, yaw_deg or orientation}
    std::optional<nlohmann::json> behaviour = {};  ///< see behaviours
    std::optional<std::int64_t> at_ns = {};  ///< ns; world time at which it is done: after the frames that are due then, before the world's next step; those of one time in the order in which they came. The answer comes when it was done. Not past, and at most an hour ahead; 4096 may wait. Default: at once

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("class", self.object_class);
        visit("position", self.position);
        visit("yaw_deg", self.yaw_deg);
        visit("orientation", self.orientation);
        visit("scale", self.scale);
        visit("variant", self.variant);
        visit("radius_m", self.radius_m);
        visit("attach", self.attach);
        visit("behaviour", self.behaviour);
        visit("at_ns", self.at_ns);
    }
};

/// What Rig::set_actor takes; what is left out stays.
struct ActorChanges {
    std::optional<Vector3> position = {};  ///< m; of its origin
    std::optional<double> yaw_deg = {};  ///< deg; where its front looks, counter-clockwise from +x; or orientation
    std::optional<Quaternion> orientation = {};  ///< instead of yaw_deg
    std::optional<std::uint64_t> variant = {};  ///< at least 0: which of the looks of its model: colors and what it wears follow from this number
    std::optional<nlohmann::json> behaviour = {};  ///< see behaviours
    std::optional<Attachment> attach = {};  ///< hangs it on a node of another actor: {actor, node, position, yaw_deg or orientation}
    std::optional<bool> detach = {};  ///< no longer hangs on anything
    std::optional<std::string> play = {};  ///< a clip over the one of the behaviour; empty: no longer
    std::optional<double> play_speed = {};  ///< 0 to 100: of that clip
    std::optional<std::int64_t> at_ns = {};  ///< ns; world time at which it is done: after the frames that are due then, before the world's next step; those of one time in the order in which they came. The answer comes when it was done. Not past, and at most an hour ahead; 4096 may wait. Default: at once

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("position", self.position);
        visit("yaw_deg", self.yaw_deg);
        visit("orientation", self.orientation);
        visit("variant", self.variant);
        visit("behaviour", self.behaviour);
        visit("attach", self.attach);
        visit("detach", self.detach);
        visit("play", self.play);
        visit("play_speed", self.play_speed);
        visit("at_ns", self.at_ns);
    }
};

/// What Rig::spawn_object takes.
struct ObjectOptions {
    std::optional<std::string> object_class = {};  ///< what ground truth calls it, as `person`
    std::optional<Vector3> position = {};  ///< m; of its origin
    std::optional<double> yaw_deg = {};  ///< deg; counter-clockwise from above; or orientation
    std::optional<Quaternion> orientation = {};  ///< instead of yaw_deg
    std::optional<double> scale = {};  ///< 1e-6 to 1e6: of the model
    std::optional<std::string> clip = {};  ///< an animation of the model, played in a loop
    std::optional<std::int64_t> at_ns = {};  ///< ns; world time at which it is done: after the frames that are due then, before the world's next step; those of one time in the order in which they came. The answer comes when it was done. Not past, and at most an hour ahead; 4096 may wait. Default: at once

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("class", self.object_class);
        visit("position", self.position);
        visit("yaw_deg", self.yaw_deg);
        visit("orientation", self.orientation);
        visit("scale", self.scale);
        visit("clip", self.clip);
        visit("at_ns", self.at_ns);
    }
};

/// What Rig::set_object takes; what is left out stays.
struct ObjectChanges {
    std::optional<bool> hidden = {};  ///< in no picture and no ground truth; casts no shadow, and goes on moving if it does
    std::optional<double> scale = {};  ///< 1e-6 to 1e6: of the model
    std::optional<Vector3> position = {};  ///< m; of its origin; not of actors, which actor.set places
    std::optional<double> yaw_deg = {};  ///< deg; counter-clockwise from above; or orientation
    std::optional<Quaternion> orientation = {};  ///< instead of yaw_deg
    std::optional<std::int64_t> at_ns = {};  ///< ns; world time at which it is done: after the frames that are due then, before the world's next step; those of one time in the order in which they came. The answer comes when it was done. Not past, and at most an hour ahead; 4096 may wait. Default: at once

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("hidden", self.hidden);
        visit("scale", self.scale);
        visit("position", self.position);
        visit("yaw_deg", self.yaw_deg);
        visit("orientation", self.orientation);
        visit("at_ns", self.at_ns);
    }
};

/// What Rig::set_fault takes.
struct FaultOptions {
    std::optional<nlohmann::json> params = {};  ///< of that kind (docs/faults.md)
    std::optional<double> severity = {};  ///< 0 to 1: 1: as params say; less is milder, 0 is as if there were no fault
    std::optional<std::uint64_t> seed = {};  ///< at least 0: of what is random in it
    std::optional<double> start_s = {};  ///< s; 0 to 1e9: world time from which on it is there
    std::optional<double> end_s = {};  ///< s; 0 to 1e9: world time at which it is over
    std::optional<std::int64_t> at_ns = {};  ///< ns; world time at which it is done: after the frames that are due then, before the world's next step; those of one time in the order in which they came. The answer comes when it was done. Not past, and at most an hour ahead; 4096 may wait. Default: at once

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("params", self.params);
        visit("severity", self.severity);
        visit("seed", self.seed);
        visit("start_s", self.start_s);
        visit("end_s", self.end_s);
        visit("at_ns", self.at_ns);
    }
};

/// What Rig::steer_actors takes of each actor.
struct Steering {
    std::string name = {};  ///< name of the actor
    std::optional<Vector3> velocity = {};  ///< m/s; held until it is told another
    std::optional<Vector3> position = {};  ///< m; instead of a velocity: reached after `seconds`
    std::optional<double> seconds = {};  ///< s; 0 to 3600
    std::optional<double> yaw_deg = {};  ///< deg; where its front looks
    std::optional<std::string> clip = {};  ///< that it plays

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("name", self.name);
        visit("velocity", self.velocity);
        visit("position", self.position);
        visit("seconds", self.seconds);
        visit("yaw_deg", self.yaw_deg);
        visit("clip", self.clip);
    }
};

/// An actor at the world's last step.
struct ActorState {
    std::string name = {};  ///< its name
    std::int64_t id = 0;  ///< its identity in ground truth, in all cameras
    std::string object_class = {};  ///< what ground truth calls it
    std::string model = {};  ///< of the scene
    double scale = 0;  ///< of the model
    std::optional<std::uint64_t> variant = {};  ///< at least 0: which of the looks of its model; null: as its file has it
    Vector3 position = {};  ///< m; of its origin, at the world's last step
    Quaternion orientation = {0, 0, 0, 1};  ///< of the actor: its front is +x
    double yaw_deg = 0;  ///< deg; of its front, counter-clockwise from +x
    Vector3 velocity = {};  ///< m/s; over the last step
    std::string behaviour = {};  ///< type of its behaviour
    bool arrived = {};  ///< whether it has done what its behaviour is to do
    std::string clip = {};  ///< the clip it plays; empty: none
    std::string attached_to = {};  ///< the actor that it hangs on; empty: none

    /// The rig tells all of them.
    static constexpr bool is_answer = true;

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("name", self.name);
        visit("id", self.id);
        visit("class", self.object_class);
        visit("model", self.model);
        visit("scale", self.scale);
        visit("variant", self.variant);
        visit("position", self.position);
        visit("orientation", self.orientation);
        visit("yaw_deg", self.yaw_deg);
        visit("velocity", self.velocity);
        visit("behaviour", self.behaviour);
        visit("arrived", self.arrived);
        visit("clip", self.clip);
        visit("attached_to", self.attached_to);
    }
};

/// An object or actor at the world's last step.
struct ObjectState {
    std::string name = {};  ///< its name
    std::int64_t id = 0;  ///< its identity in pictures of kind `instance` and in ground truth
    std::string object_class = {};  ///< what ground truth calls it
    std::string model = {};  ///< of the scene
    bool moves = {};  ///< an actor, or an object that plays a clip or was picked up
    bool hidden = {};  ///< as object.set says
    double scale = 0;  ///< of the model
    Vector3 position = {};  ///< m; of its origin
    Quaternion orientation = {0, 0, 0, 1};  ///< of an actor: its front is +x

    /// The rig tells all of them.
    static constexpr bool is_answer = true;

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("name", self.name);
        visit("id", self.id);
        visit("class", self.object_class);
        visit("model", self.model);
        visit("moves", self.moves);
        visit("hidden", self.hidden);
        visit("scale", self.scale);
        visit("position", self.position);
        visit("orientation", self.orientation);
    }
};

/// One of them, with its box.
struct ObjectInfo {
    std::string name = {};  ///< its name
    std::int64_t id = 0;  ///< its identity in pictures of kind `instance` and in ground truth
    std::string object_class = {};  ///< what ground truth calls it
    std::string model = {};  ///< of the scene
    bool moves = {};  ///< an actor, or an object that plays a clip or was picked up
    bool hidden = {};  ///< as object.set says
    double scale = 0;  ///< of the model
    Vector3 position = {};  ///< m; of its origin
    Quaternion orientation = {0, 0, 0, 1};  ///< of an actor: its front is +x
    std::optional<Box> box = {};  ///< m; its box along the world's axes; null: nothing of it is drawn
    std::int64_t state_ns = 0;  ///< ns; world time of the last step

    /// The rig tells all of them.
    static constexpr bool is_answer = true;

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("name", self.name);
        visit("id", self.id);
        visit("class", self.object_class);
        visit("model", self.model);
        visit("moves", self.moves);
        visit("hidden", self.hidden);
        visit("scale", self.scale);
        visit("position", self.position);
        visit("orientation", self.orientation);
        visit("box", self.box);
        visit("state_ns", self.state_ns);
    }
};

/// An event that waits.
struct EventState {
    std::string name = {};  ///< its name
    std::string when = {};  ///< the kind of its trigger
    std::int64_t fired = 0;  ///< how often it has fired
    std::int64_t limit = 0;  ///< how often it fires at most; 0: any number

    /// The rig tells all of them.
    static constexpr bool is_answer = true;

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("name", self.name);
        visit("when", self.when);
        visit("fired", self.fired);
        visit("limit", self.limit);
    }
};

/// What has fired.
struct EventLog {
    std::vector<FiredEvent> events = {};  ///< each sequence, event (its name), world_ns, actor (who entered, left, met or arrived, else empty), data (of its user actions) and errors (actions that could not be done)
    std::int64_t last = 0;  ///< number of the newest event of all
    std::int64_t missed = 0;  ///< events after `since` that are not kept any more

    /// The rig tells all of them.
    static constexpr bool is_answer = true;

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("events", self.events);
        visit("last", self.last);
        visit("missed", self.missed);
    }
};

/// A fault of a camera.
struct FaultState {
    std::int64_t id = 0;  ///< of this fault, unique in the rig
    std::string camera = {};  ///< that fails
    std::string kind = {};  ///< what goes wrong
    std::string layer = {};  ///< where: body, optics, sensor, driver or transport; faults act in this order
    std::int64_t start_ns = 0;  ///< ns; world time from which on it is there
    std::optional<std::int64_t> end_ns = {};  ///< ns; world time at which it is over; null: when it is cleared
    double severity = 0;  ///< 0 to 1
    std::int64_t seed = 0;  ///< of what is random in it
    nlohmann::json params = {};  ///< of that kind, all of them

    /// The rig tells all of them.
    static constexpr bool is_answer = true;

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("id", self.id);
        visit("camera", self.camera);
        visit("kind", self.kind);
        visit("layer", self.layer);
        visit("start_ns", self.start_ns);
        visit("end_ns", self.end_ns);
        visit("severity", self.severity);
        visit("seed", self.seed);
        visit("params", self.params);
    }
};

/// Of a log of readers: events.
struct ReaderEvent {
    std::int64_t number = 0;  ///< counts from 1
    std::string kind = {};  ///< `closed`, `open`, `refused`, `thrown_out` or `good`: closed: from now on who comes is refused, or finds no device; open: not any more, its server or device is there again; refused: somebody came and was; thrown_out: a reader was; good: a reader was given a frame without faults, its first or the first after one that had some
    std::string camera = {};  ///< its name
    std::string output = {};  ///< of which kind: mjpeg, rtsp, device or v4l2
    std::string peer = {};  ///< who, as in the books (stats.get): of all readers of an RTSP stream its path; of closed and open empty
    std::int64_t world_ns = 0;  ///< ns; world time of the frame that was given or kept back; of refused, of the rig's newest instant
    std::int64_t monotonic_ns = 0;  ///< ns; when it happened, CLOCK_MONOTONIC
    std::int64_t real_ns = 0;  ///< ns; the same since 1970, CLOCK_REALTIME

    /// The rig tells all of them.
    static constexpr bool is_answer = true;

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("number", self.number);
        visit("kind", self.kind);
        visit("camera", self.camera);
        visit("output", self.output);
        visit("peer", self.peer);
        visit("world_ns", self.world_ns);
        visit("monotonic_ns", self.monotonic_ns);
        visit("real_ns", self.real_ns);
    }
};

/// What faults let readers meet.
struct ReaderLog {
    std::vector<ReaderEvent> events = {};  ///< each number, kind, camera, output, peer, world_ns, monotonic_ns, real_ns
    std::int64_t last = 0;  ///< number of the newest event of all cameras
    std::int64_t missed = 0;  ///< events after `since`, of all cameras, that are not kept any more

    /// The rig tells all of them.
    static constexpr bool is_answer = true;

    template <typename Self, typename Visit>
    static void each_member(Self& self, Visit&& visit) {
        visit("events", self.events);
        visit("last", self.last);
        visit("missed", self.missed);
    }
};

/// Texts that are null in the protocol where they are empty here.
inline constexpr const char* null_when_empty[] = {"quality", };

inline CameraOptions CameraState::options() const {
    CameraOptions options;
    options.size = size;
    options.fps = fps;
    options.intrinsics = intrinsics;
    options.zoom = zoom;
    options.position = pose.position;
    options.orientation = pose.orientation;
    options.mount = mount;
    options.ptz = ptz;
    options.clock = clock;
    options.sensor = sensor;
    options.backdrop = backdrop;
    options.lens = lens;
    options.antialias = antialias;
    options.near = near;
    options.far = far;
    options.quality = quality;
    options.exposure_ev = exposure_ev;
    options.controls = controls;
    options.code_strip = code_strip;
    options.clock_text = clock_text;
    options.description = description;
    options.group = group;
    return options;
}

}  // namespace camrig::client

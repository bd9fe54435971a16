"""The parameters of cameras, actors and events, for editors and type checkers.

Made from the rig's own tables by: camrig methods --write . -- changes here are lost.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from typing import Any, Literal, TypedDict, Union

import numpy as np

Rate = Union[int, float, str, Fraction]
Vector = Union[Sequence[float], np.ndarray]


class Intrinsics(TypedDict, total=False):
    """Of a camera: intrinsics."""

    fx: float
    """px; over 0: focal length"""
    fy: float
    """px; over 0: focal length"""
    cx: float
    """px; -1e6 to 1e6: principal point"""
    cy: float
    """px; -1e6 to 1e6: principal point"""


class Pose(TypedDict, total=False):
    """Of a camera: pose."""

    position: list[float]
    """m; where it is"""
    pan_deg: float
    """deg; about world z, counter-clockwise from above; 0 looks along +x"""
    tilt_deg: float
    """deg; positive looks up"""
    roll_deg: float
    """deg; about the viewing direction, clockwise seen from behind the camera"""
    orientation: list[float]
    """quaternion of the body frame: x forward, y left, z up"""


class Mount(TypedDict, total=False):
    """Of a camera: mount."""

    actor: str
    """its name"""
    node: str
    """a node of its model: the frame is at the node and turns as the node does in its clips; at rest, one without a turn of its own has the axes of the actor. Empty: the actor's own frame, at its origin"""


class Ptz(TypedDict, total=False):
    """Of a camera: ptz."""

    preset: Literal["ideal", "dome", "cheap"]
    """`ideal`, `dome` or `cheap`: figures of a kind of head; what is given beside it counts"""
    pan_limits_deg: Union[list[float], None]
    """deg; [low, high] from `pose`, positive to the left; null: it turns without end"""
    tilt_limits_deg: list[float]
    """deg; [low, high] from `pose`, positive upwards"""
    zoom_max: float
    """1 to 100: focal length at the long end, of that at the wide end"""
    speed_deg_s: float
    """deg/s; 0.01 to 10000: of pan and of tilt, at most"""
    acceleration_deg_s2: float
    """deg/s2; 0.01 to 1e6: of both"""
    zoom_s: float
    """s; 0.01 to 60: from one end of the zoom to the other"""
    latency_s: float
    """s; 0 to 10: from a command to the begin of its motion"""
    stop_latency_s: float
    """s; 0 to 10: from a stop to the begin of braking"""
    quantum_deg: float
    """deg; 0 to 10: of the angles that it tells"""
    repeatability_deg: float
    """deg; 0 to 10: it stops at most so far from where it believes to be"""
    backlash_deg: float
    """deg; 0 to 10: play of its gears: where it stops depends on where it comes from"""
    proportional: bool
    """relative and continuous moves are slower by the zoom"""
    flip: bool
    """past straight up or down the picture is turned over and relative and continuous tilt with it"""
    seed: int
    """at least 0: of where it stops"""


class Clock(TypedDict, total=False):
    """Of a camera: clock."""

    state: Literal["free", "ntp", "ptp", "ptp_lost", "tai"]
    """`free`, `ntp`, `ptp`, `ptp_lost` or `tai`: what keeps it right: nothing, a server by NTP, a master by PTP, no longer a master; tai: a master by PTP whose TAI it takes for UTC"""
    offset_ns: int
    """ns; -2e18 to 2e18: it says so much more than the true time"""
    drift_ppb: int
    """ppb; -1e6 to 1e6: so many billionths faster, from world time 0 on; of state free"""
    walk_ns: int
    """ns; 0 to 1e6: standard deviation of its random walk after a second; grows with the root of the time; of state free"""
    jitter_ns: int
    """ns; 0 to 1e9: standard deviation of each stamp on its own; at most 3.5 of it"""
    step_ns: int
    """ns; -2e18 to 2e18: somebody sets it: so much is added from step_at_ns on"""
    step_at_ns: int
    """ns; 0 to 4.6e18: world time of that"""
    phase_ns: int
    """ns; 0 to 1e10: the camera exposes so much later than cameras of its rate do"""
    rate_ppb: int
    """ppb; -1e6 to 1e6: it exposes so many billionths more often than `fps` says"""
    trigger_jitter_ns: int
    """ns; 0 to 1e9: each exposure is late by 0 to this, at most half a period"""
    seed: int
    """at least 0: of all that is random in it"""


class Sensor(TypedDict, total=False):
    """Of a camera: sensor."""

    preset: Literal["ideal", "imx219", "imx477", "imx290", "ov9281", "imx249", "webcam"]
    """`ideal`, `imx219`, `imx477`, `imx290`, `ov9281`, `imx249` or `webcam`: figures of a sensor; what is given beside it counts"""
    filter: Literal["mono", "rgb", "rggb", "grbg", "gbrg", "bggr"]
    """`mono`, `rgb`, `rggb`, `grbg`, `gbrg` or `bggr`: of colours: none (mono), three photosites at each place (rgb), or a mosaic of Bayer"""
    exposure_s: Union[float, Literal["auto"]]
    """s; 1e-6 to 10: how long it counts"""
    gain_db: float
    """dB; 0 to 48: electrons are multiplied by 10^(dB/20) before they become numbers"""
    lux: Union[float, None]
    """lx; 0.0001 to 1e6: illuminance of the scene where white is drawn as white; null: white fills the wells in 10 ms"""
    full_well_e: float
    """e; 100 to 1e6: what a photosite holds"""
    read_noise_e: float
    """e; 0 to 1000: standard deviation"""
    dark_e_per_s: float
    """e/s; 0 to 100000: dark current"""
    quantum_efficiency: float
    """0 to 1: electrons a photon; counts where lux is given"""
    response_red: float
    """0.05 to 2: of a mosaic: electrons of white light under red, of those under green"""
    response_blue: float
    """0.05 to 2: the same of blue"""
    prnu: float
    """0 to 0.2: standard deviation of sensitivity between photosites"""
    dsnu_e: float
    """e; 0 to 1000: standard deviation of the offset between photosites"""
    row_noise_e: float
    """e; 0 to 1000: standard deviation of the offset of a row in a picture"""
    hot_pixels_ppm: float
    """0 to 10000: hot photosites of a million"""
    hot_e_per_s: float
    """e/s; 0 to 1e6: their mean dark current"""
    bits: int
    """8 to 16: of the converter"""
    black_level: Union[float, None]
    """0 to 16384: the number of no electrons, at most a quarter of the range; null: 1/16 of the range; 0 without noise"""
    f_number: float
    """0.5 to 64: counts where lux or focus_m is given"""
    focus_m: Union[float, None]
    """m; 0.01 to 1e6: what is so far along the optical axis is sharp, what is nearer or farther less; null: all is sharp"""
    pixel_pitch_m: float
    """m; 1e-7 to 0.001: of the picture's pixels; counts where lux or focus_m is given"""
    vignetting: float
    """0 to 4: 1 is the natural falloff of a lens, cos^4 of the angle"""
    white_balance: Union[float, Literal["auto"]]
    """K; 2000 to 12000: the light that is taken for white"""
    flicker_hz: float
    """Hz; 0 to 400: of the mains: automatic exposures last whole periods of its lamps; 0: any"""
    least_highlights: float
    """0 to 1: of automatic exposure: mean of the brightest 2 %, where the largest number is 1, that counts more than the mean of all; 0: none does"""
    readout_s: float
    """s; 0 to 0.2: rows begin one after the other in this time (rolling shutter); 0: all at once"""
    blur: bool
    """what moves while a row counts is smeared; false: sharp, as in the middle of it"""
    dynamic_framerate: bool
    """exposures may last longer than the camera's period, and its rate falls; automatic ones up to 0.2 s"""
    seed: int
    """at least 0: of all that is random"""


class PanoramaDetail(TypedDict, total=False):
    """Of a camera: details."""

    file: str
    """PNG or JPEG, beside `file` of the panorama; what is not wholly opaque is left out"""
    scale: int
    """2 to 64: 2, 4, 8, 16, 32 or 64: its pixels are those of a panorama with so many times the columns, 524288 of them at most"""
    at_px: list[float]
    """px; its upper left pixel in that larger panorama"""


class PictureLens(TypedDict, total=False):
    """Of a camera: lens."""

    model: Literal["pinhole", "plumb_bob", "rational_polynomial", "equidistant"]
    """`pinhole`, `plumb_bob`, `rational_polynomial` or `equidistant`: with k1 k2 p1 p2 k3 of plumb_bob, k1 k2 p1 p2 k3 k4 k5 k6 of rational_polynomial, k1 k2 k3 k4 of equidistant"""
    coefficients: list[float]
    """as many as the model has; pinhole has none"""


class GroundProxy(TypedDict, total=False):
    """Of a camera: ground."""

    polygon_m: list[list[float]]
    """m; its corners in the world"""
    polygon_px: list[list[float]]
    """px; instead: its corners in the picture, below the horizon"""
    z: float
    """m; -1e10 to 1e10: height of the ground"""
    role: Literal["both", "catcher", "holdout"]
    """`both`, `catcher` or `holdout`: both: it hides who goes behind it, and shadows fall on it; catcher: only shadows fall on it; holdout: it only hides"""


class BoxProxy(TypedDict, total=False):
    """Of a camera: boxes."""

    position: list[float]
    """m; the middle of its bottom"""
    size: list[float]
    """m; along its x, y and z"""
    yaw_deg: float
    """deg; -360 to 360: about z, counter-clockwise"""
    role: Literal["both", "catcher", "holdout"]
    """`both`, `catcher` or `holdout`: both: it hides who goes behind it, and shadows fall on it; catcher: only shadows fall on it; holdout: it only hides"""


class CutoutProxy(TypedDict, total=False):
    """Of a camera: cutouts."""

    polygon_px: list[list[float]]
    """px; its outline in the picture"""
    mask: str
    """instead: PNG of the picture's size, beside it; what is opaque or, if all of it is, light is cut out. Empty: none"""
    foot_px: list[float]
    """px; where it stands on the ground, below the horizon"""
    z: float
    """m; -1e10 to 1e10: height of the ground"""
    role: Literal["both", "catcher", "holdout"]
    """`both`, `catcher` or `holdout`: both: it hides who goes behind it, and shadows fall on it; catcher: only shadows fall on it; holdout: it only hides"""


class DepthProxy(TypedDict, total=False):
    """Of a camera: depth."""

    file: str
    """PNG of 16-bit gray of the picture's size, beside it; 0 where nothing is known or there"""
    unit_m: float
    """m; 1e-6 to 1000: of its numbers"""
    measure: Literal["z", "range"]
    """`z` or `range`: what they tell. z: along the camera's axis; range: from its eye"""
    role: Literal["both", "catcher", "holdout"]
    """`both`, `catcher` or `holdout`: both: it hides who goes behind it, and shadows fall on it; catcher: only shadows fall on it; holdout: it only hides"""


class WalkableGround(TypedDict, total=False):
    """Of a camera: walkable."""

    polygon_m: list[list[float]]
    """m; its corners in the world"""
    polygon_px: list[list[float]]
    """px; instead: its corners in the picture, below the horizon"""
    z: float
    """m; -1e10 to 1e10: height of the ground"""


class Proxies(TypedDict, total=False):
    """Of a camera: proxies."""

    file: str
    """.glb or .gltf, placed in the world as it is; beside `file` of the picture. Its nodes may say by extras.camrig_proxy what they are: ground, obstacle, wall, catcher, holdout or walkable. Empty: none"""
    ground: Union[GroundProxy, None]
    """a piece of level ground, by one of the polygons; null: none"""
    boxes: list[BoxProxy]
    """at most 200: that stand in the place"""
    cutouts: list[CutoutProxy]
    """at most 200: parts of the picture that stand upright where their foot is, and face the camera: trees, poles, fences"""
    depth: Union[DepthProxy, None]
    """how far away each pixel of the picture is; null: not known"""
    walkable: list[WalkableGround]
    """at most 200: pieces of level ground where people may go, as ground is given; routes and areas of the scene file that leave those of all cameras are errors. Empty: anywhere"""
    scene: Literal["drawn", "proxies", "hidden"]
    """`drawn`, `proxies` or `hidden`: what the scene's objects that stand still are. drawn: they are drawn into the picture; proxies: the picture shows them already; hidden: they are not in it"""


class PlateNoise(TypedDict, total=False):
    """Of a camera: noise."""

    k: float
    """0 to 10: how its variance grows with the level"""
    read: float
    """0 to 50: standard deviation at level 0, in codes of 255"""


class IgnoredRegion(TypedDict, total=False):
    """Of a camera: ignore."""

    polygon_px: list[list[float]]
    """px; its outline in the picture"""
    object_class: str
    """of 1 to 64 characters: of what the picture shows there"""


class Backdrop(TypedDict, total=False):
    """Of a camera: backdrop."""

    kind: Literal["plate", "film", "panorama", "projected"]
    """`plate`, `film`, `panorama` or `projected`: plate: one picture of a camera that stands still; film: a film of one, which is shown in step with world time, over and over; panorama: equirectangular, what is all around a camera that may turn and zoom; projected: one picture, laid on the proxies from where it was taken, for a camera that moves a little"""
    file: str
    """PNG or JPEG, or a film (MP4, Matroska, WebM, AVI, MPEG-TS, MJPEG), upright, of the camera's size or of one with the same sides, a panorama of any size twice as wide as high, a projected picture of any size; relative to the scene file, in its folder or below, or, of commands, an absolute path"""
    picture_size: list[int]
    """px; of the picture: that of all pixels here; 0 of a panorama"""
    fps: Union[Union[int, str], None]
    """1/s; of a film: how many of its pictures are shown in a second, 1/10 to 1000; null: as the film says"""
    yaw_deg: float
    """deg; -360 to 360: of a panorama: which way its middle looks, about z, counter-clockwise from +x"""
    details: list[PanoramaDetail]
    """at most 200: of a panorama: parts of it in finer pixels, for long lenses"""
    intrinsics: Union[Intrinsics, None]
    """px; of the picture's own pixels, see intrinsics; they take the place of the camera's, whatever its size (of a projected picture they are needed, and the camera has its own); null: the camera's are those of its size"""
    taken_from: Union[Pose, None]
    """of a projected picture: the pose of its camera, see pose; null: the kind is another one"""
    lens: Union[PictureLens, None]
    """of a projected picture: that of the camera that took it, see lens; null: the camera's own"""
    proxies: Proxies
    """shapes of what the picture shows: they hide what goes behind them"""
    shadow: Literal["none", "blob", "mapped"]
    """`none`, `blob` or `mapped`: of what moves, on what the picture shows. none; blob: about feet; mapped: of the scene's lights at quality beautiful, at simple as blob"""
    plate_gain: list[float]
    """factors on the light of what is drawn, red, green and blue, so that white is that of the picture"""
    edge_px: float
    """px; 0 to 3: what is drawn is made as soft as the picture: standard deviation of a Gaussian"""
    noise: Union[PlateNoise, None]
    """noise on what is drawn, as that of the picture: its standard deviation at a level of 0 to 255 is sqrt(read^2 + k * level); null: none"""
    ignore: list[IgnoredRegion]
    """at most 200: where the picture shows people or vehicles of its own, which truth does not know"""


class Lens(TypedDict, total=False):
    """Of a camera: lens."""

    model: Literal["pinhole", "plumb_bob", "rational_polynomial", "equidistant"]
    """`pinhole`, `plumb_bob`, `rational_polynomial` or `equidistant`: with k1 k2 p1 p2 k3 of plumb_bob, k1 k2 p1 p2 k3 k4 k5 k6 of rational_polynomial, k1 k2 k3 k4 of equidistant"""
    coefficients: list[float]
    """as many as the model has; pinhole has none"""
    method: Literal["auto", "warp", "cube"]
    """`auto`, `warp` or `cube`: what the picture is resampled from; warp: one larger pinhole picture, cube: the faces of a cube, auto: what needs fewer pixels"""
    filter: Literal["auto", "bilinear", "bicubic"]
    """`auto`, `bilinear` or `bicubic`: bicubic (Catmull-Rom) keeps more contrast; auto: bicubic at quality beautiful; ssaa always takes bilinear samples"""


class Controls(TypedDict, total=False):
    """Of a camera: controls."""

    auto_exposure: bool
    """the scene's exposure; off when exposure_ev is given"""
    exposure_ev: float
    """EV; -6 to 6: light is multiplied by 2^ev"""
    gain_db: float
    """dB; 0 to 24: light is multiplied by 10^(dB/20)"""
    auto_white_balance: bool
    """neutral; off when white_balance_k is given"""
    white_balance_k: float
    """K; 2800 to 10000: the light that is taken for white; lower makes bluer pictures"""
    brightness: float
    """-1 to 1: added to the sRGB codes (1: from black to white)"""
    contrast: float
    """0 to 2: about the middle code"""
    saturation: float
    """0 to 2: 0 is grey"""


class Output(TypedDict, total=False):
    """Of a camera: outputs."""

    kind: Literal["v4l2", "device", "rtsp", "mjpeg", "onvif"]
    """`v4l2`, `device`, `rtsp`, `mjpeg` or `onvif`"""
    number: int
    """0 to 255: of v4l2 and device: N of /dev/videoN"""
    format: Literal["YUYV", "YU12", "MJPG", "BGR3"]
    """`YUYV`, `YU12`, `MJPG` or `BGR3`: of v4l2"""
    subsampling: Literal["4:2:2", "4:2:0"]
    """`4:2:2` or `4:2:0`: of v4l2 and device: chroma of MJPG"""
    error_controls: bool
    """of device: it has V4L2 controls by which programs let it fail, with the names and numbers of the kernel's vivid (docs/faults.md)"""
    codec: Literal["h264", "h265", "mjpeg"]
    """`h264`, `h265` or `mjpeg`: of rtsp: main with mjpeg is a stream beside that of h264 or h265"""
    stream: Literal["main", "sub"]
    """`main` or `sub`: of rtsp"""
    size: list[int]
    """px; of rtsp: with stream sub, at most the camera's; by default half of it"""
    fps: Union[int, str]
    """1/s; of rtsp: 1/10 to 1000, at most the camera's; by default the camera's, of sub half of it"""
    quality: int
    """1 to 100: of rtsp and mjpeg: JPEG quality"""
    bitrate_kbps: int
    """kbit/s; 16 to 200000: of rtsp: with h264 and h265; by default 0.15 bits per pixel"""
    key_interval_s: float
    """s; 0.01 to 60: of rtsp: with h264 and h265: a key frame at least so often"""
    preset: Literal["ultrafast", "superfast", "veryfast", "faster", "fast", "medium", "slow"]
    """`ultrafast`, `superfast`, `veryfast`, `faster`, `fast`, `medium` or `slow`: of rtsp: with h264 and h265"""
    profile: Literal["baseline", "main", "high"]
    """`baseline`, `main` or `high`: of rtsp: with h264"""
    port: int
    """1 to 65535: of onvif: TCP port of the device, on the host of HTTP"""
    move_status: Literal["told", "none", "stuck"]
    """`told`, `none` or `stuck`: of onvif: whether the head moves is told as it is, not at all, or as MOVING for ever after the first move"""
    relative_fov: bool
    """of onvif: offers moves by field of view, which trackers need and many devices lack"""


class CameraOptions(TypedDict, total=False):
    """What Rig.create_camera and Camera.set take; what is left out stays as it is."""

    size: Sequence[int]
    """px; 16x16 to 8192x8192; default [640, 480]"""
    fps: Rate
    """1/s; 1/10 to 1000; default 25"""
    vfov_deg: float
    """deg; over 0.01 and below 179.9: vertical field of view, edge to edge; give hfov_deg or intrinsics instead; default 60"""
    hfov_deg: float
    """deg; over 0.01 and below 179.9: horizontal field of view, edge to edge"""
    intrinsics: Union[Intrinsics, Sequence[Sequence[float]], np.ndarray]
    """px; see intrinsics; in an answer, as they follow from the above and zoom"""
    zoom: float
    """1 to 10: scales the focal length; optics are given as they are at the zoom given with them, else at 1; default 1"""
    position: Vector
    """m; where it is"""
    look_at: Vector
    """m; the point in the middle of the picture; the horizon stays level"""
    pan_deg: float
    """deg; about world z, counter-clockwise from above; 0 looks along +x; default 0"""
    tilt_deg: float
    """deg; positive looks up; default 0"""
    roll_deg: float
    """deg; about the viewing direction, clockwise seen from behind the camera; default 0"""
    orientation: Vector
    """quaternion of the body frame: x forward, y left, z up"""
    mount: Union[Union[Mount, str], None]
    """see mount; null: on nothing, where `pose` is in the world; default null"""
    ptz: Union[Ptz, None]
    """the head that turns and zooms it, see ptz; `pose` is where it looks at pan and tilt 0; null: no head; default null"""
    clock: Union[Clock, None]
    """its own clock, see clock: what its stamps say and when it exposes, each wrong on its own; null: none, it is right; default null"""
    sensor: Union[Sensor, None]
    """counts electrons as a real camera does, see sensor: exposure, noise, saturation, raw numbers; null: none: light of 1 is white; default null"""
    backdrop: Union[Backdrop, None]
    """a picture of a real place that people walk in, see backdrop; null: the scene's own objects are what it sees; default null"""
    lens: Union[Lens, str, tuple[str, Vector]]
    """see lens; default pinhole"""
    antialias: Literal["none", "coverage", "msaa4", "ssaa2", "ssaa3", "ssaa4", "auto"]
    """`none`, `coverage`, `msaa4`, `ssaa2`, `ssaa3`, `ssaa4` or `auto`: samples of a pixel of the colour picture; coverage: each surface by how much of the pixel it covers, of 64 places, shaded once (as msaa4 on a GPU), msaa4: four coverage samples, ssaa2 to ssaa4: 2x2 to 4x4 full samples, auto: coverage at quality beautiful up to 4 megapixels, else none; default auto"""
    near: float
    """m; over 0 and at most 1e6: nearest distance drawn; default 0.05"""
    far: float
    """m; at least 0: farthest distance drawn, over near; 0: no limit; default 0"""
    quality: Union[Literal["fast", "simple", "beautiful"], None]
    """`fast`, `simple` or `beautiful`; null: the rig's; default null"""
    exposure_ev: float
    """EV; -20 to 20: stops by which it is exposed more than the scene's `exposure` has it, before anything is cut at white; of cameras without sensor and backdrop; default 0"""
    controls: Controls
    """see controls; what is not given in it stays"""
    code_strip: bool
    """draws camera number, sequence and world time into the picture; needs 128x32 pixels; default false"""
    clock_text: bool
    """burns days, hours, minutes and seconds of world time as its clock has it into the lower left corner of the picture; needs 128x32 pixels; default false"""
    description: str
    """of at most 200 characters: free text of yours: where it hangs, what it is for; default """""
    group: str
    """of at most 24 characters: a name of yours: of cameras with the same (a stereo pair) the pictures of an instant are all drawn or all dropped; default """""
    outputs: Iterable[Union[Output, str]]
    """at most 16, no two the same, all of them given; see outputs; default []"""


class CameraState(TypedDict):
    """What Camera.get answers."""

    name: str
    """`[a-z0-9_]{1,24}`"""
    size: list[int]
    """px; 16x16 to 8192x8192"""
    fps: Union[int, str]
    """1/s; 1/10 to 1000"""
    vfov_deg: float
    """deg; over 0.01 and below 179.9: vertical field of view, edge to edge; give hfov_deg or intrinsics instead"""
    hfov_deg: float
    """deg; over 0.01 and below 179.9: horizontal field of view, edge to edge"""
    intrinsics: Intrinsics
    """px; see intrinsics; in an answer, as they follow from the above and zoom"""
    zoom: float
    """1 to 10: scales the focal length; optics are given as they are at the zoom given with them, else at 1"""
    pose: Pose
    """see pose; in the frame of its mount, if it has one. A camera without it and without a `place` is at the origin and looks along +x"""
    mount: Union[Mount, None]
    """see mount; null: on nothing, where `pose` is in the world"""
    ptz: Union[Ptz, None]
    """the head that turns and zooms it, see ptz; `pose` is where it looks at pan and tilt 0; null: no head"""
    clock: Union[Clock, None]
    """its own clock, see clock: what its stamps say and when it exposes, each wrong on its own; null: none, it is right"""
    sensor: Union[Sensor, None]
    """counts electrons as a real camera does, see sensor: exposure, noise, saturation, raw numbers; null: none: light of 1 is white"""
    backdrop: Union[Backdrop, None]
    """a picture of a real place that people walk in, see backdrop; null: the scene's own objects are what it sees"""
    lens: Lens
    """see lens"""
    antialias: Literal["none", "coverage", "msaa4", "ssaa2", "ssaa3", "ssaa4", "auto"]
    """`none`, `coverage`, `msaa4`, `ssaa2`, `ssaa3`, `ssaa4` or `auto`: samples of a pixel of the colour picture; coverage: each surface by how much of the pixel it covers, of 64 places, shaded once (as msaa4 on a GPU), msaa4: four coverage samples, ssaa2 to ssaa4: 2x2 to 4x4 full samples, auto: coverage at quality beautiful up to 4 megapixels, else none"""
    near: float
    """m; over 0 and at most 1e6: nearest distance drawn"""
    far: float
    """m; at least 0: farthest distance drawn, over near; 0: no limit"""
    quality: Union[Literal["fast", "simple", "beautiful"], None]
    """`fast`, `simple` or `beautiful`; null: the rig's"""
    exposure_ev: float
    """EV; -20 to 20: stops by which it is exposed more than the scene's `exposure` has it, before anything is cut at white; of cameras without sensor and backdrop"""
    controls: Controls
    """see controls; what is not given in it stays"""
    code_strip: bool
    """draws camera number, sequence and world time into the picture; needs 128x32 pixels"""
    clock_text: bool
    """burns days, hours, minutes and seconds of world time as its clock has it into the lower left corner of the picture; needs 128x32 pixels"""
    description: str
    """of at most 200 characters: free text of yours: where it hangs, what it is for"""
    group: str
    """of at most 24 characters: a name of yours: of cameras with the same (a stereo pair) the pictures of an instant are all drawn or all dropped"""
    outputs: list[Output]
    """at most 16, no two the same, all of them given; see outputs"""
    world_pose: Pose
    """where it is in the world, as pose; of a mounted camera, at its latest due frame"""
    shown_intrinsics: Intrinsics
    """px; intrinsics of its picture now, with what its head zooms"""
    id: int
    """one life of a camera; never used again"""
    sequence: int
    """number of its latest due frame"""
    readers: int
    """how many watch it now"""
    applied_ns: int
    """ns; world time from which this state shows"""
    arrives_ns: int
    """ns; world time from which it is where its last command sent it"""


Attachment = TypedDict("Attachment", {"actor": str, "node": str, "position": Vector, "yaw_deg": float, "orientation": Vector}, total=False)
StandBehaviour = TypedDict("StandBehaviour", {"type": Literal["stand"], "clip": str}, total=False)
RouteBehaviour = TypedDict("RouteBehaviour", {"type": Literal["route"], "route": str, "speed": float, "start_m": float, "mode": Literal["loop", "ping_pong", "once"], "clip": str}, total=False)
GoToBehaviour = TypedDict("GoToBehaviour", {"type": Literal["go_to"], "position": Vector, "yaw_deg": float, "area": str, "speed": float, "clip": str, "idle_clip": str}, total=False)
WanderBehaviour = TypedDict("WanderBehaviour", {"type": Literal["wander"], "pause_s": float, "area": str, "speed": float, "clip": str, "idle_clip": str}, total=False)
LookAtBehaviour = TypedDict("LookAtBehaviour", {"type": Literal["look_at"], "actor": str, "position": Vector, "clip": str}, total=False)
FollowBehaviour = TypedDict("FollowBehaviour", {"type": Literal["follow"], "actor": str, "distance_m": float, "area": str, "speed": float, "clip": str, "idle_clip": str}, total=False)
GroupBehaviour = TypedDict("GroupBehaviour", {"type": Literal["group"], "group": str, "position": Vector, "radius_m": float, "area": str, "speed": float, "clip": str, "idle_clip": str}, total=False)
VehicleBehaviour = TypedDict("VehicleBehaviour", {"type": Literal["vehicle"], "route": str, "speed": float, "start_m": float, "length_m": float, "width_m": float, "headway_s": float, "gap_m": float, "acceleration": float, "braking": float, "clip": str}, total=False)
SteeredBehaviour = TypedDict("SteeredBehaviour", {"type": Literal["steered"], "clip": str}, total=False)
SequenceBehaviour = TypedDict("SequenceBehaviour", {"type": Literal["sequence"], "steps": Sequence[Mapping[str, Any]], "repeat": bool}, total=False)
Behaviour = Union[StandBehaviour, RouteBehaviour, GoToBehaviour, WanderBehaviour, LookAtBehaviour, FollowBehaviour, GroupBehaviour, VehicleBehaviour, SteeredBehaviour, SequenceBehaviour]
AtSTrigger = TypedDict("AtSTrigger", {"at_s": float}, total=False)
EverySTrigger = TypedDict("EverySTrigger", {"every_s": float, "from_s": float}, total=False)
EnterTrigger = TypedDict("EnterTrigger", {"enter": str, "actor": str, "class": str}, total=False)
LeaveTrigger = TypedDict("LeaveTrigger", {"leave": str, "actor": str, "class": str}, total=False)
MeetTrigger = TypedDict("MeetTrigger", {"meet": Sequence[str], "distance_m": float}, total=False)
EventTrigger = TypedDict("EventTrigger", {"event": str, "after_s": float}, total=False)
ArrivedTrigger = TypedDict("ArrivedTrigger", {"arrived": str}, total=False)
Trigger = Union[AtSTrigger, EverySTrigger, EnterTrigger, LeaveTrigger, MeetTrigger, EventTrigger, ArrivedTrigger]
BehaveAction = TypedDict("BehaveAction", {"action": Literal["behave"], "actor": str, "behaviour": Behaviour}, total=False)
StopAction = TypedDict("StopAction", {"action": Literal["stop"], "actor": str, "clip": str}, total=False)
StartAction = TypedDict("StartAction", {"action": Literal["start"], "actor": str}, total=False)
PlayAction = TypedDict("PlayAction", {"action": Literal["play"], "actor": str, "clip": str, "speed": float, "seconds": float}, total=False)
SpawnAction = TypedDict("SpawnAction", {"action": Literal["spawn"], "actor": Mapping[str, Any]}, total=False)
RemoveAction = TypedDict("RemoveAction", {"action": Literal["remove"], "actor": str}, total=False)
PickUpAction = TypedDict("PickUpAction", {"action": Literal["pick_up"], "object": str, "actor": str, "node": str, "position": Vector, "yaw_deg": float, "orientation": Vector}, total=False)
PutDownAction = TypedDict("PutDownAction", {"action": Literal["put_down"], "object": str, "position": Vector}, total=False)
LightAction = TypedDict("LightAction", {"action": Literal["light"], "light": str, "intensity": float, "candela": float, "lux": float, "color": Vector, "flicker_hz": float, "seconds": float}, total=False)
EnvironmentAction = TypedDict("EnvironmentAction", {"action": Literal["environment"], "background": Vector, "sky": Vector, "ground": Vector, "exposure": float, "glow": float, "daylight": Mapping[str, Any], "fog": Mapping[str, Any]}, total=False)
CameraAction = TypedDict("CameraAction", {"action": Literal["camera"], "camera": str, "pose": Mapping[str, Any], "vfov_deg": float, "clock": Mapping[str, Any], "seconds": float}, total=False)
FaultAction = TypedDict("FaultAction", {"action": Literal["fault"], "camera": str, "kind": Literal["knock", "sag", "vibration", "defocus", "dirt", "drops", "condensation", "covered", "exposure", "white_balance", "chroma_lost", "noise", "banding", "dead_pixels", "dead_rows", "mirrored", "upside_down", "tearing", "black", "freeze", "duplicate", "reduced_rate", "drop", "late", "corrupt_jpeg", "other_size", "stall", "disconnect", "refuse", "restart", "bandwidth", "cut_part", "packet_loss", "packet_reorder", "packet_delay", "new_ssrc", "bad_part", "corrupt_video", "buffer_error", "wrong_size", "device_error", "unplug"], "params": Mapping[str, Any], "severity": float, "seed": int, "seconds": float}, total=False)
ClearFaultAction = TypedDict("ClearFaultAction", {"action": Literal["clear_fault"], "camera": str, "kind": Literal["knock", "sag", "vibration", "defocus", "dirt", "drops", "condensation", "covered", "exposure", "white_balance", "chroma_lost", "noise", "banding", "dead_pixels", "dead_rows", "mirrored", "upside_down", "tearing", "black", "freeze", "duplicate", "reduced_rate", "drop", "late", "corrupt_jpeg", "other_size", "stall", "disconnect", "refuse", "restart", "bandwidth", "cut_part", "packet_loss", "packet_reorder", "packet_delay", "new_ssrc", "bad_part", "corrupt_video", "buffer_error", "wrong_size", "device_error", "unplug"]}, total=False)
UserAction = TypedDict("UserAction", {"action": Literal["user"], "data": Any}, total=False)
Action = Union[BehaveAction, StopAction, StartAction, PlayAction, SpawnAction, RemoveAction, PickUpAction, PutDownAction, LightAction, EnvironmentAction, CameraAction, FaultAction, ClearFaultAction, UserAction]


class ActorOptions(TypedDict, total=False):
    """What Rig.spawn_actor takes."""

    object_class: str
    """what ground truth calls it, as `person`; default object"""
    position: Vector
    """m; of its origin; where a route does not place it; default [0, 0, 0]"""
    yaw_deg: float
    """deg; where its front looks, counter-clockwise from +x; or orientation"""
    orientation: Vector
    """instead of yaw_deg"""
    scale: float
    """1e-6 to 1e6: of the model; default 1"""
    variant: int
    """at least 0: which of the looks of its model: colors and what it wears follow from this number; default none: as its file has it"""
    radius_m: float
    """m; 0 to 100: of its body, for those who walk round it; default 0.28 for class person, else 0"""
    attach: Attachment
    """hangs it on a node of another actor: {actor, node, position, yaw_deg or orientation}"""
    behaviour: Behaviour
    """see behaviours; default {"type": "stand"}"""


class ActorChanges(TypedDict, total=False):
    """What Rig.set_actor takes; what is left out stays as it is."""

    position: Vector
    """m; of its origin"""
    yaw_deg: float
    """deg; where its front looks, counter-clockwise from +x; or orientation"""
    orientation: Vector
    """instead of yaw_deg"""
    variant: int
    """at least 0: which of the looks of its model: colors and what it wears follow from this number"""
    behaviour: Behaviour
    """see behaviours"""
    attach: Attachment
    """hangs it on a node of another actor: {actor, node, position, yaw_deg or orientation}"""
    detach: bool
    """no longer hangs on anything; default false"""
    play: str
    """a clip over the one of the behaviour; empty: no longer"""
    play_speed: float
    """0 to 100: of that clip; default 1"""


class Steering(TypedDict, total=False):
    """What Rig.steer takes of each actor."""

    velocity: Vector
    """m/s; held until it is told another"""
    position: Vector
    """m; instead of a velocity: reached after `seconds`"""
    seconds: float
    """s; 0 to 3600; default 0: at once"""
    yaw_deg: float
    """deg; where its front looks; default the way it moves"""
    clip: str
    """that it plays; default as it is"""


# Each option, its JSON type, and the object of the protocol that it is in.
CAMERA_OPTIONS: dict[str, tuple[str, str]] = {
    "size": ("[width, height]", ""),
    "fps": ('number or "num/den"', ""),
    "vfov_deg": ("number", ""),
    "hfov_deg": ("number", ""),
    "intrinsics": ("object", ""),
    "zoom": ("number", ""),
    "position": ("[x, y, z]", "pose"),
    "look_at": ("[x, y, z]", "pose"),
    "pan_deg": ("number", "pose"),
    "tilt_deg": ("number", "pose"),
    "roll_deg": ("number", "pose"),
    "orientation": ("[x, y, z, w]", "pose"),
    "mount": ("object or null", ""),
    "ptz": ("object or null", ""),
    "clock": ("object or null", ""),
    "sensor": ("object or null", ""),
    "backdrop": ("object or null", ""),
    "lens": ("object", ""),
    "antialias": ("string", ""),
    "near": ("number", ""),
    "far": ("number", ""),
    "quality": ("string or null", ""),
    "exposure_ev": ("number", ""),
    "controls": ("object", ""),
    "code_strip": ("boolean", ""),
    "clock_text": ("boolean", ""),
    "description": ("string", ""),
    "group": ("string", ""),
    "outputs": ("array of objects", ""),
}

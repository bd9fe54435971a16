"""Colour, JPEG quality and H.264 presets: what the way out of the rig costs in likeness, bytes and time."""

import base64
import pathlib
import subprocess
import tempfile
import time

import cv2
import numpy as np
from camrig_assets.glb import Glb
from camrig_assets.scene import Scene

from . import REPOSITORY, measure, quality
from .lenses import Camera
from .part_sampling import LOBBY, moved

HALL = REPOSITORY / "scenes" / "hall.json"
CELL_PX, COLUMNS, ROWS = 16, 40, 30


def patches_scene(folder, seed):
    """A chart of flat colours, one cell of 16 x 16 px each for the camera of `chart`."""
    random = np.random.default_rng(seed)
    glb = Glb("patches")
    grid = [(r, g, b) for r in (0, 255) for g in (0, 255) for b in (0, 255)] + [(v, v, v) for v in range(0, 256, 17)]
    colours = np.array(grid + [tuple(random.integers(0, 256, 3)) for _ in range(COLUMNS * ROWS - len(grid))])
    from .estimator import LINEAR

    parts = []
    for i, colour in enumerate(colours):
        row, column = divmod(i, COLUMNS)
        x, y = (column - COLUMNS / 2) * CELL_PX / 512, (ROWS / 2 - row - 1) * CELL_PX / 512
        s = CELL_PX / 512
        material = glb.material(f"c{i}", base=tuple(LINEAR[colour]), unlit=True, double_sided=True)
        corners = [(x, y, 0), (x + s, y, 0), (x + s, y + s, 0), (x, y + s, 0)]
        parts.append(glb.primitive(corners, [(0, 0, 1)] * 4, [(0, 1, 2), (0, 2, 3)], material))
    glb.node("patches", mesh=glb.mesh("patches", parts))
    (folder / "patches.glb").write_bytes(glb.bytes())
    scene = Scene("patches", "Flat colours.", seed=1)
    scene.environment(background=(0, 0, 0), sky=(1, 1, 1), ground=(1, 1, 1))
    scene.model("patches", "patches.glb")
    scene.object("patches", "patches", "patches", (1, 0, 0), -90)
    path = folder / f"patches-{seed}.json"
    path.write_bytes(scene.text())
    return path


# At 1 m, one cell is one 16 x 16 block of JPEG with half as many chroma samples.
CHART = Camera("chart", fx=512, fy=512)


def patch_codes(image):
    """The pixels (cells, 64, B G R) in the middle of every cell."""
    cells = image.reshape(ROWS, CELL_PX, COLUMNS, CELL_PX, 3).swapaxes(1, 2).reshape(-1, CELL_PX, CELL_PX, 3)
    return cells[:, 4:12, 4:12].reshape(len(cells), -1, 3)


def colour_errors(rig, decode, seeds=range(1, 7)):
    """Codes (N, 3), decoded minus drawn, of flat patches; `decode(cam)` gets the picture through an output."""
    errors = []
    for seed in seeds:
        rig.load(patches_scene(rig.folder, seed))
        cam = measure.new_camera(rig, **CHART.options(), position=(0, 0, 0))
        drawn = patch_codes(cam.frame().image)
        if np.ptp(drawn, axis=1).any():
            raise ValueError("the chart's patches are not flat in the drawn picture")
        decoded = patch_codes(decode(cam)).astype(int)
        errors.append((decoded - drawn.astype(int)).reshape(-1, 3))
    return np.concatenate(errors)


def jpeg_of(cam, level):
    reply = cam._rig.call("frame.get", camera=cam.name, format="jpeg", quality=level)
    return base64.b64decode(reply["data"])


def decode_jpeg(cam, level=100):
    return cv2.imdecode(np.frombuffer(jpeg_of(cam, level), np.uint8), cv2.IMREAD_COLOR)


def colour(section, quick):
    with measure.rig_of() as rig:
        jpeg = colour_errors(rig, decode_jpeg)
        png = colour_errors(rig, lambda cam: cam.frame(format="png").image[:, :, :3])
    rows = [
        ("PNG, raw", "sRGB", "", int(np.abs(png).max()), float(np.abs(png.mean(axis=0)).max())),
        ("JPEG and MJPEG, quality 100, decoded by libjpeg-turbo", "BT.601 full (JFIF)", "4:2:0, centred", int(np.abs(jpeg).max()), float(np.abs(jpeg.mean(axis=0)).max())),
    ]
    section.say(f"Flat patches of {len(jpeg) // 64} colours, drawn unlit, through the output and a stock decoder, decoded minus drawn:")
    section.table(("output", "matrix and range", "chroma", "largest error, codes", "bias, codes"), rows)
    section.gate("JPEG, flat colours, largest error", np.abs(jpeg).max(), 2, "codes, exclusive")
    section.gate("JPEG, flat colours, bias", np.abs(jpeg.mean(axis=0)).max(), 0.02, "codes")


def stage(rig, name):
    for entry in rig.stats()["stages"]:
        if entry["name"] == name:
            return entry["count"], entry["count"] * entry["mean_ms"]
    return 0, 0.0


def jpeg(section, quick):
    levels = (50, 75, 90, 100) if quick else (30, 50, 60, 70, 75, 80, 85, 90, 93, 95, 97, 98, 99, 100)
    rows = []
    with measure.rig_of(HALL) as rig:
        camera = Camera("hall", fx=480, fy=480)
        cam = measure.new_camera(rig, **camera.options(), **LOBBY, antialias="ssaa2")
        raw = cam.frame().image
        for level in levels:
            data = jpeg_of(cam, level)
            picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
            rows.append((level, len(data), quality.psnr(picture, raw), quality.ssim(picture, raw), encode_ms(rig, cam, level, 8 if quick else 20)))
    section.say("One 640x480 picture of the hall (ssaa2). Likeness to the raw picture; time is the rig's own encoding stage, mean over many pictures of one run.")
    section.table(("quality", "bytes", "PSNR, dB", "SSIM", "encode, ms"), [(q, b, p, f"{s:.4f}", m) for q, b, p, s, m in rows])

    def draw(_, axes):
        axes.plot([r[4] for r in rows], [r[2] for r in rows], "o-")
        for r in rows[:: 1 if quick else 2]:
            axes.annotate(f"q{r[0]}\n{r[1] // 1024} KiB", (r[4], r[2]), fontsize=7, xytext=(4, -12), textcoords="offset points")
        axes.set(xlabel="encoding one 640x480 picture, ms", ylabel="PSNR, dB")

    section.plot("jpeg", draw, "Speed against likeness of JPEG qualities (labels: quality and size)")


def encode_ms(rig, cam, level, frames):
    """Mean of the encoding stage over `frames` pictures of this quality."""
    before = stage(rig, "encode")
    for i in range(frames):
        cam.set(**moved(LOBBY, i))
        jpeg_of(cam, level)
    cam.set(**LOBBY)
    after = stage(rig, "encode")
    count = after[0] - before[0]
    return (after[1] - before[1]) / count if count else float("nan")


def h264(section, quick):
    presets = ("ultrafast", "veryfast", "medium") if quick else ("ultrafast", "superfast", "veryfast", "faster", "fast", "medium")
    frames = 25 if quick else 75
    rows = []
    with tempfile.TemporaryDirectory(prefix="camrig-accuracy-") as folder, measure.rig_of(HALL) as rig:
        camera = Camera("hall", fx=480, fy=480)
        cam = measure.new_camera(rig, **camera.options(), fps=25, **LOBBY, antialias="ssaa2")
        pictures = []
        for _ in range(frames):
            rig.step(nanoseconds=40_000_000)
            pictures.append(cam.frame().image)
        raw = pathlib.Path(folder) / "raw.bgr"
        raw.write_bytes(b"".join(p.tobytes() for p in pictures))
        source = ["-f", "rawvideo", "-pix_fmt", "bgr24", "-s", "640x480", "-r", "25", "-i", str(raw)]
        to_yuv = ["-vf", "scale=out_color_matrix=bt601:out_range=tv:flags=accurate_rnd+full_chroma_int", "-pix_fmt", "yuv420p"]
        planes = pathlib.Path(folder) / "raw.yuv"
        _ffmpeg(*source, *to_yuv, "-f", "rawvideo", str(planes))
        for preset in presets:
            coded = pathlib.Path(folder) / f"{preset}.h264"
            start = time.perf_counter()
            _ffmpeg("-f", "rawvideo", "-pix_fmt", "yuv420p", "-s", "640x480", "-r", "25", "-i", str(planes), "-c:v", "libx264", "-preset", preset, "-tune", "zerolatency", "-b:v", "2M", "-threads", "1", "-f", "h264", str(coded))
            cost = (time.perf_counter() - start) * 1e3 / frames
            decoded = pathlib.Path(folder) / "decoded.yuv"
            _ffmpeg("-i", str(coded), "-pix_fmt", "yuv420p", "-f", "rawvideo", str(decoded))
            a = np.frombuffer(planes.read_bytes(), np.uint8).reshape(frames, -1)[:, : 640 * 480]
            b = np.frombuffer(decoded.read_bytes(), np.uint8).reshape(frames, -1)[:, : 640 * 480]
            psnr = float(np.mean([quality.psnr(x, y) for x, y in zip(a, b)]))
            ssim = float(np.mean([quality.ssim(*(cv2.cvtColor(i.reshape(480, 640), cv2.COLOR_GRAY2BGR) for i in pair)) for pair in list(zip(a, b))[::5]]))
            rows.append((preset, coded.stat().st_size * 8 * 25 / frames / 1e6, psnr, ssim, cost))
    section.say(
        f"{frames} frames of the hall with people walking, 640x480 at 25 frames/s, by x264 through ffmpeg, one thread, `-tune zerolatency`, 2 Mbit/s asked for: the rig's own encoder, outside of it. "
        "Likeness of luma to the frames before encoding; time is ffmpeg's, start and reading included. What the rig's RTSP server makes of a preset is in streams.md."
    )
    section.table(("preset", "Mbit/s", "PSNR, dB", "SSIM", "ms a frame"), [(n, r, p, f"{s:.4f}", m) for n, r, p, s, m in rows])

    def draw(_, axes):
        axes.plot([r[4] for r in rows], [r[2] for r in rows], "o-")
        for r in rows:
            axes.annotate(r[0], (r[4], r[2]), fontsize=8, xytext=(4, -10), textcoords="offset points")
        axes.set(xlabel="encoding one 640x480 frame, ms, one thread", ylabel="PSNR of luma, dB")

    section.plot("h264", draw, "Speed against likeness of x264 presets at 2 Mbit/s")


def _ffmpeg(*arguments):
    done = subprocess.run(["ffmpeg", "-v", "error", "-y", *arguments], capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"ffmpeg: {done.stderr.strip()}")

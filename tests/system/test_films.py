"""Cameras whose picture is a film that people walk in, or a panorama that they turn before."""

import struct
import subprocess

import cv2
import numpy as np
import pytest

import camrig

SIZE = (320, 240)
GROUND = {"ground": {"polygon_m": [[1, -30], [60, -30], [60, 30], [1, 30]]}}
POSE = {"position": (0, 0, 3), "pan_deg": 0, "tilt_deg": -10}


def film(path, frames, *options, layout="bgr24", size=SIZE, rate="25"):
    """A film of these frames, encoded by ffmpeg without loss if the options say so."""
    data = b"".join(np.ascontiguousarray(frame).tobytes() for frame in frames)
    command = ["ffmpeg", "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", layout, "-s", f"{size[0]}x{size[1]}",
               "-r", rate, "-i", "-", *options, str(path)]
    subprocess.run(command, input=data, check=True, timeout=60)
    return path


def gray_film(path, count, *options, rate="25", size=(64, 48)):
    """Picture n has the luma 40 + 4n, limited range: its code is (24 + 4n) * 255 / 219."""
    frames = [np.full(size[0] * size[1] * 3 // 2, 128, np.uint8) for _ in range(count)]
    for n, frame in enumerate(frames):
        frame[:size[0] * size[1]] = 40 + 4 * n
    return film(path, frames, *options, layout="yuv420p", size=size, rate=rate)


def tagged(matrix, is_full):
    """Options of ffmpeg for a film that holds the planes that it is given, and says that they are of this matrix and range.

    What comes in is said to be so too: of planes of no known matrix ffmpeg 7 makes those of the matrix that is asked for."""
    tags = {"colorspace": matrix, "color_primaries": matrix, "color_trc": matrix}
    told = [f"range={'full' if is_full else 'limited'}", *(f"{name}={tag}" for name, tag in tags.items())]
    return ("-vf", "setparams=" + ":".join(told), *(part for name, tag in tags.items() for part in (f"-{name}", tag)),
            "-color_range", "pc" if is_full else "tv")


def quarter_turned(film):
    """An MP4 film whose track header (tkhd, ISO/IEC 14496-12, 8.3.2) asks for a turn by 90 degrees when it is shown."""
    matrix = film.index(b"tkhd") + 44
    one, turn = ((0x10000, 0, 0, 0, 0x10000, 0, 0, 0, 1 << 30), (0, 0x10000, 0, -0x10000, 0, 0, 0, 0, 1 << 30))
    assert film[matrix:matrix + 36] == struct.pack(">9i", *one)
    return film[:matrix] + struct.pack(">9i", *turn) + film[matrix + 36:]


H264 = ("-c:v", "libx264", "-qp", "0", "-pix_fmt", "yuv420p", "-g", "9", "-bf", "3")


@pytest.mark.camrig(scene="street", mode="lockstep", seed=5)
@pytest.mark.parametrize("quality", ["fast", "beautiful"])
def test_each_picture_of_a_film_is_a_plate(rig, tmp_path, quality):
    """Pictures, depth and ids are those of a camera with that picture alone; what is drawn into it stays in it."""
    rng = np.random.default_rng(3)
    frames = [rng.integers(0, 256, (240, 320, 3), np.uint8) for _ in range(3)]
    path = film(tmp_path / "noise.mkv", frames, "-c:v", "ffv1", "-pix_fmt", "bgr0")
    common = {"place": "corner", "size": SIZE, "fps": 25, "quality": quality, "antialias": "none"}
    for n, frame in enumerate(frames):
        cv2.imwrite(str(tmp_path / f"{n}.png"), frame)
    for scene in ("proxies", "drawn"):
        proxies = {"scene": scene, "boxes": [{"position": [300, 0, 0], "size": [1, 1, 1]}]}
        plates = [rig.create_camera(f"{scene}{n}", **common, backdrop={"file": str(tmp_path / f"{n}.png"), "proxies": proxies})
                  for n in range(3)]
        cam = rig.create_camera(scene, **common, backdrop={"kind": "film", "file": str(path), "fps": "20", "proxies": proxies})
        for _ in range(5):
            rig.step(seconds=0.08)
            truth = cam.truth()
            shown = truth["time_ns"] * 20 // 10**9 % 3
            assert (truth["backdrop_frame"], truth["backdrop_late"]) == (shown, 0)
            assert truth["backdrop"]["kind"] == "film" and plates[0].truth()["backdrop_frame"] is None
            assert np.array_equal(cam.frame().image, plates[shown].frame().image)
            assert not np.array_equal(cam.frame().image, frames[shown])
            for kind in ("depth", "instance", "normal"):
                assert np.array_equal(cam.frame(kind=kind).image, plates[shown].frame(kind=kind).image), kind


@pytest.mark.camrig(scene="minimal", mode="lockstep")
def test_the_picture_follows_from_world_time_in_whole_numbers(rig, tmp_path):
    """Whatever the rates are, and wherever time goes: with pictures that need those before and after them."""
    path = gray_film(tmp_path / "steps.mp4", 40, *H264, rate="30000/1001")
    backdrop = {"kind": "film", "file": str(path), "proxies": GROUND}
    cams = {fps: rig.create_camera(f"cam{n}", size=(64, 48), fps=fps, **POSE, backdrop=backdrop)
            for n, fps in enumerate(("25", "60", "1/10"))}
    for actor in rig.actors():
        rig.remove_actor(actor["name"])
    for seconds in (0.04, 0.04, 0.5, 1.24, 0.02, 0.1, 601.3, 0.04, 0.04):
        rig.step(seconds=seconds)
        for fps, cam in cams.items():
            frame, truth = cam.frame(), cam.truth()
            # Of pictures that are due at whole nanoseconds, rounded down.
            shown = (-(-(truth["time_ns"] + 1) * 30000 // (1001 * 10**9)) - 1) % 40
            assert truth["backdrop_frame"] == shown, fps
            assert np.abs(frame.image.astype(float)[:10] - (24 + 4 * shown) * 255 / 219).max() <= 1, fps


@pytest.mark.camrig(scene="minimal", mode="lockstep")
@pytest.mark.parametrize("matrix, is_full, codec", [
    ("bt709", False, "h264"), ("bt709", True, "h264"), ("smpte170m", False, "h264"), ("smpte170m", True, "h264"),
    ("smpte170m", True, "mjpeg")])
def test_colours_are_those_of_its_matrix_and_range(rig, tmp_path, matrix, is_full, codec):
    """ITU-R BT.601-7 and BT.709-6 from luma and chroma that are known."""
    lumas, blues, reds = [60, 120, 180, 200], [90, 128, 150, 100], [160, 128, 110, 140]
    planes = [np.repeat(np.array(values, np.uint8), 16)[None].repeat(48, 0) for values in (lumas, blues, reds)]
    codecs = {"h264": ("-c:v", "libx264", "-qp", "0", "-pix_fmt", "yuv444p"), "mjpeg": ("-c:v", "mjpeg", "-q:v", "1", "-pix_fmt", "yuvj444p")}
    path = film(tmp_path / "colours.mkv", [np.stack(planes)] * 3, *tagged(matrix, is_full), *codecs[codec], layout="yuv444p", size=(64, 48))
    kr, kb = (0.2126, 0.0722) if matrix == "bt709" else (0.299, 0.114)
    y, b, r = (np.array(values, float) for values in (lumas, blues, reds))
    y, b, r = (y / 255, (b - 128) / 255, (r - 128) / 255) if is_full else ((y - 16) / 219, (b - 128) / 224, (r - 128) / 224)
    red, blue = y + 2 * (1 - kr) * r, y + 2 * (1 - kb) * b
    green = (y - kr * red - kb * blue) / (1 - kr - kb)
    codes = 255 * np.clip(np.stack([blue, green, red], -1), 0, 1)
    cam = rig.create_camera("cam", size=(64, 48), fps=25, **POSE, backdrop={"kind": "film", "file": str(path), "proxies": GROUND})
    rig.step(seconds=0.04)
    middles = cam.frame().image[2, 8::16].astype(float)
    assert np.abs(middles - codes).max() <= (3 if codec == "mjpeg" else 1.5), (middles, codes)


@pytest.mark.camrig(scene="minimal", mode="lockstep")
def test_colours_where_chroma_changes_are_between_those_of_its_pixels(rig, tmp_path):
    """Of chroma with half as many columns and rows, as films have it: linear between its middles, to rounding."""
    rng = np.random.default_rng(8)
    luma = rng.integers(90, 160, (48, 64), np.uint8)
    blue, red = rng.integers(90, 166, (2, 24, 32), np.uint8)
    planes = np.concatenate([luma.ravel(), blue.ravel(), red.ravel()])
    path = film(tmp_path / "chroma.mkv", [planes] * 3, *tagged("bt709", False), *H264, layout="yuv420p", size=(64, 48))
    y = (luma.astype(float) - 16) / 219
    b, r = ((cv2.resize(plane.astype(float), (64, 48), interpolation=cv2.INTER_LINEAR) - 128) / 224 for plane in (blue, red))
    kr, kb = 0.2126, 0.0722
    reds, blues = y + 2 * (1 - kr) * r, y + 2 * (1 - kb) * b
    expected = 255 * np.clip(np.stack([blues, (y - kr * reds - kb * blues) / (1 - kr - kb), reds], -1), 0, 1)
    cam = rig.create_camera("cam", size=(64, 48), fps=25, **POSE, backdrop={"kind": "film", "file": str(path), "proxies": {"scene": "hidden", **GROUND}})
    for actor in rig.actors():
        rig.remove_actor(actor["name"])
    rig.step(seconds=0.04)
    off = np.abs(cam.frame().image.astype(float) - expected)
    assert off.max() <= 1, (off.max(), off.mean())


@pytest.mark.camrig(scene="minimal", mode="lockstep")
def test_what_is_wrong_with_a_film_is_said_with_its_place(rig, tmp_path):
    good = gray_film(tmp_path / "good.mp4", 9, *H264)
    turned, cut, text = (tmp_path / name for name in ("turned.mp4", "cut.mp4", "text.mp4"))
    turned.write_bytes(quarter_turned(good.read_bytes()))
    cut.write_bytes(good.read_bytes()[:900])
    text.write_text("#EXTM3U\n/etc/passwd\n")
    wide = gray_film(tmp_path / "wide.mkv", 2, "-vf", "setsar=4/3", *H264)
    photo = tmp_path / "photo.png"
    cv2.imwrite(str(photo), np.zeros((48, 64, 3), np.uint8))

    def refused(file=good, kind="film", proxies=GROUND, size=(64, 48), **more):
        with pytest.raises(camrig.CamrigError) as error:
            rig.create_camera("gate", size=size, **POSE, backdrop={"kind": kind, "file": str(file), "proxies": proxies, **more})
        return str(error.value)

    assert "backdrop.file: " in refused(turned) and "is stored turned" in refused(turned)
    assert "backdrop.file: " in refused(cut) and "has no pictures that can be decoded" in refused(cut)
    assert "no film that is read here" in refused(text) and "no film that is read here" in refused(photo)
    assert "its pixels are no squares (4:3)" in refused(wide)
    assert "no such file" in refused(tmp_path / "none.mp4")
    assert "a picture of 64x48 for a camera of 64x64" in refused(size=(64, 64))
    assert "backdrop.fps: is that of a film" in refused(photo, "plate", fps=25)
    assert "backdrop.fps" in refused(fps=0)
    assert "backdrop.yaw_deg: is that of a panorama" in refused(yaw_deg=10)
    assert "a panorama of 64x48; it shows the whole sphere, and is twice as wide as high" in refused(photo, "panorama")
    sphere = tmp_path / "sphere.png"
    cv2.imwrite(str(sphere), np.zeros((32, 64, 3), np.uint8))
    assert "ground.polygon_px: a panorama has no such pixels" in refused(
        sphere, "panorama", {"ground": {"polygon_px": [[9, 40], [20, 40], [20, 45]]}})


@pytest.mark.camrig(scene="minimal", mode="realtime")
def test_in_real_time_a_film_plays_and_tells_what_it_shows(rig, tmp_path):
    path = gray_film(tmp_path / "steps.mkv", 40, *H264)
    cam = rig.create_camera("cam", size=(64, 48), fps=25, **POSE, backdrop={"kind": "film", "file": str(path), "proxies": GROUND})
    shown, told = {}, {}  # by frame
    for _ in range(200):
        frame = cam.frame(min_ns=cam.frame().time_ns + 1)
        shown[frame.sequence] = int(round((np.median(frame.image[:10]) * 219 / 255 - 24) / 4))
        truth = cam.truth()
        told[truth["sequence"]] = truth["backdrop_frame"]
        if len(both := shown.keys() & told.keys()) >= 8:
            break
    assert len(both) >= 8 and len(set(shown.values())) > 4
    assert {sequence: shown[sequence] for sequence in both} == {sequence: told[sequence] for sequence in both}
    assert cam.truth()["backdrop_late"] >= 0


def direction(pan_deg, tilt_deg):
    pan, tilt = np.radians(pan_deg), np.radians(tilt_deg)
    return np.array([np.cos(tilt) * np.cos(pan), np.cos(tilt) * np.sin(pan), np.sin(tilt)])


@pytest.mark.camrig(scene="minimal", mode="lockstep")
def test_a_head_turns_before_a_panorama(rig, tmp_path):
    """The middle of the picture is the panorama where the head looks, at all zooms; people stand on its ground."""
    rows, columns = np.mgrid[0:512, 0:1024]
    # Smooth, so that a code is known without knowing the filter.
    sphere = np.stack([columns / 4 % 256, rows / 2, 255 - np.abs(columns - 512) / 2], -1)
    sphere = np.clip(sphere, 0, 255).astype(np.uint8)
    cv2.imwrite(str(tmp_path / "sphere.png"), sphere)
    backdrop = {"kind": "panorama", "file": str(tmp_path / "sphere.png"), "yaw_deg": 30,
                "proxies": {"scene": "hidden", "ground": {"polygon_m": [[-9, -9], [9, -9], [9, 9], [-9, 9]]}}}
    cam = rig.create_camera("dome", size=(161, 121), fps=25, vfov_deg=50, position=(0, 0, 3), ptz={"preset": "dome"}, backdrop=backdrop)
    for pan, tilt, zoom in ((0, -5, 1), (100, -30, 3), (-60, 5, 10), (20, -80, 20)):
        rig.call("ptz.move", camera="dome", mode="absolute", pan_deg=pan, tilt_deg=tilt, zoom=zoom)
        rig.step(seconds=20)
        state = cam.truth()["ptz"]["true"]
        looks = direction(state["pan_deg"], state["tilt_deg"])
        azimuth = np.degrees(np.arctan2(looks[1], looks[0])) - 30
        u = (0.5 - azimuth / 360) % 1 * 1024 - 0.5
        v = (0.5 - np.degrees(np.arcsin(looks[2])) / 180) * 512 - 0.5
        middle = cam.frame().image[60, 80].astype(float)
        expected = np.array([u / 4, v / 2, 255 - abs(u - 512) / 2])
        assert np.abs(middle - np.clip(expected, 0, 255)).max() <= 1.5, (pan, tilt, zoom)
    depth = cam.depth()
    assert abs(depth[60, 80] - 3 / np.sin(np.radians(-state["tilt_deg"]))) < 0.01
    rig.call("camera.set", name="dome", ptz=None)
    rig.call("camera.set", name="dome", pose={"position": [0, 0, 3], "pan_deg": 90}, seconds=1)
    rig.step(seconds=2)
    with pytest.raises(camrig.CamrigError, match="seconds: a camera with a backdrop stands still"):
        rig.call("camera.set", name="dome", pose={"position": [1, 0, 3], "pan_deg": 0}, seconds=1)
    rig.fault.set("dome", "knock")

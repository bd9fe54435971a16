"""Panoramas with finer parts, for heads that zoom in on them."""

import json
import os
import subprocess

import cv2
import numpy as np
import pytest

import camrig

CAMRIG = os.environ["CAMRIG_BIN"]
COLUMNS, SCALE = 4096, 32
#: Stripes of this period in pixels of the details: 30 to a degree, where 45 pixels of one could tell 22.
PERIOD = 12
LEFT, TOP, WIDTH, HEIGHT = 57_000, 32_300, 2400, 1600
GROUND = {"scene": "hidden", "ground": {"polygon_m": [[-9, -9], [9, -9], [9, 9], [-9, 9]]}}


def code(light):
    return 255 * np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.power(light, 1 / 2.4) - 0.055)


def linear(codes):
    value = codes / 255
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def stripes(x, y):
    """Light at a pixel of the details: upright stripes, and the same lying in the lower half."""
    return 0.5 + 0.4 * np.cos(2 * np.pi * np.where(y < TOP + HEIGHT / 2, x, y) / PERIOD)


@pytest.fixture
def square(tmp_path):
    """A gray panorama, the mean of what its details show, and these: four pictures of a rectangle of it that is cut where it happens to be."""
    cv2.imwrite(str(tmp_path / "square.png"), np.full((COLUMNS // 2, COLUMNS, 3), 188, np.uint8))
    rows, columns = np.mgrid[TOP:TOP + HEIGHT, LEFT:LEFT + WIDTH]
    whole = np.repeat(np.round(code(stripes(columns, rows)))[..., None], 3, -1).astype(np.uint8)
    details = []
    for name, x0, x1, y0, y1 in (("a", 0, 1111, 0, 803), ("b", 1111, WIDTH, 0, 803), ("c", 0, 900, 803, HEIGHT), ("d", 900, WIDTH, 803, HEIGHT)):
        cv2.imwrite(str(tmp_path / f"{name}.png"), whole[y0:y1, x0:x1])
        details.append({"file": str(tmp_path / f"{name}.png"), "scale": SCALE, "at_px": [LEFT + x0, TOP + y0]})
    return {"kind": "panorama", "file": str(tmp_path / "square.png"), "proxies": GROUND, "details": details}


def look(rig, cam, zoom):
    """The head looks at the middle of the details; which of their pixels each pixel of the camera shows."""
    pan, tilt = 180 - (LEFT + WIDTH / 2) * 360 / (COLUMNS * SCALE), 90 - (TOP + HEIGHT / 2) * 360 / (COLUMNS * SCALE)
    rig.call("ptz.move", camera=cam.name, mode="absolute", pan_deg=pan, tilt_deg=tilt, zoom=zoom)
    rig.step(seconds=10)
    seen = camrig.Projection.of(cam.truth())
    height, width = cam.frame().image.shape[:2]
    rows, columns = np.mgrid[0:height, 0:width]
    rays = np.stack([columns, rows, np.ones_like(rows)], -1) @ np.linalg.inv(seen.K).T @ seen.world_from_camera[:3, :3].T
    azimuth, elevation = np.arctan2(rays[..., 1], rays[..., 0]), np.arctan2(rays[..., 2], np.hypot(rays[..., 0], rays[..., 1]))
    per_rad = COLUMNS * SCALE / (2 * np.pi)
    return (np.pi - azimuth) * per_rad - 0.5, (np.pi / 2 - elevation) * per_rad - 0.5, seen.K[0, 0]


@pytest.mark.camrig(scene="minimal", mode="lockstep")
def test_a_head_that_zooms_in_sees_what_is_finer_than_one_picture_can_hold(rig, square):
    """At the long end the stripes are there, at their places, over the seams too; at the wide end only their mean is."""
    cam = rig.create_camera("dome", size=(640, 480), fps=25, vfov_deg=50, position=(0, 0, 3), ptz={"preset": "dome"}, backdrop=square)
    x, y, focal_px = look(rig, cam, 30)
    assert focal_px * np.pi / 180 > 200, "pixels of a degree"
    got = linear(cam.frame().image[..., 1].astype(float)) - 0.5
    inside = (x > LEFT + 20) & (x < LEFT + WIDTH - 20) & (y > TOP + 20) & (y < TOP + HEIGHT - 20) & (np.abs(y - TOP - HEIGHT / 2) > 20)
    assert inside.mean() > 0.8
    wanted = stripes(x, y) - 0.5
    assert np.corrcoef(got[inside], wanted[inside])[0, 1] > 0.99
    kept = (got * wanted)[inside].sum() / (wanted**2)[inside].sum()
    # A pixel of the camera is the mean of 1.7 of theirs, of stripes of 12.
    assert 0.85 < kept < 1.01, kept
    # One picture shows none of it.
    plain = rig.create_camera("plain", size=(640, 480), fps=25, vfov_deg=50, position=(0, 0, 3), ptz={"preset": "dome"},
                              backdrop={key: value for key, value in square.items() if key != "details"})
    look(rig, plain, 30)
    assert np.ptp(plain.frame().image) == 0
    # At the wide end a pixel is three stripes wide and their mean.
    for of in (cam, plain):
        look(rig, of, 1)
    assert np.abs(cam.frame().image.astype(int) - plain.frame().image.astype(int)).max() <= 2


@pytest.mark.camrig(scene="minimal", mode="lockstep")
def test_details_are_those_of_the_scene_file_and_told_as_they_were_given(rig, square, tmp_path):
    cameras = [{"name": "dome", "size": [320, 240], "vfov_deg": 50, "pose": {"position": [0, 0, 3]}, "ptz": {},
                "backdrop": {**square, "file": "square.png", "details": [{**one, "file": os.path.basename(one["file"])} for one in square["details"]]}}]
    file = tmp_path / "square.json"
    file.write_text(json.dumps({"camrig_scene": 1, "name": "square", "cameras": cameras}))
    checked = subprocess.run([CAMRIG, "check", str(file)], capture_output=True, text=True, timeout=60, check=False)
    assert checked.returncode == 0, checked.stdout + checked.stderr
    rig.load(str(file))
    told = rig.call("camera.get", name="dome")
    assert told["backdrop"]["details"] == square["details"]
    rig.call("camera.create", **{**told, "name": "again"})
    cameras[0]["backdrop"]["details"][1]["at_px"] = [LEFT, COLUMNS * SCALE // 2 - 5]
    file.write_text(json.dumps({"camrig_scene": 1, "name": "square", "cameras": cameras}))
    checked = subprocess.run([CAMRIG, "check", str(file)], capture_output=True, text=True, timeout=60, check=False)
    assert checked.returncode == 1 and "cameras[0].backdrop.details[1].at_px: a picture of 1289x803 at 57000, 65531 is beyond the 131072x65536 pixels" in checked.stdout + checked.stderr


@pytest.mark.camrig(scene="minimal", mode="lockstep")
def test_what_is_wrong_with_details_is_said_with_its_place(rig, square, tmp_path):
    def refused(detail, **more):
        with pytest.raises(camrig.CamrigError) as error:
            rig.create_camera("dome", size=(320, 240), vfov_deg=50, position=(0, 0, 3),
                              backdrop={**square, "details": [square["details"][0], {**square["details"][1], **detail}], **more})
        return str(error.value)

    text, wide = tmp_path / "text.png", tmp_path / "wide.png"
    text.write_text("no picture")
    wide.write_bytes(cv2.imencode(".png", np.zeros((16000, 16000), np.uint8))[1].tobytes())
    assert "backdrop.details[1].file: " in refused({"file": str(text)}) and "is neither a PNG nor a JPEG" in refused({"file": str(text)})
    assert "no such file" in refused({"file": str(tmp_path / "none.png")})
    assert "backdrop.details[1].scale: must be 2, 4, 8, 16, 32 or 64" in refused({"scale": 24})
    assert "backdrop.details[1].scale: must be 2 to 64" in refused({"scale": 128})
    assert "backdrop.details[1].at_px: a picture of 1289x803 at 200000, 0 is beyond" in refused({"at_px": [200000, 0]})
    assert "backdrop.details: are those of a panorama, and the kind is plate" in refused({}, kind="plate")
    many = [{"file": str(wide), "scale": 64, "at_px": [16000 * i, 100]} for i in range(4)]
    with pytest.raises(camrig.CamrigError, match=r"backdrop.details\[1\].file: with it the panorama's details take over 2048 MiB of memory"):
        rig.create_camera("dome", size=(320, 240), backdrop={**square, "details": many})

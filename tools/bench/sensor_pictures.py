"""python -m tools.bench.sensor_pictures: makes two pictures of docs/sensor.md, a fan under a rolling shutter and automatic exposure from hall to street.

Both scenes are made here of boxes; pictures are those of a rig in lockstep, so they come out the same again.
"""

from __future__ import annotations

import json
import tempfile
from pathlib import Path

import cv2
import numpy as np

import camrig
from tools.bench import report

PICTURES = report.REPOSITORY / "docs" / "pictures"
QUALITY = [cv2.IMWRITE_JPEG_QUALITY, 88]


def scene_file(folder: str, **scene) -> Path:
    file = Path(folder) / f"{scene['name']}.json"
    file.write_text(json.dumps({"camrig_scene": 1, **scene}))
    return file


def box(size, color, **more):
    return {"shape": "box", "size": list(size), "color": list(color), **more}


def labelled(image: np.ndarray, text: str) -> np.ndarray:
    image = image.copy()
    for color, thick in (((0, 0, 0), 4), ((255, 255, 255), 1)):
        cv2.putText(image, text, (8, image.shape[0] - 10), cv2.FONT_HERSHEY_SIMPLEX, 0.5, color, thick, cv2.LINE_AA)
    return image


def fan() -> np.ndarray:
    """Seen from below, five turns a second."""
    turn_deg_per_ms = 1.8
    models = {"hub": box((0.3, 0.3, 0.12), (0.2, 0.2, 0.22)), "ceiling": box((8, 8, 0.1), (0.85, 0.83, 0.78)), "beam": box((8, 0.12, 0.14), (0.4, 0.3, 0.2))}
    models |= {f"blade{i}": box((0.2, 0.9, 0.02), color) for i, color in enumerate(((0.7, 0.1, 0.08), (0.12, 0.2, 0.5), (0.12, 0.4, 0.15), (0.75, 0.55, 0.1)))}
    blades = [{"name": f"blade{i}", "model": f"blade{i}", "class": "blade",
               "attach": {"actor": "hub", "position": [round(0.55 * float(np.cos(a)), 6), round(0.55 * float(np.sin(a)), 6), 0.02], "yaw_deg": 90 * i}}
              for i, a in enumerate(np.radians([0, 90, 180, 270]))]  # fmt: skip
    beams = [{"name": f"beam{i}", "model": "beam", "class": "beam", "position": [0, 0.8 * i - 1.6, 3.1]} for i in range(5)]
    with tempfile.TemporaryDirectory() as folder:
        file = scene_file(
            folder, name="fan", step_ns=1_000_000, models=models,
            environment={"background": [0.5, 0.5, 0.5], "ambient": {"sky": [0.3, 0.3, 0.3], "ground": [0.9, 0.9, 0.9]}},
            objects=[{"name": "ceiling", "model": "ceiling", "class": "ceiling", "position": [0, 0, 3.24]}, *beams],
            actors=[{"name": "hub", "model": "hub", "class": "fan", "position": [0, 0, 2.5]}, *blades])  # fmt: skip
        with camrig.start(str(file), mode="lockstep") as rig:
            base = {"preset": "imx477", "white_balance": 6500, "lux": 6000, "vignetting": 0}
            shots = {
                "global shutter, 0.2 ms": {"exposure_s": 0.0002, "gain_db": 24, "readout_s": 0},
                "readout 30 ms, 0.2 ms": {"exposure_s": 0.0002, "gain_db": 24, "readout_s": 0.03},
                "readout 30 ms, 10 ms": {"exposure_s": 0.01, "gain_db": 0, "f_number": 4, "readout_s": 0.03},
            }
            cameras = [rig.create_camera(f"cam{i}", size=(426, 426), fps=10, vfov_deg=62, antialias="coverage", sensor={**base, **sensor},
                                         position=(0, 0, 0.5), pan_deg=0, tilt_deg=90) for i, sensor in enumerate(shots.values())]  # fmt: skip
            for ms in range(100):
                rig.steer({"hub": {"position": [0, 0, 2.5], "yaw_deg": turn_deg_per_ms * (ms + 1), "seconds": 0.001}})
                rig.step(nanoseconds=1_000_000)
            return np.hstack([labelled(cam.frame(format="png").image, text) for cam, text in zip(cameras, shots, strict=True)])


def from_hall_to_street() -> np.ndarray:
    """A camera that looks back into a dark hall, then turns and goes out; the hall is dark in its paint."""
    dark, wall = (0.03, 0.027, 0.024), (0.045, 0.04, 0.034)
    models = {
        "floor": box((12, 5, 0.1), dark), "roof": box((12, 5, 0.1), dark), "side": box((12, 0.2, 3), wall), "back": box((0.2, 5, 3), wall),
        "front": box((0.2, 1.8, 3), wall), "lintel": box((0.2, 1.4, 0.8), wall), "picture": box((1.2, 0.05, 0.8), (0.1, 0.04, 0.03)),
        "road": {"shape": "ground", "size": [200, 200], "color": [0.42, 0.41, 0.4], "grid_m": 2}, "house": box((6, 9, 8), (0.62, 0.5, 0.38)),
        "window": box((0.1, 1.2, 1.4), (0.12, 0.14, 0.18)), "sky": {"shape": "sky"}, "van": {"file": "camrig:street/van.glb"}, "anna": {"file": "camrig:people/anna"},
    }  # fmt: skip
    objects = [
        {"name": "floor", "position": [-6, 0, -0.04]}, {"name": "roof", "position": [-6, 0, 3]}, {"name": "back", "position": [-12, 0, 0]},
        *({"name": f"side{y}", "model": "side", "position": [-6, 2.5 * y, 0]} for y in (-1, 1)),
        *({"name": f"front{y}", "model": "front", "position": [0, 1.6 * y, 0]} for y in (-1, 1)), {"name": "lintel", "position": [0, 0, 2.2]},
        *({"name": f"picture{i}", "model": "picture", "position": [-10 + 2.2 * i, 2.37 * (-1) ** i, 1.2]} for i in range(4)),
        {"name": "road", "position": [0, 0, -0.05]}, {"name": "sky", "position": [0, 0, 0]},
        *({"name": f"house{i}", "model": "house", "position": [22, -20 + 10 * i, 0]} for i in range(5)),
        *({"name": f"window{i}_{j}_{k}", "model": "window", "position": [18.98, -22 + 10 * i + 2 * j, 1 + 2.6 * k]} for i in range(5) for j in range(3) for k in range(2)),
        {"name": "van", "position": [10, 3.5, 0], "yaw_deg": 100}, {"name": "anna", "position": [8, -1.2, 0], "yaw_deg": -60},
    ]  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        file = scene_file(
            folder, name="threshold", models=models, objects=[{"model": one["name"], "class": "thing", **one} for one in objects],
            environment={"background": [0.6, 0.7, 0.8], "ambient": {"sky": [0.16, 0.17, 0.19], "ground": [0.1, 0.095, 0.09]}, "lux": 30_000},
            lights=[{"name": "sun", "type": "directional", "color": [1, 0.96, 0.9], "intensity": 1.1, "direction": [0.6, 0.35, -0.8]}])  # fmt: skip
        with camrig.start(str(file), mode="lockstep") as rig:
            cam = rig.create_camera("walks", size=(320, 240), fps=25, vfov_deg=55, quality="beautiful", sensor={"preset": "imx290", "exposure_s": "auto", "white_balance": 6500},
                                    position=(-1.5, 0, 1.6), pan_deg=180, tilt_deg=-3)  # fmt: skip
            for _ in range(50):
                rig.step(seconds=0.04)
                cam.frame(kind="sensor")
            tiles = []
            for frame in range(51):
                rig.step(seconds=0.04)
                shown = cam.frame(format="png")
                if frame == 0:
                    cam.set(position=(1.5, 0, 1.6), pan_deg=0, tilt_deg=-3, seconds=0.6)
                if frame in (0, 9, 15, 21, 27, 33, 39, 50):
                    tiles.append(labelled(shown.image, f"{0.04 * frame:.2f} s: {1e3 * shown.sensor['exposure_s']:.3g} ms"))
            return np.vstack([np.hstack(tiles[:4]), np.hstack(tiles[4:])])


def main() -> None:
    for name, make in (("sensor-fan.jpg", fan), ("sensor-exposure.jpg", from_hall_to_street)):
        cv2.imwrite(str(PICTURES / name), make(), QUALITY)
        print(PICTURES / name)


if __name__ == "__main__":
    main()

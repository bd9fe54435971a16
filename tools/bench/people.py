"""python -m tools.bench.people [--pictures 6]

How well OpenCV's people detector knows each of the people, alone before plain grey, by how steeply the camera looks down on them: what is
missed here is missed for their looks, not for furniture, light or others. They walk a small circle, so that all sides and steps come by.
"""

import argparse
import json
import math
import pathlib
import shutil
import tempfile

import camrig
from camrig.samples.hog import Detector
from camrig.samples.people import Views
from camrig.samples.scoring import Tally

SCENES = pathlib.Path(__file__).resolve().parents[2] / "scenes"
ANGLES_DEG = (2, 15, 30, 40, 50)
APART_M, CIRCLE_M = 40.0, 0.8
SIZE, VFOV_DEG, HEIGHT_PX = (320, 320), 30, 120


def scene(folder, people):
    """One person every APART_M along x."""
    (folder / "hall").mkdir()
    data = {
        "camrig_scene": 1, "name": "people",
        "environment": {"background": [0.35, 0.35, 0.35], "ambient": {"sky": [1.08, 1.05, 1.01], "ground": [0.66, 0.62, 0.575]}},
        "lights": [{"name": "daylight", "type": "directional", "color": [1, 0.97, 0.92], "intensity": 0.34, "direction": [-0.35, 0.62, -0.7]}],
        "models": {}, "routes": {}, "actors": [],
        "cameras": [{"name": "cam", "size": SIZE, "fps": 25, "vfov_deg": VFOV_DEG, "pose": {"position": [-5, 0, 1], "look_at": [0, 0, 1]}}],
    }  # fmt: skip
    for number, name in enumerate(people):
        shutil.copy(SCENES / f"hall/{name}.glb", folder / "hall")
        turns = [math.tau * k / 24 for k in range(24)]
        data["models"][name] = {"file": f"hall/{name}.glb", "front": "+z"}
        data["routes"][name] = {"points": [[APART_M * number + CIRCLE_M * math.cos(a), CIRCLE_M * math.sin(a)] for a in turns], "closed": True}
        behaviour = {"type": "route", "route": name, "speed": 1.2, "mode": "loop", "clip": "walk"}
        data["actors"].append({"name": name, "model": name, "class": "person", "behaviour": behaviour})
    path = folder / "people.json"
    path.write_text(json.dumps(data))
    return path


def look(number, angle_deg):
    """Pose that shows person `number` about HEIGHT_PX high."""
    angle = math.radians(angle_deg)
    focal_px = SIZE[1] / 2 / math.tan(math.radians(VFOV_DEG / 2))
    away = 1.75 * math.cos(angle) * focal_px / HEIGHT_PX
    middle = (APART_M * number, 0.0, 0.9)
    return {"position": (middle[0] - away * math.cos(angle), 0.0, middle[2] + away * math.sin(angle)), "look_at": middle}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pictures", type=int, default=6, help="of each person at each angle (default 6)")
    options = parser.parse_args()
    people = sorted((path.stem for path in (SCENES / "hall").glob("person_*.glb")), key=lambda name: int(name.split("_")[1]))
    detector, views = Detector(0.3), Views("as-seen", 1.5)
    tallies = {(name, angle): Tally() for name in people for angle in ANGLES_DEG}
    with tempfile.TemporaryDirectory() as folder, camrig.start(scene(pathlib.Path(folder), people), mode="lockstep") as rig:
        camera = rig.camera("cam")
        for _ in range(options.pictures):
            rig.step(seconds=0.83)
            for name, angle in tallies:
                camera.set(**look(people.index(name), angle))
                truth = camera.truth()
                # Those who stand far behind are not looked for.
                truth["objects"] = [item for item in truth["objects"] if item["name"] == name]
                tallies[name, angle].add(detector(camera.frame().image, views.of(truth)), truth)
    print("| found, seen from above by | " + " | ".join(f"{angle} deg" for angle in ANGLES_DEG) + " |\n" + "|---" * (len(ANGLES_DEG) + 1) + "|")
    for title, members in [(name, [name]) for name in people] + [("all", people)]:
        cells = []
        for angle in ANGLES_DEG:
            found, there = (sum(getattr(tallies[name, angle], kind)["clear",] for name in members) for kind in ("found", "there"))
            cells.append(f"{found / there:.2f} ({there})" if there else "-")
        print(f"| {title} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()

"""The rig on whose stage the network plays: its cameras, its clock and its truth. Only the conductor and the scorer know of it."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import camrig
from camrig.samples.scoring import is_seated

FOLDER = Path(__file__).parent
SIZE, VFOV_DEG, HEAD_VFOV_DEG = (480, 360), 55.0, 40.0
FIRST_DEVICE = 20
KEYS = ("name", "size", "intrinsics", "lens", "pose")  # of camera.get: what a program is told of its own camera


def build(rig: camrig.Rig, cameras: int, heads: int, fps: float) -> tuple[dict[str, Any], dict[str, Any]]:
    """Puts up the first so many cameras and heads of cameras.json in the place of the scene's; their calibrations by name."""
    told = json.loads((FOLDER / "cameras.json").read_text())
    for kind, wanted in (("cameras", cameras), ("heads", heads)):
        if not (0 if kind == "heads" else 1) <= wanted <= len(told[kind]):
            raise SystemExit(f"--{kind} {wanted}: cameras.json has places for up to {len(told[kind])}")
    for camera in rig.cameras():
        camera.delete()
    made: dict[str, dict[str, Any]] = {"cameras": {}, "heads": {}}
    number = FIRST_DEVICE
    for kind, wanted in (("cameras", cameras), ("heads", heads)):
        for name, pose in list(told[kind].items())[:wanted]:
            options = {"vfov_deg": HEAD_VFOV_DEG, "ptz": {"preset": "dome"}} if kind == "heads" else {"vfov_deg": VFOV_DEG}
            state = rig.create_camera(name, size=SIZE, fps=fps, **pose, code_strip=True, outputs=[{"kind": "device", "number": number}], **options).get()
            made[kind][name] = {key: state[key] for key in KEYS}
            number += 1
    return made["cameras"], made["heads"]


def source(rig: camrig.Rig, name: str, is_device: bool) -> str:
    camera = rig.camera(name)
    if not is_device:
        return camera.url("rtsp")
    (device,) = (output for output in camera.get()["outputs"] if output["kind"] == "device")
    return f"/dev/video{device['number']}"


def truth_line(rig: camrig.Rig, names: list[str]) -> dict[str, Any]:
    """Who is where, and how each camera sees them: distance and angle off its axis, share that shows, height in px. Of the latest instant of a world that stands."""
    people: dict[int, dict[str, Any]] = {}
    # Of the latest frames, though a head may have been told to turn since: the next ones show that.
    truths = {name: rig.camera(name).truth(min_ns=1) for name in names}
    (time_ns,) = {truth["time_ns"] for truth in truths.values()}
    for name, truth in truths.items():
        eye, k = truth["pose"]["position"], truth["intrinsics"]
        half_deg = math.degrees(math.atan2(truth["size"][0] / 2, k["fx"]))
        for one in truth["objects"]:
            if one["class"] != "person" or is_seated(one):
                continue
            x, y = one["position"][:2]
            box = one["box_full"]
            seen = {"visible": round(one["visible_fraction"] * (1 - one["truncated"]), 3), "distance_m": round(math.dist(eye[:2], (x, y)), 3), "height_px": round(box[3], 1),
                    "off_axis": round(min(1.0, abs(math.degrees(math.atan2(box[0] + box[2] / 2 - k["cx"], k["fx"]))) / half_deg), 3)}
            people.setdefault(one["id"], {"id": one["id"], "floor": [round(x, 3), round(y, 3)], "seen": {}})["seen"][name] = seen
    return {"t": time_ns, "people": [people[key] for key in sorted(people)]}

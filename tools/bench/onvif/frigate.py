"""Frigate's own calibration and autotracking, unmodified, with camrig's heads: see README.md."""

from __future__ import annotations

import argparse
import asyncio
import enum
import json
import logging
import pathlib
import socket
import sys
import tempfile
import threading
import time
import types

import numpy as np

import camrig

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
SCENE = REPOSITORY / "examples" / "tracker" / "yard.json"
DETECT_FPS = 5  # Frigate's default


def load(source: pathlib.Path):
    """`frigate.ptz` of the copy at `source`. Its configuration, messages and shared memory are stood in for: they would bring all of Frigate."""
    def module(name, **members):
        made = types.ModuleType(name)
        made.__dict__.update(members)
        sys.modules[name] = made
        return made

    for name in ("frigate", "frigate.util", "frigate.ptz", "frigate.comms", "frigate.track", "frigate.config.camera"):
        module(name).__path__ = [str(source / name.replace(".", "/"))]

    class Updates:
        def __init__(self, *_):
            pass

        def check_for_updates(self):
            return {}

        def stop(self):
            pass

    config_file = tempfile.NamedTemporaryFile("w", suffix=".yml", delete=False)
    config_file.write("cameras: {}\n")
    config_file.close()
    zooming = enum.Enum("ZoomingModeEnum", {one: one for one in ("disabled", "absolute", "relative")}, type=str)
    module("frigate.config", FrigateConfig=object, CameraConfig=object, ZoomingModeEnum=zooming).__path__ = []
    module("frigate.config.camera.updater", CameraConfigUpdateSubscriber=Updates, CameraConfigUpdateEnum=enum.Enum("Update", "add autotracking onvif"))
    module("frigate.comms.dispatcher", Dispatcher=object)
    module("frigate.track.tracked_object", TrackedObject=object)
    module("frigate.util.config", find_config_file=lambda: config_file.name)
    from frigate.camera import PTZMetrics
    from frigate.ptz.autotrack import PtzAutoTracker
    from frigate.ptz.onvif import OnvifController
    return PTZMetrics, OnvifController, PtzAutoTracker, zooming


def config_of(name, port, size, zooming):
    """What Frigate makes of `onvif: {host, port, autotracking: {enabled: true, calibrate_on_startup: true}}`."""
    tracking = types.SimpleNamespace(enabled=True, enabled_in_config=True, calibrate_on_startup=True, zooming=zooming.disabled, zoom_factor=0.3, track=["person"],
                                     required_zones=["all"], return_preset="home", timeout=10, movement_weights=[])
    onvif = types.SimpleNamespace(host="127.0.0.1", port=port, user="camrig", password="", tls_insecure=False, profile=None, ignore_time_mismatch=False,
                                  autotracking=tracking)
    camera = types.SimpleNamespace(name=name, enabled=True, onvif=onvif, frame_shape=(size[1], size[0]),
                                   detect=types.SimpleNamespace(fps=DETECT_FPS, width=size[0], height=size[1]))
    return types.SimpleNamespace(cameras={name: camera})


class Seen:
    """What Frigate's tracker knows of an object, made of camrig's truth in the place of a detector: box, and its speed against what stands, in pixels a picture."""

    def __init__(self, truth, person, frame_time, camera_config):
        lens = camrig.Projection.of(truth)
        x, y, w, h = person["box_full"]
        middle = np.array(person["center"])
        here, soon = lens.project([middle, middle + np.array(person["velocity"]) / DETECT_FPS])
        box = [int(x), int(y), int(x + w), int(y + h)]
        self.obj_data = {"id": "walker", "label": "person", "box": box, "region": box, "area": w * h, "centroid": (int(x + w / 2), int(y + h / 2)),
                         "frame_time": frame_time, "estimate_velocity": np.array([soon - here] * 2)}
        self.camera_config, self.previous = camera_config, {"false_positive": False}
        self.false_positive, self.active, self.entered_zones = False, True, ["all"]


def track(cam, tracker, metrics, name, seconds):
    """Shows it what the truth sees, at the rate of its detector; distances of the person from the middle, in widths of the picture."""
    off, end = [], time.monotonic() + seconds
    while time.monotonic() < end:
        due = time.monotonic() + 1 / DETECT_FPS
        truth = cam.truth()
        frame_time = time.time()
        metrics[name].frame_time.value = frame_time
        person = next((one for one in truth["objects"] if one["class"] == "person" and one["pixels"]), None)
        off.append(abs(person["box_full"][0] + person["box_full"][2] / 2 - (truth["size"][0] - 1) / 2) / truth["size"][0] if person else np.inf)
        if person:
            tracker.autotrack_object(name, Seen(truth, person, frame_time, tracker.config.cameras[name]))
        elif tracker.tracked_object[name]:
            tracker.end_object(name, tracker.tracked_object[name])
        asyncio.run_coroutine_threadsafe(tracker.camera_maintenance(name), tracker.onvif.loop).result()
        time.sleep(max(0.0, due - time.monotonic()))
    return np.array(off)


def run(rig, source, name, port, seconds):
    ptz_metrics, controller, auto_tracker, zooming = source
    cam = rig.camera(name)
    config = config_of(name, port, cam.get()["size"], zooming)
    metrics = {name: ptz_metrics(autotracker_enabled=True)}
    onvif = controller(config, metrics)
    while name not in onvif.cams:
        time.sleep(0.01)
    begin = time.monotonic()
    tracker = auto_tracker(config, onvif, metrics, types.SimpleNamespace(publish=lambda *_, **__: None), threading.Event())
    took = time.monotonic() - begin
    weights = config.cameras[name].onvif.autotracking.movement_weights
    result = {"head": name, "features": onvif.cams[name]["features"], "tracks": config.cameras[name].onvif.autotracking.enabled, "calibrated": bool(weights), "calibration_s": round(took, 1)}
    moves = tracker.move_metrics[name]
    times = [one["end_timestamp"] - one["start_timestamp"] for one in moves]
    if times:
        ways = np.array([one["pan"] + one["tilt"] for one in moves])
        line = np.linalg.lstsq(np.column_stack((np.ones(len(ways)), ways)), times, rcond=None)[0]
        result |= {"no_way_s": round(times[0], 3), "intercept_s": round(line[0], 3), "s_per_unit": round(line[1], 3)}
    if weights:
        while not any(one["class"] == "person" and one["visible_fraction"] == 1 for one in cam.truth()["objects"]):
            time.sleep(0.1)
        off = track(cam, tracker, metrics, name, seconds)
        seen = off[np.isfinite(off)]
        result |= {"looks": len(off), "in_view": round(float(np.isfinite(off).mean()), 3), "within_a_fifth": round(float((off <= 0.2).mean()), 3),
                   "median_off": round(float(np.median(seen)), 3) if len(seen) else None}
    tracker.stop_event.set()
    time.sleep(0.3)  # its loop looks at that ten times a second
    onvif.close()
    return result


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("source", type=pathlib.Path, help="a checkout of Frigate")
    parser.add_argument("--heads", default="dome,ideal,cheap")
    parser.add_argument("--seconds", type=float, default=60, help="of tracking")
    parser.add_argument("--manners", type=json.loads, default={}, help="""options of the outputs onvif beside their port: '{"move_status": "none"}'""")
    parser.add_argument("--verbose", action="store_true", help="Frigate's own log")
    arguments = parser.parse_args()
    logging.basicConfig(level=logging.DEBUG if arguments.verbose else logging.WARNING)
    source = load(arguments.source.resolve())
    scene = json.loads(SCENE.read_text())
    sockets = [socket.socket() for _ in scene["cameras"]]
    for one, camera in zip(sockets, scene["cameras"]):
        one.bind(("127.0.0.1", 0))
        camera["outputs"] = [{"kind": "onvif", "port": one.getsockname()[1], **arguments.manners}]
    for one in sockets:
        one.close()
    with tempfile.TemporaryDirectory() as folder:
        (path := pathlib.Path(folder) / SCENE.name).write_text(json.dumps(scene))
        with camrig.start(str(path)) as rig:
            for camera in scene["cameras"]:
                if camera["name"] in arguments.heads.split(","):
                    print(json.dumps(run(rig, source, camera["name"], camera["outputs"][0]["port"], arguments.seconds)), flush=True)


if __name__ == "__main__":
    main()

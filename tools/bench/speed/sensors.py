"""What a sensor costs: noise, automatic exposure, the time that a picture takes, and focus."""

from __future__ import annotations

import statistics
import time
from typing import Any

import camrig
import numpy as np

from . import runs
from .meter import use_of
from .plan import FULL_HD, VGA, Plan, table
from .sharing import row, watch

PLACE = "lobby"
_SETTLE = 15
FOCUS = "`imx249`, focus 5 m, f/2.8"
FOCUS_FULL_HD_PICTURES = 2
#: Sensors that differ in one thing from the one before which they are compared with.
_GLOBAL = {"preset": "imx249", "exposure_s": 0.01, "blur": False}
_ROLLING = {"preset": "imx219", "exposure_s": 0.01, "blur": False}
CASES: dict[str, dict[str, Any] | None] = {
    "no sensor": None,
    "`imx249`: noise, global shutter": _GLOBAL,
    "the same, blur of 10 ms": {**_GLOBAL, "blur": True},
    "`imx219`: noise, as if all rows were read at once": {**_ROLLING, "readout_s": 0},
    "the same, rolling shutter of 23.3 ms": _ROLLING,
    "the same, with blur of 10 ms": {**_ROLLING, "blur": True},
    FOCUS: {**_GLOBAL, "focus_m": 5, "f_number": 2.8},
}
#: Of the cases: what each costs at most of another.
BOUNDS = {"the same, blur of 10 ms": ("`imx249`: noise, global shutter", 1.3), "the same, rolling shutter of 23.3 ms": ("`imx219`: noise, as if all rows were read at once", 1.2)}


def sensors(plan: Plan) -> str:
    return "## What a sensor costs\n\n" + _cost(plan) + "\n\n" + _twelve(plan)


def _cpu_ms(rig: camrig.Rig, cam: camrig.Camera, pictures: int) -> float:
    for _ in range(_SETTLE):
        rig.step(seconds=0.04)
        cam.frame()
    pid = rig.info()["pid"]
    before = use_of(pid).cpu_s
    for _ in range(pictures):
        rig.step(seconds=0.04)
        cam.frame()
    return 1e3 * (use_of(pid).cpu_s - before) / pictures


def _share_that_moves() -> float:
    """Of the pixels: those that two pictures one after the other, clean ones, do not share; the median of some."""
    shares = []
    with camrig.start("hall", mode="lockstep", device="cpu") as rig:
        cam = rig.create_camera("seen", size=VGA, fps=25, place=PLACE)
        rig.step(seconds=2)
        last = cam.frame().image
        for _ in range(20):
            rig.step(seconds=0.04)
            now = cam.frame().image
            shares.append(float(np.mean(np.any(now != last, axis=-1))))
            last = now
    return statistics.median(shares)


def _cost(plan: Plan) -> str:
    pictures, turns = {VGA: max(5, plan.steps // 4), FULL_HD: max(3, plan.steps // 16)}, 1 if plan.steps < 50 else 3
    spent: dict[tuple[str, tuple[int, int]], list[float]] = {}
    for _ in range(turns):
        for size in (VGA, FULL_HD):
            for case, sensor in CASES.items():
                with camrig.start("hall", mode="lockstep", device="cpu", seed=7) as rig:
                    cam = rig.create_camera("taken", size=size, fps=25, place=PLACE, **({"sensor": sensor} if sensor else {}))
                    rig.step(seconds=2)
                    spent.setdefault((case, size), []).append(_cpu_ms(rig, cam, FOCUS_FULL_HD_PICTURES if (case, size) == (FOCUS, FULL_HD) else pictures[size]))
    ms = {key: statistics.median(values) for key, values in spent.items()}
    rows = []
    for case in CASES:
        to, bound = BOUNDS.get(case, ("", 0.0))
        ratios = [ms[case, size] / ms[to, size] for size in (VGA, FULL_HD)] if to else []
        rows.append([case, *(f"{ms[case, size]:.1f}" for size in (VGA, FULL_HD)), f"{bound:g} x" if to else "", " / ".join(f"{ratio:.2f} x" for ratio in ratios),
                     ("yes" if max(ratios) <= bound else "**no**") if to else ""])
    return (f"One standing camera at `{PLACE}` of the hall, quality `simple`, lockstep, pictures taken by a Python program; {100 * _share_that_moves():.0f} % of the pixels change from one picture to the next. "
            f"CPU milliseconds a picture, medians of {turns} turns of {pictures[VGA]} pictures of 640x480 and {pictures[FULL_HD]} of 1920x1080 each; 1920x1080 with focus, which takes long: {FOCUS_FULL_HD_PICTURES}.\n\n"
            + table(["", "640x480", "1920x1080", "at most", "against the one that lacks it", "reached"], rows))


def _twelve(plan: Plan) -> str:
    rows = []
    for what, sensor in (("without a sensor", None), ("`imx219`, automatic exposure and white balance, global shutter", {**_ROLLING, "readout_s": 0, "exposure_s": "auto", "white_balance": "auto"}),
                         ("the same, with its rolling shutter and blur", {"preset": "imx219", "exposure_s": "auto", "white_balance": "auto"})):
        with runs.rig_with(12, VGA, 25) as (rig, names):
            if sensor:
                for name in names:
                    rig.camera(name).set(sensor=sensor)
            readings = []

            def meter(duration: float) -> None:
                begun = runs.Meter(rig)
                time.sleep(duration)
                readings.append(begun.read())

            streams, seconds = watch(rig, names, plan.seconds / 2, meter)
        rows.append([*row(f"12 standing cameras 640x480 at 25/s, {what}", "300/s" if sensor else "", list(streams.values()), 300 * seconds, seconds, lambda lost, _: lost <= 0.02), f"{readings[0].cores:.2f}"])
    return ("Each with one MJPEG reader, in real time, in the hall, on the same machine as the rig.\n\n"
            + table(["what", "wanted", "frames/s", "lost", "latency p50 / p99 ms", "reached", "cores"], rows))

"""All motion of one person, sampled for a glTF file."""

import numpy as np

from . import gait
from .posture import quaternion, solve
from .standing import FREE_CLIPS

FREE_RATE = 8  # keys a second of what is not a walk


def all_clips(rig, style):
    """{name: (times, rotations per joint (keys x joints x 4), hip positions, extras)} ready for a glTF file."""
    style = {**gait.DEFAULT_STYLE, **style}
    times, postures, speed = gait.walk(rig, style)
    made = {"walk": _sampled(rig, times, postures, {"ground_speed_m_s": round(speed, 6)})}
    for name, (function, seconds) in FREE_CLIPS.items():
        times = np.arange(int(seconds * FREE_RATE) + 1) / FREE_RATE
        made[name] = _sampled(rig, times, [function(rig, t % seconds, style) for t in times], {"ground_speed_m_s": 0})
    return made


def _sampled(rig, times, postures, extras):
    turns, places = [], []
    for posture in postures:
        local, pelvis = solve(rig, posture)
        turns.append([quaternion(m) for m in local])
        places.append(pelvis)
    turns = np.array(turns)
    for k in range(1, len(turns)):
        flip = (turns[k] * turns[k - 1]).sum(axis=1) < 0
        turns[k][flip] *= -1
    return times, turns, np.array(places), extras

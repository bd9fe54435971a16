"""Walking with feet that do not slide: the stance foot moves back exactly as fast as the body goes forward.

The pattern (share of the cycle on the ground, pelvis motion, the foot's heel, ankle and ball rockers) follows Perry,
Gait Analysis (1992).
"""

import math

import numpy as np

from .posture import Foot, Posture, ankle, hang, rotation

DUTY = 0.62  # share of the cycle a foot is on the ground
FLAT_FROM, FLAT_TO = 0.09, 0.37  # part of the cycle with the whole sole on the ground
STRIKE_DEG, PUSH_DEG = 19, 58  # toes up at heel strike; heel up at toe-off
WALK_KEYS = 40


DEFAULT_STYLE = {
    "cadence": 1.0,
    "stride": 1.0,
    "sway": 0.020,
    "hip_yaw": 6.0,
    "hip_roll": 3.0,
    "chest_yaw": 5.0,
    "lean": 3.0,
    "head_pitch": 1.0,
    "left_swing": 20.0,
    "right_swing": 20.0,
    "arm_in": 10.5,
    "width": 0.80,
}


def _rocker(rig, side, pitch, pivot):
    """Where the ankle is, against its place in the flat foot, when the foot turns by pitch about its heel or ball."""
    scale = rig.build.scale
    joint, toes = rig.at(f"{side}_foot"), rig.at(f"{side}_toes")
    point = np.array([joint[0], 0, joint[2] - 0.066 * scale] if pivot == "heel" else [joint[0], toes[1], toes[2]])
    return point + rotation(pitch=-pitch) @ (joint - point) - joint


def _walk_foot(rig, side, phase, stride, ahead, width):
    """The foot at `phase` of its own cycle (0 = heel strike), in the frame that moves with the body."""
    base = ankle(rig, side)
    base[0] *= width

    def stance(p):
        if p < FLAT_FROM:
            t = p / FLAT_FROM
            pitch, pivot = STRIKE_DEG * (1 - t) ** 1.5, "heel"
        elif p < FLAT_TO:
            return base + (0, 0, ahead - stride * p), 0.0
        else:
            t = (p - FLAT_TO) / (DUTY - FLAT_TO)
            pitch, pivot = -PUSH_DEG * t**1.8, "ball"
        return base + _rocker(rig, side, pitch, pivot) + (0, 0, ahead - stride * p), pitch

    if phase <= DUTY:
        place, pitch = stance(phase)
        return Foot(place, pitch, 0.0, max(0.0, -pitch))
    t, span, step = (phase - DUTY) / (1 - DUTY), 1 - DUTY, 1e-3
    (start, _), (before, _), (end, _), (after, _) = stance(DUTY), stance(DUTY - step), stance(0.0), stance(step)
    # The swing is a cubic curve that leaves and arrives at the speed of the stance foot (Hermite).
    leave, arrive = (start - before) / step * span, (after - end) / step * span
    h00, h10 = 2 * t**3 - 3 * t**2 + 1, t**3 - 2 * t**2 + t
    h01, h11 = -2 * t**3 + 3 * t**2, t**3 - t**2
    place = h00 * start + h10 * leave + h01 * end + h11 * arrive
    place[1] += 0.035 * rig.build.scale * math.sin(math.pi * t) ** 2
    pitch = float(np.interp(t, [0, 0.12, 0.35, 0.6, 0.8, 1], [-PUSH_DEG, -55, -28, -2, 14, STRIKE_DEG]))
    return Foot(place, pitch, 0.0, max(0.0, -pitch) * (1 - t) ** 2)


def walk_posture(rig, phase, stride, style, height):
    """One instant of the gait; `height` is that of the pelvis, see `walk`."""
    turn = math.tau * phase
    s = rig.build.scale
    ahead = stride * style["ahead"]
    feet = {
        "left": _walk_foot(rig, "left", phase % 1, stride, ahead, style["width"]),
        "right": _walk_foot(rig, "right", (phase + 0.5) % 1, stride, ahead, style["width"]),
    }
    sway = math.sin(turn - 0.35)
    pelvis = np.array(
        [
            style["sway"] * s * sway,
            height + 0.021 * s * math.cos(2 * (turn - math.tau * 0.30)),
            0.01 * s * math.sin(2 * turn),
        ]
    )
    yaw, lift = -style["hip_yaw"] * math.cos(turn), style["hip_roll"] * sway
    lean = style["lean"]
    chest_yaw = style["chest_yaw"] * math.cos(turn)
    angles = {
        "hips": (lean, yaw, lift),
        "spine": (0.5, (chest_yaw - yaw) * 0.5, -lift * 0.75),
        "chest": (0.5, (chest_yaw - yaw) * 0.5, -lift * 0.4),
        "neck": (-lean * 0.4, -chest_yaw * 0.5, lift * 0.1),
        "head": (-lean * 0.6 + style["head_pitch"], -chest_yaw * 0.5, lift * 0.05),
    }
    for side, sign in (("left", 1), ("right", -1)):
        swing = -sign * math.cos(turn - 0.25) * style[f"{side}_swing"]  # forward > 0, against the leg of the same side
        flex = 14 + 0.5 * max(0.0, swing + 10) + style.get(f"{side}_flex", 0)
        angles[f"{side}_upper_arm"] = (-(swing * 0.95 + 1), 0, -sign * style["arm_in"])
        angles[f"{side}_forearm"] = (-flex, -sign * 6, 0)
        angles[f"{side}_hand"] = (-4, 0, 0)
        angles[f"{side}_shoulder"] = (0, sign * swing * 0.12, 0)
    hang(angles, style)
    return Posture(pelvis, feet, angles, knee_out=style.get("knee_out", 4.0))


def walk(rig, style):
    """The walking cycle: (times, postures, ground speed). The pelvis is as high as both legs can reach all the time."""
    legs = rig.at("left_thigh")[1]
    stride = 1.43 * legs * style["stride"]
    period = 1.04 * math.sqrt(legs / 0.915) / style["cadence"]
    phases = np.arange(WALK_KEYS + 1) / WALK_KEYS
    best = (0.0, 0.0)
    for ahead in np.arange(0.20, 0.32, 0.01):  # where the foot strikes: the choice that lets the pelvis stay highest
        low, high = 0.7 * legs, legs * 1.1
        for _ in range(16):
            height = (low + high) / 2
            low, high = (
                (height, high) if _stretch(rig, stride, {**style, "ahead": ahead}, height) < 0.996 else (low, height)
            )
        best = max(best, (low, ahead))
    low, style = best[0], {**style, "ahead": best[1]}
    return phases * period, [walk_posture(rig, p % 1, stride, style, low) for p in phases], stride / period


def _stretch(rig, stride, style, height):
    """The largest hip-to-ankle distance over the cycle as a share of the leg's length."""
    worst = 0.0
    for p in np.arange(24) / 24:
        posture = walk_posture(rig, p, stride, style, height)
        turn = rotation(*posture.angles["hips"])
        for side in ("left", "right"):
            hip = posture.pelvis + turn @ rig.offset(rig.index[f"{side}_thigh"])
            length = sum(np.linalg.norm(rig.offset(rig.index[f"{side}_{part}"])) for part in ("shin", "foot"))
            worst = max(worst, np.linalg.norm(posture.feet[side].ankle - hip) / length)
    return worst

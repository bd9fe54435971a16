"""What people do on the spot: stand, look around, talk, sit."""

import math

import numpy as np

from .posture import Foot, Posture, ankle, hang


def _standing(rig, shift, style, drop=0.004):
    """Feet on the ground a little apart and turned out; the pelvis above them, `shift` to the left (-1..1)."""
    s = rig.build.scale
    feet = {}
    for side, sign in (("left", 1), ("right", -1)):
        feet[side] = Foot(ankle(rig, side) + (sign * 0.025 * s, 0, sign * -0.015 * s), 0, sign * 9)
    pelvis = np.array([0.028 * s * shift, rig.at("hips")[1] - (drop + 0.006 * abs(shift)) * s, 0.0])
    angles = {
        "hips": (1, 0, 3.0 * shift),
        "spine": (0, 0, -2.2 * shift),
        "chest": (0, 0, -1.0 * shift),
        "neck": (0, 0, 0.4 * shift),
        "head": (0, 0, 0),
    }
    for side, sign in (("left", 1), ("right", -1)):
        angles[f"{side}_upper_arm"] = (2, 0, -sign * (style["arm_in"] + 0.5 + sign * 0.8 * shift))
        angles[f"{side}_forearm"] = (-(12 + style.get(f"{side}_flex", 0)), -sign * 8, 0)
        angles[f"{side}_hand"] = (-4, 0, 0)
        angles[f"{side}_shoulder"] = (0, 0, 0)
    hang(angles, style)
    return Posture(pelvis, feet, angles, knee_out=9)


def _added(posture, joint, pitch=0.0, yaw=0.0, roll=0.0):
    old = posture.angles.get(joint, (0, 0, 0))
    posture.angles[joint] = (old[0] + pitch, old[1] + yaw, old[2] + roll)


def _breathe(posture, t, period=3.0):
    breath = math.sin(math.tau * t / period)
    _added(posture, "chest", pitch=-0.9 * breath)
    _added(posture, "head", pitch=0.8 * breath)
    for side, sign in (("left", 1), ("right", -1)):
        _added(posture, f"{side}_shoulder", roll=sign * 1.2 * breath)
        _added(posture, f"{side}_upper_arm", roll=-sign * 1.0 * breath)


def idle_posture(rig, t, style):
    turn = math.tau * t / 6
    posture = _standing(rig, 0.75 * math.sin(turn) + 0.15, style)
    _breathe(posture, t)
    _added(posture, "head", yaw=9 * math.sin(turn + 1) + 4 * math.sin(2 * turn), pitch=2 * math.sin(turn * 2 + 0.5))
    return posture


def wait_posture(rig, t, style):
    """Looks around: left, ahead, right, at the wrist."""
    posture = _standing(rig, 0.6 * math.cos(math.tau * t / 9), style)
    _breathe(posture, t)
    look = _curve(t, [(0, 0), (1.2, 42), (2.6, 38), (3.6, 0), (4.4, -30), (5.6, -48), (6.4, -20), (7.2, 0), (9, 0)])
    down = _curve(t, [(0, 2), (1.2, -3), (2.6, 0), (4.4, 4), (5.6, -4), (6.6, 18), (8.0, 20), (9, 2)])
    wrist = _curve(t, [(0, 0), (6.0, 0), (6.8, 1), (8.0, 1), (8.8, 0), (9, 0)])
    for joint, share in (("spine", 0.12), ("chest", 0.18), ("neck", 0.3), ("head", 0.4)):
        _added(posture, joint, yaw=look * share, pitch=down * (share if joint in ("neck", "head") else 0))
    _added(posture, "left_forearm", pitch=-78 * wrist, yaw=-28 * wrist)
    _added(posture, "left_upper_arm", pitch=-18 * wrist, roll=-4 * wrist)
    return posture


def talk_posture(rig, t, style):
    """Both forearms raised by turns, the head nods."""
    turn = math.tau * t / 6
    posture = _standing(rig, 0.5 * math.sin(turn), style)
    _breathe(posture, t)
    right = _curve(
        t, [(0, 0.15), (0.6, 0.9), (1.1, 0.7), (1.5, 1.0), (2.1, 0.75), (2.6, 0.9), (3.3, 0.2), (4.5, 0.1), (6, 0.15)]
    )
    left = _curve(
        t, [(0, 0.1), (1.2, 0.2), (2.6, 0.5), (3.3, 0.95), (3.8, 0.7), (4.3, 0.95), (4.9, 0.6), (5.5, 0.15), (6, 0.1)]
    )
    for side, sign, lift in (("right", -1, right), ("left", 1, left)):
        wave = math.sin(math.tau * t * 5 / 6 + (0 if sign > 0 else 1.3)) * lift
        _added(posture, f"{side}_upper_arm", pitch=-24 * lift, roll=sign * 5 * lift)
        _added(posture, f"{side}_forearm", pitch=-72 * lift - 9 * wave, yaw=-sign * (20 * lift - 16 * wave))
        _added(posture, f"{side}_hand", pitch=-10 * wave, yaw=-sign * 20 * lift)
    _added(
        posture,
        "head",
        pitch=4 * math.sin(2 * turn) + 2 * math.sin(5 * turn),
        yaw=7 * math.sin(turn + 0.7),
        roll=2 * math.sin(turn),
    )
    _added(posture, "chest", yaw=4 * math.sin(turn))
    return posture


def sit_posture(rig, t, style):
    """On a seat 0.45 m high whose front edge is 0.12 m behind the origin, which stays between the feet."""
    s = rig.build.scale
    seat = 0.45 + 0.10 * s
    thigh = np.linalg.norm(rig.offset(rig.index["left_shin"]))
    feet = {
        side: Foot(ankle(rig, side) + (sign * 0.03 * s, 0, 0.02), 0, sign * 8)
        for side, sign in (("left", 1), ("right", -1))
    }
    posture = Posture(np.array([0, seat, -thigh * 0.93]), feet, knee_out=8)
    posture.angles = {"hips": (-8, 0, 0), "spine": (7, 0, 0), "chest": (8, 0, 0), "neck": (3, 0, 0), "head": (-2, 0, 0)}
    for side, sign in (("left", 1), ("right", -1)):
        posture.angles[f"{side}_upper_arm"] = (-24, 0, -sign * (style["arm_in"] + 1))
        posture.angles[f"{side}_forearm"] = (-48, -sign * 22, 0)
        posture.angles[f"{side}_hand"] = (12, 0, 0)
    _breathe(posture, t, 4.0)
    look = _curve(t, [(0, 5), (2, 25), (3.5, 20), (5, -15), (6.5, -18), (8, 5)])
    _added(posture, "neck", yaw=look * 0.4)
    _added(posture, "head", yaw=look * 0.6, pitch=3 * math.sin(math.tau * t / 4))
    return posture


def _curve(t, keys):
    """Smooth passage through (time, value) keys, level at each of them."""
    times, values = zip(*keys)
    i = min(max(int(np.searchsorted(times, t, "right")) - 1, 0), len(times) - 2)
    f = min(max((t - times[i]) / (times[i + 1] - times[i]), 0), 1)
    f = f * f * (3 - 2 * f)
    return values[i] * (1 - f) + values[i + 1] * f


FREE_CLIPS = {
    "idle": (idle_posture, 6.0),
    "talk": (talk_posture, 6.0),
    "wait": (wait_posture, 9.0),
    "sit": (sit_posture, 8.0),
}

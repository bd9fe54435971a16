"""Human motion: walking with feet that do not slide, standing, talking, waiting, sitting.

Each clip samples a `Posture` and solves it: the pelvis and the feet are placed, legs follow by two-bone inverse kinematics, the
rest are joint angles. Angles in degrees; pitch > 0 leans or looks down/forward, yaw > 0 turns left, roll > 0 lifts the left side.
Gait pattern: duty factor, pelvis motion and foot rockers (heel, ankle, ball) after Perry, Gait Analysis (1992).
"""

import math
from dataclasses import dataclass, field

import numpy as np

DUTY = 0.62             # share of the cycle a foot is on the ground
FLAT_FROM, FLAT_TO = 0.09, 0.37  # part of the cycle with the whole sole on the ground
STRIKE_DEG, PUSH_DEG = 19, 58    # toes up at heel strike; heel up at toe-off
WALK_KEYS, FREE_RATE = 40, 8     # keys in one walking cycle; keys a second elsewhere


@dataclass
class Foot:
    """Ankle position, sole pitch (toes up > 0), heading, and bend of the toes against the sole."""
    ankle: np.ndarray
    pitch: float = 0.0
    yaw: float = 0.0
    toes: float = 0.0


@dataclass
class Posture:
    pelvis: np.ndarray
    feet: dict
    angles: dict = field(default_factory=dict)   # joint -> (pitch, yaw, roll) relative to its parent, bind pose = 0
    knee_out: float = 6.0                        # direction the knees point to, degrees outwards


def rotation(pitch=0.0, yaw=0.0, roll=0.0):
    """Yaw about +Y, then pitch about +X, then roll about +Z (intrinsic), degrees."""
    p, y, r = (math.radians(v) for v in (pitch, yaw, roll))
    about_x = np.array([[1, 0, 0], [0, math.cos(p), -math.sin(p)], [0, math.sin(p), math.cos(p)]])
    about_y = np.array([[math.cos(y), 0, math.sin(y)], [0, 1, 0], [-math.sin(y), 0, math.cos(y)]])
    about_z = np.array([[math.cos(r), -math.sin(r), 0], [math.sin(r), math.cos(r), 0], [0, 0, 1]])
    return about_y @ about_x @ about_z


def quaternion(m):
    """[x, y, z, w] of a rotation matrix (the largest component is found first: stable for every turn)."""
    squares = np.array([1 + m[0, 0] - m[1, 1] - m[2, 2], 1 - m[0, 0] + m[1, 1] - m[2, 2], 1 - m[0, 0] - m[1, 1] + m[2, 2], 1 + np.trace(m)])
    k = int(squares.argmax())
    q = [np.array([squares[0], m[1, 0] + m[0, 1], m[0, 2] + m[2, 0], m[2, 1] - m[1, 2]]),
         np.array([m[1, 0] + m[0, 1], squares[1], m[2, 1] + m[1, 2], m[0, 2] - m[2, 0]]),
         np.array([m[0, 2] + m[2, 0], m[2, 1] + m[1, 2], squares[2], m[1, 0] - m[0, 1]]),
         np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], squares[3]])][k]
    return q / np.linalg.norm(q)


def _frame(along, front):
    """Orthonormal frame whose y is `along` and whose z is nearest to `front`."""
    y = along / np.linalg.norm(along)
    z = front - y * (front @ y)
    z /= np.linalg.norm(z)
    return np.stack([np.cross(y, z), y, z], axis=1)


def solve(rig, posture):
    """Local rotation matrices of all joints, and the translation of the hips, for a posture."""
    local = [np.eye(3) for _ in rig.names]
    world = [np.eye(3) for _ in rig.names]
    place = [np.zeros(3) for _ in rig.names]
    legs = {f"{side}_{part}" for side in ("left", "right") for part in ("thigh", "shin", "foot", "toes")}
    for i, name in enumerate(rig.names):
        parent = rig.parents[i]
        if parent < 0 or name in legs:
            continue
        local[i] = rotation(*posture.angles.get(name, (0, 0, 0)))
        world[i] = world[parent] @ local[i]
        place[i] = place[parent] + world[parent] @ rig.offset(i) if name != "hips" else posture.pelvis
    hips = rig.index["hips"]
    for side, sign in (("left", 1), ("right", -1)):
        thigh, shin, foot, toes = (rig.index[f"{side}_{part}"] for part in ("thigh", "shin", "foot", "toes"))
        target = posture.feet[side]
        hip = posture.pelvis + world[hips] @ rig.offset(thigh)
        upper, lower = np.linalg.norm(rig.offset(shin)), np.linalg.norm(rig.offset(foot))
        reach = target.ankle - hip
        length = min(np.linalg.norm(reach), (upper + lower) * 0.9995)
        forward = rotation(yaw=sign * posture.knee_out + 0.6 * target.yaw) @ np.array([0, 0, 1.0])
        frame = _frame(reach, forward)
        along = (upper ** 2 - lower ** 2 + length ** 2) / (2 * length)
        knee = hip + frame[:, 1] * along + frame[:, 2] * math.sqrt(max(upper ** 2 - along ** 2, 0))
        ankle = hip + frame[:, 1] * length
        world[thigh] = _frame(knee - hip, forward) @ _frame(rig.offset(shin), np.array([0, 0, 1.0])).T
        world[shin] = _frame(ankle - knee, forward) @ _frame(rig.offset(foot), np.array([0, 0, 1.0])).T
        world[foot] = rotation(pitch=-target.pitch, yaw=target.yaw)
        local[thigh] = world[hips].T @ world[thigh]
        local[shin] = world[thigh].T @ world[shin]
        local[foot] = world[shin].T @ world[foot]
        local[toes] = rotation(pitch=-target.toes)
    return local, posture.pelvis


def _ankle(rig, side):
    return rig.at(f"{side}_foot").copy()


def _rocker(rig, side, pitch, pivot):
    """Where the ankle is, against its place in the flat foot, when the foot turns by pitch about its heel or ball."""
    scale = rig.build.scale
    ankle = rig.at(f"{side}_foot")
    point = np.array([ankle[0], 0, ankle[2] - 0.066 * scale]) if pivot == "heel" else np.array([ankle[0], rig.at(f"{side}_toes")[1], rig.at(f"{side}_toes")[2]])
    return point + rotation(pitch=-pitch) @ (ankle - point) - ankle


def _walk_foot(rig, side, phase, stride, ahead, width):
    """The foot at `phase` of its own cycle (0 = heel strike), in the frame that moves with the body."""
    base = _ankle(rig, side)
    base[0] *= width

    def stance(p):
        if p < FLAT_FROM:
            t = p / FLAT_FROM
            pitch, pivot = STRIKE_DEG * (1 - t) ** 1.5, "heel"
        elif p < FLAT_TO:
            return base + (0, 0, ahead - stride * p), 0.0
        else:
            t = (p - FLAT_TO) / (DUTY - FLAT_TO)
            pitch, pivot = -PUSH_DEG * t ** 1.8, "ball"
        return base + _rocker(rig, side, pitch, pivot) + (0, 0, ahead - stride * p), pitch

    if phase <= DUTY:
        ankle, pitch = stance(phase)
        return Foot(ankle, pitch, 0.0, max(0.0, -pitch))
    t, span, step = (phase - DUTY) / (1 - DUTY), 1 - DUTY, 1e-3
    (start, _), (before, _), (end, _), (after, _) = stance(DUTY), stance(DUTY - step), stance(0.0), stance(step)
    end = end  # heel strike of the next cycle happens at the same place in the body's frame
    leave, arrive = (start - before) / step * span, (after - end) / step * span
    h00, h10, h01, h11 = 2 * t ** 3 - 3 * t ** 2 + 1, t ** 3 - 2 * t ** 2 + t, -2 * t ** 3 + 3 * t ** 2, t ** 3 - t ** 2
    ankle = h00 * start + h10 * leave + h01 * end + h11 * arrive
    ankle[1] += 0.035 * rig.build.scale * math.sin(math.pi * t) ** 2
    pitch = float(np.interp(t, [0, 0.12, 0.35, 0.6, 0.8, 1], [-PUSH_DEG, -55, -28, -2, 14, STRIKE_DEG]))
    return Foot(ankle, pitch, 0.0, max(0.0, -pitch) * (1 - t) ** 2)


def walk_posture(rig, phase, stride, style, height):
    """One instant of the gait; `height` is that of the pelvis, see `walk`."""
    turn = math.tau * phase
    s = rig.build.scale
    ahead = stride * style["ahead"]
    feet = {"left": _walk_foot(rig, "left", phase % 1, stride, ahead, style["width"]),
            "right": _walk_foot(rig, "right", (phase + 0.5) % 1, stride, ahead, style["width"])}
    sway = math.sin(turn - 0.35)
    pelvis = np.array([style["sway"] * s * sway, height + 0.021 * s * math.cos(2 * (turn - math.tau * 0.30)), 0.01 * s * math.sin(2 * turn)])
    yaw, lift = -style["hip_yaw"] * math.cos(turn), style["hip_roll"] * sway
    lean = style["lean"]
    chest_yaw = style["chest_yaw"] * math.cos(turn)
    angles = {"hips": (lean, yaw, lift), "spine": (0.5, (chest_yaw - yaw) * 0.5, -lift * 0.75), "chest": (0.5, (chest_yaw - yaw) * 0.5, -lift * 0.4),
              "neck": (-lean * 0.4, -chest_yaw * 0.5, lift * 0.1), "head": (-lean * 0.6 + style["head_pitch"], -chest_yaw * 0.5, lift * 0.05)}
    for side, sign in (("left", 1), ("right", -1)):
        swing = -sign * math.cos(turn - 0.25) * style[f"{side}_swing"]    # forward > 0, against the leg of the same side
        flex = 14 + 0.5 * max(0.0, swing + 10) + style.get(f"{side}_flex", 0)
        angles[f"{side}_upper_arm"] = (-(swing * 0.95 + 1), 0, -sign * style["arm_in"])
        angles[f"{side}_forearm"] = (-flex, -sign * 6, 0)
        angles[f"{side}_hand"] = (-4, 0, 0)
        angles[f"{side}_shoulder"] = (0, sign * swing * 0.12, 0)
    _hang(angles, style)
    return Posture(pelvis, feet, angles, knee_out=style.get("knee_out", 4.0))


def _hang(angles, style):
    """A hand that carries a bag: the arm stays nearly straight and the bag's weight keeps it upright in the grip."""
    for side in ("left", "right"):
        if style.get("carry") == side:
            arm, fore = angles[f"{side}_upper_arm"], angles[f"{side}_forearm"]
            angles[f"{side}_forearm"] = (-8.0, fore[1], 0)
            angles[f"{side}_hand"] = (8.0 - arm[0], 0, -arm[2])


DEFAULT_STYLE = {"cadence": 1.0, "stride": 1.0, "sway": 0.020, "hip_yaw": 6.0, "hip_roll": 3.0, "chest_yaw": 5.0, "lean": 3.0, "head_pitch": 1.0,
                 "left_swing": 20.0, "right_swing": 20.0, "arm_in": 10.5, "width": 0.80}


def walk(rig, style):
    """The walking cycle: (times, postures, ground speed). The pelvis is as high as both legs can reach all the time."""
    legs = rig.at("left_thigh")[1]
    stride = 1.43 * legs * style["stride"]
    period = 1.04 * math.sqrt(legs / 0.915) / style["cadence"]
    phases = np.arange(WALK_KEYS + 1) / WALK_KEYS
    best = (0.0, 0.0)
    for ahead in np.arange(0.20, 0.32, 0.01):   # where the foot strikes: the choice that lets the pelvis stay highest
        low, high = 0.7 * legs, legs * 1.1
        for _ in range(16):
            height = (low + high) / 2
            low, high = (height, high) if _stretch(rig, stride, {**style, "ahead": ahead}, height) < 0.996 else (low, height)
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


def _standing(rig, shift, style, drop=0.004):
    """Feet on the ground a little apart and turned out; the pelvis above them, `shift` to the left (-1..1)."""
    s = rig.build.scale
    feet = {}
    for side, sign in (("left", 1), ("right", -1)):
        ankle = _ankle(rig, side) + (sign * 0.025 * s, 0, sign * -0.015 * s)
        feet[side] = Foot(ankle, 0, sign * 9)
    pelvis = np.array([0.028 * s * shift, rig.at("hips")[1] - (drop + 0.006 * abs(shift)) * s, 0.0])
    angles = {"hips": (1, 0, 3.0 * shift), "spine": (0, 0, -2.2 * shift), "chest": (0, 0, -1.0 * shift), "neck": (0, 0, 0.4 * shift), "head": (0, 0, 0)}
    for side, sign in (("left", 1), ("right", -1)):
        angles[f"{side}_upper_arm"] = (2, 0, -sign * (style["arm_in"] + 0.5 + sign * 0.8 * shift))
        angles[f"{side}_forearm"] = (-(12 + style.get(f"{side}_flex", 0)), -sign * 8, 0)
        angles[f"{side}_hand"] = (-4, 0, 0)
        angles[f"{side}_shoulder"] = (0, 0, 0)
    _hang(angles, style)
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
    right = _curve(t, [(0, 0.15), (0.6, 0.9), (1.1, 0.7), (1.5, 1.0), (2.1, 0.75), (2.6, 0.9), (3.3, 0.2), (4.5, 0.1), (6, 0.15)])
    left = _curve(t, [(0, 0.1), (1.2, 0.2), (2.6, 0.5), (3.3, 0.95), (3.8, 0.7), (4.3, 0.95), (4.9, 0.6), (5.5, 0.15), (6, 0.1)])
    for side, sign, lift in (("right", -1, right), ("left", 1, left)):
        wave = math.sin(math.tau * t * 5 / 6 + (0 if sign > 0 else 1.3)) * lift
        _added(posture, f"{side}_upper_arm", pitch=-24 * lift, roll=sign * 5 * lift)
        _added(posture, f"{side}_forearm", pitch=-72 * lift - 9 * wave, yaw=-sign * (20 * lift - 16 * wave))
        _added(posture, f"{side}_hand", pitch=-10 * wave, yaw=-sign * 20 * lift)
    _added(posture, "head", pitch=4 * math.sin(2 * turn) + 2 * math.sin(5 * turn), yaw=7 * math.sin(turn + 0.7), roll=2 * math.sin(turn))
    _added(posture, "chest", yaw=4 * math.sin(turn))
    return posture


def sit_posture(rig, t, style):
    """On a seat 0.45 m high whose front edge is 0.12 m behind the origin, which stays between the feet."""
    s = rig.build.scale
    seat = 0.45 + 0.10 * s
    thigh = np.linalg.norm(rig.offset(rig.index["left_shin"]))
    feet = {side: Foot(_ankle(rig, side) + (sign * 0.03 * s, max(0.0, 0.0), 0.02), 0, sign * 8) for side, sign in (("left", 1), ("right", -1))}
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


FREE_CLIPS = {"idle": (idle_posture, 6.0), "talk": (talk_posture, 6.0), "wait": (wait_posture, 9.0), "sit": (sit_posture, 8.0)}


def all_clips(rig, style):
    """{name: (times, rotations per joint (keys x joints x 4), hip positions, extras)} ready for a glTF file."""
    style = {**DEFAULT_STYLE, **style}
    times, postures, speed = walk(rig, style)
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

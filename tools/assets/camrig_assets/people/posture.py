"""A posture places the pelvis and the feet and turns the other joints; `solve` finds the legs by two-bone inverse
kinematics.

Angles in degrees; pitch > 0 leans or looks down/forward, yaw > 0 turns left, roll > 0 lifts the left side.
"""

import math
from dataclasses import dataclass, field

import numpy as np


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
    angles: dict = field(default_factory=dict)  # joint -> (pitch, yaw, roll) relative to its parent, bind pose = 0
    knee_out: float = 6.0  # direction the knees point to, degrees outwards


def rotation(pitch=0.0, yaw=0.0, roll=0.0):
    """Yaw about +Y, then pitch about +X, then roll about +Z (intrinsic), degrees."""
    p, y, r = (math.radians(v) for v in (pitch, yaw, roll))
    about_x = np.array([[1, 0, 0], [0, math.cos(p), -math.sin(p)], [0, math.sin(p), math.cos(p)]])
    about_y = np.array([[math.cos(y), 0, math.sin(y)], [0, 1, 0], [-math.sin(y), 0, math.cos(y)]])
    about_z = np.array([[math.cos(r), -math.sin(r), 0], [math.sin(r), math.cos(r), 0], [0, 0, 1]])
    return about_y @ about_x @ about_z


def quaternion(m):
    """[x, y, z, w] of a rotation matrix (the largest component is found first: stable for every turn)."""
    squares = np.array(
        [
            1 + m[0, 0] - m[1, 1] - m[2, 2],
            1 - m[0, 0] + m[1, 1] - m[2, 2],
            1 - m[0, 0] - m[1, 1] + m[2, 2],
            1 + np.trace(m),
        ]
    )
    k = int(squares.argmax())
    q = [
        np.array([squares[0], m[1, 0] + m[0, 1], m[0, 2] + m[2, 0], m[2, 1] - m[1, 2]]),
        np.array([m[1, 0] + m[0, 1], squares[1], m[2, 1] + m[1, 2], m[0, 2] - m[2, 0]]),
        np.array([m[0, 2] + m[2, 0], m[2, 1] + m[1, 2], squares[2], m[1, 0] - m[0, 1]]),
        np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], squares[3]]),
    ][k]
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
        along = (upper**2 - lower**2 + length**2) / (2 * length)
        knee = hip + frame[:, 1] * along + frame[:, 2] * math.sqrt(max(upper**2 - along**2, 0))
        ankle = hip + frame[:, 1] * length
        world[thigh] = _frame(knee - hip, forward) @ _frame(rig.offset(shin), np.array([0, 0, 1.0])).T
        world[shin] = _frame(ankle - knee, forward) @ _frame(rig.offset(foot), np.array([0, 0, 1.0])).T
        world[foot] = rotation(pitch=-target.pitch, yaw=target.yaw)
        local[thigh] = world[hips].T @ world[thigh]
        local[shin] = world[thigh].T @ world[shin]
        local[foot] = world[shin].T @ world[foot]
        local[toes] = rotation(pitch=-target.toes)
    return local, posture.pelvis


def ankle(rig, side):
    return rig.at(f"{side}_foot").copy()


def hang(angles, style):
    """A hand that carries a bag: the arm stays nearly straight and the bag's weight keeps it upright in the grip."""
    for side in ("left", "right"):
        if style.get("carry") == side:
            arm, fore = angles[f"{side}_upper_arm"], angles[f"{side}_forearm"]
            angles[f"{side}_forearm"] = (-8.0, fore[1], 0)
            angles[f"{side}_hand"] = (8.0 - arm[0], 0, -arm[2])

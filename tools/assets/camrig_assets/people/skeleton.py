"""The people's skeleton: joints with identity rotation in the bind pose, +Y up, facing +Z, the person's left is +X.

Lengths are for a person of 1.75 m and scale with height. Arms hang 18 degrees away from the body in the bind pose:
close to how they are used, so that shoulders deform little.
"""

import math
from dataclasses import dataclass

import numpy as np

REFERENCE_HEIGHT = 1.75
ARM_ANGLE = math.radians(18)

# COCO's 17 keypoints and the nodes that stand for them.
KEYPOINTS = {
    "nose": "nose",
    "left_eye": "left_eye",
    "right_eye": "right_eye",
    "left_ear": "left_ear",
    "right_ear": "right_ear",
    **{
        f"{side}_{coco}": f"{side}_{node}"
        for side in ("left", "right")
        for coco, node in (
            ("shoulder", "upper_arm"),
            ("elbow", "forearm"),
            ("wrist", "hand"),
            ("hip", "thigh"),
            ("knee", "shin"),
            ("ankle", "foot"),
        )
    },
}
FACE = {
    "nose": (0, 0.077, 0.118),
    "left_eye": (0.031, 0.113, 0.083),
    "right_eye": (-0.031, 0.113, 0.083),
    "left_ear": (0.078, 0.10, -0.005),
    "right_ear": (-0.078, 0.10, -0.005),
}


@dataclass(frozen=True)
class Build:
    """What makes one body differ from another; lengths in metres at the reference height, factors around 1."""

    height: float = 1.75
    female: float = 0.0  # 0 man .. 1 woman: shoulders, waist, hips, bust
    weight: float = 0.0  # -1 thin .. +1 heavy
    shoulders: float = 1.0
    legs: float = 1.0  # leg length against the usual share of the height
    head: float = 1.0

    @property
    def scale(self):
        return self.height / REFERENCE_HEIGHT


def joints(build):
    """(name, parent, position) in the bind pose, parents first, metres."""
    hip_y, rise = 0.915 * build.legs, (build.legs - 1) * 0.915
    shoulder_x = (0.174 - 0.024 * build.female + 0.008 * build.weight) * build.shoulders
    hip_x = 0.088 + 0.006 * build.female
    top = 1.412 + rise * 0.35
    chin = 1.75 - 0.225 * build.head
    listing = [
        ("root", None, (0, 0, 0)),
        ("hips", "root", (0, hip_y + 0.02, 0)),
        ("spine", "hips", (0, 1.06 + rise * 0.8, -0.005)),
        ("chest", "spine", (0, 1.22 + rise * 0.5, -0.01)),
        ("neck", "chest", (0, 1.485 + rise * 0.35, -0.018)),
        ("head", "neck", (0, chin + 0.045, -0.005)),
    ]
    for side, sign in (("left", 1), ("right", -1)):
        shoulder = np.array([sign * shoulder_x, top, -0.012])
        elbow = shoulder + 0.285 * np.array([sign * math.sin(ARM_ANGLE), -math.cos(ARM_ANGLE), -0.02])
        wrist = elbow + 0.25 * np.array([sign * math.sin(ARM_ANGLE * 0.85), -math.cos(ARM_ANGLE * 0.85), 0.10])
        listing += [
            (f"{side}_shoulder", "chest", (sign * 0.03, top + 0.015, -0.012)),
            (f"{side}_upper_arm", f"{side}_shoulder", shoulder),
            (f"{side}_forearm", f"{side}_upper_arm", elbow),
            (f"{side}_hand", f"{side}_forearm", wrist),
            (f"{side}_thigh", "hips", (sign * hip_x, hip_y, 0)),
            (f"{side}_shin", f"{side}_thigh", (sign * (hip_x - 0.006), 0.5 * build.legs, 0.012)),
            (f"{side}_foot", f"{side}_shin", (sign * (hip_x - 0.008), 0.088, -0.018)),
            (f"{side}_toes", f"{side}_foot", (sign * (hip_x - 0.002), 0.024, 0.11)),
        ]
    return [(name, parent, np.asarray(place, dtype=np.float64) * build.scale) for name, parent, place in listing]


def face_nodes(build):
    """(name, position) of the keypoints of the face, in the bind pose."""
    chin = 1.75 - 0.225 * build.head
    return [(name, (np.array(place) * build.head + (0, chin, 0.012)) * build.scale) for name, place in FACE.items()]


class Rig:
    """Joint names, parents and bind positions of one person."""

    def __init__(self, build):
        listing = joints(build)
        self.build = build
        self.names = [name for name, _, _ in listing]
        self.index = {name: i for i, name in enumerate(self.names)}
        self.parents = [-1 if parent is None else self.index[parent] for _, parent, _ in listing]
        self.places = np.array([place for _, _, place in listing])

    def at(self, name):
        return self.places[self.index[name]]

    def offset(self, i):
        """Bind position relative to the parent."""
        return self.places[i] - (self.places[self.parents[i]] if self.parents[i] >= 0 else 0)

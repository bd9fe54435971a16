"""glTF posing and writing in numpy, written from the glTF 2.0 specification and sharing nothing with camrig: what the truth
is checked against."""

from __future__ import annotations

import json
import struct

import cv2
import numpy as np

_TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
#: z-up from glTF's y-up.
WORLD_FROM_GLTF = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]])


def rotation(xyzw) -> np.ndarray:
    x, y, z, w = np.asarray(xyzw, float) / np.linalg.norm(xyzw)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])


def about_z(deg: float) -> np.ndarray:
    c, s = np.cos(np.radians(deg)), np.sin(np.radians(deg))
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])


def affine(linear, translation=(0, 0, 0)) -> np.ndarray:
    m = np.eye(4)
    m[:3, :3], m[:3, 3] = linear, translation
    return m


class Glb:
    """A .glb file with at most one skin."""

    def __init__(self, path):
        data = open(path, "rb").read()
        length = struct.unpack_from("<I", data, 12)[0]
        self.json = json.loads(data[20:20 + length])
        self.binary = data[28 + length:]

    def accessor(self, index) -> np.ndarray:
        a = self.json["accessors"][index]
        view = self.json["bufferViews"][a["bufferView"]]
        dtype, width = np.dtype(_TYPES[a["componentType"]]), _WIDTHS[a["type"]]
        start = view.get("byteOffset", 0) + a.get("byteOffset", 0)
        stride = view.get("byteStride", dtype.itemsize * width)
        raw = np.frombuffer(self.binary, "u1")
        rows = np.stack([raw[start + i * stride:start + i * stride + dtype.itemsize * width] for i in range(a["count"])])
        values = np.ascontiguousarray(rows).view(dtype).astype(float)
        return values / np.iinfo(dtype).max if a.get("normalized") else values

    def clip_duration(self, name) -> float:
        animation = next(a for a in self.json["animations"] if a["name"] == name)
        return max(self.json["accessors"][s["input"]]["max"][0] for s in animation["samplers"])

    def node_matrices(self, clip=None, seconds=0.0) -> list[np.ndarray]:
        """Of every node, in the z-up frame of the model."""
        nodes = self.json["nodes"]
        local = [{"translation": n.get("translation", [0, 0, 0]), "rotation": n.get("rotation", [0, 0, 0, 1]),
                  "scale": n.get("scale", [1, 1, 1])} for n in nodes]
        if clip:
            animation = next(a for a in self.json["animations"] if a["name"] == clip)
            for channel in animation["channels"]:
                sampler = animation["samplers"][channel["sampler"]]
                assert sampler.get("interpolation", "LINEAR") == "LINEAR"
                times, values = self.accessor(sampler["input"])[:, 0], self.accessor(sampler["output"])
                local[channel["target"]["node"]][channel["target"]["path"]] = _between(times, values, seconds)
        parents = {child: i for i, n in enumerate(nodes) for child in n.get("children", [])}
        made: dict[int, np.ndarray] = {}

        def matrix(i):
            if i not in made:
                n = local[i]
                own = affine(rotation(n["rotation"]) @ np.diag(n["scale"]), n["translation"])
                made[i] = (matrix(parents[i]) if i in parents else WORLD_FROM_GLTF) @ own
            return made[i]

        return [matrix(i) for i in range(len(nodes))]

    def surface(self, clip=None, seconds=0.0) -> np.ndarray:
        """Vertices (N x 3) that triangles use, of opaque and masked materials that are shown without a variant, posed, in the z-up frame of the model."""
        matrices = self.node_matrices(clip, seconds)
        points = []
        for node, matrix in zip(self.json["nodes"], matrices):
            if "mesh" not in node:
                continue
            for primitive in self.json["meshes"][node["mesh"]]["primitives"]:
                material = self.json["materials"][primitive["material"]] if "material" in primitive else {}
                is_worn = material.get("extras", {}).get("camrig_variants", {}).get("shown", True)
                if material.get("alphaMode") == "BLEND" or not is_worn:
                    continue
                attributes = primitive["attributes"]
                used = np.unique(self.accessor(primitive["indices"]).astype(int))
                p = np.c_[self.accessor(attributes["POSITION"]), np.ones(self.json["accessors"][attributes["POSITION"]]["count"])][used]
                if "skin" in node:
                    skin = self.json["skins"][node["skin"]]
                    inverse = self.accessor(skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
                    joints = np.stack([matrices[j] for j in skin["joints"]]) @ inverse
                    weights = self.accessor(attributes["WEIGHTS_0"])[used]
                    weights /= weights.sum(axis=1, keepdims=True)
                    blended = np.einsum("nk,nkij->nij", weights, joints[self.accessor(attributes["JOINTS_0"]).astype(int)[used]])
                    points.append(np.einsum("nij,nj->ni", blended, p)[:, :3])
                else:
                    points.append((p @ matrix.T)[:, :3])
        return np.concatenate(points)

    def keypoints(self, clip=None, seconds=0.0) -> dict[str, np.ndarray]:
        matrices = self.node_matrices(clip, seconds)
        return {n["extras"]["keypoint"]: m[:3, 3] for n, m in zip(self.json["nodes"], matrices) if "keypoint" in n.get("extras", {})}


def _between(times, values, t):
    if t <= times[0]:
        return values[0]
    if t >= times[-1]:
        return values[-1]
    i = int(np.searchsorted(times, t, side="right")) - 1
    share = (t - times[i]) / (times[i + 1] - times[i])
    a, b = values[i], values[i + 1]
    if values.shape[1] == 3:
        return a + share * (b - a)
    dot = a @ b
    if dot < 0:
        b, dot = -b, -dot
    if dot > 0.999999:
        return a + share * (b - a)
    angle = np.arccos(dot)
    return (np.sin((1 - share) * angle) * a + np.sin(share * angle) * b) / np.sin(angle)


def project(truth, points) -> np.ndarray:
    """N x 2 pixels of world points by OpenCV, with the camera that a truth describes."""
    k, lens = truth["intrinsics"], truth["lens"]
    link = rotation(truth["pose"]["orientation"])
    optical_from_world = np.stack([-link[:, 1], -link[:, 2], link[:, 0]])
    seen = (np.asarray(points) - truth["pose"]["position"]) @ optical_from_world.T
    matrix = np.array([[k["fx"], 0, k["cx"]], [0, k["fy"], k["cy"]], [0, 0, 1.0]])
    zero = np.zeros(3)
    if lens["model"] == "equidistant":
        return cv2.fisheye.projectPoints(seen[:, None], zero, zero, matrix, np.array(lens["coefficients"]))[0][:, 0]
    return cv2.projectPoints(seen[:, None], zero, zero, matrix, np.array(lens["coefficients"] or [0.0] * 5))[0][:, 0]


def write_glb(path, positions, indices, double_sided=True) -> None:
    """A white mesh of one primitive; positions in glTF's y-up frame."""
    positions, indices = np.asarray(positions, "<f4"), np.asarray(indices, "<u4").ravel()
    binary = positions.tobytes() + indices.tobytes()
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"metallicFactor": 0}, "doubleSided": double_sided}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": len(positions),
             "min": positions.min(0).tolist(), "max": positions.max(0).tolist()},
            {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": len(indices)}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": positions.nbytes},
                        {"buffer": 0, "byteOffset": positions.nbytes, "byteLength": indices.nbytes}],
        "buffers": [{"byteLength": len(binary)}],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(text) + 8 + len(binary)))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text)
        file.write(struct.pack("<I4s", len(binary), b"BIN\0") + binary)


def sphere(radius=1.0, rings=400, sectors=800):
    """Positions and indices of a sphere whose vertices lie on it."""
    polar, turn = np.meshgrid(np.linspace(0, np.pi, rings + 1), np.linspace(0, 2 * np.pi, sectors + 1), indexing="ij")
    positions = radius * np.stack([np.sin(polar) * np.cos(turn), np.cos(polar), np.sin(polar) * np.sin(turn)], -1).reshape(-1, 3)
    i = (np.arange(rings)[:, None] * (sectors + 1) + np.arange(sectors)).ravel()
    quads = np.stack([i, i + 1, i + sectors + 2, i, i + sectors + 2, i + sectors + 1], 1)
    return positions, quads.reshape(-1, 3)

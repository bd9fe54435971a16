"""What a .glb file shows in its rest pose, read for the export: triangles of each node with their material. glTF 2.0."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

_TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
#: z up from glTF's y up.
WORLD_FROM_GLTF = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]])


@dataclass(frozen=True)
class Material:
    """Factors are linear. `texture`: (bytes of a PNG or JPEG file, whether it repeats), coded in sRGB, or None."""

    name: str
    base_color: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)
    roughness: float = 1.0
    metallic: float = 1.0
    emissive: tuple[float, float, float] = (0.0, 0.0, 0.0)
    texture: tuple[bytes, bool] | None = field(default=None, repr=False)
    alpha_mode: str = "OPAQUE"
    alpha_cutoff: float = 0.5
    transmission: float = 0.0
    is_unlit: bool = False
    is_shown: bool = True  #: where no variant is asked for


@dataclass(frozen=True)
class Primitive:
    """positions, normals: Nx3; colors: Nx4 linear; uv: Nx2, v down, or None; triangles: Mx3."""

    positions: np.ndarray
    normals: np.ndarray
    colors: np.ndarray
    uv: np.ndarray | None
    triangles: np.ndarray
    material: Material


class Glb:
    """A binary glTF file. ValueError names what the export does not take."""

    def __init__(self, path: Path) -> None:
        data = path.read_bytes()
        if data[:4] != b"glTF":
            raise ValueError(f"{path}: not a binary glTF file")
        length = struct.unpack_from("<I", data, 12)[0]
        self.path = path
        self.json: dict[str, Any] = json.loads(data[20:20 + length])
        self.binary = data[28 + length:]
        self.materials = [self._material(item) for item in self.json.get("materials", [])]

    def primitives(self) -> list[Primitive]:
        """Those of the scene, in world axes (z up), about the model's origin."""
        found: list[Primitive] = []
        for node in self.json["scenes"][self.json.get("scene", 0)]["nodes"]:
            self._walk(node, WORLD_FROM_GLTF, found)
        return found

    def accessor(self, index: int) -> np.ndarray:
        """Rows x width; integers that are normalised become 0 to 1."""
        a = self.json["accessors"][index]
        if "sparse" in a:
            raise ValueError(f"{self.path}: accessor {index} is sparse")
        view = self.json["bufferViews"][a["bufferView"]]
        dtype, width = np.dtype(_TYPES[a["componentType"]]), _WIDTHS[a["type"]]
        stride = view.get("byteStride", dtype.itemsize * width)
        start = view.get("byteOffset", 0) + a.get("byteOffset", 0)
        values = np.ndarray((a["count"], width), dtype, self.binary, start, (stride, dtype.itemsize))
        if a.get("normalized"):
            return values / np.iinfo(dtype).max
        return values.astype(float if dtype.kind == "f" else np.int64)

    def _walk(self, index: int, parent: np.ndarray, found: list[Primitive]) -> None:
        node = self.json["nodes"][index]
        placed = parent @ _local(node)
        if "mesh" in node:
            # A skin places its mesh by its joints alone; in the rest pose they leave it where the file has it.
            at = WORLD_FROM_GLTF if "skin" in node else placed
            for item in self.json["meshes"][node["mesh"]]["primitives"]:
                if item.get("mode", 4) == 4:
                    found.append(self._primitive(item, at))
        for child in node.get("children", []):
            self._walk(child, placed, found)

    def _primitive(self, item: dict[str, Any], placed: np.ndarray) -> Primitive:
        names = item["attributes"]
        positions = self.accessor(names["POSITION"])
        colors = np.ones((len(positions), 4))
        if "COLOR_0" in names:
            given = self.accessor(names["COLOR_0"])
            colors[:, :given.shape[1]] = given
        normals = self.accessor(names["NORMAL"]) @ np.linalg.inv(placed[:3, :3])
        triangles = self.accessor(item["indices"]).reshape(-1, 3)
        if np.linalg.det(placed[:3, :3]) < 0:
            triangles = triangles[:, ::-1]
        return Primitive(
            positions=positions @ placed[:3, :3].T + placed[:3, 3],
            normals=normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12),
            colors=colors,
            uv=self.accessor(names["TEXCOORD_0"]) if "TEXCOORD_0" in names else None,
            triangles=triangles,
            material=self.materials[item["material"]] if "material" in item else Material("none"),
        )

    def _material(self, item: dict[str, Any]) -> Material:
        pbr = item.get("pbrMetallicRoughness", {})
        texture = None
        if "baseColorTexture" in pbr:
            if pbr["baseColorTexture"].get("texCoord", 0) != 0:
                raise ValueError(f"{self.path}: material {item.get('name')} has its colours at another TEXCOORD than 0")
            entry = self.json["textures"][pbr["baseColorTexture"]["index"]]
            view = self.json["bufferViews"][self.json["images"][entry["source"]]["bufferView"]]
            start = view.get("byteOffset", 0)
            sampler = self.json["samplers"][entry["sampler"]] if "sampler" in entry else {}
            texture = (self.binary[start:start + view["byteLength"]], sampler.get("wrapS", 10497) == 10497)
        strength = item.get("extensions", {}).get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
        return Material(
            name=item.get("name", ""),
            base_color=tuple(pbr.get("baseColorFactor", (1, 1, 1, 1))),
            roughness=pbr.get("roughnessFactor", 1.0),
            metallic=pbr.get("metallicFactor", 1.0),
            emissive=tuple(strength * value for value in item.get("emissiveFactor", (0, 0, 0))),
            texture=texture,
            alpha_mode=item.get("alphaMode", "OPAQUE"),
            alpha_cutoff=item.get("alphaCutoff", 0.5),
            transmission=item.get("extensions", {}).get("KHR_materials_transmission", {}).get("transmissionFactor", 0.0),
            is_unlit="KHR_materials_unlit" in item.get("extensions", {}),
            is_shown=item.get("extras", {}).get("camrig_variants", {}).get("shown", True),
        )


def rotation(xyzw: Any) -> np.ndarray:
    """3x3 of a quaternion."""
    x, y, z, w = np.asarray(xyzw, float) / np.linalg.norm(xyzw)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])


def _local(node: dict[str, Any]) -> np.ndarray:
    if "matrix" in node:
        return np.reshape(node["matrix"], (4, 4)).T.astype(float)
    placed = np.eye(4)
    placed[:3, :3] = rotation(node.get("rotation", (0, 0, 0, 1))) * np.asarray(node.get("scale", (1, 1, 1)), float)
    placed[:3, 3] = node.get("translation", (0, 0, 0))
    return placed

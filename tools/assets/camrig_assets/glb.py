"""A small writer of binary glTF 2.0 (GLB).

Only what the project's own assets need: nodes, triangle meshes, PBR materials, embedded images, skins and animations.
The bytes depend on the input alone: no time stamps, no hashes, keys in the order they were added.
"""

import json
import struct

import numpy as np

FLOAT, UINT8, UINT16, UINT32 = 5126, 5121, 5123, 5125
DTYPES = {FLOAT: np.float32, UINT8: np.uint8, UINT16: np.uint16, UINT32: np.uint32}
COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963
LINEAR_MIPMAP_LINEAR, LINEAR = 9987, 9729
REPEAT, CLAMP = 10497, 33071
LEAST_STEP = (
    2.0**-16
)  # positions are rounded to this (15 um), so that float noise of the generators stays out of the file


def number(value):
    """A JSON number with at most seven significant digits (what a float32 holds)."""
    value = float(f"{float(value):.7g}")
    return int(value) if value == int(value) and abs(value) < 1e9 else value


def numbers(values):
    return [number(v) for v in values]


class Glb:
    """Collects one asset; `bytes()` gives the file."""

    def __init__(self, name, extras=None):
        self.json = {
            "asset": {"version": "2.0", "generator": "camrig tools/assets"},
            "scene": 0,
            "scenes": [{"name": name, "nodes": []}],
            "nodes": [],
        }
        if extras:
            self.json["asset"]["extras"] = extras
        self._binary = bytearray()

    def _add(self, key, item):
        self.json.setdefault(key, []).append(item)
        return len(self.json[key]) - 1

    def _view(self, data, target=None):
        while len(self._binary) % 4:
            self._binary.append(0)
        view = {"buffer": 0, "byteOffset": len(self._binary), "byteLength": len(data)}
        if target:
            view["target"] = target
        self._binary += data
        return self._add("bufferViews", view)

    def accessor(self, values, kind, component=FLOAT, target=None, normalized=False, bounds=False):
        """Stores an array of `kind` (SCALAR, VEC3, ...) and returns the accessor's index."""
        array = np.ascontiguousarray(values, dtype=DTYPES[component])
        if array.size % COMPONENTS[kind]:
            raise ValueError(f"{array.size} numbers do not make whole {kind}s")
        item = {
            "bufferView": self._view(array.tobytes(), target),
            "componentType": component,
            "count": array.size // COMPONENTS[kind],
            "type": kind,
        }
        if normalized:
            item["normalized"] = True
        if bounds:
            rows = array.reshape(-1, COMPONENTS[kind])
            item["min"] = [float(v) for v in rows.min(axis=0)]
            item["max"] = [float(v) for v in rows.max(axis=0)]
        return self._add("accessors", item)

    def image(self, data, mime, name):
        return self._add("images", {"name": name, "mimeType": mime, "bufferView": self._view(data)})

    def texture(self, image, wrap=REPEAT, minify=LINEAR_MIPMAP_LINEAR):
        sampler = {"magFilter": LINEAR, "minFilter": minify, "wrapS": wrap, "wrapT": wrap}
        samplers = self.json.setdefault("samplers", [])
        if sampler not in samplers:
            samplers.append(sampler)
        return self._add("textures", {"sampler": samplers.index(sampler), "source": image})

    def material(
        self,
        name,
        base=(1, 1, 1, 1),
        texture=None,
        metallic=0.0,
        roughness=0.8,
        emissive=None,
        emissive_strength=None,
        emissive_texture=None,
        occlusion_texture=None,
        occlusion_set=1,
        alpha="OPAQUE",
        cutoff=0.5,
        double_sided=False,
        unlit=False,
        extras=None,
        transmission=None,
    ):
        pbr = {
            "baseColorFactor": numbers(tuple(base) + (1,) * (4 - len(base))),
            "metallicFactor": number(metallic),
            "roughnessFactor": number(roughness),
        }
        if texture is not None:
            pbr["baseColorTexture"] = {"index": texture}
        item = {"name": name, "pbrMetallicRoughness": pbr}
        if emissive is not None:
            item["emissiveFactor"] = numbers(emissive)
        if emissive_strength is not None:
            self._extend(item, "KHR_materials_emissive_strength", {"emissiveStrength": number(emissive_strength)})
        if transmission is not None:
            self._extend(item, "KHR_materials_transmission", {"transmissionFactor": number(transmission)})
        if emissive_texture is not None:
            item["emissiveTexture"] = {"index": emissive_texture}
        if occlusion_texture is not None:
            item["occlusionTexture"] = {"index": occlusion_texture, "texCoord": occlusion_set}
        if alpha != "OPAQUE":
            item["alphaMode"] = alpha
        if alpha == "MASK":
            item["alphaCutoff"] = number(cutoff)
        if double_sided:
            item["doubleSided"] = True
        if unlit:
            self._extend(item, "KHR_materials_unlit", {})
        if extras:
            item["extras"] = extras
        return self._add("materials", item)

    def _extend(self, item, extension, values):
        item.setdefault("extensions", {})[extension] = values
        used = self.json.setdefault("extensionsUsed", [])
        if extension not in used:
            used.append(extension)

    def primitive(
        self, positions, normals, triangles, material, uv=None, uv1=None, colors=None, joints=None, weights=None
    ):
        """One drawable part. `colors` are linear 0..1 (stored as normalized bytes); `joints`/`weights` are Nx4.
        Unused vertices are dropped.
        """
        used, triangles = np.unique(np.asarray(triangles).reshape(-1), return_inverse=True)
        if used[-1] >= len(positions):
            raise ValueError("a triangle names a vertex that does not exist")
        uv, uv1, colors, joints, weights = (
            None if v is None else np.asarray(v)[used] for v in (uv, uv1, colors, joints, weights)
        )
        positions, normals = np.asarray(positions)[used], np.asarray(normals)[used]
        positions = np.round(np.asarray(positions, dtype=np.float64) / LEAST_STEP) * LEAST_STEP
        normals = np.round(np.asarray(normals, dtype=np.float64), 4)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        attributes = {
            "POSITION": self.accessor(positions, "VEC3", target=ARRAY_BUFFER, bounds=True),
            "NORMAL": self.accessor(normals, "VEC3", target=ARRAY_BUFFER),
        }
        if uv is not None:
            attributes["TEXCOORD_0"] = self.accessor(np.round(uv, 5), "VEC2", target=ARRAY_BUFFER)
        if uv1 is not None:
            attributes["TEXCOORD_1"] = self.accessor(np.round(uv1, 5), "VEC2", target=ARRAY_BUFFER)
        if colors is not None:
            rgba = np.ones((len(positions), 4))
            rgba[:, : np.shape(colors)[1]] = colors
            attributes["COLOR_0"] = self.accessor(
                np.round(np.clip(rgba, 0, 1) * 255), "VEC4", UINT8, ARRAY_BUFFER, normalized=True
            )
        if joints is not None:
            shares = byte_weights(weights)
            attributes["JOINTS_0"] = self.accessor(np.where(shares > 0, joints, 0), "VEC4", UINT8, ARRAY_BUFFER)
            attributes["WEIGHTS_0"] = self.accessor(shares, "VEC4", UINT8, ARRAY_BUFFER, normalized=True)
        component = UINT16 if len(positions) < 65535 else UINT32
        return {
            "attributes": attributes,
            "material": material,
            "indices": self.accessor(triangles, "SCALAR", component, ELEMENT_ARRAY_BUFFER),
        }

    def mesh(self, name, primitives):
        return self._add("meshes", {"name": name, "primitives": primitives})

    def node(self, name, parent=None, translation=None, rotation=None, scale=None, mesh=None, skin=None, extras=None):
        item = {"name": name}
        if translation is not None and any(translation):
            item["translation"] = numbers(translation)
        if rotation is not None and tuple(rotation) != (0, 0, 0, 1):
            item["rotation"] = numbers(rotation)
        if scale is not None and tuple(scale) != (1, 1, 1):
            item["scale"] = numbers(scale)
        if mesh is not None:
            item["mesh"] = mesh
        if skin is not None:
            item["skin"] = skin
        if extras:
            item["extras"] = extras
        index = self._add("nodes", item)
        siblings = (
            self.json["scenes"][0]["nodes"] if parent is None else self.json["nodes"][parent].setdefault("children", [])
        )
        siblings.append(index)
        return index

    def skin(self, name, joints, inverse_binds, skeleton):
        """`inverse_binds` are 4x4 row-major arrays in the order of `joints` (stored column-major, as glTF wants)."""
        matrices = np.transpose(np.asarray(inverse_binds), (0, 2, 1))
        return self._add(
            "skins",
            {
                "name": name,
                "joints": list(joints),
                "skeleton": skeleton,
                "inverseBindMatrices": self.accessor(matrices, "MAT4"),
            },
        )

    def animation(self, name, times, tracks, extras=None):
        """`tracks` is a list of (node, path, values), all sampled at `times` and interpolated linearly."""
        clock = self.accessor(times, "SCALAR", bounds=True)
        samplers, channels = [], []
        for node, path, values in tracks:
            kind = "VEC4" if path == "rotation" else "VEC3"
            samplers.append(
                {"input": clock, "interpolation": "LINEAR", "output": self.accessor(np.round(values, 6), kind)}
            )
            channels.append({"sampler": len(samplers) - 1, "target": {"node": node, "path": path}})
        item = {"name": name, "samplers": samplers, "channels": channels}
        if extras:
            item["extras"] = extras
        return self._add("animations", item)

    def bytes(self):
        while len(self._binary) % 4:
            self._binary.append(0)
        self.json["buffers"] = [{"byteLength": len(self._binary)}]
        text = json.dumps(self.json, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        total = 12 + 8 + len(text) + 8 + len(self._binary)
        return (
            struct.pack("<III", 0x46546C67, 2, total)
            + struct.pack("<II", len(text), 0x4E4F534A)
            + text
            + struct.pack("<II", len(self._binary), 0x004E4942)
            + bytes(self._binary)
        )


def byte_weights(weights):
    """Four weights a vertex as bytes whose sum is exactly 255: the rounding error goes to the largest."""
    weights = np.asarray(weights, dtype=np.float64)
    whole = np.round(weights / weights.sum(axis=1, keepdims=True) * 255).astype(np.int64)
    whole[np.arange(len(whole)), whole.argmax(axis=1)] += 255 - whole.sum(axis=1)
    return whole


def read(data):
    """Splits GLB bytes into (json, binary chunk); raises ValueError when the frame is wrong."""
    magic, version, total = struct.unpack_from("<III", data)
    if magic != 0x46546C67 or version != 2 or total != len(data):
        raise ValueError("not a GLB 2.0 file of the stated length")
    length, kind = struct.unpack_from("<II", data, 12)
    if kind != 0x4E4F534A:
        raise ValueError("the first chunk is not JSON")
    text = json.loads(data[20 : 20 + length])
    size, kind = struct.unpack_from("<II", data, 20 + length)
    if kind != 0x004E4942:
        raise ValueError("the second chunk is not binary")
    start = 28 + length
    return text, data[start : start + size]


def array(gltf, binary, index):
    """The values of an accessor as rows; normalized integers become 0..1."""
    item = gltf["accessors"][index]
    view = gltf["bufferViews"][item["bufferView"]]
    width = COMPONENTS[item["type"]]
    values = np.frombuffer(
        binary,
        DTYPES[item["componentType"]],
        item["count"] * width,
        view.get("byteOffset", 0) + item.get("byteOffset", 0),
    ).reshape(-1, width)
    if item.get("normalized"):
        return values / float(np.iinfo(values.dtype).max)
    return values

"""Writes tests/fuzz/corpus/gltf: small models that together use everything the loader reads.

A seed is a .glb, a .gltf, or what fuzz_gltf makes a .glb of: JSON, a NUL byte, the binary chunk. The last kind has no
lengths that a mutation would break.
"""

import base64
import io
import json
import pathlib
import struct

from PIL import Image

FOLDER = pathlib.Path(__file__).parent / "corpus/gltf"
FLOAT, I8, U8, I16, U16, U32 = 5126, 5120, 5121, 5122, 5123, 5125
CODES = {FLOAT: "f", I8: "b", U8: "B", I16: "h", U16: "H", U32: "I"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
TRIANGLE = [0, 0, 0, 1, 0, 0, 0, 1, 0]
QUAD = [0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0]


class Seed:
    def __init__(self, **document):
        self.json = {"asset": {"version": "2.0"}, **document}
        self.binary = b""

    def view(self, data, **more):
        self.binary += b"\0" * (-len(self.binary) % 4)
        views = self.json.setdefault("bufferViews", [])
        views.append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data), **more})
        self.binary += data
        return len(views) - 1

    def accessor(self, values, kind="VEC3", component=FLOAT, **more):
        view = self.view(struct.pack(f"<{len(values)}{CODES[component]}", *values))
        accessors = self.json.setdefault("accessors", [])
        accessors.append({"bufferView": view, "componentType": component, "count": len(values) // WIDTHS[kind], "type": kind, **more})
        return len(accessors) - 1

    def mesh(self, *primitives, **more):
        self.json.setdefault("meshes", []).append({"primitives": list(primitives), **more})
        self.json.setdefault("nodes", []).append({"mesh": len(self.json["meshes"]) - 1})
        self.json.setdefault("scenes", [{"nodes": []}])[0]["nodes"].append(len(self.json["nodes"]) - 1)
        return self

    def document(self):
        return json.dumps(self.json | ({"buffers": [{"byteLength": len(self.binary)}]} if self.binary else {})).encode()

    def split(self):
        return self.document() + b"\0" + self.binary

    def glb(self):
        text, binary = self.document(), self.binary
        text += b" " * (-len(text) % 4)
        binary += b"\0" * (-len(binary) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def picture(mode, kind, size=(5, 3), **save):
    image = Image.new("RGB", size)
    image.putdata([(40 * x, 80 * y, 255 - 40 * x) for y in range(size[1]) for x in range(size[0])])
    out = io.BytesIO()
    image.convert(mode).save(out, kind, **save)
    return out.getvalue()


def triangle():
    seed = Seed()
    return seed.mesh({"attributes": {"POSITION": seed.accessor(TRIANGLE)}})


def modes():
    seed = Seed()
    positions, normals = seed.accessor(QUAD), seed.accessor([0, 0, 1] * 4)
    indices = [seed.accessor([0, 1, 2, 3], "SCALAR", c) for c in (U8, U16, U32)]
    attributes = {"POSITION": positions, "NORMAL": normals}
    return seed.mesh(*({"mode": m, "attributes": attributes, "indices": indices[m % 3]} for m in range(7)))


def textured():
    texture = {"index": 0, "texCoord": 1, "extensions": {"KHR_texture_transform": {"offset": [0.5, 0], "scale": [2, 3], "rotation": 1.5, "texCoord": 0}}}
    seed = Seed(
        extensionsUsed=["KHR_texture_transform", "KHR_materials_unlit"],
        samplers=[{"magFilter": 9728, "minFilter": 9985, "wrapS": 33071, "wrapT": 33648}],
        textures=[{"source": i, "sampler": 0} for i in range(5)],
        materials=[
            {"pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0.2, 1], "baseColorTexture": texture, "metallicFactor": 0, "roughnessFactor": 0.5,
                                      "metallicRoughnessTexture": {"index": 1}},
             "normalTexture": {"index": 2, "scale": 0.5}, "occlusionTexture": {"index": 3, "strength": 0.5}, "emissiveTexture": {"index": 4},
             "emissiveFactor": [0, 0, 1], "alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": True},
            {"alphaMode": "BLEND", "extensions": {"KHR_materials_unlit": {}}}])
    kinds = [("RGBA", "PNG", {}), ("RGB", "JPEG", {"quality": 60}), ("P", "PNG", {"transparency": 1}), ("L", "JPEG", {"progressive": True}), ("I;16", "PNG", {})]
    seed.json["images"] = [{"bufferView": seed.view(picture(m, k, **save)), "mimeType": f"image/{k.lower()}"} for m, k, save in kinds]
    uv = seed.accessor([0, 0, 65535, 0, 0, 65535], "VEC2", U16, normalized=True)
    common = {"POSITION": seed.accessor(TRIANGLE), "TEXCOORD_0": uv, "TEXCOORD_1": seed.accessor([0, 0, 1, 0, 0, 1], "VEC2")}
    tangent, color = seed.accessor([1, 0, 0, 1] * 3, "VEC4"), seed.accessor([255, 0, 0] * 3, "VEC3", U8, normalized=True)
    return seed.mesh({"attributes": common | {"NORMAL": seed.accessor([0, 0, 1] * 3), "TANGENT": tangent, "COLOR_0": color}, "material": 0},
                     {"attributes": common, "material": 1})


def animate(seed, name, *channels):
    """channels: (node, path, interpolation, times, values, type)"""
    samplers = [{"input": seed.accessor(times, "SCALAR"), "output": seed.accessor(values, kind), "interpolation": interpolation}
                for _, _, interpolation, times, values, kind in channels]
    targets = [{"sampler": i, "target": {"node": c[0], "path": c[1]}} for i, c in enumerate(channels)]
    seed.json.setdefault("animations", []).append({"name": name, "samplers": samplers, "channels": targets, "extras": {"ground_speed_m_s": 1.2}})
    return seed


def skinned():
    seed = Seed()
    skin = {f"{name}_{i}": seed.accessor(values, "VEC4", component)
            for i in range(2) for name, values, component in (("JOINTS", [0, 1, 0, 1] * 3, U8), ("WEIGHTS", [0.4, 0.1, 0, 0] * 3, FLOAT))}
    seed.mesh({"attributes": {"POSITION": seed.accessor(TRIANGLE), **skin}})
    identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
    seed.json["nodes"][0]["skin"] = 0
    seed.json["nodes"] += [{"name": "hip", "children": [2], "translation": [0, 1, 0]}, {"name": "knee", "rotation": [0, 0, 0, 1], "scale": [1, 2, 1]}]
    seed.json["scenes"][0]["nodes"].append(1)
    seed.json["skins"] = [{"joints": [1, 2], "skeleton": 1, "inverseBindMatrices": seed.accessor(identity * 2, "MAT4")}]
    animate(seed, "walk", (1, "translation", "STEP", [0, 0.5, 1], TRIANGLE, "VEC3"),
            (2, "rotation", "LINEAR", [0, 1], [0, 0, 0, 1, 0, 0.6, 0, 0.8], "VEC4"),
            (2, "scale", "CUBICSPLINE", [0.25, 1], [0, 0, 0, 1, 1, 1, 0.5, 0, 0, 0, 0, 0, 2, 1, 1, 0, 0, 0], "VEC3"))
    return animate(seed, "wait", (2, "rotation", "CUBICSPLINE", [0, 1], [0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0] * 2, "VEC4"))


def morphed():
    seed = Seed()
    targets = [{"POSITION": seed.accessor(TRIANGLE), "NORMAL": seed.accessor([0, 0.5, 0] * 3)}, {"POSITION": seed.accessor([0, 0, 1] * 3)}]
    attributes = {"POSITION": seed.accessor(TRIANGLE), "NORMAL": seed.accessor([0, 0, 1] * 3)}
    seed.mesh({"attributes": attributes, "targets": targets}, weights=[0.5, 0])
    seed.json["nodes"][0]["weights"] = [0.25, 0.25]
    return animate(seed, "smile", (0, "weights", "LINEAR", [0, 1], [0, 1, 1, 0], "SCALAR"))


def sparse():
    seed = triangle()
    indices, values = seed.view(bytes([0, 2])), seed.view(struct.pack("<6f", 0, 0, 1, 0, 1, 1))
    part = {"count": 2, "indices": {"bufferView": indices, "componentType": U8}, "values": {"bufferView": values}}
    seed.json["accessors"][0]["sparse"] = part
    seed.json["accessors"].append({"componentType": FLOAT, "count": 3, "type": "VEC3", "sparse": part})
    seed.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = 1
    return seed


def quantized():
    seed = Seed(extensionsUsed=["KHR_mesh_quantization"], extensionsRequired=["KHR_mesh_quantization"])
    view = seed.view(struct.pack("<12h", 0, 0, 0, 0, 32767, 0, 0, 0, 0, 32767, 0, 0), byteStride=8)
    normals = seed.view(struct.pack("<12b", *[0, 0, 127, 0] * 3), byteStride=4)
    seed.json["accessors"] = [{"bufferView": view, "componentType": I16, "count": 3, "type": "VEC3", "normalized": True},
                              {"bufferView": normals, "componentType": I8, "count": 3, "type": "VEC3", "normalized": True}]
    seed.mesh({"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": seed.accessor([0, 0, 7, 0, 0, 7], "VEC2", U8)}})
    seed.json["nodes"][0]["matrix"] = [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 1, 2, 3, 1]
    return seed


def lights_and_cameras():
    seed = triangle()
    seed.json["cameras"] = [{"type": "perspective", "name": "Front", "perspective": {"yfov": 0.7, "znear": 0.1, "zfar": 50, "aspectRatio": 1.5}},
                            {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 9}}]
    seed.json["extensionsUsed"] = ["KHR_lights_punctual"]
    lights = [{"type": "directional", "color": [1, 0.5, 0]}, {"type": "point", "intensity": 20, "range": 5},
              {"type": "spot", "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.5}}]
    seed.json["extensions"] = {"KHR_lights_punctual": {"lights": lights}}
    seed.json["nodes"] += [{"camera": i, "translation": [0, 1, 5]} for i in range(2)]
    seed.json["nodes"] += [{"name": f"l{i}", "extensions": {"KHR_lights_punctual": {"light": i}}} for i in range(3)]
    seed.json["scenes"][0]["nodes"] = list(range(6))
    return seed


def data_uri():
    seed = triangle()
    uri = "data:application/octet-stream;base64," + base64.b64encode(seed.binary).decode()
    seed.json["buffers"] = [{"byteLength": len(seed.binary), "uri": uri}]
    pixel = "data:image/png;base64," + base64.b64encode(picture("RGB", "PNG", (1, 1))).decode()
    seed.json |= {"images": [{"uri": pixel}, {"uri": "missing.png"}], "textures": [{"source": 0}]}
    return json.dumps(seed.json).encode()


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    seeds = (triangle, modes, textured, skinned, morphed, sparse, quantized, lights_and_cameras)
    for seed in seeds:
        (FOLDER / seed.__name__).write_bytes(seed().split())
    for seed in (triangle, textured, skinned):
        (FOLDER / f"{seed.__name__}.glb").write_bytes(seed().glb())
    (FOLDER / "data_uri.gltf").write_bytes(data_uri())


if __name__ == "__main__":
    main()

"""Looks into GLB files for what viewers choke on, and compares generated with committed files."""

import io

import numpy as np
from PIL import Image

from . import glb


def problems(data):
    """What is wrong with a GLB, as a list of sentences (empty: sound)."""
    try:
        gltf, binary = glb.read(data)
    except ValueError as error:
        return [str(error)]
    found = []
    for i, item in enumerate(gltf.get("accessors", [])):
        view = gltf["bufferViews"][item["bufferView"]]
        size = item["count"] * glb.COMPONENTS[item["type"]] * np.dtype(glb.DTYPES[item["componentType"]]).itemsize
        if size > view["byteLength"] or view["byteOffset"] + size > len(binary):
            found.append(f"accessor {i} runs past its view")
            continue
        values = glb.array(gltf, binary, i)
        if not np.isfinite(values).all():
            found.append(f"accessor {i} holds NaN or infinity")
        if "min" in item and not (
            np.array_equal(values.min(axis=0), np.float32(item["min"]))
            and np.array_equal(values.max(axis=0), np.float32(item["max"]))
        ):
            found.append(f"accessor {i}: min/max do not match its values")
    for mesh in gltf.get("meshes", []):
        for primitive in mesh["primitives"]:
            found += [f"mesh {mesh['name']}: {text}" for text in _primitive_problems(gltf, binary, primitive)]
    for skin in gltf.get("skins", []):
        if gltf["accessors"][skin["inverseBindMatrices"]]["count"] != len(skin["joints"]):
            found.append(f"skin {skin['name']}: joints and inverse bind matrices differ in number")
    for clip in gltf.get("animations", []):
        for sampler in clip["samplers"]:
            times, values = (glb.array(gltf, binary, sampler[key]) for key in ("input", "output"))
            if len(times) != len(values) or (np.diff(times[:, 0]) <= 0).any():
                found.append(f"clip {clip['name']}: key times must rise and match the values")
            if values.shape[1] == 4 and np.abs(np.linalg.norm(values, axis=1) - 1).max() > 1e-4:
                found.append(f"clip {clip['name']}: a rotation is no unit quaternion")
    names = [node["name"] for node in gltf["nodes"]]
    if len(set(names)) != len(names):
        found.append("two nodes have one name: " + next(name for name in names if names.count(name) > 1))
    return found


def _primitive_problems(gltf, binary, primitive):
    attributes = {name: glb.array(gltf, binary, index) for name, index in primitive["attributes"].items()}
    count = len(attributes["POSITION"])
    triangles = glb.array(gltf, binary, primitive["indices"]).reshape(-1, 3)
    if any(len(values) != count for values in attributes.values()):
        yield "attributes differ in length"
    if triangles.max() >= count:
        yield "an index is out of range"
        return
    if len(np.unique(triangles)) != count:
        yield f"{count - len(np.unique(triangles))} vertices are not used"
    if np.abs(np.linalg.norm(attributes["NORMAL"], axis=1) - 1).max() > 1e-3:
        yield "a normal is not of unit length"
    corners = attributes["POSITION"][triangles]
    if (np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) < 1e-9).any():
        yield "a triangle has no area"
    if "WEIGHTS_0" in attributes:
        if np.abs(attributes["WEIGHTS_0"].sum(axis=1) - 1).max() > 1e-6:
            yield "weights do not sum to one"
        joints = max(len(skin["joints"]) for skin in gltf["skins"])
        if attributes["JOINTS_0"].max() >= joints:
            yield "a joint is out of range"


def difference(made, committed):
    """Compares two GLBs. None: the same bytes. Else (fits, sentence): what differs, and whether it is only rounding.

    Another processor or library version may round differently or pack an image differently; structure must not differ.
    """
    if made == committed:
        return None
    (new, new_binary), (old, old_binary) = glb.read(made), glb.read(committed)
    shape = [
        (key, len(new.get(key, [])), len(old.get(key, [])))
        for key in ("nodes", "meshes", "materials", "accessors", "images", "animations")
    ]
    if any(a != b for _, a, b in shape):
        return False, ", ".join(f"{key}: {b} committed, {a} made" for key, a, b in shape if a != b)
    worst = 0.0
    for i, (a, b) in enumerate(zip(new["accessors"], old["accessors"])):
        if (a["count"], a["type"], a["componentType"]) != (b["count"], b["type"], b["componentType"]):
            return False, f"accessor {i} has another shape"
        worst = max(worst, float(np.abs(glb.array(new, new_binary, i) - glb.array(old, old_binary, i)).max()))
    pixels = 0.0
    for a, b in zip(new.get("images", []), old.get("images", [])):
        left, right = (
            _pixels(gltf, binary, item) for gltf, binary, item in ((new, new_binary, a), (old, old_binary, b))
        )
        if left.shape != right.shape:
            return False, f"image {a['name']} has another size"
        pixels = max(pixels, float(np.abs(left - right).mean()))
    return (
        worst < 0.02 and pixels < 2,
        f"largest difference of a value {worst:.2g}, mean of an image {pixels:.2g} grey levels",
    )


def _pixels(gltf, binary, item):
    view = gltf["bufferViews"][item["bufferView"]]
    return np.asarray(
        Image.open(io.BytesIO(binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]])).convert("RGBA"),
        dtype=float,
    )


def summary(data):
    """Counts for the report: (nodes, primitives drawn, triangles drawn, vertices stored)."""
    gltf, _ = glb.read(data)
    drawn = [p for node in gltf["nodes"] if "mesh" in node for p in gltf["meshes"][node["mesh"]]["primitives"]]
    triangles = sum(gltf["accessors"][p["indices"]]["count"] // 3 for p in drawn)
    vertices = sum(gltf["accessors"][p["attributes"]["POSITION"]]["count"] for p in drawn)
    return {
        "nodes": len(gltf["nodes"]),
        "primitives": len(drawn),
        "triangles": triangles,
        "vertices": vertices,
        "kilobytes": round(len(data) / 1000),
    }

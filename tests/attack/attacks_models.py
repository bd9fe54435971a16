"""Models, scenes and calibrations of strangers: damaged ones, and such as are small and mean to be large."""

from __future__ import annotations

import json
import random
import re
import struct
import time
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path

import camrig

from target import Target, run_measured

REPOSITORY = Path(__file__).resolve().parents[2]
FAIR = ("invalid_argument", "unsupported", "resource_exhausted", "not_found")
#: One file may cost so much: core/world/gltf/limits.h allows 1 GiB of what is decoded.
MOST_MIB, MOST_S = 1600, 20.0


def _load_all(target: Target, files: Iterator[tuple[str, bytes, str]]) -> str:
    """Loads them one after the other into a rig of their own: (what, bytes, how the name ends)."""
    count = refused = 0
    most_s, most_mib = (0.0, ""), (0.0, "")
    with camrig.start("minimal", mode="lockstep") as rig:
        other = Target(rig, target.folder)
        for what, data, suffix in files:
            count += 1
            path = target.folder / f"loaded{count % 2}{suffix}"
            path.write_bytes(data)
            other.forget_peak()
            begin, before = time.monotonic(), other.rss_kib()
            try:
                rig.load(str(path))
                if (cam := next(iter(rig.cameras()), None)) is not None:
                    cam.frame()
            except camrig.CamrigError as error:
                assert error.kind in FAIR, f"{what}: {error}"
                refused += 1
            most_s, most_mib = max(most_s, (time.monotonic() - begin, what)), max(most_mib, ((other.peak_kib() - before) / 1024, what))
            path.unlink()
        other.owner_is_answered()
    assert most_s[0] < MOST_S and most_mib[0] < MOST_MIB, (most_s, most_mib)
    return f"{refused} of {count} refused; at most {most_s[0]:.1f} s ({most_s[1]}) and {most_mib[0]:.0f} MiB ({most_mib[1]})"


def _some_model() -> bytes:
    return next(iter(sorted((REPOSITORY / "scenes" / "minimal").glob("*.glb")))).read_bytes()


def _in_json(glb: bytes, changed: Callable[[str], str]) -> bytes:
    """The model with its JSON changed."""
    size = struct.unpack_from("<I", glb, 12)[0]
    text, rest = changed(glb[20 : 20 + size].decode().rstrip()).encode(), glb[20 + size :]
    text += b" " * (-len(text) % 4)
    return struct.pack("<4sII", b"glTF", 2, 20 + len(text) + len(rest)) + struct.pack("<I4s", len(text), b"JSON") + text + rest


def damaged_models(target: Target) -> str:
    """200 models that end early, 1000 with a bit turned round, 1500 with a number exchanged."""
    whole, rng = _some_model(), random.Random(3)
    numbers = ["-1", "0", "1", "255", "65536", "2147483647", "4294967296", "9007199254740993", "1e300", "-1e300", "0.5", "null", '"1"']

    def exchanged(text: str) -> str:
        found = rng.choice(list(re.finditer(r"-?\d+(\.\d+)?([eE][-+]?\d+)?", text)))
        return text[: found.start()] + rng.choice(numbers) + text[found.end() :]

    def files() -> Iterator[tuple[str, bytes, str]]:
        for _ in range(200):
            yield "cut off", whole[: rng.randrange(len(whole))], ".glb"
        for _ in range(1000):
            data = bytearray(whole)
            data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
            yield "a bit turned", bytes(data), ".glb"
        for _ in range(1500):
            yield "a number exchanged", _in_json(whole, exchanged), ".glb"

    return _load_all(target, files())


def damaged_scenes(target: Target) -> str:
    """1200 scenes with a part left out, doubled, or exchanged for another part."""
    rng = random.Random(5)
    originals = [json.loads((REPOSITORY / "scenes" / f"{name}.json").read_text()) for name in ("minimal", "clock", "street")]
    wrong = [None, True, -1, 1e308, "", "x" * 3000, [], {}, [[]]]

    def places(value: object, found: list) -> list:
        for key, inner in value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ():
            found.append((value, key))
            places(inner, found)
        return found

    def files() -> Iterator[tuple[str, bytes, str]]:
        for number in range(1200):
            scene = json.loads(json.dumps(originals[number % len(originals)]))
            for _ in range(rng.choice([1, 1, 3])):
                all_places = places(scene, [])
                (holder, key), (giver, other) = rng.choice(all_places), rng.choice(all_places)
                how = rng.randrange(3)
                if how == 0:
                    del holder[key]
                else:
                    holder[key] = json.loads(json.dumps(giver[other])) if how == 1 else rng.choice(wrong)
            yield "a scene", json.dumps(scene).encode(), ".json"

    # Models lie in folders beside the scenes.
    for folder in (REPOSITORY / "scenes").iterdir():
        if folder.is_dir() and not (target.folder / folder.name).exists():
            (target.folder / folder.name).symlink_to(folder)
    return _load_all(target, files())


def _document(**parts: object) -> bytes:
    return json.dumps({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], **parts}).encode()


def _mesh(**parts: object) -> dict:
    return {"nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], **parts}


def _bombs() -> Iterator[tuple[str, bytes, str]]:
    positions = {"componentType": 5126, "type": "VEC3"}
    for count in (-1, 0, 10**8, 2**31 - 1, 2**32, 2**53, 2**64, 1e300):
        yield f"{count:g} vertices of nothing", _document(**_mesh(accessors=[{**positions, "count": count}])), ".gltf"
        sparse = {"count": count, "indices": {"bufferView": 0, "componentType": 5125}, "values": {"bufferView": 0}}
        yield f"{count:g} sparse values", _document(**_mesh(accessors=[{**positions, "count": 3, "sparse": sparse}], bufferViews=[{"buffer": 0, "byteLength": 64}],
                                                          buffers=[{"byteLength": 64, "uri": "data:;base64," + "AAAA" * 22}])), ".gltf"
        yield f"a buffer of {count:g}", _document(**_mesh(accessors=[{**positions, "count": 3, "bufferView": 0}], bufferViews=[{"buffer": 0, "byteLength": count, "byteOffset": count, "byteStride": 252}],
                                                        buffers=[{"byteLength": count, "uri": "data:;base64,AAAA"}])), ".gltf"
    for depth in (1000, 100_000):
        yield f"nodes {depth} deep", _document(nodes=[*({"children": [n + 1]} for n in range(depth)), {}]), ".gltf"
        yield f"JSON {depth} deep", _document(extras=None).replace(b"null", b"[" * depth + b"]" * depth), ".gltf"
    yield "nodes in a ring", _document(nodes=[{"children": [1]}, {"children": [0]}]), ".gltf"
    yield "a node that is its own child", _document(nodes=[{"children": [0]}]), ".gltf"
    yield "each node the child of all before", _document(nodes=[{"children": list(range(n + 1, 200))} for n in range(200)]), ".gltf"
    yield "two children each, 40 times", _document(nodes=[*({"children": [n + 1, n + 1]} for n in range(40)), {"mesh": 0}], meshes=[{"primitives": []}]), ".gltf"
    few = {"accessors": [{**positions, "count": 3}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}] * 1000}]}
    yield "1000 surfaces shown 10 000 times", _document(nodes=[{"children": list(range(1, 10_001))}, *({"mesh": 0} for _ in range(10_000))], **few), ".gltf"
    yield "16 million vertices shown 100 times", _document(nodes=[{"children": list(range(1, 101))}, *({"mesh": 0} for _ in range(100))],
                                                          accessors=[{**positions, "count": 2**24}], meshes=[{"primitives": [{"attributes": {"POSITION": 0}}]}]), ".gltf"
    yield "200 000 nodes", _document(nodes=[{}] * 200_000), ".gltf"
    yield "200 000 materials", _document(nodes=[{}], materials=[{}] * 200_000), ".gltf"
    target_list = [{"POSITION": 0}] * 100_000
    yield "100 000 morph targets", _document(nodes=[{"mesh": 0}], accessors=[{**positions, "count": 3}],
                                            meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "targets": target_list}], "weights": [1] * 100_000}]), ".gltf"
    yield "a million joints", _document(nodes=[{"mesh": 0, "skin": 0}], skins=[{"joints": [0] * 1_000_000}], **few), ".gltf"
    yield "keys without end", _document(nodes=[{}], accessors=[{"componentType": 5126, "type": "SCALAR", "count": 2**31 - 1}, {**positions, "count": 2**31 - 1}],
                                       animations=[{"samplers": [{"input": 0, "output": 1}], "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}]), ".gltf"
    for side in (16_384, 65_535):
        yield f"a black picture of {side}x{side}", _document(**_mesh(accessors=[{**positions, "count": 3}], materials=[{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
                                                                   textures=[{"source": 0}], images=[{"uri": "black.png"}])), f".{side}.gltf"
    yield "a node far away and huge", _document(nodes=[{"mesh": 0, "matrix": [1e300] * 16}], **few), ".gltf"
    yield "chunks longer than the file", struct.pack("<4sIIII", b"glTF", 2, 2**32 - 1, 2**32 - 4, 0x4E4F534A), ".glb"


def _black_png(side: int) -> bytes:
    """Small in the file: zlib makes a thousandth of it."""
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    packer, rows = zlib.compressobj(9), b""
    for _ in range(side):
        rows += packer.compress(bytes(1 + (side + 7) // 8))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 1, 0, 0, 0, 0)) + chunk(b"IDAT", rows + packer.flush()) + chunk(b"IEND", b"")


def bombs_of_models(target: Target) -> str:
    """43 models that are small and claim to be large: counts, depth, rings, sparse accessors, pictures."""

    def files() -> Iterator[tuple[str, bytes, str]]:
        for what, data, suffix in _bombs():
            if suffix.count(".") > 1:
                (target.folder / "black.png").write_bytes(_black_png(int(suffix.split(".")[1])))
            yield what, data, suffix

    assert len(list(_bombs())) >= 43, len(list(_bombs()))
    return _load_all(target, files())


def _yaml_bombs() -> Iterator[bytes]:
    for breadth, depth in ((2, 30), (9, 9), (100, 5), (2, 1000)):
        lines = ["a0: &a0 [x]", *(f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * breadth)}]" for n in range(1, depth)), f"camera_matrix: *a{depth - 1}"]
        yield "\n".join(lines).encode()
        merged = ["m0: &m0 {k: 1}", *(f"m{n}: &m{n} {{<<: [{', '.join([f'*m{n - 1}'] * min(breadth, 50))}]}}" for n in range(1, min(depth, 100)))]
        yield "\n".join(merged).encode()
    yield b"a: &a [*a]\n"
    yield b"a: &a {b: *a}\ncamera_matrix: *a\n"
    for opened, closed in ((b"[", b"]"), (b"{a: ", b"}"), (b"- ", b""), (b"? ", b""), (b"!!x ", b""), (b"&a ", b""), (b"'", b"")):
        for depth in (100, 100_000):
            yield b"camera_matrix: " + opened * depth + closed * depth
    yield b"\n".join(b" " * depth + b"a:" for depth in range(3000))
    yield b"image_width: " + b"9" * 1_000_000
    yield b"k" * 2_000_000 + b": 1"
    yield b"\xff\xfe" + "image_width: 640".encode("utf-16-le")
    yield b"image_width: 640\n" * 200_000
    yield b"%YAML 9.9\n%TAG ! tag:x:\n--- !x\n..."
    yield b"---\n" * 100_000
    yield b"data: [" + b"1, " * 3_000_000 + b"1]"


def bombs_of_calibrations(target: Target) -> str:
    """314 calibrations with anchors that multiply, depth without end, or bits turned round: an error or a camera, soon and in little memory."""
    rng, binary = random.Random(6), camrig.launch.find_binary()
    seeds = [path.read_bytes() for path in sorted((REPOSITORY / "tests/fuzz/corpus/calibration").iterdir())]
    files = list(_yaml_bombs())
    while len(files) < 314:
        data = bytearray(rng.choice(seeds))
        for _ in range(rng.choice([1, 5, 40])):
            data[rng.randrange(len(data))] = rng.randrange(256)
        files.append(bytes(data))
    path, refused, most_s, most_mib = target.folder / "camera.yaml", 0, 0.0, 0.0
    for data in files:
        path.write_bytes(data)
        ended = run_measured([binary, "--control", target.control, "camera", "create", "calibrated", "--position", "1,1,1", "--calibration", str(path)])
        assert ended.status in (0, 1) and "terminate called" not in ended.said and "internal" not in ended.said, (ended, data[:100])
        if ended.status == 0:
            target.rig.camera("calibrated").delete()
        refused += ended.status
        most_s, most_mib = max(most_s, ended.took_s), max(most_mib, ended.peak_mib)
    assert most_s < 5.0 and most_mib < 300, f"up to {most_s:.1f} s and {most_mib:.0f} MiB"
    return f"{refused} of {len(files)} refused, at most {most_s:.1f} s and {most_mib:.0f} MiB"


ATTACKS = [damaged_models, damaged_scenes, bombs_of_models, bombs_of_calibrations]

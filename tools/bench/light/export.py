"""A scene file as a path tracer takes it: placed triangles, physical lights, the camera. No renderer in here.

Units. In camrig a white Lambert surface that light c meets squarely is drawn as c, for Lambert's 1/pi is folded into the lights
(docs/decisions/0055-quality-levels.md). Radiance 1 is thus what is drawn as white, and

    directional light c        irradiance pi c across its direction
    point light c              radiant intensity pi c: at distance d irradiance pi c / d^2
    ambient {sky, ground}      an environment of radiance sky above the horizon and ground below; a normal at the angle t to the
                               vertical then gathers pi (sky (1 + cos t) / 2 + ground (1 - cos t) / 2): camrig's hemisphere term
    emissive, unlit colour c   an emitter of radiance c times the environment's `glow`; the camera sees c
    background                 what the camera sees where nothing is; lights nothing
    daylight                   sun, ambient ground and background of it (daylight.py), and the sky from every direction as it is: our
                               renderers have its mean; a `sky` shape is left out of both pictures
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "control" / "python"))
from camrig.tone import light_of as untoned, pbr_neutral  # noqa: E402

from .daylight import Daylight, read as read_daylight
from .gltf import Glb, Material, Primitive, rotation


@dataclass(frozen=True)
class Light:
    """`value`: irradiance of a directional light, radiant intensity of a point light; linear RGB."""

    type: str
    value: np.ndarray
    direction: np.ndarray | None = None
    position: np.ndarray | None = None


@dataclass(frozen=True)
class Exported:
    surfaces: list[Primitive]
    lights: list[Light]
    sky: np.ndarray
    ground: np.ndarray
    background: np.ndarray
    exposure: float
    glow: float
    daylight: Daylight | None = None

    @property
    def has_tone_curve(self) -> bool:
        """At quality beautiful."""
        return self.daylight is not None


@dataclass(frozen=True)
class Eye:
    """A pinhole: `world_from_eye` 4x4, axes x right, y down, z ahead; the picture's plane spans pixels 0 to width, 0 to height."""

    size: tuple[int, int]
    vfov_deg: float
    world_from_eye: np.ndarray


def still(scene: dict[str, Any]) -> dict[str, Any]:
    """A scene (its base put in) without what moves or happens, and without its sky. Its models are told by `camrig:` names, so that it can lie anywhere."""
    made = {key: value for key, value in scene.items() if key not in ("actors", "events", "routes", "areas", "cameras")}
    made["models"] = {
        name: {**model, "file": "camrig:" + model["file"].removesuffix(".glb")} if "file" in model and not model["file"].startswith("camrig:") else model
        for name, model in scene["models"].items()
    }
    made["objects"] = [item for item in scene["objects"] if scene["models"][item["model"]].get("shape") != "sky"]
    return made


@dataclass(frozen=True)
class Person:
    """Stands in the rest pose; `yaw_deg`: where it looks, counter-clockwise from +x."""

    model: str
    x: float
    y: float
    yaw_deg: float


def with_people(scene: dict[str, Any], people: tuple[Person, ...]) -> dict[str, Any]:
    """The still scene with these as actors: what is baked of it stays good."""
    actors = [
        {"name": f"person_{i}", "model": one.model, "class": "person", "position": [one.x, one.y, 0.0], "yaw_deg": one.yaw_deg}
        for i, one in enumerate(people)
    ]
    return scene | {"actors": actors}


def read(scene: dict[str, Any], folder: Path) -> Exported:
    """`scene` as still() gives it; `folder`: of the shipped scenes. ValueError says what cannot be told to a path tracer."""
    environment = scene.get("environment", {})
    ambient = environment.get("ambient", {})
    files: dict[str, list[Primitive]] = {}
    surfaces: list[Primitive] = []
    # An actor's yaw 0 is towards +x, and an object's as its file has it: its front (+z of the file) towards -y.
    actors = [actor | {"yaw_deg": actor["yaw_deg"] + 90.0} for actor in scene.get("actors", [])]
    for item in [*scene["objects"], *actors]:
        model = scene["models"][item["model"]]
        if "file" not in model or "attach" in item:
            raise ValueError(f"object {item['name']}: the export takes models of files that stand for themselves")
        name = model["file"].removeprefix("camrig:")
        if name not in files:
            files[name] = Glb(folder / f"{name}.glb").primitives()
        surfaces += [_placed(primitive, item) for primitive in files[name] if primitive.material.is_shown and primitive.material.name != "contact_shadow"]
    day = read_daylight(environment) if "daylight" in environment else None
    lights = [_light(item) for item in scene.get("lights", []) if item.get("intensity", 1.0) > 0 and not (day and item["name"] == "sun")]
    if day:
        lights.insert(0, Light("directional", math.pi * day.sun, direction=-day.to_sun))
    return Exported(
        surfaces=_merged(surfaces),
        lights=lights,
        sky=day.sky if day else np.array(ambient.get("sky", (0.5, 0.5, 0.5)), float),
        ground=day.ground if day else np.array(ambient.get("ground", (0.3, 0.3, 0.3)), float),
        background=day.background() if day else np.array(environment.get("background", (0.6, 0.7, 0.8)), float),
        exposure=float(environment.get("exposure", 1.0)),
        glow=float(environment.get("glow", 1.0)),
        daylight=day,
    )


def eye(size: tuple[int, int], k: np.ndarray, world_from_eye: np.ndarray) -> Eye:
    """Of a camera's matrix with pixel centres at integers. ValueError where it is not a pinhole of square pixels about the middle."""
    middle = ((size[0] - 1) / 2, (size[1] - 1) / 2)
    if not np.allclose((k[0, 2], k[1, 2]), middle, atol=1e-6) or not math.isclose(k[0, 0], k[1, 1], rel_tol=1e-9):
        raise ValueError(f"the camera's matrix {k.tolist()} is none of square pixels about the middle {middle}")
    return Eye(size, math.degrees(2 * math.atan(0.5 * size[1] / k[1, 1])), world_from_eye)


def codes(light: np.ndarray, exposure: float = 1.0, *, is_toned: bool = False) -> np.ndarray:
    """camrig's picture of linear light: by its tone curve where there is one, clamped, IEC 61966-2-1 (sRGB), 0 to 255, not rounded."""
    x = np.clip(pbr_neutral(light * exposure) if is_toned else light * exposure, 0, 1)
    return 255 * np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def light_of(picture: np.ndarray, *, is_toned: bool = False) -> np.ndarray:
    """Linear light of codes 0 to 255: what codes() did, undone, but for what it clamped."""
    if is_toned:
        return untoned(picture)
    x = np.asarray(picture, float) / 255
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


def _placed(primitive: Primitive, item: dict[str, Any]) -> Primitive:
    half = math.radians(item.get("yaw_deg", 0.0)) / 2
    turn = rotation(item.get("orientation", (0, 0, math.sin(half), math.cos(half))))
    return replace(
        primitive,
        positions=primitive.positions @ turn.T * item.get("scale", 1.0) + np.asarray(item.get("position", (0, 0, 0)), float),
        normals=primitive.normals @ turn.T,
    )


def _merged(surfaces: list[Primitive]) -> list[Primitive]:
    """One of each material: a path tracer compiles each by itself."""
    groups: dict[tuple[Material, bool], list[Primitive]] = {}
    for surface in surfaces:
        groups.setdefault((surface.material, surface.uv is None), []).append(surface)
    made = []
    for (material, is_plain), group in groups.items():
        starts = np.cumsum([0, *(len(item.positions) for item in group)])
        made.append(Primitive(
            positions=np.concatenate([item.positions for item in group]),
            normals=np.concatenate([item.normals for item in group]),
            colors=np.concatenate([item.colors for item in group]),
            uv=None if is_plain else np.concatenate([item.uv for item in group]),
            triangles=np.concatenate([item.triangles + start for item, start in zip(group, starts)]),
            material=material,
        ))
    return made


def _light(item: dict[str, Any]) -> Light:
    value = math.pi * item.get("intensity", 1.0) * np.asarray(item.get("color", (1, 1, 1)), float)
    if item["type"] == "directional":
        direction = np.asarray(item["direction"], float)
        return Light("directional", value, direction=direction / np.linalg.norm(direction))
    if item["type"] == "point" and not item.get("range"):
        return Light("point", value, position=np.asarray(item["position"], float))
    raise ValueError(f"light {item.get('name')}: the export takes directional lights, and point lights without a range")

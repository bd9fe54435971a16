"""Renders an exported scene with Mitsuba 3. Needs build/light (tools/bench/light/setup); the rest of the bench does not.

Materials: glTF's own (gltf_material.py) with the file's colour, roughness and metal, two-sided. Blended ones are
there with the probability of their alpha, masked ones where their texture is. Baked occlusion textures are left out: that is what
is measured. Integrator: `volpath`, whose shadow rays pass what is masked.
"""

from __future__ import annotations

import ctypes.util
import io
import math
import tempfile
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
import pyoidn
from PIL import Image
from scipy.ndimage import gaussian_filter

from .export import Exported, Eye, Light
from .gltf import Material, Primitive

mi.set_variant("llvm_ad_rgb" if ctypes.util.find_library("LLVM") or list(Path("/usr/lib").glob("*/libLLVM*.so*")) else "scalar_rgb")

#: Bounces after which a path ends; most end before, by chance (Russian roulette). With 16 the hall's light was a third of a code darker.
BOUNCES = 64
#: Samples a pixel of one pass.
PART = 64
#: Samples a pixel of what guides the denoiser.
GUIDE = 256
#: Rows of the environment picture: the horizon is a row of 0.35 degrees.
SKY_ROWS = 512


class _Product(mi.Texture):
    """One texture times another, as a file's colours times its picture are."""

    def __init__(self, properties: mi.Properties) -> None:
        mi.Texture.__init__(self, properties)
        self.picture, self.factor = properties["picture"], properties["factor"]

    def eval(self, si: Any, active: Any = True) -> Any:
        return self.picture.eval(si, active) * self.factor.eval(si, active)

    def eval_1(self, si: Any, active: Any = True) -> Any:
        return mi.luminance(self.eval(si, active))

    def mean(self) -> Any:
        return self.picture.mean()

    def is_spatially_varying(self) -> bool:
        return True

    def to_string(self) -> str:
        return "Product[]"


mi.register_texture("camrig_product", lambda properties: _Product(properties))
from . import gltf_material  # noqa: E402, F401  (registers camrig_gltf, of the variant that is set)


class Reference:
    def __init__(self, exported: Exported, eye: Eye, *, is_lambert: bool = False) -> None:
        """`is_lambert`: all surfaces are Lambert's alone, whose answers are known."""
        self.exported, self.eye = exported, eye
        self._folder = tempfile.TemporaryDirectory()
        lit = [_shape(surface, Path(self._folder.name), i, is_lambert, exported.glow) for i, surface in enumerate(exported.surfaces)]
        dark = {f"shape{i}": shape for i, (shape, surface) in enumerate(zip(lit, exported.surfaces)) if not surface.material.is_unlit}
        every = {f"shape{i}": shape for i, shape in enumerate(lit)}
        for item in dark.values():
            item.pop("emitter", None)
        sensor = {"sensor": _sensor(eye)}
        # Loading takes seconds, and loaded shapes are shared. What is unlit lets the sun through, as in camrig.
        loaded = {name: mi.load_dict(item) for name, item in dark.items()}
        self._sun = mi.load_dict({"type": "scene", **sensor, **loaded, **{f"light{i}": _emitter(light) for i, light in enumerate(exported.lights)}})
        def glowing(strength: float) -> dict[str, Any]:
            return {
                name: mi.load_dict(_with_glow(item, surface, Path(self._folder.name), name, strength)) if _glows(surface.material) else loaded[name]
                for (name, item), surface in zip(every.items(), exported.surfaces)
            }

        # What glows lights others by its strength, and is seen as it is drawn.
        seen, lights = glowing(1.0), glowing(exported.glow)
        self._sky = mi.load_dict({"type": "scene", **sensor, **lights, "environment": _environment(exported)})
        self._mask = mi.load_dict({"type": "scene", **sensor, **seen, "environment": {"type": "constant", "radiance": 1.0}})
        self._emitters = mi.load_dict({"type": "scene", **sensor, **seen, "environment": {"type": "constant", "radiance": 0.0}})

    def light(self, samples: int, seed: int) -> np.ndarray:
        """HxWx3 linear light in camrig's units, `samples` a pixel; other seeds give independent noise."""
        # Emission alone, before and behind the environment of 1: equal seeds begin with equal camera rays, so differences have no noise.
        behind = self._render(self._sky, samples, seed, 1)
        emitters = self._render(self._emitters, samples, seed, 1)
        open_share = self._render(self._mask, samples, seed, 1) - emitters
        light = emitters + open_share * self.exported.background + self._render(self._sky, samples, seed, BOUNCES) - behind
        return light + self._render(self._sun, samples, seed + 1, BOUNCES) if self.exported.lights else light

    def denoised(self, light: np.ndarray) -> np.ndarray:
        """What Open Image Denoise makes of light(): guided by colours and normals of the surfaces that are seen, which have no noise of light. Its colours are off
        by 0.15 % (green up, blue down), which FLIP sees, so each channel keeps its level about each pixel."""
        integrator = mi.load_dict({"type": "aov", "aovs": "colour:albedo,normal:sh_normal"})
        guides = np.array(mi.render(self._sky, integrator=integrator, spp=GUIDE, seed=1), np.float32)
        colour, normal = np.ascontiguousarray(guides[..., :3]), np.ascontiguousarray(guides[..., 3:6])
        clean = pyoidn.denoise(light.astype(np.float32), np.clip(colour, 0, 1), normal, hdr=True, clean_aux=True).astype(float)
        return clean * _about(light) / np.maximum(_about(clean), 1e-6)

    def depth(self) -> np.ndarray:
        """HxW metres along the axis, through pixel centres; infinite where nothing is. Masked surfaces count where they are."""
        width, height = self.eye.size
        y, x = np.mgrid[0:height, 0:width]
        place = mi.Point2f(mi.Float(((x.ravel() + 0.5) / width)), mi.Float(((y.ravel() + 0.5) / height)))
        ray, _ = self._sky.sensors()[0].sample_ray(0.0, 0.5, place, mi.Point2f(0.5, 0.5))
        eye, ahead = self.eye.world_from_eye[:3, 3], self.eye.world_from_eye[:3, 2]
        depth = np.full(width * height, np.inf)
        open_rays = np.ones(width * height, bool)
        for _ in range(8):
            hit = self._sky.ray_intersect(ray, mi.Bool(open_rays))
            through = np.array(mi.luminance(hit.bsdf().eval_null_transmission(hit, hit.is_valid()))) > 0.5
            is_hit = np.array(hit.is_valid()) & open_rays
            at = (np.array(hit.p).T - eye) @ ahead
            depth[is_hit & ~through] = at[is_hit & ~through]
            open_rays = is_hit & through
            if not open_rays.any():
                break
            ray = hit.spawn_ray(ray.d)
        return depth.reshape(height, width)

    def _render(self, scene: mi.Scene, samples: int, seed: int, depth: int) -> np.ndarray:
        integrator = mi.load_dict({"type": "volpath", "max_depth": depth, "rr_depth": 6})
        # In parts: LLVM keeps all of a wavefront in memory, at 320x240 about 100 MB a sample.
        part = min(PART, samples)
        passes = [np.array(mi.render(scene, integrator=integrator, spp=part, seed=seed * 100_003 + i), dtype=float)[..., :3] for i in range(-(-samples // part))]
        return _without_gaps(np.mean(passes, axis=0))


def _about(light: np.ndarray) -> np.ndarray:
    """HxWx3: the mean about each pixel of what is not over white; a lamp's light would hide all that is beside it."""
    return gaussian_filter(np.clip(light, 0.0, 1.0), sigma=(8, 8, 0))


def _without_gaps(picture: np.ndarray) -> np.ndarray:
    """Mitsuba's shading now and then divides by nothing, and the pixel is no number: it gets the mean of its neighbours that are.
    RuntimeError where that is more than a pixel in 200."""
    gaps = ~np.isfinite(picture).all(axis=2)
    if gaps.mean() > 0.005:
        raise RuntimeError(f"{gaps.sum()} pixels of the reference are no numbers")
    whole = picture.copy()
    for y, x in np.argwhere(gaps):
        around = np.s_[max(y - 1, 0):y + 2, max(x - 1, 0):x + 2]
        whole[y, x] = picture[around][~gaps[around]].mean(axis=0)
    return whole


def _sensor(eye: Eye) -> dict[str, Any]:
    # Mitsuba's camera looks along +z, x left, y up.
    placed = eye.world_from_eye @ np.diag([-1.0, -1.0, 1.0, 1.0])
    film = {"type": "hdrfilm", "width": eye.size[0], "height": eye.size[1], "rfilter": {"type": "box"}, "pixel_format": "rgb", "component_format": "float32"}
    return {
        "type": "perspective", "fov": eye.vfov_deg, "fov_axis": "y", "near_clip": 0.01, "far_clip": 10_000.0,
        "to_world": mi.ScalarTransform4f(placed), "film": film, "sampler": {"type": "multijitter"},
    }


def _emitter(light: Light) -> dict[str, Any]:
    value = {"type": "rgb", "value": light.value.tolist()}
    if light.type == "directional":
        return {"type": "directional", "direction": light.direction.tolist(), "irradiance": value}
    return {"type": "point", "position": light.position.tolist(), "intensity": value}


def _environment(exported: Exported) -> dict[str, Any]:
    """Rows from above down, columns from +y through +x."""
    columns = 8 if exported.daylight is None else SKY_ROWS
    picture = np.empty((SKY_ROWS, columns, 3), np.float32)
    picture[:SKY_ROWS // 2], picture[SKY_ROWS // 2:] = exported.sky, exported.ground
    if exported.daylight is not None:
        down = math.pi * (np.arange(SKY_ROWS // 2) + 0.5)[:, None] / SKY_ROWS
        pan = 2 * math.pi * (np.arange(columns) + 0.5) / columns
        towards = np.stack([np.sin(down) * np.sin(pan), np.sin(down) * np.cos(pan), np.cos(down) * np.ones(columns)], axis=-1)
        picture[:SKY_ROWS // 2] = exported.daylight.radiance(towards)
    return {"type": "envmap", "bitmap": mi.Bitmap(picture), "to_world": mi.ScalarTransform4f().rotate([1, 0, 0], 90)}


def _glows(material: Material) -> bool:
    return material.is_unlit or any(material.emissive)


def _shape(surface: Primitive, folder: Path, number: int, is_lambert: bool, glow: float) -> dict[str, Any]:
    name = f"{number}"
    colors = surface.colors[:, :3] * np.asarray(surface.material.base_color[:3])
    mesh = mi.Mesh(name, len(surface.positions), len(surface.triangles), has_vertex_normals=True, has_vertex_texcoords=surface.uv is not None)
    mesh.add_attribute("vertex_color", 3, np.ascontiguousarray(colors, np.float32).ravel())
    mesh.add_attribute("vertex_glow", 3, np.ascontiguousarray(colors * glow, np.float32).ravel())
    values = mi.traverse(mesh)
    values["vertex_positions"] = np.ascontiguousarray(surface.positions, np.float32).ravel()
    values["vertex_normals"] = np.ascontiguousarray(surface.normals, np.float32).ravel()
    values["faces"] = np.ascontiguousarray(surface.triangles, np.uint32).ravel()
    if surface.uv is not None:
        values["vertex_texcoords"] = np.ascontiguousarray(surface.uv, np.float32).ravel()
    values.update()
    path = folder / f"{name}.ply"
    mesh.write_ply(str(path))
    return {"type": "ply", "filename": str(path), "bsdf": _material(surface, folder, name, is_lambert)}


def _color(surface: Primitive, folder: Path, name: str, attribute: str = "vertex_color") -> dict[str, Any]:
    factor = {"type": "mesh_attribute", "name": attribute}
    if surface.material.texture is None or surface.uv is None:
        return factor
    data, repeats = surface.material.texture
    path = folder / f"{name}.png"
    Image.open(io.BytesIO(data)).convert("RGB").save(path, compress_level=1)
    return {"type": "camrig_product", "factor": factor, "picture": {"type": "bitmap", "filename": str(path), "wrap_mode": "repeat" if repeats else "clamp"}}


def _material(surface: Primitive, folder: Path, name: str, is_lambert: bool) -> dict[str, Any]:
    material = surface.material
    if material.is_unlit:
        made: dict[str, Any] = {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}}
    elif material.transmission > 0.0:
        return {"type": "camrig_gltf_pane", "base_color": list(material.base_color[:3]), "transmission": material.transmission}
    elif is_lambert:
        made = {"type": "diffuse", "reflectance": _color(surface, folder, name)}
    else:
        made = {
            "type": "camrig_gltf", "base_color": _color(surface, folder, name),
            "roughness": max(material.roughness, math.sqrt(0.002)), "metallic": material.metallic,
        }
    made = {"type": "twosided", "bsdf": made}
    if material.alpha_mode == "BLEND":
        return {"type": "mask", "opacity": material.base_color[3], "bsdf": made}
    if material.alpha_mode == "MASK" and material.texture is not None:
        alpha = np.asarray(Image.open(io.BytesIO(material.texture[0])).convert("RGBA"))[..., 3:] / np.float32(255)
        there = (alpha >= material.alpha_cutoff).astype(np.float32)
        return {"type": "mask", "opacity": {"type": "bitmap", "bitmap": mi.Bitmap(there), "raw": True}, "bsdf": made}
    return made


def _with_glow(item: dict[str, Any], surface: Primitive, folder: Path, name: str, strength: float) -> dict[str, Any]:
    material = surface.material
    if material.is_unlit:
        radiance = _color(surface, folder, f"glow_{name}", "vertex_color" if strength == 1.0 else "vertex_glow")
    else:
        radiance = {"type": "rgb", "value": [strength * value for value in material.emissive]}
    return {**item, "emitter": {"type": "area", "radiance": radiance}}

"""The hall as plain triangles: what every renderer is given."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh
from PIL import Image

SCENE = Path(__file__).resolve().parents[3] / "scenes" / "hall.json"
PEOPLE = 8
SIZE = (640, 480)
SUN = np.array([-0.35, 0.62, -0.7]) / np.linalg.norm([-0.35, 0.62, -0.7])


@dataclass
class Piece:
    """Triangles of one material, z up, metres."""

    positions: np.ndarray  # (n, 3) float32
    normals: np.ndarray  # (n, 3) float32
    uv: np.ndarray  # (n, 2) float32, v up
    faces: np.ndarray  # (m, 3) uint32
    color: tuple[float, float, float]
    image: Image.Image | None


@dataclass
class Camera:
    eye: np.ndarray
    target: np.ndarray
    vfov_deg: float

    def turned(self, degrees: float) -> "Camera":
        a = np.radians(degrees)
        turn = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
        return Camera(self.eye, self.eye + turn @ (self.target - self.eye), self.vfov_deg)

    def world_from_camera(self) -> np.ndarray:
        """OpenGL's camera: looks along -z, y up."""
        back = self.eye - self.target
        back /= np.linalg.norm(back)
        right = np.cross([0, 0, 1], back)
        right /= np.linalg.norm(right)
        pose = np.eye(4)
        pose[:3, 0], pose[:3, 1], pose[:3, 2], pose[:3, 3] = right, np.cross(back, right), back, self.eye
        return pose


def _pieces(file: Path, place: np.ndarray) -> list[Piece]:
    z_up = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]])
    pieces = []
    scene = trimesh.load(file, process=False)
    for node in scene.graph.nodes_geometry:
        matrix, name = scene.graph[node]
        mesh = scene.geometry[name]
        if not isinstance(mesh, trimesh.Trimesh):
            continue
        whole = place @ z_up @ matrix
        material = getattr(mesh.visual, "material", None)
        image = getattr(material, "baseColorTexture", None)
        factor = getattr(material, "baseColorFactor", None)
        color = (1.0, 1.0, 1.0) if factor is None else tuple(np.asarray(factor[:3], float) / (255 if np.asarray(factor).dtype == np.uint8 else 1))
        uv = getattr(mesh.visual, "uv", None)
        normals = mesh.vertex_normals @ np.linalg.inv(whole[:3, :3])
        pieces.append(Piece(
            (mesh.vertices @ whole[:3, :3].T + whole[:3, 3]).astype(np.float32), (normals / np.linalg.norm(normals, axis=1, keepdims=True)).astype(np.float32),
            np.zeros((len(mesh.vertices), 2), np.float32) if uv is None else np.asarray(uv, np.float32), np.asarray(mesh.faces, np.uint32), color,
            None if image is None or uv is None else image.convert("RGB")))
    return pieces


def load(cameras: int) -> tuple[list[Piece], list[Camera]]:
    scene = json.loads(SCENE.read_text())
    pieces = []
    for thing in scene["objects"]:
        place = np.eye(4)
        a = np.radians(thing.get("yaw_deg", 0))
        place[:2, :2] = [[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]]
        place[:3, 3] = thing.get("position", (0, 0, 0))
        pieces += _pieces(SCENE.parent / scene["models"][thing["model"]]["file"], place)
    for actor in scene["actors"][:PEOPLE]:
        place = np.eye(4)
        route = actor["behaviour"].get("route")
        start = scene["routes"][route]["points"][0] if route else actor.get("position", actor["behaviour"].get("position", (12, 8, 0)))
        place[:3, 3] = [*start, 0][:3]
        pieces += _pieces(SCENE.parent / scene["models"][actor["model"]]["file"], place)
    places = [scene["places"][name] for name in ("lobby", "entrance", "benches", "desk", "stairs", "gallery", "cafe", "overhead")]
    return pieces, [Camera(np.array(p["pose"]["position"], float), np.array(p["pose"]["look_at"], float), p["vfov_deg"]) for p in (places[i % len(places)] for i in range(cameras))]

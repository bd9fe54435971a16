"""Writes hall.json and the footprints of what stands in the hall."""

import json

from ..scene import Scene
from . import plan, routes, story, structure
from .bake import AMBIENT_GROUND, AMBIENT_SKY, KEY


#: Of windows and lamps, where light is baked: outside it is brighter than a picture can be.
GLOW = 2.4


def scene():
    scene = Scene(
        "hall",
        "A public hall of 30 m x 20 m with a gallery, its furniture, and people who walk, stand and talk.",
        seed=1,
    )
    scene.environment(background=(0.75, 0.83, 0.92), sky=AMBIENT_SKY, ground=AMBIENT_GROUND, glow=GLOW)
    scene.model("hall", "hall/hall.glb")
    people = sorted({model for _, model, *_ in plan.WALKERS + plan.STANDERS}, key=lambda name: int(name.split("_")[1]))
    for model in people:
        scene.model(model, f"hall/{model}.glb", front="+z")
    scene.model("bag", "hall/bag.glb", front="+z")
    scene.object("hall", "hall", "building")
    scene.light("daylight", "directional", **KEY)
    for name, points in plan.ROUTES.items():
        scene.route(name, points, closed=True)
    for name, model, route, share, speed in plan.WALKERS:
        start = round(share * routes.length(plan.ROUTES[route]), 2)
        scene.actor(
            name,
            model,
            "person",
            {"type": "route", "route": route, "speed": speed, "start_m": start, "mode": "loop", "clip": "walk"},
        )
    for name, model, position, yaw, clip in plan.STANDERS:
        scene.actor(name, model, "person", {"type": "stand", "clip": clip}, position=position, yaw_deg=yaw)
    for name, (points, obstacles) in plan.AREAS.items():
        scene.area(name, points, [plan.OBSTACLES[obstacle] for obstacle in obstacles])
    story.add_to(scene)
    for name, (description, position, look_at, vfov) in plan.PLACES.items():
        scene.place(name, description, position, look_at, vfov)
    for name, size, fps in plan.CAMERAS:
        scene.camera(name, name, size, fps)
    return scene.text()


def footprints():
    """Footprints for whoever plans ways through the hall: where the floor is and what stands on it."""
    places = {
        "floor": [0.3, 0.3, structure.LENGTH - 0.3, structure.WIDTH - 0.3],
        "gallery": [0.3, 15.3, structure.LENGTH - 0.3, structure.WIDTH - 0.3, structure.GALLERY_Z],
        "obstacles": {name: list(rect) for name, rect in plan.OBSTACLES.items()},
    }
    return (json.dumps(places, indent=1) + "\n").encode()

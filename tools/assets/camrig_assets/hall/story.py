"""What happens in the hall from 8 s on, every two minutes: people come in by the doors, talk in a group, wait, stroll and
leave again, and one of them leaves a bag behind at 30 s. Before that everything is as the routes have it."""

from .. import bag as travel_bag
from . import plan

FIRST_S, PERIOD_S = 8, 120
WALK = {"area": "entrance_hall", "clip": "walk", "idle_clip": "idle"}
# name, model, when they come and leave (seconds after the beginning); one after the other through the doors
TALKERS = [("dora", "person_3", 2, 62), ("emil", "person_8", 4.5, 72), ("fritz", "person_11", 7, 82)]
# the same, and how long they pause
STROLLERS = [("gina", "person_5", 10, 92, 4), ("hugo", "person_2", 13, 104, 8)]
TALK_AT = (25.4, 9.6, 0)
WAIT_AT = (21.6, 7.0, 0)


def _go_to(place, **keys):
    return {"type": "go_to", "position": place, **WALK, **keys}


def _come(name, model, behaviour):
    person = {"name": name, "model": model, "class": "person", "position": plan.DOOR, "yaw_deg": 180}
    return {"action": "spawn", "actor": {**person, "behaviour": behaviour}}


def _behave(name, behaviour):
    return {"action": "behave", "actor": name, "behaviour": behaviour}


def add_to(scene):
    def after(name, seconds, do):
        scene.event(name, {"event": "day", "after_s": seconds}, do)

    def leave(name, seconds, walk_s):
        after(f"{name}_leaves", seconds, [_behave(name, _go_to(plan.DOOR))])
        after(f"{name}_is_gone", seconds + walk_s, [{"action": "remove", "actor": name}])

    scene.event("day", {"every_s": PERIOD_S, "from_s": FIRST_S}, [])
    bag = {"name": "bag", "model": "bag", "class": "bag"}
    carla = _come("carla", "person_9", _go_to(WAIT_AT, yaw_deg=180, idle_clip="wait"))
    hang = {"actor": "carla", "node": "left_hand", "position": (0, 0, -travel_bag.GRIP - 0.06)}
    after("carla_comes", 0.5, [carla, {"action": "spawn", "actor": {**bag, "attach": hang}}])
    put_down = {"action": "put_down", "object": "bag"}
    told = {"action": "user", "data": {"abandoned": "bag", "by": "carla"}}
    after("bag_abandoned", 30 - FIRST_S, [put_down, _behave("carla", _go_to(plan.DOOR)), told])
    after("carla_is_gone", 40 - FIRST_S, [{"action": "remove", "actor": "carla"}])
    after("bag_taken_away", 100 - FIRST_S, [{"action": "remove", "actor": "bag"}])
    for name, model, seconds, until in TALKERS:
        group = {"type": "group", "group": "newcomers", "position": TALK_AT, "radius_m": 0.75, **WALK}
        after(f"{name}_comes", seconds, [_come(name, model, {**group, "idle_clip": "talk"})])
        leave(name, until, 8)
    for name, model, seconds, until, pause in STROLLERS:
        after(f"{name}_comes", seconds, [_come(name, model, {"type": "wander", "pause_s": pause, **WALK})])
        leave(name, until, 11)
    scene.event("somebody_comes", {"enter": "door", "class": "person"}, [])
    scene.event("somebody_goes", {"leave": "door", "class": "person"}, [])

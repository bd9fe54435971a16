"""Light and clothes by chance (domain randomisation): what one number makes of a scene.

What comes of it are values of the scene file and nothing else, as a plan of `camrig farm record` sets them (docs/farm-record.md), and functions of the
seed and of names alone: the same on every machine, and one kind does not change with another.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Collection, Mapping, Sequence

from .command_line import Parser, connect_as_told, rig_options, run
from .errors import CamrigError
from .farm.batch.hashing import seed_of
from .scene_base import on_its_base, read_scene_file

if TYPE_CHECKING:
    from .rig import Rig

#: light: daylight and exposure, or lamps and exposure where no sun shines; clothes: the variant of each person.
KINDS = ("light", "clothes")
_PERSON = "person"
_MAX_VARIANT = 2**31
#: Where white is drawn as white, in a scene with daylight that says nothing else: daylight_lux of core/world/daylit.h.
_DAYLIGHT_LUX = 100e3
#: Of one event.act.
_MAX_ACTS = 64


def changes(scene: Mapping[str, Any], seed: int, kinds: Collection[str] = KINDS, people: Collection[str] | None = None) -> dict[str, Any]:
    """Places in the scene (JSON Pointers) and their values. `scene`: a scene file's JSON, its base put in (scene_base.on_its_base);
    `people`: names of actors, by default all of class person."""
    if unknown := sorted(set(kinds) - set(KINDS)):
        raise CamrigError("invalid_argument", f"'{unknown[0]}' is none of {', '.join(KINDS)}")
    made: dict[str, Any] = {}
    if "light" in kinds:
        made |= _daylight(scene, seed) if _has_sun(scene) else _lamps(scene, seed)
    if "clothes" in kinds:
        if people is None:
            people = [actor["name"] for actor in scene.get("actors", []) if actor.get("class") == _PERSON]
        made |= {f"/actors/{_word(name)}/variant": seed_of(seed, "clothes", name) % _MAX_VARIANT for name in people}
    return made


def randomize(rig: Rig, seed: int, kinds: Collection[str] = KINDS) -> dict[str, Any]:
    """Makes those changes in the world of a running rig, whose scene file must be on this machine; people who came later are dressed too. Gives what
    was changed."""
    path = Path(rig.status()["scene_file"])
    people = [actor["name"] for actor in rig.actors() if actor["class"] == _PERSON]
    scene = on_its_base(read_scene_file(path), path)
    made = changes(scene, seed, kinds, people)
    groups = {light["name"]: light["group"] for light in scene.get("lights", []) if "group" in light}
    environment: dict[str, Any] = {}
    acts: list[dict[str, Any]] = []
    for place, value in made.items():
        _, of, *name, key = (word.replace("~1", "/").replace("~0", "~") for word in place.split("/"))
        if of == "environment":
            environment[key] = value
        elif of == "lights":
            # Actions know neither members of groups nor units.
            act = {"action": "light", "light": groups.get(name[0], name[0]), "intensity": value if key == "intensity" else _number(value / scene["environment"]["lux"])}
            if act not in acts:
                acts.append(act)
        else:
            rig.set_actor(name[0], **{key: value})
    if environment:
        acts.append({"action": "environment", **environment})
    for first in range(0, len(acts), _MAX_ACTS):
        rig.act(*acts[first : first + _MAX_ACTS])
    return made


def _unit(*names: Any) -> float:
    return seed_of(*names) / 2**53


def _number(value: float) -> float:
    """Nine digits: what a mathematical library rounds otherwise in the last one makes no other scene."""
    return float(f"{value:.9g}")


def _word(name: str) -> str:
    return name.replace("~", "~0").replace("/", "~1")


def _has_sun(scene: Mapping[str, Any]) -> bool:
    return "daylight" in scene.get("environment", {}) or any(light.get("name") == "sun" for light in scene.get("lights", []))


def _daylight(scene: Mapping[str, Any], seed: int) -> dict[str, Any]:
    """A sun from 8 degrees up anywhere in the sky, air from clean to hazy, half of the days with clouds; exposed as a camera would, within half a stop."""
    low, high = math.sin(math.radians(8)), math.sin(math.radians(68))
    height = low + (high - low) * _unit(seed, "elevation")
    overcast = max(0.0, 2 * _unit(seed, "overcast") - 1)
    # Of a level surface, in multiples of 100 klx: core/daylight's within 10 % (clear, and all clouds).
    light = (1 - overcast) * 1.24 * height**1.36 + overcast * 0.21 * height
    white = scene.get("environment", {}).get("lux", _DAYLIGHT_LUX) / 100e3
    return {
        "/environment/daylight": {
            "azimuth_deg": _number(360 * _unit(seed, "azimuth")),
            "elevation_deg": _number(math.degrees(math.asin(height))),
            "turbidity": _number(2.2 + 5.8 * _unit(seed, "turbidity")),
            "overcast": _number(overcast),
        },
        "/environment/exposure": _number(0.9 / light * white * 2 ** (_unit(seed, "exposure") - 0.5)),
    }


def _lamps(scene: Mapping[str, Any], seed: int) -> dict[str, Any]:
    """Each light, or group of them, between half and one and a half times as strong, and the exposure within half a stop."""
    made = {}
    for light in scene.get("lights", []):
        key = next((unit for unit in ("candela", "lux") if unit in light), "intensity")
        share = 0.5 + _unit(seed, "light", light.get("group", light["name"]))
        made[f"/lights/{_word(light['name'])}/{key}"] = _number(light.get(key, 1.0) * share)
    exposure = scene.get("environment", {}).get("exposure", 1.0)
    return made | {"/environment/exposure": _number(exposure * 2 ** (_unit(seed, "exposure") - 0.5))}


def main(arguments: Sequence[str]) -> int:
    parser = Parser(prog="camrig randomize", parents=[rig_options()],
                    description="Changes light and people's clothes in the rig's world by chance: equal seeds make equal changes. "
                    "Then record: camrig randomize 7 && camrig record set --seconds 10")
    parser.add_argument("seed", type=_seed, help="0 to 2^53 - 1")
    parser.add_argument("--only", choices=KINDS, help="light (sun, sky, lamps, exposure) or clothes; default: both")
    options = parser.parse_args(arguments)
    with connect_as_told(options) as rig:
        made = randomize(rig, options.seed, KINDS if options.only is None else (options.only,))
    print(json.dumps(made) if getattr(options, "json", False) else f"{len(made)} values changed by seed {options.seed}")
    return 0


def _seed(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) <= 16 and int(text) < 2**53):
        raise argparse.ArgumentTypeError(f"'{text[:40]}' is not a whole number from 0 to 2^53 - 1")
    return int(text)


if __name__ == "__main__":
    sys.exit(run(main))

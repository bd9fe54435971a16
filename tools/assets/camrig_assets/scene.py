"""Writes a scene file (docs: scenes/schema): keys in a fixed order, one item a line, numbers rounded."""

import json

from .glb import number


#: Written as null; None is not written.
NULL = object()


def _clean(value):
    if value is NULL:
        return None
    if isinstance(value, (bool, str)) or value is None:
        return value
    if isinstance(value, dict):
        return {key: _clean(item) for key, item in value.items() if item is not None}
    if isinstance(value, (list, tuple)):
        return [_clean(item) for item in value]
    return number(round(float(value), 4))


class Scene:
    """World frame: z up, metres, x forward. Colours are linear RGB."""

    def __init__(self, name, description, seed):
        self.data = {"camrig_scene": 1, "name": name, "description": description, "seed": seed, "step_ns": 10_000_000}

    def environment(self, background, sky, ground, exposure=1.0, glow=None):
        self.data["environment"] = {
            "background": background,
            "ambient": {"sky": sky, "ground": ground},
            "exposure": exposure,
            "glow": glow,
        }

    def model(self, name, file, front=None):
        self.data.setdefault("models", {})[name] = {"file": file, "front": front}

    def object(self, name, model, kind, position=(0, 0, 0), yaw_deg=0, clip=None):
        self.data.setdefault("objects", []).append(
            {"name": name, "model": model, "class": kind, "position": position, "yaw_deg": yaw_deg, "clip": clip}
        )

    def light(self, name, kind, **values):
        self.data.setdefault("lights", []).append({"name": name, "type": kind, **values})

    def route(self, name, points, closed):
        self.data.setdefault("routes", {})[name] = {"points": points, "closed": closed}

    def area(self, name, points, obstacles=()):
        """`obstacles`: rectangles (x0, y0, x1, y1)."""
        corners = [[(x0, y0), (x1, y0), (x1, y1), (x0, y1)] for x0, y0, x1, y1 in obstacles]
        self.data.setdefault("areas", {})[name] = {"points": points, "obstacles": corners}

    def event(self, name, when, do):
        self.data.setdefault("events", []).append({"name": name, "when": when, "do": do})

    def actor(self, name, model, kind, behaviour, position=None, yaw_deg=None, scale=None, variant=None):
        self.data.setdefault("actors", []).append(
            {
                "name": name,
                "model": model,
                "class": kind,
                "position": position,
                "yaw_deg": yaw_deg,
                "scale": scale,
                "variant": variant,
                "behaviour": behaviour,
            }
        )

    def person(self, name, model, behaviour, position=None, yaw_deg=None, scale=None):
        """An actor of class person that looks like nobody else: a variant of its own, and a height within 6 %."""
        number = sum(actor["class"] == "person" for actor in self.data.get("actors", [])) + 1
        height = round(0.94 + 0.12 * (number * 0.6180339887 % 1), 3)
        self.actor(name, model, "person", behaviour, position, yaw_deg, scale or height, number)

    def place(self, name, description, position, look_at, vfov_deg):
        self.data.setdefault("places", {})[name] = {
            "description": description,
            "vfov_deg": vfov_deg,
            "pose": {"position": position, "look_at": look_at},
        }

    def camera(self, name, place, size, fps):
        self.data.setdefault("cameras", []).append({"name": name, "place": place, "size": size, "fps": fps})

    def text(self):
        """The file's text: top-level keys one a line, their items one a line below them."""
        lines = []
        for key, value in _clean(self.data).items():
            head = f"  {json.dumps(key)}: "
            if isinstance(value, list) and value:
                body = ",\n".join("    " + json.dumps(item) for item in value)
                lines.append(f"{head}[\n{body}\n  ]")
            elif isinstance(value, dict) and value:
                body = ",\n".join(f"    {json.dumps(name)}: {json.dumps(item)}" for name, item in value.items())
                lines.append(f"{head}{{\n{body}\n  }}")
            else:
                lines.append(head + json.dumps(value))
        return ("{\n" + ",\n".join(lines) + "\n}\n").encode()

"""Where the camrig program and the scenes that come with it are."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from .errors import CamrigError


def _checkout_above(place: Path) -> Path | None:
    """The source checkout that holds `place`, if one does."""
    return next((folder for folder in place.parents if (folder / "control" / "python" / "pyproject.toml").is_file()), None)


#: When the package is used from one: in place, or by pip install -e.
_CHECKOUT = _checkout_above(Path(__file__).resolve())


def find_binary() -> str:
    """The camrig program: $CAMRIG_BIN, else one in $PATH, else the one built in this source checkout."""
    if path := os.environ.get("CAMRIG_BIN"):
        return path
    if path := shutil.which("camrig"):
        return path
    places = "neither in $CAMRIG_BIN nor in $PATH"
    if _CHECKOUT is not None:
        for preset in ("dev", "run", "ci"):
            candidate = _CHECKOUT / "build" / preset / "tools" / "camrig" / "camrig"
            if candidate.is_file():
                return str(candidate)
        places += f" nor built in {_CHECKOUT}"
    raise CamrigError("unavailable", f"no camrig program: {places}; build it with tools/run and set CAMRIG_BIN")


def find_scene(scene: str | os.PathLike[str], binary: str | os.PathLike[str]) -> str:
    """The file as given; else the one that came with the package or the program, so that "scenes/minimal.json" works from
    anywhere: in the checkout of either, or where the program is installed. What is found nowhere is left to the program."""
    path = Path(scene)
    if not path.is_absolute() and not path.exists():
        program = Path(shutil.which(binary) or binary).resolve()
        for root in (_CHECKOUT, _checkout_above(program), program.parent.parent / "share" / "camrig"):
            if root is not None and (root / path).is_file():
                return str(root / path)
    return str(path)

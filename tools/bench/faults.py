"""python -m tools.bench.faults: what faults of the picture look like; writes the pictures of docs/faults.md."""

from __future__ import annotations

import sys
from fractions import Fraction

from tools.bench import report

ROOT = report.REPOSITORY
PICTURES = ROOT / "docs" / "pictures" / "faults"
SIZE = (320, 240)
#: Kind, severity, parameters.
SHOWN = (
    ("none", 0.0, {}),
    ("knock", 1.0, {}),
    ("defocus", 1.0, {}),
    ("dirt", 0.8, {}),
    ("covered", 0.5, {}),
    ("exposure", 1.0, {}),
    ("white_balance", 1.0, {}),
    ("noise", 0.8, {}),
    ("banding", 1.0, {}),
    ("dead_pixels", 1.0, {}),
    ("dead_rows", 1.0, {}),
    ("mirrored", 1.0, {}),
    ("upside_down", 1.0, {}),
    ("black", 0.7, {}),
)


def main() -> int:
    PICTURES.mkdir(parents=True, exist_ok=True)
    with report.start(ROOT / "scenes" / "hall.json", mode="lockstep", device="cpu", seed=1) as rig:
        camera = rig.create_camera("desk", place="lobby", size=SIZE, fps=Fraction(5))
        rig.step(seconds=4)
        for kind, severity, params in SHOWN:
            if kind != "none":
                rig.fault.set("desk", kind, severity=severity, **params)
            rig.step(seconds=0.2)
            camera.snapshot(PICTURES / f"{kind}.jpg")
            rig.fault.clear("desk")
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Draws the hall with one of the other renderers and prints one JSON line: see README.md."""

from __future__ import annotations

import argparse
import json
import os
import time

os.environ.setdefault("LP_NUM_THREADS", "2")
os.environ.setdefault("MUJOCO_GL", "egl")
os.environ.setdefault("PYOPENGL_PLATFORM", "egl")

import numpy as np  # noqa: E402
import renderers  # noqa: E402
import world  # noqa: E402
from PIL import Image  # noqa: E402


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("renderer", choices=list(renderers.ALL))
    parser.add_argument("--cameras", type=int, default=4)
    parser.add_argument("--seconds", type=float, default=4)
    parser.add_argument("--picture", help="writes what the first camera sees")
    arguments = parser.parse_args()
    pieces, cameras = world.load(arguments.cameras)
    draw = renderers.ALL[arguments.renderer](pieces, cameras)
    count, begin, cpu = 0, 0.0, 0.0
    warm_up = 3
    while count <= warm_up or time.perf_counter() < begin + arguments.seconds:
        if count == warm_up:
            begin, cpu = time.perf_counter(), time.process_time()
        pictures = draw([camera.turned(0.05 * (count % 40)) for camera in cameras])
        assert len(pictures) == len(cameras)
        for picture in pictures:
            assert picture.shape[:2] == (world.SIZE[1], world.SIZE[0]) and picture[::50, ::50].std() > 5, "an empty picture"
        count += 1
    wall, used, drawn = time.perf_counter() - begin, time.process_time() - cpu, (count - warm_up) * len(cameras)
    if arguments.picture:
        Image.fromarray(np.ascontiguousarray(draw(cameras)[0][..., :3])).save(arguments.picture)
    triangles = sum(len(piece.faces) for piece in pieces)
    print(json.dumps({"name": arguments.renderer, "cameras": len(cameras), "per_second": drawn / wall, "cpu_ms": 1000 * used / drawn, "triangles": triangles}))


main()

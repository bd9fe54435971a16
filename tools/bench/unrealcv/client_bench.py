#!/usr/bin/env python3
"""What UnrealCV's unaltered client gets from a rig: pictures of 640x480 and small commands a second.

    tools/bench/unrealcv/client_bench.py [--scene minimal] [--seconds 5]
"""

import argparse
import sys
import time

import beside

sys.path.extend(beside.places())

import unrealcv  # noqa: E402

import camrig  # noqa: E402


def rate(do, seconds):
    do(0)
    count, begin = 0, time.monotonic()
    while (spent := time.monotonic() - begin) < seconds:
        count += do(count + 1) or 1
    return count / spent


def measure(scene, seconds):
    with camrig.start(scene, mode="lockstep", args=["--unrealcv", "0"]) as rig:
        names = [camera.name for camera in rig.cameras()] or [rig.create_camera("main", hfov_deg=90).name]
        rig.camera(names[0]).set(size=(640, 480))
        api = unrealcv.UnrealCv_API(rig.call("server.info")["unrealcv"], "127.0.0.1", (640, 480))
        ask = api.client.request
        x, y, z = api.get_cam_location(0)

        def moved(what):
            def do(count):
                ask(f"vset /camera/0/location {x + count % 50} {y} {z}", -1)
                ask(what)

            return do

        def ticked(count):
            ask("vset /action/tick", -1)
            ask("vget /camera/0/lit bmp")

        def batch(count):
            ask(["vset /camera/0/location %g %g %g" % (x + count % 50, y, z), "vget /camera/0/lit bmp", "vget /camera/0/object_mask bmp", "vget /camera/0/depth npy"])
            return 3

        def small_batch(count):
            ask(["vget /camera/0/location"] * 1000)
            return 1000

        ask(["vset /action/tick_intervel 0.04"])
        for name, do in {
            "lit bmp, the world stands": lambda count: ask("vget /camera/0/lit bmp") and None,
            "lit bmp, a tick before each": ticked,
            "lit bmp, the camera moves before each": moved("vget /camera/0/lit bmp"),
            "lit png, the camera moves before each": moved("vget /camera/0/lit png"),
            "depth npy, the camera moves before each": moved("vget /camera/0/depth npy"),
            "object_mask bmp, the camera moves before each": moved("vget /camera/0/object_mask bmp"),
            "lit, mask and depth in one batch, the camera moves": batch,
            "small commands, each waits": lambda count: ask("vget /camera/0/location") and None,
            "small commands, in batches of 1000": small_batch,
        }.items():
            print(f"{scene:8} {name:52} {rate(do, seconds):8.0f} /s", flush=True)
        api.client.disconnect()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--scene", default="minimal")
    parser.add_argument("--seconds", type=float, default=5)
    options = parser.parse_args()
    measure(options.scene, options.seconds)


if __name__ == "__main__":
    main()

"""How well a person was kept in the picture, by camrig's truth: the only part that knows of camrig."""

import json
import threading

import numpy as np

import camrig


class Watch(threading.Thread):
    """While it is open, asks the camera's truth a few times a second; then prints one line of JSON."""

    def __init__(self, name, every_s=0.25):
        super().__init__(daemon=True)
        self.camera, self.every_s, self.done, self.off = camrig.connect().camera(name), every_s, threading.Event(), []

    def run(self):
        while not self.done.wait(self.every_s):
            truth = self.camera.truth()
            person = next((one for one in truth["objects"] if one["class"] == "person" and one["pixels"]), None)
            width = truth["size"][0]
            # Of the whole body, what the picture cuts off included, in widths of the picture; who is not in view is at no distance.
            self.off.append(abs(person["box_full"][0] + person["box_full"][2] / 2 - (width - 1) / 2) / width if person else np.inf)

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *_):
        self.done.set()
        self.join()
        off = np.array(self.off)
        seen = off[np.isfinite(off)]
        print(json.dumps({
            "camera": self.camera.name, "looks": len(off), "in_view": round(float(np.isfinite(off).mean()), 3),
            "within_a_fifth": round(float((off <= 0.2).mean()), 3),
            "median_off": round(float(np.median(seen)), 3) if len(seen) else None,
            "p90_off": round(float(np.quantile(seen, 0.9)), 3) if len(seen) else None}), flush=True)

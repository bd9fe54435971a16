#!/usr/bin/env python3
"""Runs the server tests of UnrealCV's repository, unaltered, against a rig on port 9000.

    tools/bench/unrealcv/upstream_tests.py FOLDER      a checkout of github.com/unrealcv/unrealcv
"""

import os
import pathlib
import subprocess
import sys
import tempfile

import beside

import camrig

PORT = 9000
# The package lost its module's client with 1.1, and the tests show pictures on a display.
PLUGIN = f"""
import cv2
import unrealcv

unrealcv.client = unrealcv.Client(("localhost", {PORT}))
cv2.imshow = lambda *arguments: None
cv2.waitKey = lambda *arguments: -1
"""


def main():
    if len(sys.argv) != 2 or not (tests := pathlib.Path(sys.argv[1], "test/server")).is_dir():
        sys.exit("usage: upstream_tests.py FOLDER: a checkout of github.com/unrealcv/unrealcv, with test/server in it")
    with tempfile.TemporaryDirectory() as folder:
        pathlib.Path(folder, "module_client.py").write_text(PLUGIN)
        pathlib.Path(folder, "files").mkdir()
        with camrig.start("minimal", mode="realtime", args=["--unrealcv", str(PORT), "--unrealcv-dir", f"{folder}/files"]) as rig:
            rig.create_camera("right", hfov_deg=90)  # they ask two
            path = os.pathsep.join([folder, *beside.places()])
            files = sorted(str(file) for file in tests.resolve().glob("*_test.py"))
            done = subprocess.run(
                [sys.executable, "-m", "pytest", "-p", "module_client", "-p", "no:cacheprovider", "-rs", "-v", f"--rootdir={tests}", *files],
                cwd=folder, env={**os.environ, "PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1"}, check=False)
    sys.exit(done.returncode)


if __name__ == "__main__":
    main()

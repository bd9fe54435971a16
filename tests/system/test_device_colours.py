"""Colours survive the way through a device: within two codes of what the renderer made, whoever converts them."""

import json
import os
import subprocess
import sys

from conftest import REPOSITORY


def test_a_chart_is_read_back_within_two_codes_in_every_format():
    done = subprocess.run([sys.executable, str(REPOSITORY / "tools/bench/device_colours"), "--json"], env=os.environ,
                          capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    results = json.loads(done.stdout)
    assert set(results) == {"YUYV", "MJPG", "YU12", "NV12", "BGR3"}
    for fourcc, ways in results.items():
        for way in ("formula", "OpenCV"):
            assert ways[way]["max"] <= 2, (fourcc, way, ways[way])
    assert results["BGR3"]["OpenCV"]["max"] == 0  # nothing is converted

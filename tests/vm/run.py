#!/usr/bin/env python3
"""The kernel-module devices on real kernels: boots a virtual machine for each version of v4l2loopback and runs guest/ in it.

    tests/vm/run.py                     both versions; needs CAMRIG_BIN or build/ci
    tests/vm/run.py --module 0.15 -k opencv
    tests/vm/run.py --bench             instead: latency and CPU time of devices of both ways, on the emulated machine
"""

from __future__ import annotations

import argparse
import os
import pathlib
import shlex
import subprocess
import sys
import time

from guest_kernel import MODULE_SUITES, GuestKernel
from machine import Machine

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
LIMIT_S = 900.0  # a bound for a machine that hangs; minutes are normal


def gstreamer_registry(folder: pathlib.Path) -> pathlib.Path:
    """What GStreamer knows of its plug-ins; looking through them all takes minutes on an emulated processor."""
    registry = folder / "gstreamer-registry"
    subprocess.run(["gst-inspect-1.0", "fakesink"], env={**os.environ, "GST_REGISTRY": str(registry)}, stdout=subprocess.DEVNULL,
                   check=True)
    return registry


def test_command(only: str | None) -> list[str]:
    command = [sys.executable, "-m", "pytest", "-v", "-rP", "-p", "no:cacheprovider", "--durations=0", "--durations-min=1",
               str(REPOSITORY / "tests" / "vm" / "guest")]
    return command + ["-k", only] if only else command


def bench_command(version: str) -> list[str]:
    """A small picture and a low rate: all is drawn on an emulated processor. 0.12 has its devices from when it is loaded."""
    devices = "devices=1 video_nr=10 exclusive_caps=1 max_buffers=4" if version.startswith("0.12") else "devices=0"
    measure = [sys.executable, str(REPOSITORY / "tools/bench/devices"), *"--kernel --number 10 --size 160x120 --fps 5 --seconds 8".split()]
    return ["bash", "-c", f"insmod /tmp/modules/v4l2loopback-{version}.ko {devices} && exec {shlex.join(measure)}"]


def main() -> int:
    parser = argparse.ArgumentParser(description="Tests of the kernel-module devices in a virtual machine.")
    parser.add_argument("--module", choices=list(MODULE_SUITES), action="append", help="only this version")
    parser.add_argument("-k", dest="only", help="only tests of this name, as for pytest")
    parser.add_argument("--bench", action="store_true", help="runs tools/bench/devices instead of the tests")
    arguments = parser.parse_args()

    started = time.monotonic()
    kernel = GuestKernel(REPOSITORY / "build" / "vm")
    registry = gstreamer_registry(kernel.folder)
    machine = Machine(kernel, REPOSITORY)
    binary = os.environ.get("CAMRIG_BIN", str(REPOSITORY / "build" / "ci" / "tools" / "camrig" / "camrig"))
    status = 0
    for key in arguments.module or MODULE_SUITES:
        version = kernel.modules[key][0]
        print(f"-- Linux {kernel.version} with v4l2loopback {version} ({time.monotonic() - started:.0f} s)", flush=True)
        command = bench_command(version) if arguments.bench else test_command(arguments.only)
        environment = {"CAMRIG_BIN": binary, "CAMRIG_LOOPBACK": version, "HOME": "/tmp", "PATH": os.environ["PATH"],
                       "PYTHONDONTWRITEBYTECODE": "1", "TERM": "dumb", "GST_REGISTRY": str(registry), "GST_REGISTRY_UPDATE": "no",
                       # Shaders are compiled on the emulated processor: without optimising them, and for short vectors.
                       "GALLIVM_PERF": "nopt", "LP_NATIVE_VECTOR_WIDTH": "128"}
        status |= machine.run(command, environment, LIMIT_S)
    print(f"-- {time.monotonic() - started:.0f} s")
    return 1 if status else 0


if __name__ == "__main__":
    sys.exit(main())

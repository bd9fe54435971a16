"""The kernel that the VM boots, and v4l2loopback built for it: fetched and built once, kept in build/vm."""

from __future__ import annotations

import json
import os
import pathlib
import shutil
import subprocess

from debian_packages import Suite

# Where each module version comes from. Debian 12 has 0.12.7; 13 has 0.15.0, which builds for the kernel of 12 too.
MODULE_SUITES = {"0.12": "bookworm", "0.15": "trixie"}
_FORMAT = 1  # raise it to have everything fetched again


class GuestKernel:
    """Paths of what was made. `modules` maps "0.12" and "0.15" to (exact version, .ko file)."""

    def __init__(self, folder: pathlib.Path, suites: dict[str, str] = MODULE_SUITES):
        self.folder = folder
        done = folder / "kernel.json"
        facts = json.loads(done.read_text()) if done.exists() else {}
        if facts.get("format") != _FORMAT or facts.get("suites") != suites:
            facts = self._make(suites)
            done.write_text(json.dumps(facts, indent=1))
        self.version: str = facts["kernel"]
        self.vmlinuz = folder / "root" / "boot" / f"vmlinuz-{self.version}"
        self.module_tree = folder / "root"
        self.modules = {key: (version, folder / "modules" / version / "v4l2loopback.ko")
                        for key, version in facts["modules"].items()}

    def _make(self, suites: dict[str, str]) -> dict:
        shutil.rmtree(self.folder, ignore_errors=True)
        root = self.folder / "root"
        root.mkdir(parents=True)
        apt = {name: Suite(name, self.folder / "apt") for name in {"bookworm", *suites.values()}}
        stable = apt["bookworm"]
        (headers,) = stable.dependencies("linux-headers-amd64")
        kernel = headers.removeprefix("linux-headers-")
        build_parts = [name for name in stable.dependencies(headers) if name.startswith("linux-")]
        stable.unpack([f"linux-image-{kernel}-unsigned", headers, *build_parts], root)
        # The package expects to be installed in /usr/src.
        makefile = root / "usr" / "src" / headers / "Makefile"
        makefile.write_text(makefile.read_text().replace("include /usr/src/", f"include {root}/usr/src/"))
        subprocess.run(["depmod", "-b", root, kernel], check=True)
        modules = {}
        for key, suite in suites.items():
            modules[key] = self._build_module(apt[suite], root / "usr" / "src" / headers)
            if not modules[key].startswith(key + "."):
                raise SystemExit(f"tests/vm: {suite} has v4l2loopback {modules[key]}, wanted {key}.x")
        shutil.rmtree(self.folder / "apt")
        return {"format": _FORMAT, "suites": suites, "kernel": kernel, "modules": modules}

    def _build_module(self, suite: Suite, headers: pathlib.Path) -> str:
        unpacked = suite.folder / "module"
        suite.unpack(["v4l2loopback-dkms"], unpacked)
        (source,) = (unpacked / "usr" / "src").glob("v4l2loopback-*")
        version = source.name.removeprefix("v4l2loopback-")
        target = self.folder / "modules" / version
        shutil.copytree(source, target)
        # The rest of the environment (MAKEFLAGS, CFLAGS of a caller) is none of the kernel's business.
        done = subprocess.run(["make", "-C", headers, f"M={target}", f"-j{os.cpu_count()}", "modules"], capture_output=True,
                              text=True, check=False, env={"PATH": os.environ["PATH"]})
        if done.returncode != 0:
            raise SystemExit(f"tests/vm: v4l2loopback {version} does not build:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
        return version

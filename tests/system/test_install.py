"""An installed camrig works from where it was put, without the build tree."""

import os
import pathlib
import subprocess

import pytest

CAMRIG = pathlib.Path(os.environ["CAMRIG_BIN"]).resolve()


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_an_installed_camrig_finds_its_device_library(rig, tmp_path):
    build = next(folder for folder in CAMRIG.parents if (folder / "cmake_install.cmake").exists() and (folder / "CMakeCache.txt").exists())
    subprocess.run(["cmake", "--install", str(build), "--prefix", str(tmp_path / "usr")], check=True, capture_output=True, timeout=120)
    # Moved afterwards: nothing may remember where it was installed.
    (tmp_path / "usr").rename(tmp_path / "elsewhere")
    program = tmp_path / "elsewhere" / "bin" / "camrig"
    library = tmp_path / "elsewhere" / "lib" / "camrig" / "libcamrig_device.so"

    rig.create_camera("eye", size=(320, 240), outputs=[{"kind": "device", "number": 7}])
    command = [str(program), "exec", "--control", rig.call("server.info")["control"], "--"]
    preload = subprocess.run([*command, "sh", "-c", "echo $LD_PRELOAD"], check=True, capture_output=True, text=True, timeout=60)
    assert preload.stdout.strip() == str(library.resolve())
    subprocess.run([*command, "v4l2-ctl", "-d", "/dev/video7", "--stream-mmap", "--stream-count=3"], check=True, capture_output=True, timeout=60)

"""An installed camrig works from where it was put, without the build tree; so does the one in a Debian package."""

import os
import pathlib
import re
import select
import subprocess
import sys

import pytest

from conftest import REPOSITORY, wait_until

CAMRIG = pathlib.Path(os.environ["CAMRIG_BIN"]).resolve()
BUILD = next(folder for folder in CAMRIG.parents if (folder / "cmake_install.cmake").exists() and (folder / "CMakeCache.txt").exists())


def run(*command, **options):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=300, check=False, **options)
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    return done.stdout


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("installed")
    run("cmake", "--build", BUILD, "--target", "wheel")
    run("cmake", "--install", BUILD, "--prefix", folder / "usr")
    # Moved afterwards: nothing may remember where it was installed.
    (folder / "usr").rename(folder / "elsewhere")
    return folder / "elsewhere"


@pytest.fixture(scope="module")
def extracted(tmp_path_factory):
    """The Debian package, taken apart: (its root, what it says of itself)."""
    folder = tmp_path_factory.mktemp("package")
    run("cmake", "--build", BUILD, "--target", "wheel")
    run("cpack", "-G", "DEB", "-B", folder / "made", cwd=BUILD)
    (package,) = (folder / "made").glob("camrig_*.deb")
    run("dpkg-deb", "-x", package, folder / "root")
    return folder / "root", run("dpkg-deb", "-f", package)


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_an_installed_camrig_finds_its_device_library(rig, installed):
    library = installed / "lib" / "camrig" / "libcamrig_device.so"
    rig.create_camera("eye", size=(320, 240), outputs=[{"kind": "device", "number": 7}])
    command = [str(installed / "bin" / "camrig"), "exec", "--control", rig.call("server.info")["control"], "--"]
    preload = subprocess.run([*command, "sh", "-c", "echo $LD_PRELOAD"], check=True, capture_output=True, text=True, timeout=60)
    assert preload.stdout.strip() == str(library.resolve())
    subprocess.run([*command, "v4l2-ctl", "-d", "/dev/video7", "--stream-mmap", "--stream-count=3"], check=True, capture_output=True, timeout=60)


def test_everything_that_a_user_needs_is_installed(installed):
    for path in ("share/camrig/scenes/hall.json", "share/camrig/scenes/schema.json", "share/doc/camrig/docs/streams.md", "share/doc/camrig/copyright",
                 "share/man/man1/camrig.1.gz", "share/man/man1/camrig-camera.1.gz", "share/bash-completion/completions/camrig",
                 "share/zsh/vendor-completions/_camrig", "share/fish/vendor_completions.d/camrig.fish", "lib/systemd/system/camrig.service",
                 "lib/python3/dist-packages/camrig/pytest_plugin.py", "lib/python3/dist-packages/camrig/ros2/__main__.py",
                 "lib/libcamrig_client.a", "lib/cmake/camrig/camrigConfig.cmake", "include/camrig/client.h", "include/camrig/opencv.h",
                 "share/camrig/examples/first_camera.cpp", "lib/camrig/camrig-view"):
        assert (installed / path).stat().st_size > 0, path
    entry_points = next((installed / "lib/python3/dist-packages").glob("camrig-*.dist-info")) / "entry_points.txt"
    assert "pytest_plugin" in entry_points.read_text()
    # A command in Python runs from there, not from the checkout.
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    environment["CAMRIG_PYTHON"] = sys.executable
    assert "record" in run(installed / "bin" / "camrig", "ros2", "--help", env=environment, cwd="/")
    where = run(sys.executable, "-c", "import camrig; print(camrig.__file__)", cwd="/",
                env=dict(environment, PYTHONPATH=str(installed / "lib/python3/dist-packages")))
    assert where.startswith(str(installed))


def test_links_of_the_installed_documents_lead_somewhere(installed):
    root = installed / "share" / "doc" / "camrig"
    pages = [root / "README.md", *root.glob("docs/**/*.md"), root / "control" / "python" / "README.md"]
    links = [(page, link) for page in pages for link in re.findall(r"\[[^]]+\]\(([^)#\s]+)[^)]*\)", page.read_text()) if "://" not in link]
    assert len(links) > 300
    assert [(page.name, link) for page, link in links if not (page.parent / link).exists()] == []


def test_the_wheel_goes_into_a_fresh_environment_with_its_pytest_plugin(installed, tmp_path):
    (wheel,) = (installed / "share" / "camrig").glob("camrig-*.whl")
    # numpy comes from the tests' own environment: no network.
    run(sys.executable, "-m", "venv", "--without-pip", tmp_path / "venv")
    python = tmp_path / "venv" / "bin" / "python"
    run(sys.executable, "-m", "pip", "--python", python, "install", "--quiet", "--no-index", "--no-deps", "--disable-pip-version-check", wheel)
    site = next(path for path in sys.path if path.endswith("site-packages"))
    program = "import camrig, importlib.metadata as m; print(camrig.__file__); print([e.value for e in m.entry_points(group='pytest11') if e.name == 'camrig'])"
    said = run(python, "-c", f"import sys; sys.path.append({site!r}); {program}", cwd=tmp_path)
    assert said.startswith(str(tmp_path / "venv")) and "camrig.pytest_plugin" in said


def test_the_debian_package_is_whole_and_runs_where_it_is_taken_apart(extracted):
    root, control = extracted
    assert "Package: camrig\n" in control and "Depends: " in control
    depends = control.split("Depends: ")[1].splitlines()[0]
    for library in ("libc6", "libgstreamer1.0-0", "libgstrtspserver-1.0-0", "gstreamer1.0-plugins-ugly"):
        assert library in depends, depends
    # Mesa is loaded for some pictures only; of what camrig does without it nothing is to fail for want of a package.
    assert "mesa" not in depends and "libegl" not in depends
    assert "libgl1-mesa-dri" in control.split("Recommends: ")[1].splitlines()[0]
    assert "RUNPATH" not in run("readelf", "-d", root / "usr/bin/camrig")
    import camrig

    with camrig.start(root / "usr/share/camrig/scenes/minimal.json", mode="lockstep", binary=root / "usr/bin/camrig") as rig:
        rig.step(seconds=0.1)
        assert rig.camera("main").frame().image.shape == (480, 640, 3)
        said = run(root / "usr/bin/camrig", "camera", "list", "--control", rig.info()["control"])
        assert "main" in said


def test_every_command_has_a_manual_page_without_a_warning(installed):
    commands = run(CAMRIG, "--help").split("Subcommands:")[1]
    names = [line.split()[0] for line in commands.splitlines() if line.startswith("  ") and not line.startswith("   ")]
    assert len(names) > 12
    for name in ["camrig", *(f"camrig-{name}" for name in names)]:
        page = installed / "share" / "man" / "man1" / f"{name}.1.gz"
        shown = subprocess.run(f"gzip -dc {page} | groff -man -Tutf8 -ww", shell=True, capture_output=True, text=True, timeout=60, check=True)
        assert shown.stderr == "", name
    create = run("sh", "-c", f"gzip -dc {installed}/share/man/man1/camrig-camera.1.gz | groff -man -Tascii -P-c -P-b -P-u")
    assert "camrig camera create" in create and "--vfov-deg" in create


def completed(installed, *words):
    """What bash offers for the last word."""
    script = installed / "share" / "bash-completion" / "completions" / "camrig"
    line = " ".join(f"'{word}'" for word in words)
    return run("bash", "-c", f"source {script}; COMP_WORDS=({line}); COMP_CWORD={len(words) - 1}; _camrig; printf '%s\\n' \"${{COMPREPLY[@]}}\"").split()


def test_shells_complete_commands_and_options_from_the_definitions(installed):
    assert {"camera", "serve", "exec"} <= set(completed(installed, "camrig", ""))
    assert completed(installed, "camrig", "camera", "cr") == ["create"]
    assert "--vfov-deg" in completed(installed, "camrig", "camera", "create", "eye", "--v")
    assert "--vfov-deg" not in completed(installed, "camrig", "camera", "list", "--")
    assert completed(installed, "camrig", "camera", "create", "--file", "") == []
    assert completed(installed, "camrig", "exec", "--", "") == []
    run("zsh", "-n", installed / "share/zsh/vendor-completions/_camrig")
    fish = installed / "share/fish/vendor_completions.d/camrig.fish"
    offered = run("fish", "--no-config", "-c", f"source {fish}; complete -C 'camrig camera cre'")
    assert offered.startswith("create")


class Zsh:
    """A zsh at a terminal, as a person has it."""

    def __init__(self, functions):
        self._terminal, end = os.openpty()
        environment = {"TERM": "dumb", "PATH": f"{CAMRIG.parent}:/usr/bin:/bin", "HOME": "/nonexistent", "COLUMNS": "200"}
        self.process = subprocess.Popen(["zsh", "-f", "-i"], stdin=end, stdout=end, stderr=end, env=environment, start_new_session=True)
        os.close(end)
        self.type(f"fpath=({functions} $fpath); autoload -Uz compinit; compinit -u -D; echo re''ady\n")
        self.wait("ready\r")

    def type(self, text):
        os.write(self._terminal, text.encode())

    def wait(self, words):
        """Until these words have been shown."""
        shown = b""

        def is_shown():
            nonlocal shown
            if select.select([self._terminal], [], [], 0)[0]:
                shown += os.read(self._terminal, 65536)
            return words.encode() in shown

        wait_until(is_shown, what=f"'{words}' from zsh")

    def close(self):
        self.process.kill()
        self.process.wait()
        os.close(self._terminal)


def test_zsh_completes_what_a_person_types(installed):
    zsh = Zsh(installed / "share/zsh/vendor-completions")
    try:
        for typed, completed in (("camrig camera cre", "camrig camera create "), ("camrig camera create eye --vf", "--vfov-deg "), ("camrig vie", "camrig view ")):
            zsh.type(typed + "\t")
            zsh.wait(completed)
            zsh.type("\x15")  # the line is forgotten
    finally:
        zsh.close()


def test_the_service_is_a_good_unit_and_hardened(installed, tmp_path):
    unit = tmp_path / "camrig.service"
    text = (installed / "lib/systemd/system/camrig.service").read_text()
    unit.write_text(text.replace("/usr/bin/camrig", str(installed / "bin" / "camrig")))
    done = subprocess.run(["systemd-analyze", "verify", "--man=no", str(unit)], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0 and "camrig.service" not in done.stderr, done.stderr
    exposure = subprocess.run(["systemd-analyze", "security", "--offline=true", "--threshold=30", str(unit)], capture_output=True, text=True, timeout=60, check=False)
    assert exposure.returncode == 0, exposure.stdout[-600:]
    assert (REPOSITORY / "tools/install/camrig.service").read_text() == text

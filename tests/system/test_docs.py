"""The examples of the README run as they stand (only the ports are replaced: tests take free ones), and no page for users has a block that no test runs."""

import os
import pathlib
import re
import shutil
import subprocess
import sys

import pytest

import camrig
from conftest import REPOSITORY


#: What a reader goes through block by block. Every sh and python block of these pages is run, by this file or by test_guides.py,
#: test_actors_docs.py, test_ros2_docs.py and test_cpp_client.py ...
PAGES = ["README.md", "docs/getting-started.md", "docs/recipes.md", "docs/actors.md", "docs/devices.md", "docs/ros2.md",
         "docs/sensor.md", "docs/ptz.md", "docs/clocks.md"]
#: ... and these are all others: how they begin, and why not.
NOT_RUN = {
    "git clone ADDRESS": "is how the tests came here",
    "sudo apt install v4l2loopback-dkms": "needs a kernel with the module: tests/vm",
    "sudo modprobe v4l2loopback": "needs a kernel with the module: tests/vm",
    "vlc ": "as the page says",
    "FROM debian:12": "as the page says",
    "camrig exec -- ros2 launch": "ROS 2 is not in Debian; what it starts is checked by test_ros2.py",
    "m = E t q V": "formulas",
}
#: The other pages with blocks, and who runs these or why nobody does.
ELSEWHERE = {
    "docs/accuracy.md": "minutes, with an environment of its own: tools/bench/accuracy, of which test_accuracy.py runs a part",
    "docs/architecture.md": "drawings",
    "docs/backdrops.md": "they need a photo; test_backdrops.py, test_plate.py and test_projected.py give them one",
    "docs/control-protocol.md": "messages and answers as they were, written by `camrig methods --write` and compared by CI",
    "docs/cpp-client.md": "test_cpp_client.py and test_install.py",
    "docs/farm-record.md": "folders of the reader; test_farm_record.py reads its plan and runs the same commands",
    "docs/farm.md": "need the extra camrig[farm] and a NATS server; test_farm.py starts farms, test_command_log.py logs",
    "docs/faults.md": "test_faults.py and test_campaigns.py",
    "docs/install.md": "needs root; test_install.py installs, packs and verifies",
    "docs/mutations.md": "answers",
    "docs/network.md": "minutes; test_network.py runs them shorter",
    "docs/onvif.md": "files of other programs and a server's start: test_onvif*.py start theirs with the same options",
    "docs/probe.md": "addresses of other machines; test_probe.py",
    "docs/quality.md": "the scene is the reader's; test_bake.py has one",
    "docs/scene-format.md": "test_scene_schema.py loads them",
    "docs/streams.md": "players that need a display; test_clients.py and test_rtsp*.py have the same programs without one",
    "docs/truth.md": "a list of doors; test_truth.py and test_record.py use each",
    "docs/unrealcv.md": "test_unrealcv.py runs the program, with the client where it is installed",
    "docs/view.md": "needs a display; test_view.py has one",
    "control/python/README.md": "test_guides.py",
    "tools/bench/onvif/README.md": "clients of others, got from their makers: for who measures",
    "tools/bench/unrealcv/README.md": "UnrealCV itself, got from its makers: for who measures",
    "tools/bench/peers/README.md": "simulators of others, got from their makers: for who measures",
    "examples/tracker/README.md": "minutes; test_tracker.py runs the example on the dome",
}


def blocks(document: str, language: str) -> list[str]:
    text = (REPOSITORY / document).read_text()
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


def test_every_block_of_a_users_page_is_run_or_says_why_not():
    left = dict(NOT_RUN)
    for page in PAGES:
        for language, block in re.findall(r"^```([^\n]*)\n(.*?)^```", (REPOSITORY / page).read_text(), re.MULTILINE | re.DOTALL):
            if language not in ("sh", "python", "python test", "cpp"):
                assert (start := next((start for start in NOT_RUN if block.startswith(start)), None)), f"{page}: {block}"
                left.pop(start, None)
    assert not left, "no page has these any more"


def test_every_page_with_blocks_is_run_or_says_by_whom():
    files = [name for name in run(["git", "ls-files", "*.md"], cwd=REPOSITORY).split() if not name.startswith("docs/decisions/")]  # notes for who changes camrig
    pages = {name for name in files if re.search(r"^```", (REPOSITORY / name).read_text(), re.MULTILINE)}
    assert pages == set(PAGES) | set(ELSEWHERE)
    assert not set(PAGES) & set(ELSEWHERE)


def run(command, timeout=120, **options):
    done = subprocess.run(command, capture_output=True, text=True, timeout=timeout, check=False, **options)
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    return done.stdout


@pytest.fixture
def hall():
    with camrig.start(str(REPOSITORY / "scenes" / "hall.json")) as rig:
        yield rig


@pytest.fixture
def environment(hall, tmp_path):
    """A reader's: `camrig` on the PATH and pointed at the running hall, and an environment of Python of their own, in which `pip install` works
    without the network and does not see this checkout's camrig."""
    tools = tmp_path / "bin"
    tools.mkdir()
    (tools / "camrig").symlink_to(os.environ["CAMRIG_BIN"])
    run([sys.executable, "-m", "venv", "--without-pip", tmp_path / "venv"])
    (site,) = (tmp_path / "venv" / "lib").glob("python*/site-packages")
    (site / "others.pth").write_text("\n".join(path for path in sys.path if path.endswith("-packages")))  # numpy, OpenCV, pytest, setuptools
    (tools / "pip").write_text(f'#!/bin/sh\nexec "{sys.executable}" -m pip --python "{tmp_path}/venv/bin/python" "$@"\n')
    (tools / "pip").chmod(0o755)
    # In place, pip would leave its build folders in the checkout.
    shutil.copytree(REPOSITORY / "control" / "python", tmp_path / "control" / "python", ignore=shutil.ignore_patterns("build", "*.egg-info", "__pycache__"))
    known = {key: value for key, value in os.environ.items() if key not in ("CAMRIG_BIN", "PYTHONPATH")}
    return dict(known, PATH=f"{tools}:{tmp_path}/venv/bin:{os.environ['PATH']}", CAMRIG_CONTROL=hall.call("server.info")["control"],
                PIP_NO_BUILD_ISOLATION="0", PIP_NO_INDEX="1", PIP_NO_DEPS="1", PIP_DISABLE_PIP_VERSION_CHECK="1")  # 0: none of it (sic)


def ported(text, hall):
    """With the ports that the running hall has."""
    return text.replace("http://127.0.0.1:8080/", hall.http_url.rstrip("/") + "/").replace("rtsp://127.0.0.1:8554", hall.rtsp_url)


def shell(block, hall, environment, folder):
    return run(["bash", "-euo", "pipefail", "-c", ported(block, hall)], env=environment, cwd=folder)


def test_the_readme_opencv_program_reads_frames(hall, environment, tmp_path):
    program = next(block for block in blocks("README.md", "python") if "VideoCapture" in block)
    program = ported(program, hall).replace("while capture.read()[0]:\n    pass", "assert all(capture.read()[0] for _ in range(10))")
    assert "range(10)" in program
    run(["python", "-c", program], env=environment, cwd=tmp_path)


def test_the_readme_python_programs_run_after_the_readmes_install(hall, environment, tmp_path):
    programs = [block for block in blocks("README.md", "python") if "import camrig" in block]
    assert programs and "`pip install ./control/python` brings the package" in (REPOSITORY / "README.md").read_text()
    shell("pip install ./control/python", hall, environment, tmp_path)
    for program in programs:
        assert "(480, 640, 3)" in run(["python", "-c", program], env=environment, cwd=tmp_path)


def test_the_readme_shell_commands_run(hall, environment, tmp_path):
    found = [block for block in blocks("README.md", "sh") if "tools/run" not in block]  # that and tools/test: what runs this
    assert len(found) >= 2
    for block in found:
        shell(block, hall, environment, tmp_path)
    assert (tmp_path / "desk.jpg").stat().st_size > 10_000
    assert (tmp_path / "lobby.png").stat().st_size > 10_000
    assert "nb_read_frames=50\n" in run(["ffprobe", "-v", "error", "-count_frames", "-show_entries", "stream=nb_read_frames", str(tmp_path / "lobby.mp4")])


def test_every_link_of_the_documents_leads_somewhere():
    for document in ["README.md", *(str(p.relative_to(REPOSITORY)) for p in (REPOSITORY / "docs").rglob("*.md"))]:
        prose = re.sub(r"^```.*?^```", "", (REPOSITORY / document).read_text(), flags=re.DOTALL | re.MULTILINE)
        for target in re.findall(r"\]\(([^)#]+)", prose):
            if "://" not in target:
                assert ((REPOSITORY / document).parent / target).exists(), f"{document}: {target}"


def test_nothing_names_the_machine_it_was_made_on():
    files = run(["git", "ls-files"], cwd=REPOSITORY).split()
    for name in files:
        path = REPOSITORY / name
        if path.suffix in (".md", ".py", ".cpp", ".h", ".json", ".txt", ".cmake") and path.stat().st_size < 1 << 20:
            assert "/work" + "/" not in path.read_text(errors="replace"), name

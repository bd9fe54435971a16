"""docs/getting-started.md and docs/recipes.md do what they say: their commands run as they stand, but for the ports."""

import re
import subprocess
import sys

import pytest

from conftest import REPOSITORY
from test_docs import blocks, environment, hall, run  # noqa: F401  (fixtures)


def ported(text, hall):  # noqa: F811
    return text.replace("http://127.0.0.1:8080/", hall.http_url.rstrip("/") + "/").replace("rtsp://127.0.0.1:8554", hall.rtsp_url)


@pytest.fixture
def in_venv(environment, tmp_path):  # noqa: F811
    """`python3` in a document is one that has OpenCV."""
    (tmp_path / "bin" / "python3").symlink_to(sys.executable)
    # A link to a virtual environment's Python does not find the environment by itself.
    return dict(environment, PYTHONPATH=":".join(path for path in sys.path if "site-packages" in path) + f":{REPOSITORY}/control/python")


@pytest.mark.parametrize("document", ["docs/getting-started.md", "docs/recipes.md"])
def test_the_shell_commands_of_a_guide_run_in_their_order(document, hall, in_venv, tmp_path):  # noqa: F811
    shell = blocks(document, "sh")
    assert len(shell) >= 4
    said = [run(["bash", "-euo", "pipefail", "-c", ported(block, hall)], env=in_venv, cwd=tmp_path) for block in shell]
    if document.endswith("started.md"):
        assert "(480, 640, 3)" in said[1]
        assert '"front"' in (tmp_path / "cameras.json").read_text()
        # And back again, as the text promises.
        run(["bash", "-euc", "camrig camera delete lobby; camrig camera delete entrance; camrig camera delete gallery; camrig camera create --file cameras.json"],
            env=in_venv, cwd=tmp_path)
        assert [camera.name for camera in hall.cameras()] == ["lobby", "entrance", "gallery", "front"]
        assert hall.camera("front").get()["pose"]["pan_deg"] == pytest.approx(40)
    else:
        assert (tmp_path / "ros2").is_dir() and (tmp_path / "both.mp4").stat().st_size > 10_000


@pytest.mark.parametrize("document", ["docs/getting-started.md", "docs/recipes.md"])
def test_the_python_programs_of_a_guide_run(document, hall, in_venv, tmp_path):  # noqa: F811
    programs = blocks(document, "python")
    assert programs
    for program in programs:
        assert "(480, 640, 3)" in run([sys.executable, "-c", ported(program, hall)], env=in_venv, cwd=tmp_path)


def test_the_test_of_ones_own_detector_passes_under_pytest(tmp_path):
    (test,) = blocks("docs/getting-started.md", "python test")
    (tmp_path / "test_detector.py").write_text(test)
    done = subprocess.run([sys.executable, "-m", "pytest", "-q", "test_detector.py"], cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0 and "1 passed" in done.stdout, done.stdout


def test_troubleshooting_quotes_what_is_really_said(hall, in_venv, tmp_path):  # noqa: F811
    text = (REPOSITORY / "docs" / "troubleshooting.md").read_text()
    for command in re.findall(r"`(camrig [a-z][^`]*?)`", text):
        words = command.split()[1:3]
        if words[0] in ("exec", "probe", "call", "stats", "snapshot"):
            words = words[:1]
        if words[0] in ("call", "stats", "exec", "probe", "camera", "world"):
            subprocess.run(["camrig", *words, "--help"], env=in_venv, check=True, capture_output=True, timeout=30)
    taken = subprocess.run(["camrig", "serve", str(REPOSITORY / "scenes/minimal.json"), "--control", str(tmp_path / "other.sock"), "--rtsp", "0",
                            "--http", hall.http_url.rstrip("/").rsplit(":", 1)[1]], env=in_venv, capture_output=True, text=True, timeout=60, check=False)
    assert taken.returncode == 1 and "ddress already in use" in taken.stderr, taken.stderr
    open_door = subprocess.run(["camrig", "serve", str(REPOSITORY / "scenes/minimal.json"), "--host", "0.0.0.0", "--control", str(tmp_path / "other.sock")],
                               env=in_venv, capture_output=True, text=True, timeout=60, check=False)
    assert open_door.returncode == 1 and "token-file" in open_door.stderr, open_door.stderr

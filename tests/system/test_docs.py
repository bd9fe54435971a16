"""The examples of the README run as they stand (only the ports are replaced: tests take free ones)."""

import os
import pathlib
import re
import subprocess
import sys

import pytest

import camrig
from conftest import REPOSITORY


def blocks(document: str, language: str) -> list[str]:
    text = (REPOSITORY / document).read_text()
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


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
    """`camrig` on the PATH and pointed at the running hall; scenes/ as seen from the repository."""
    tools = tmp_path / "bin"
    tools.mkdir()
    (tools / "camrig").symlink_to(os.environ["CAMRIG_BIN"])
    (tmp_path / "scenes").symlink_to(REPOSITORY / "scenes")
    return dict(os.environ, PATH=f"{tools}:{os.environ['PATH']}", CAMRIG_CONTROL=hall.call("server.info")["control"])


def test_the_readme_opencv_program_reads_frames(hall, environment, tmp_path):
    program = next(block for block in blocks("README.md", "python") if "VideoCapture" in block)
    program = program.replace("http://127.0.0.1:8080/", hall.http_url.rstrip("/") + "/")
    program = program.replace("while capture.read()[0]:\n    pass", "assert all(capture.read()[0] for _ in range(10))")
    assert "range(10)" in program
    run([sys.executable, "-c", program], env=environment, cwd=tmp_path)


def test_the_readme_python_programs_run(environment, tmp_path):
    programs = [block for block in blocks("README.md", "python") if "import camrig" in block]
    assert programs
    for program in programs:
        assert "(480, 640, 3)" in run([sys.executable, "-c", program], env=environment, cwd=tmp_path)


def test_the_readme_shell_commands_run(hall, environment, tmp_path):
    shell = [block for block in blocks("README.md", "sh") if "tools/run" not in block]
    assert len(shell) >= 2
    for block in shell:
        block = block.replace("http://127.0.0.1:8080/", hall.http_url.rstrip("/") + "/")
        block = block.replace("rtsp://127.0.0.1:8554", hall.rtsp_url)
        run(["bash", "-euo", "pipefail", "-c", block], env=environment, cwd=tmp_path)
    assert (tmp_path / "desk.jpg").stat().st_size > 10_000
    assert (tmp_path / "lobby.png").stat().st_size > 10_000
    assert "50" in run(["ffprobe", "-v", "error", "-count_frames", "-show_entries", "stream=nb_read_frames", str(tmp_path / "lobby.mp4")])


def test_every_link_of_the_documents_leads_somewhere():
    for document in ["README.md", *(str(p.relative_to(REPOSITORY)) for p in (REPOSITORY / "docs").rglob("*.md"))]:
        for target in re.findall(r"\]\(([^)#]+)", (REPOSITORY / document).read_text()):
            if "://" not in target:
                assert ((REPOSITORY / document).parent / target).exists(), f"{document}: {target}"


def test_nothing_names_the_machine_it_was_made_on():
    files = run(["git", "ls-files"], cwd=REPOSITORY).split()
    for name in files:
        path = REPOSITORY / name
        if path.suffix in (".md", ".py", ".cpp", ".h", ".json", ".txt", ".cmake") and path.stat().st_size < 1 << 20:
            assert "/work" + "/" not in path.read_text(errors="replace"), name

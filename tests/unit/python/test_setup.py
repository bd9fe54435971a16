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


def test_setup_installs_the_package_in_place_once_and_again_when_it_changes(tmp_path):
    for file in ("tools/setup", "tools/requirements.txt", "tools/requirements-beside.txt", "control/python/pyproject.toml"):
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(REPOSITORY / file, tmp_path / file)
    program(tmp_path / "bin" / "dpkg-query", "echo install ok installed")
    program(tmp_path / ".venv" / "bin" / "python", "exit 1")
    program(tmp_path / ".venv" / "bin" / "pip", f'echo "$*" >>{tmp_path}/installed')

    def installed():
        subprocess.run([tmp_path / "tools" / "setup", "--build-only"], env=dict(os.environ, PATH=f"{tmp_path}/bin:{os.environ['PATH']}"), check=True)
        lines = (tmp_path / "installed").read_text().splitlines() if (tmp_path / "installed").exists() else []
        (tmp_path / "installed").unlink(missing_ok=True)
        return [line.split()[-2:] for line in lines]

    assert installed() == [["-r", "tools/requirements.txt"], ["-r", "tools/requirements-beside.txt"], ["-e", "control/python"]]
    assert installed() == []
    with (tmp_path / "control/python/pyproject.toml").open("a") as project:
        project.write("# changed\n")
    assert ["-e", "control/python"] in installed()


@pytest.mark.parametrize("bench", ["accuracy", "first_steps", "people", "quality", "speed", "truth"])
def test_a_bench_starts_by_its_name_from_the_checkout(bench):
    done = subprocess.run([sys.executable, "-m", f"tools.bench.{bench}", "--help"], cwd=REPOSITORY, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0 and "usage:" in done.stdout, done.stderr

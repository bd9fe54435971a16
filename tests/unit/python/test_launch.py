"""camrig.start: the daemon as a child that is always cleared away."""

import gc
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import camrig
from camrig import places


def alive(pid):
    """False when it ended, or only waits to be reaped."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def private_directory(rig):
    return Path(rig.info()["arguments"][rig.info()["arguments"].index("--control") + 1]).parent


def test_options_become_the_command_line(fake_binary):
    with camrig.start("scene.json", mode="lockstep", device="cpu", seed=7, binary=fake_binary) as rig:
        arguments = rig.info()["arguments"]
        assert arguments[:2] == ["serve", "scene.json"]
        for pair in (["--mode", "lockstep"], ["--device", "cpu"], ["--seed", "7"], ["--http", "0"], ["--rtsp", "0"]):
            at = arguments.index(pair[0])
            assert arguments[at : at + 2] == pair
        assert rig.http_url == "http://127.0.0.1:8123"
        assert rig.rtsp_url == "rtsp://127.0.0.1:8555"


def test_a_token_that_clients_show_is_in_the_rigs_urls(fake_binary, tmp_path):
    (tmp_path / "token").write_text("secret-token\n")
    with camrig.start("scene.json", binary=fake_binary, token_file=tmp_path / "token") as rig:
        arguments = rig.info()["arguments"]
        assert arguments[arguments.index("--token-file") + 1] == str(tmp_path / "token")
        assert rig.token == "secret-token"
        assert rig.device("lobby") == camrig.Camera(rig, "lobby").url() == "http://127.0.0.1:8123/cameras/lobby/stream.mjpg?token=secret-token"
    with pytest.raises(camrig.CamrigError, match="--token-file .*nothing: No such file") as caught:
        camrig.start("scene.json", binary=fake_binary, token_file=tmp_path / "nothing")
    assert caught.value.kind == "invalid_argument"


@pytest.mark.parametrize("long", [float("inf"), 1e10])
def test_it_may_take_as_long_as_one_likes_to_be_ready(fake_binary, long):
    with camrig.start("scene.json", binary=fake_binary, timeout=long) as rig:
        assert alive(rig.info()["pid"])


def test_nothing_is_left_after_close(fake_binary):
    with camrig.start("scene.json", binary=fake_binary) as rig:
        pid, directory = rig.info()["pid"], private_directory(rig)
        assert directory.stat().st_mode & 0o777 == 0o700
    assert not alive(pid)
    assert not directory.exists()
    assert "fake rig: serve" in rig.log, "its log is still there"
    rig.close()


def test_nothing_is_left_when_the_rig_is_forgotten(fake_binary):
    rig = camrig.start("scene.json", binary=fake_binary)
    pid = rig.info()["pid"]
    del rig
    gc.collect()
    assert not alive(pid)


def test_nothing_is_left_when_the_program_ends(fake_binary):
    program = f"import camrig; rig = camrig.start('scene.json', binary={str(fake_binary)!r}); print(rig.info()['pid'])"
    path = os.pathsep.join([str(Path(camrig.__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run([sys.executable, "-c", program], env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, timeout=30)
    assert done.returncode == 0, done.stderr
    assert not alive(int(done.stdout))


def test_a_forked_copy_does_not_stop_the_rig(fake_binary):
    with camrig.start("scene.json", binary=fake_binary) as rig:
        child = os.fork()
        if child == 0:
            rig._owner.stop()
            os._exit(0)
        os.waitpid(child, 0)
        assert alive(rig.info()["pid"])


def test_a_rig_that_ignores_sigterm_is_killed_and_that_is_an_error(fake_binary, monkeypatch):
    monkeypatch.setenv("CAMRIG_STOP_TIMEOUT_S", "0.1")
    rig = camrig.start("stubborn.json", binary=fake_binary)
    pid, directory = rig.info()["pid"], private_directory(rig)
    with pytest.raises(camrig.CamrigError, match=r"did not end within 0.1 s of SIGTERM(.|\n)*fake rig: serve"):
        rig.close()
    assert not alive(pid) and not directory.exists()
    rig.close()


@pytest.mark.parametrize(
    ("scene", "said"), [("failing.json", "ended, with exit code 3"), ("crashing.json", r"ended, by signal 6(.|\n)*CHECK failed: nothing is left")]
)
def test_a_rig_that_ends_badly_is_an_error_with_the_end_of_its_log(fake_binary, scene, said):
    rig = camrig.start(scene, binary=fake_binary)
    with pytest.raises(camrig.CamrigError, match=said):
        rig.close()


def test_a_rig_that_had_crashed_before_is_an_error_at_its_close(fake_binary):
    rig = camrig.start("scene.json", binary=fake_binary)
    os.kill(rig.info()["pid"], signal.SIGKILL)
    with pytest.raises(camrig.CamrigError, match="by signal 9"):
        rig.close()


def test_what_went_wrong_in_the_block_is_not_hidden_by_a_bad_end(fake_binary):
    with pytest.raises(ZeroDivisionError) as caught:
        with camrig.start("failing.json", binary=fake_binary):
            1 / 0
    if sys.version_info >= (3, 11):
        assert "exit code 3" in caught.value.__notes__[0]


def test_a_rig_that_cannot_start_says_why(fake_binary):
    with pytest.raises(camrig.CamrigError, match=r"exit code 1.*\n.*\n.*cameras\[0\].size: is too small") as caught:
        camrig.start("broken.json", binary=fake_binary)
    assert caught.value.kind == "unavailable"


def test_a_rig_that_never_gets_ready_is_a_timeout_and_is_gone(fake_binary):
    with pytest.raises(camrig.CamrigTimeout, match="not ready within 1 s"):
        camrig.start("silent.json", binary=fake_binary, timeout=1)


def test_a_missing_program_is_an_error(tmp_path, monkeypatch):
    with pytest.raises(camrig.CamrigError, match="cannot run"):
        camrig.start("scene.json", binary=tmp_path / "nothing")
    monkeypatch.delenv("CAMRIG_BIN", raising=False)
    monkeypatch.setenv("PATH", "")
    monkeypatch.setattr(places, "_CHECKOUT", tmp_path)
    with pytest.raises(camrig.CamrigError, match="tools/run"):
        places.find_binary()


def test_the_program_is_found_by_variable_path_and_checkout(tmp_path, monkeypatch):
    built = tmp_path / "build" / "dev" / "tools" / "camrig" / "camrig"
    built.parent.mkdir(parents=True)
    built.touch()
    monkeypatch.setattr(places, "_CHECKOUT", tmp_path)
    monkeypatch.delenv("CAMRIG_BIN", raising=False)
    monkeypatch.setenv("PATH", "")
    assert places.find_binary() == str(built)
    in_path = tmp_path / "bin" / "camrig"
    in_path.parent.mkdir()
    in_path.touch(mode=0o755)
    monkeypatch.setenv("PATH", str(in_path.parent))
    assert places.find_binary() == str(in_path)
    monkeypatch.setenv("CAMRIG_BIN", "/somewhere/camrig")
    assert places.find_binary() == "/somewhere/camrig"


@pytest.mark.parametrize("belongs_to", ["package", "program", "installation"])
def test_scenes_that_came_along_are_found_from_anywhere(tmp_path, monkeypatch, belongs_to):
    """In the checkout of the package (pip install -e), of the program (pip install), and beside an installed program."""
    root, program = {
        "package": (tmp_path, Path("/nowhere/camrig")),
        "program": (tmp_path, tmp_path / "build" / "run" / "tools" / "camrig" / "camrig"),
        "installation": (tmp_path / "share" / "camrig", tmp_path / "bin" / "camrig"),
    }[belongs_to]
    (root / "scenes").mkdir(parents=True)
    (root / "scenes" / "x.json").touch()
    if belongs_to == "program":
        (tmp_path / "control" / "python").mkdir(parents=True)
        (tmp_path / "control" / "python" / "pyproject.toml").touch()
    monkeypatch.setattr(places, "_CHECKOUT", tmp_path if belongs_to == "package" else None)
    assert places.find_scene("scenes/x.json", program) == str(root / "scenes" / "x.json")
    for left in ("missing.json", "hall"):
        assert places.find_scene(left, program) == left

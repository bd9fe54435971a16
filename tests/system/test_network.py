"""examples/network on a rig: every camera a process of its own, over a real bus. Short runs with few cameras; the rest is test_network_algorithms.py's."""

import asyncio
import contextlib
import json
import os
import pathlib
import signal
import subprocess
import sys
import threading
from collections import Counter
from types import SimpleNamespace

import nats
import pytest

import camrig
from conftest import REPOSITORY, wait_until

sys.path.insert(0, str(REPOSITORY))
from examples.network import stage  # noqa: E402
from examples.network.bus import environment  # noqa: E402
from examples.network.conductor import Conductor  # noqa: E402
from examples.network.nodes import Plan  # noqa: E402
from examples.network.score import read_logs, read_truth  # noqa: E402
from examples.network.sweep import Recording  # noqa: E402
from test_docs import blocks

STEPS = 10


def play(folder, cameras=3, heads=1, steps=STEPS, mode="lockstep", fps=4, on_step=lambda *_: None, **more):
    """Runs a network; (its plan, the ends of programs that ended early)."""
    folder.mkdir(exist_ok=True)
    with camrig.start(str(REPOSITORY / "scenes" / "hall.json"), mode=mode, seed=1, overload="slow" if mode == "realtime" else None) as rig:
        plan = Plan(*stage.build(rig, cameras, heads, fps), fps=fps, **more)
        return plan, Conductor(rig, plan, folder, mode == "lockstep", on_step).run(steps)


def written(folder):
    return {path.name: path.read_bytes() for path in sorted(folder.glob("*.jsonl"))}


@pytest.mark.slow
def test_a_run_in_lockstep_repeats_to_the_byte_and_its_replay_in_one_process_is_the_same(tmp_path):
    plan, ended = play(tmp_path / "a", fps=3, strategy="ABC", rounds=2, loss=0.1)  # a period of no whole number of ns
    assert not ended
    play(tmp_path / "b", fps=3, strategy="ABC", rounds=2, loss=0.1)
    first = written(tmp_path / "a")
    assert first == written(tmp_path / "b")
    assert sorted(first) == sorted(["truth.jsonl", *(f"{name}.{kind}.jsonl" for name in plan.names() for kind in ("seen", "log"))])

    logs = read_logs(tmp_path / "a", plan.names())
    assert all([told["t"] for told in log] == [plan.frame_ns(4 + step) for step in range(STEPS)] for log in logs.values())
    assert Recording(tmp_path / "a").play(plan) == logs, "the same programs without processes, bus and pictures"
    kinds = {kind for log in logs.values() for kind in log[-1]["sent"]}
    assert {"claim", "search", "mix", "announce"} <= kinds and sum(log[-1]["lost"] for log in logs.values()) > 0
    got = Recording(tmp_path / "a").score(plan)
    assert got["people_steps"] > 20 and got["coverage"] > 0.2 and got["error_m"] < 1.0, got


class Spy(threading.Thread):
    """Hears everything on the bus of a run, from when it is made until stop()."""

    def __init__(self, folder):
        super().__init__()
        (ports,) = folder.glob("nats-server_*.ports")
        self._url, self._ready, self._end = json.loads(ports.read_text())["nats"][0], threading.Event(), threading.Event()
        self.heard = []
        self.start()
        assert self._ready.wait(20)

    def run(self):
        asyncio.run(self._listen())

    async def _listen(self):
        async def take(message):
            self.heard.append((message.subject.split(".")[2], len(message.subject) + len(message.data)))

        connection = await nats.connect(self._url)
        await connection.subscribe("net.>", cb=take)
        await connection.flush()
        self._ready.set()
        while not self._end.is_set():
            await asyncio.sleep(0.01)
        await connection.flush()
        await connection.drain()

    def stop(self):
        self._end.set()
        self.join()


@pytest.mark.slow
def test_messages_and_bytes_that_nodes_count_are_those_on_the_bus(tmp_path):
    spies = []

    def listen(step, of, _):
        if step == 1:
            spies.append(Spy(tmp_path / "a"))
        if step == of:
            spies[0].stop()

    plan, _ = play(tmp_path / "a", cameras=2, heads=0, on_step=listen, strategy="ABC")
    logs = read_logs(tmp_path / "a", plan.names())
    for index, key in ((0, "sent"), (1, "bytes")):
        counted = Counter()
        for log in logs.values():
            counted.update(log[-1][key])
            counted.subtract(log[0][key])
        heard = Counter()
        for message in spies[0].heard:
            heard[message[0]] += (1, message[1])[index]
        assert heard == +counted and heard


class NoRig:
    """Has no second camera, and its world does not go on."""

    program, control = "false", "/nowhere"

    def __init__(self, mode):
        self._mode = mode

    def status(self):
        return {"mode": self._mode}

    def resume(self):
        raise camrig.CamrigError("unavailable", "it is gone")

    def camera(self, name):
        if name != "one":
            raise camrig.CamrigError("not_found", name)
        return SimpleNamespace(url=lambda kind: "rtsp://127.0.0.1:1/one")


@pytest.mark.parametrize("mode, started", [("realtime", 1), ("lockstep", 2)])
def test_a_network_that_cannot_begin_leaves_nothing_running(tmp_path, monkeypatch, mode, started):
    begun, popen = [], subprocess.Popen
    monkeypatch.setattr(subprocess, "Popen", lambda *words, **how: begun.append(popen(*words, **how)) or begun[-1])
    plan = SimpleNamespace(names=lambda: ["one", "two"], cameras={"one": {}, "two": {}}, heads={}, to_json=dict)
    with pytest.raises(camrig.CamrigError):
        Conductor(NoRig(mode), plan, tmp_path, False, lambda *_: None).run(STEPS)
    # The server first, then the program that could be started.
    assert len(begun) == started and all(child.poll() is not None for child in begun)


@pytest.mark.slow
def test_sigterm_ends_programs_server_and_rig(tmp_path):
    command = [sys.executable, "-m", "examples.network", "--quick", "--heads", "0", "--out", str(tmp_path)]

    def family():
        found = []
        for path in pathlib.Path("/proc").glob("[0-9]*/environ"):
            with contextlib.suppress(OSError):
                if f"CAMRIG_NETWORK_TEST={tmp_path}".encode() in path.read_bytes():
                    found.append(int(path.parent.name))
        return found

    child = subprocess.Popen(command, cwd=REPOSITORY, env={**environment(), "CAMRIG_NETWORK_TEST": str(tmp_path)}, stderr=subprocess.DEVNULL)
    try:
        wait_until(lambda: (tmp_path / "truth.jsonl").exists() and (tmp_path / "truth.jsonl").stat().st_size > 0, 60, "the first step")
        assert len(family()) >= 5
        child.terminate()
        child.wait(30)
        wait_until(lambda: not family(), 10, "the end of all processes")
    finally:
        for pid in family():
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        child.wait(20)


@pytest.mark.slow
def test_a_camera_whose_program_is_killed_stops_no_other(tmp_path):
    def kill(step, _, programs):
        if step == 4:  # it dies within a phase: first it is waited for
            south = programs.running["south"]
            south.send_signal(signal.SIGSTOP)
            threading.Timer(1.0, south.send_signal, (signal.SIGKILL,)).start()

    plan, ended = play(tmp_path / "a", heads=0, on_step=kill, strategy="ABC")
    assert ended == {"south": -signal.SIGKILL}
    logs = read_logs(tmp_path / "a", plan.names())
    assert {name: len(log) for name, log in logs.items()} == {"lobby": STEPS, "stairs": STEPS, "south": 4}
    for name in ("lobby", "stairs"):
        assert logs[name][-1]["sent"].get("search", 0) > logs[name][4]["sent"].get("search", 0), f"{name} goes on with the others"
    assert len(read_truth(tmp_path / "a")) == STEPS


@pytest.mark.slow
def test_a_head_turns_to_whom_the_fixed_cameras_report(tmp_path):
    plan, ended = play(tmp_path / "a", cameras=2, heads=1, steps=16, strategy="ABC")
    assert not ended
    log = read_logs(tmp_path / "a", plan.names())["dome_a"]
    targets = [told for told in log if told["target"] and told["aim"]]
    assert len(targets) >= 6
    heads = Recording(tmp_path / "a").score(plan)["heads"]
    assert heads["each"]["dome_a"]["shown"] > 0.4, heads


@pytest.mark.slow
def test_in_real_time_the_same_programs_open_rtsp(tmp_path):
    plan, ended = play(tmp_path / "a", cameras=2, heads=0, steps=24, mode="realtime", fps=2, strategy="ABC")
    assert not ended, {path.name: path.read_text() for path in (tmp_path / "a").glob("*.err")}
    logs = read_logs(tmp_path / "a", plan.names())
    truth = read_truth(tmp_path / "a")
    assert len(truth) >= 3 and all(later["t"] > line["t"] for line, later in zip(truth, truth[1:])) and all(line["t"] % 500_000_000 == 0 for line in truth)
    for name, log in logs.items():
        times = [told["t"] for told in log]
        assert len(times) >= 3 and times == sorted(set(times)) and all(t % 500_000_000 == 0 for t in times), (name, times)
    assert any(told["owned"] for log in logs.values() for told in log)


class Enough(Exception):
    """Ends a run: its conductor stops the programs as for any error."""


@pytest.mark.slow
def test_heads_take_part_in_real_time(tmp_path):
    """However late this machine looks: the run ends when the head has been where it was told to look."""
    aims, steered = [], []
    with camrig.start(str(REPOSITORY / "scenes" / "hall.json"), mode="realtime", seed=1, overload="slow") as rig:
        plan = Plan(*stage.build(rig, 2, 1, 2), fps=2, strategy="ABC")

        def look(*_):
            with contextlib.suppress(ValueError):  # a line is being written
                aims.extend(told["aim"][:2] for told in read_logs(tmp_path, ["dome_a"])["dome_a"] if told["aim"])
            at = rig.camera("dome_a").ptz.status()
            steered.append(any(abs(at["pan_deg"] - pan) < 0.5 and abs(at["tilt_deg"] - tilt) < 0.5 for pan, tilt in aims))
            if sum(steered) >= 3:
                raise Enough

        with pytest.raises(Enough):
            Conductor(rig, plan, tmp_path, True, look).run(240)
    truth = read_truth(tmp_path)
    assert all(later["t"] > line["t"] for line, later in zip(truth, truth[1:]))
    heads = Recording(tmp_path).score(plan)["heads"]
    assert heads["each"]["dome_a"]["busy"] > 0, heads


@pytest.mark.slow
def test_the_central_tracker_runs_as_a_process_of_its_own(tmp_path):
    plan, ended = play(tmp_path / "a", cameras=2, heads=0, steps=6, strategy="central")
    assert not ended
    logs = read_logs(tmp_path / "a", plan.names())
    assert any(told["owned"] for told in logs["centre"]) and logs["lobby"][-1]["sent"]["seen"] > 0
    assert Recording(tmp_path / "a").play(plan) == logs


def test_bad_options_say_what_would_be_right(tmp_path):
    def told(*arguments):
        done = subprocess.run([sys.executable, "-m", "examples.network", *map(str, arguments)], cwd=REPOSITORY, env=environment(), capture_output=True, text=True, timeout=60, check=False)
        assert done.returncode != 0 and "Traceback" not in done.stderr, done.stderr
        return done.stderr

    assert "choose from ABC, ASM" in told("--strategy", "XYZ").replace("'", "")  # Python 3.13 quotes them no more
    assert "--loss is 0 to below 1" in told("--loss", 1.5)
    assert "--rounds needs lockstep" in told("--mode", "realtime", "--rounds", 3)
    assert "--source device, or --heads 0" in told("--mode", "realtime") and "needs real time" in told("--source", "rtsp")
    assert "no recording of a run" in told("--replay", tmp_path)
    assert "places for up to 8" in told("--cameras", 9, "--out", tmp_path / "a")


@pytest.mark.slow
def test_the_blocks_of_the_page_run(tmp_path):
    """The first block is the long run: it is run short here, by the option that the page tells."""
    (tmp_path / "examples").symlink_to(REPOSITORY / "examples")
    for block in blocks("docs/network.md", "sh"):
        for page, here in (("python -m examples.network\n", "python -m examples.network --quick\n"), ("--seconds 20", "--seconds 2"), ("--seeds 10", "--seeds 1"), ("python ", f"{sys.executable} ")):
            block = block.replace(page, here)
        done = subprocess.run(["bash", "-euo", "pipefail", "-c", block], cwd=tmp_path, env=environment(), capture_output=True, text=True, timeout=400, check=False)
        assert done.returncode == 0, (block, done.stdout[-2000:], done.stderr[-4000:])
    for block in blocks("docs/network.md", "python"):
        done = subprocess.run([sys.executable, "-c", block], cwd=tmp_path, env=environment(), capture_output=True, text=True, timeout=200, check=False)
        assert done.returncode == 0, (block, done.stdout[-2000:], done.stderr[-4000:])
    results = json.loads((tmp_path / "network-run" / "results.json").read_text())
    assert results["run"]["messages"] > 0 and set(results["sweeps"]["strategy"]) >= {"ABC", "PST", "central"}
    page = (tmp_path / "network-run" / "report.html").read_text()
    assert page.count("<svg") >= 8 and "NaN" not in page and "nan" not in page
    assert os.path.exists(tmp_path / "network-run" / "plan.json")

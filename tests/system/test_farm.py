"""One world on several nodes: processes on this machine, each with a rig of its own, and a NATS server of Debian."""

import contextlib
import itertools
import json
import os
import signal
import subprocess
import sys
import threading
import time

import pytest
from conftest import REPOSITORY, wait_until
from test_command_log import SMALL, commands, digest, people_of, pictures, start

import camrig


@contextlib.contextmanager
def farm(*options, nodes=2, scene="hall"):
    """(rig on the farm's control address, its facts)."""
    read_end, write_end = os.pipe()
    command = [sys.executable, "-m", "camrig.farm", "up", "--scene", scene, "--nodes", str(nodes), "--arg=--device=cpu", "--ready-fd", str(write_end), *options]
    child = subprocess.Popen(command, pass_fds=(write_end,), stderr=subprocess.PIPE, text=True, env={**os.environ, "PYTHONPATH": str(REPOSITORY / "control/python")})
    os.close(write_end)
    said = []
    reader = threading.Thread(target=lambda: said.extend(child.stderr), daemon=True)
    reader.start()
    try:
        with os.fdopen(read_end) as ready:
            line = ready.readline()
        assert line, "".join(said)
        facts = json.loads(line)
        rig = camrig.connect(facts["control"])
        yield rig, {**facts, "said": said, "child": child}
        rig.call("server.shutdown")
        assert child.wait(20) == 0, "".join(said)
    finally:
        if child.poll() is None:
            child.send_signal(signal.SIGTERM)
            try:
                child.wait(10)
            except subprocess.TimeoutExpired:
                child.kill()


def nodes_of(rig):
    return rig.call("farm.status")["nodes"]


def rigs_of(rig):
    return {node["node"]: camrig.connect(node["control"]) for node in nodes_of(rig)}


def test_in_lockstep_every_node_shows_what_one_machine_shows():
    """The unmodified client commands two nodes; each camera's pictures are those of a single machine, to the byte."""
    with start(mode="lockstep") as alone:
        people = people_of(alone)
        line = list(itertools.islice(commands(11, people), 37))
        seen = []
        for number, (method, params) in enumerate(line):
            alone.call(method, **params)
            if number >= 3 and number % 6 == 0:
                alone.step(seconds=0.1)
                seen.append(pictures(alone))
    with farm("--mode", "lockstep") as (rig, _):
        shown = []
        for number, (method, params) in enumerate(line):
            rig.call(method, **params)
            if number >= 3 and number % 6 == 0:
                assert rig.step(seconds=0.1)["world_ns"] > 0
                shown.append(pictures(rig))
        assert shown == seen
        owners = {camera["camera"]: camera["node"] for camera in rig.call("farm.status")["cameras"]}
        assert len(owners) == 7 and set(owners.values()) == {"node1", "node2"}
        digests = {name: digest(one) for name, one in rigs_of(rig).items()}
        assert len(digests) == 2 and len({json.dumps(one) for one in digests.values()}) == 1
        assert [pictures(one) for one in rigs_of(rig).values()] == [shown[-1]] * 2


def test_in_real_time_nodes_stay_equal_whoever_commands_and_whoever_dies():
    """Three clients command; the sequencer's node is killed; the farm takes commands again, and all nodes are equal."""
    with farm("--no-replace", nodes=3) as (rig, facts):
        people = people_of(rig)
        line = commands(12, people)
        for method, params in itertools.islice(line, 4):
            rig.call(method, **params)
        failed = []

        def client(seed):
            mine = camrig.connect(facts["control"])
            for method, params in itertools.islice(commands(seed, people), 4, 14):
                try:
                    mine.call(method, **params)
                except camrig.CamrigError as problem:
                    # The same on all nodes: that a guest of this name is there already.
                    if problem.kind != "already_exists":
                        failed.append(problem)

        clients = [threading.Thread(target=client, args=(seed,)) for seed in (21, 22, 23)]
        for each in clients:
            each.start()
        for each in clients:
            each.join(30)
        assert not failed

        sequencer = next(node for node in nodes_of(rig) if node["is_sequencer"])
        began = time.monotonic()
        os.kill(sequencer["pid"], signal.SIGKILL)
        rig.call("camera.set", name="cam0", vfov_deg=44)
        took_s = time.monotonic() - began
        print(f"commands are taken {took_s:.2f} s after the sequencer's death")
        assert took_s < 8
        assert len(nodes_of(rig)) == 2
        # A rig does not outlive its node.
        wait_until(lambda: not os.path.exists(f"/proc/{sequencer['rig_pid']}") or b"Z" in open(f"/proc/{sequencer['rig_pid']}/stat", "rb").read().split()[2])
        rigs = list(rigs_of(rig).values())
        at_ns = (max(one.status()["world_ns"] for one in rigs) // 10**9 + 2) * 10**9
        told = [None] * 2

        def ask(number):
            told[number] = digest(rigs[number], at_ns=at_ns + 1)

        asking = [threading.Thread(target=ask, args=(number,)) for number in range(2)]
        for each in asking:
            each.start()
        for each in asking:
            each.join(20)
        assert told[0] and told[0] == told[1] and told[0]["command_count"] >= 30
        for one in rigs:
            for camera in one.call("stats.get")["cameras"]:
                assert camera["due"] == camera["rendered"] + camera["dropped"] and camera["dropped"] == sum(camera["dropped_for"].values())


def test_a_node_that_joins_late_becomes_equal_and_one_that_differs_is_named_and_replaced():
    with farm(nodes=2) as (rig, facts):
        for method, params in itertools.islice(commands(13, people_of(rig)), 12):
            rig.call(method, **params)
        victim = next(node for node in nodes_of(rig) if not node["is_sequencer"])
        os.kill(victim["pid"], signal.SIGKILL)
        wait_until(lambda: len(nodes_of(rig)) == 2 and any(node["node"] == "node3" and node.get("applied", 0) >= 12 for node in nodes_of(rig)), 30, "a node in its place")
        # Behind the log's back, which nobody can by the node's own rules: a rig that is told something else.
        late = rigs_of(rig)["node3"]
        world_ns = late.status()["world_ns"]
        late.call("actor.steer", actors=[{"name": people_of(rig)[0], "velocity": [1, 0, 0]}], at_ns=world_ns + 300_000_000)
        wait_until(lambda: any("node3 is stopped" in line for line in facts["said"]), 20, "the node that differs to be found")
        named = lambda: [line for line in facts["said"] if "node3 stops" in line]
        wait_until(lambda: named(), 10)
        assert f"actor {people_of(rig)[0]}" in named()[0]
        wait_until(lambda: len(nodes_of(rig)) == 2 and "node4" in [node["node"] for node in nodes_of(rig)], 30, "one in its place")


def test_a_node_of_another_world_cannot_join():
    with farm(nodes=1, scene="minimal") as (rig, facts):
        command = [sys.executable, "-m", "camrig.farm", "node", "--name", "other", "--nats", facts["nats"], "--scene", "minimal", "--seed", "99"]
        other = subprocess.run(command, capture_output=True, text=True, timeout=40, env={**os.environ, "PYTHONPATH": str(REPOSITORY / "control/python")})
        assert other.returncode == 1 and "cannot join: seed is 99, the farm's is 1" in other.stderr
        assert len(nodes_of(rig)) == 1

"""Nodes that have more cameras than they can draw, on a farm that runs: what moves, and what is said where nothing can."""

import sys
import time
import urllib.request

import pytest
from conftest import REPOSITORY, Witness, wait_until

sys.path.insert(0, str(REPOSITORY / "tests" / "farm"))
from live_parts import farm as live_farm  # noqa: E402
from live_parts.readers import Reader, missing  # noqa: E402

CAMERAS, FPS = 8, 10


def costs_of(far, names):
    """In cores, of all cameras that these nodes draw now."""
    return {camera: cost for node in far.status()["nodes"] if node["node"] in names for camera, cost in node["costs"].items()}


@pytest.fixture
def watched(tmp_path):
    """A farm of two nodes, with a reader on each camera."""
    with live_farm.Farm(tmp_path, "hall", nodes=2, door_options=("--metrics", "127.0.0.1:0")) as far:
        for number in range(CAMERAS):
            far.rig.call("camera.create", name=f"eye{number}", size=[160, 120], fps=FPS, vfov_deg=60, pose={"position": [2 + number, 3, 2.8], "look_at": [12, 8, 1]})
        readers = [Reader(far.control, f"eye{number}") for number in range(CAMERAS)]
        try:
            wait_until(lambda: all(reader.seen for reader in readers), 30, "all readers to read")
            wait_until(lambda: {reader.camera for reader in readers} <= costs_of(far, far.nodes).keys(), 30, "the cameras' costs")
            yield far, readers
        finally:
            for reader in readers:
                reader.end()


def begin_again(far, cores):
    """These nodes, as nodes of smaller machines: how many cores, by name. All at once, or else one would give its cameras to another before."""
    for name in cores:
        far.nodes[name].kill()
    for name in cores:
        far.nodes[name].start("--cores", f"{cores[name]:.4f}")
    far.wait_for_nodes()


def test_a_node_that_is_full_gives_cameras_away_and_no_reader_notices(watched):
    far, readers = watched
    small = next(name for name in far.nodes if name != far.sequencer())
    own = {camera for camera, node in far.owners().items() if node == small and camera.startswith("eye")}
    assert 2 <= len(own) < CAMERAS, far.status()
    begin_again(far, {small: 0.8 * sum(costs_of(far, [small])[camera] for camera in own)})  # 125 %: more than 80 %, however busy the machine was then
    for reader in readers:  # where they should: on the small node too
        if far.owners()[reader.camera] == small and reader.node != small:
            reader.reconnect()
    wait_until(lambda: all(reader.node == small for reader in readers if reader.camera in own), 30, "its cameras to be read from it")
    connections, moment = {reader.camera: reader.connections for reader in readers}, time.monotonic()
    witness = Witness().__enter__()
    moved = lambda: {camera for camera, node in far.owners().items() if camera in own and node != small}
    wait_until(moved, 30, "cameras to move")
    time.sleep(7)  # one more look of the sequencer's
    facts = far.facts_of(small)
    left = sum(cost for camera, cost in facts["costs"].items() if camera not in moved())
    print(f"of {len(own)} cameras of {small} with {facts['cores']:.3f} cores {sorted(moved())} moved; the others take {left / facts['cores']:.0%}")
    assert moved() < own and left < 0.9 * facts["cores"] and not facts["is_full"]
    # Who reads goes on where he is, and finds the new owner when he comes again.
    assert {reader.camera: reader.connections for reader in readers} == connections
    gone = next(reader for reader in readers if reader.camera in moved())
    gone.reconnect()
    wait_until(lambda: gone.node and gone.node != small, 10, "the camera at its new owner")
    witness.__exit__()
    for reader in readers:  # a connection made anew, and where the machine was held up
        assert missing(reader.since(moment)) <= FPS * (1 + witness.longest_s), f"{reader.camera} was away"


def test_where_all_nodes_are_full_the_farm_says_so(watched):
    far, _ = watched
    begin_again(far, dict.fromkeys(far.nodes, 0.001))
    wait_until(lambda: all(node["is_full"] for node in far.status()["nodes"]), 60, "both to be named")
    assert any(f"node {name} is full: its cameras that are watched take " in far.nodes[other].log.read_text() for name in far.nodes for other in far.nodes)

    def told():
        with urllib.request.urlopen(far.door["metrics"]) as page:
            return page.read().decode().count("camrig_farm_node_full{") == 2

    wait_until(told, what="both on the page of metrics")
    # More nodes, and it is over.
    far.nodes["node3"] = live_farm.Node(far, "node3")
    wait_until(lambda: not any(node["is_full"] for node in far.status()["nodes"]) and len(far.status()["nodes"]) == 3, 60, "a third node to take what is too much")

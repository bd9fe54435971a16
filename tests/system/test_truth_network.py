"""Who sees whom in a network of cameras, against what truth.get says."""

import json
import math
import subprocess

import numpy as np
import pytest

import camrig
import posed_gltf

FIELDS = ("pixels", "visible_fraction", "truncated", "box")


@pytest.fixture(scope="module")
def rig():
    with camrig.start("scenes/hall.json", mode="lockstep") as rig:
        rig.step(seconds=0.4)
        yield rig


def test_the_network_sees_what_each_camera_sees(rig):
    network = rig.visibility()
    assert network.time_ns == rig.cameras()[0].truth()["time_ns"]
    for camera in rig.cameras():
        truth = camera.truth()
        seen = {item["name"]: item for item in truth["objects"] if item["box"]}
        told = network.seen_by(camera.name)
        assert told.keys() == seen.keys() and seen
        for name, one in told.items():
            assert {key: one[key] for key in FIELDS} == {key: seen[name][key] for key in FIELDS}
            eye, position = np.array(truth["pose"]["position"]), np.array(seen[name]["position"])
            x, y, z, w = seen[name]["orientation"]
            heading = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
            azimuth = math.degrees(math.atan2(*(eye - position)[1::-1]) - heading)
            if seen[name]["class"] == "person":
                assert abs((one["azimuth_deg"] - azimuth + 180) % 360 - 180) < 1e-6
            assert one["distance_m"] == pytest.approx(np.linalg.norm(eye - position))


def test_overlap_counts_what_both_see(rig):
    network = rig.visibility(classes=["person"])
    names = [camera.name for camera in rig.cameras()]
    assert [camera["name"] for camera in network.cameras] == names
    assert {item["class"] for item in network.objects} == {"person"}
    graph = network.graph("objects")
    for a in names:
        for b in names:
            if a != b:
                assert graph[a].get(b, 0) == len(network.seen_by(a).keys() & network.seen_by(b).keys())
    ground = {camera["name"]: camera["ground_m2"] for camera in network.cameras}
    for overlap in network.overlaps:
        a, b = overlap["cameras"]
        shared = overlap["ground_m2"]
        assert 0 < shared <= min(ground[a], ground[b])
        assert overlap["ground_share"] == pytest.approx(shared / (ground[a] + ground[b] - shared))


def test_ground_of_a_camera_that_looks_down_is_what_its_picture_covers(tmp_path):
    posed_gltf.write_glb(tmp_path / "floor.glb", [[-20, 0, 20], [20, 0, 20], [20, 0, -20], [-20, 0, -20]], [[0, 1, 2], [0, 2, 3]])
    scene = {"camrig_scene": 1, "name": "floor", "models": {"floor": {"file": "floor.glb"}}, "objects": [{"name": "floor", "model": "floor"}]}
    (tmp_path / "scene.json").write_text(json.dumps(scene))
    side = 2 * 4 * math.tan(math.radians(30))
    with camrig.start(tmp_path / "scene.json", mode="lockstep") as rig:
        for name, x in (("a", 1.0), ("b", 2.0), ("far", -12.0)):
            rig.create_camera(name, size=(200, 200), vfov_deg=60, position=(x, 1, 4), tilt_deg=-90)
        network = rig.visibility(cell_m=0.05, range_m=5)
        assert [camera["ground_m2"] for camera in network.cameras] == pytest.approx([side * side] * 3, rel=0.02)
        shares = {tuple(one["cameras"]): one["ground_m2"] for one in network.overlaps if one["ground_m2"]}
        assert shares == {("a", "b"): pytest.approx((side - 1) * side, rel=0.02)}
        assert rig.visibility(ground_z=0.5).cameras[0]["ground_m2"] == 0


def test_bad_questions_are_refused(rig):
    for params, words in (
        ({"cameras": ["lobby", "lobby"]}, "twice"),
        ({"cameras": ["nobody"]}, "nobody"),
        ({"cell_m": 0.05, "range_m": 1000.0}, "range_m"),
        ({"cell_m": 0}, "cell_m"),
        ({"classes": [3]}, "classes"),
    ):
        with pytest.raises(camrig.CamrigError, match=words):
            rig.call("truth.network", **params)


def test_the_command_line_prints_tables(rig):
    def run(*options):
        return subprocess.run([camrig.find_binary(), "truth", *options, "--control", rig._control], capture_output=True, text=True)

    words = run("--network", "--classes", "person")
    assert words.returncode == 0 and "GROUND OF BOTH" in words.stdout and "person" in words.stdout
    assert run().returncode == 2
    assert run("lobby", "gallery").returncode == 2
    assert run("lobby", "gallery", "--network", "--json").stdout.startswith("{")


def network(time_ns, **seen):
    """An instant at which cameras see so many pixels of anna."""
    objects = [{"id": 1, "name": "anna", "seen_by": [{"camera": c, "pixels": n, "visible_fraction": 1.0} for c, n in seen.items()]}]
    return camrig.Network(time_ns, [], objects if seen else [], [])


def test_handovers_go_to_who_sees_most_and_know_of_gaps():
    handovers = camrig.Handovers()
    steps = [{"a": 100}, {"a": 90, "b": 60}, {"b": 200, "c": 90}, {}, {}, {"a": 70}, {"a": 80}]
    for n, seen in enumerate(steps):
        handovers.update(network(n * 100, **seen))
    assert [(h.time_ns, h.source, h.target, h.overlap_ns) for h in handovers.handovers] == [(200, "a", "b", 100), (500, "b", "a", -200)]
    assert [(p.time_ns, p.camera, p.entered) for p in handovers.passages] == [
        (0, "a", True), (100, "b", True), (200, "a", False), (200, "c", True), (300, "b", False), (300, "c", False), (500, "a", True)]
    with pytest.raises(ValueError, match="rise"):
        handovers.update(network(600))

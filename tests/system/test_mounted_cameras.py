"""Cameras fixed to actors: their pose in each frame is the actor's at that instant times the mount's."""

import json

import numpy as np
import pytest

import camrig
from conftest import REPOSITORY


def rotation(q):
    x, y, z, w = q
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip



@pytest.fixture
def scene(tmp_path):
    """A box that drives a circle, seen from above by `eye`; `rider` is mounted on it in the scene file."""
    file = REPOSITORY / "scenes/minimal.json"
    data = json.loads(file.read_text())
    for model in data["models"].values():
        (tmp_path / model["file"]).parent.mkdir(exist_ok=True)
        (tmp_path / model["file"]).write_bytes((REPOSITORY / "scenes" / model["file"]).read_bytes())
    data["cameras"] = [
        {"name": "eye", "place": "above", "size": [160, 120], "fps": 30},
        {"name": "rider", "size": [160, 120], "fps": 30, "mount": {"actor": "mover"}, "pose": {"position": [0.3, 0.1, 0.7], "pan_deg": 90, "tilt_deg": -5}},
    ]
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(data))
    return path


def test_the_pose_of_each_frame_is_the_actors_times_the_mounts(scene):
    with camrig.start(str(scene), mode="lockstep") as rig:
        eye, rider = rig.camera("eye"), rig.camera("rider")
        local = rig.call("camera.get", name="rider")["pose"]
        seen = []
        for _ in range(12):
            rig.step(nanoseconds=71_234_567)
            truth, box = rider.truth(), next(item for item in eye.truth()["objects"] if item["name"] == "mover")
            assert eye.truth()["time_ns"] == truth["time_ns"]
            body = rotation(box["orientation"])
            assert np.abs(body @ local["position"] + box["position"] - truth["pose"]["position"]).max() < 1e-9
            assert np.abs(body @ rotation(local["orientation"]) - rotation(truth["pose"]["orientation"])).max() < 1e-9
            state = rig.call("camera.get", name="rider")
            assert np.abs(np.subtract(state["world_pose"]["position"], truth["pose"]["position"])).max() < 1e-9
            assert state["pose"] == local
            seen.append(rider.frame().image)
        assert all((a != b).any() for a, b in zip(seen, seen[1:])), "the picture moves with its actor"


def test_static_layers_change_nothing_of_a_mounted_cameras_pictures(scene):
    def pictures(*options):
        with camrig.start(str(scene), mode="lockstep", args=list(options)) as rig:
            taken = []
            for _ in range(4):
                rig.step(seconds=0.1)
                taken.append(rig.camera("rider").frame().image)
            return taken

    assert all(np.array_equal(a, b) for a, b in zip(pictures(), pictures("--static-layer-mb", "0")))


def test_cameras_are_mounted_and_taken_off_live(scene):
    with camrig.start(str(scene), mode="lockstep") as rig:
        rig.step(seconds=0.5)
        mine = rig.create_camera("mine", size=(64, 48), mount="mover", position=(0, 0, 2))
        world = rig.call("camera.get", name="mine")["world_pose"]["position"]
        box = next(actor for actor in rig.actors() if actor["name"] == "mover")
        assert np.abs(np.subtract(world, np.add(box["position"], (0, 0, 2)))).max() < 1e-9
        again = rig.call("camera.get", name="mine")
        rig.call("camera.delete", name="mine")
        rig.call("camera.create", **again)
        rig.remove_actor("mover")
        stays = rig.call("camera.get", name="mine")["world_pose"]
        rig.step(seconds=0.5)
        assert rig.call("camera.get", name="mine")["world_pose"] == stays, "without its actor it stays where it was"
        mine.set(mount="", position=(1, 2, 3))
        assert rig.call("camera.get", name="mine")["world_pose"]["position"] == [1, 2, 3]


def test_whatever_its_rate_a_camera_stays_where_its_actor_went(scene):
    with camrig.start(str(scene), mode="lockstep") as rig:
        cameras = [rig.create_camera(f"fps{fps}", size=(64, 48), fps=fps, mount="mover", position=(0, 0, 2)) for fps in (30, 2)]
        rig.call("event.add", name="go", when={"at_s": 0.83}, do=[{"action": "remove", "actor": "mover"}])
        rig.step(seconds=2)
        often, seldom = (camera.truth()["pose"] for camera in cameras)
        assert often == seldom


@pytest.mark.parametrize("mount, where", [({"actor": "nobody"}, "mount.actor"), ({"actor": "mover", "node": "wing"}, "mount.node"), ({"node": "x"}, "mount.actor"), ({"actor": "mover", "to": 1}, "mount.to")])
def test_a_wrong_mount_is_an_error_that_changes_nothing(scene, mount, where):
    with camrig.start(str(scene), mode="lockstep") as rig:
        before = rig.call("camera.get", name="rider")
        for method, name in (("camera.create", "new"), ("camera.set", "rider")):
            with pytest.raises(camrig.CamrigError, match=where):
                rig.call(method, name=name, mount=mount)
        assert rig.call("camera.get", name="rider") == before
        assert len(rig.cameras()) == 2
    data = json.loads(scene.read_text())
    data["cameras"][1]["mount"] = mount
    scene.write_text(json.dumps(data))
    with pytest.raises(camrig.CamrigError, match=rf"scene.json: cameras\[1\].{where}"):
        camrig.start(str(scene), mode="lockstep")


def test_the_drones_and_the_drivers_cameras_of_the_street():
    """At nodes: `gimbal` of the drone looks down on the street, `dashboard` of a car along its lane."""
    with camrig.start(str(REPOSITORY / "scenes/street.json"), mode="lockstep") as rig:
        drone = rig.create_camera("drone", size=(320, 240), mount="drone/gimbal", position=(0, 0, -0.1), tilt_deg=-35)
        driver = rig.create_camera("driver", size=(320, 240), mount="east_1/dashboard", position=(0.3, 0, 0.45))
        for _ in range(3):
            rig.step(seconds=1.5)
            actors = {actor["name"]: actor for actor in rig.actors()}
            pose = driver.truth()["pose"]
            car = actors["east_1"]
            ahead = rotation(car["orientation"])[:, 0]
            assert np.abs(rotation(pose["orientation"])[:, 0] - ahead).max() < 1e-9, "a node at rest has the actor's axes"
            assert 0.5 < np.dot(np.subtract(pose["position"], car["position"]), ahead) < 2.0
            assert np.linalg.norm(np.subtract(drone.truth()["pose"]["position"], actors["drone"]["position"])) < 0.5
        assert sum(item["pixels"] > 30 for item in drone.truth()["objects"]) >= 3

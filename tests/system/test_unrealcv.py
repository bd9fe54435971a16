"""UnrealCV's own Python client, unaltered, on a rig: its API class from end to end, and what no decent client sends."""

import io
import json
import math
import socket
import struct
import sys
import threading
import time
import warnings

import numpy as np
import pytest

import camrig
from conftest import Process, wait_until
from onvif_messages import beside
from test_docs import blocks

MAGIC = 0x9E2B83C1


@pytest.fixture(scope="session")
def unrealcv():
    """The client's module, from the folders where tools/setup put it and what it imports."""
    for package in ("unrealcv", "docker"):
        sys.path.append(str(beside(package)))
    import unrealcv as module

    assert module.__version__ == "1.3.2"
    return module


@pytest.fixture
def door(tmp_path):
    """A rig in lockstep with the door, its port, and the folder for files."""
    (folder := tmp_path / "files").mkdir()
    with camrig.start("minimal", mode="lockstep", args=["--unrealcv", "0", "--unrealcv-dir", str(folder)]) as rig:
        yield rig, rig.call("server.info")["unrealcv"], folder


@pytest.fixture
def api(unrealcv, door):
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # a client that misses a command warns
        made = unrealcv.UnrealCv_API(door[1], "127.0.0.1", (640, 480))
    yield made
    made.client.disconnect()


def ask(api, *commands):
    answers = api.client.request(list(commands))
    return answers[0] if len(commands) == 1 else answers


def numpy_of(answer):
    return np.load(io.BytesIO(answer))


def test_the_api_finds_cameras_objects_and_their_colours_at_its_start(api, door):
    rig = door[0]
    assert api.get_server_version() == "1.1.0" and not api.is_unrealcv_plus()
    assert set(api.cam) == {0} and api.get_camera_list() == ["main"]
    assert api.get_objects() == ["ground", "box", "mover"] == list(api.obj_dict)
    assert len({tuple(color) for color in api.obj_dict.values()}) == 3 and [0, 0, 0] not in api.obj_dict.values()
    assert float(api.cam[0]["fov"]) == pytest.approx(rig.camera("main").get()["hfov_deg"], abs=1e-6)
    assert ask(api, "vget /scene/name") == "minimal"
    # All that is listed is a command of the table, and the client knows those that its API sends.
    for command in ("vget /camera/0/lit bmp", "vset /object/box/scale 1 1 1", "vrun setres 640x480w", "vbp mover set_move 0 1"):
        assert api.supports_command(command)
    assert not api.supports_command("vget /camera/0/lit_shared")


def test_pictures_are_camrigs_own_to_the_byte(api, door):
    rig = door[0]
    cam = rig.camera("main")
    rig.step(seconds=0.4)
    bgr = cam.frame().image
    assert bgr.std() > 5  # there is something to see
    assert np.array_equal(api.get_image(0, "lit", "bmp"), bgr)
    assert np.array_equal(api.get_image(0, "lit", "png"), bgr)
    lit = numpy_of(ask(api, "vget /camera/0/lit npy"))
    assert lit.shape == (480, 640, 4) and np.array_equal(lit[:, :, 2::-1], bgr) and (lit[:, :, 3] == 255).all()

    metres = cam.depth()
    centimetres = api.get_depth(0)
    assert centimetres.shape == (480, 640, 1) and centimetres.dtype == np.float32
    nothing = np.isinf(metres)
    assert nothing.any() and (centimetres[nothing, 0] == 65504).all()
    assert np.array_equal(centimetres[~nothing, 0], (metres[~nothing].astype(np.float64) * 100).astype(np.float32))
    plane = numpy_of(ask(api, "vget /camera/0/plane_depth npy"))
    assert np.array_equal(plane[~nothing], metres[~nothing])

    ids = cam.instances()
    for mode in ("png", "bmp"):
        mask = api.get_image(0, "object_mask", mode)
        for one in rig.call("object.list")["objects"]:
            assert np.array_equal(api.get_mask(mask, one["name"]) > 0, ids == one["id"]), one["name"]
        assert (mask[ids == 0] == 0).all()

    normals = cam.frame(kind="normal").image
    world = normals @ cam.world_from_camera[:3, :3].T * [1, -1, 1]
    shown = api.get_image(0, "normal", "png")[:, :, ::-1].astype(int)
    assert np.abs(shown - np.floor((world + 1) * 127.5 + 0.5)).max() <= 1


def test_optical_flow_is_camrigs_own_and_its_pictures_show_the_way_as_a_hue(api, door):
    rig, _, folder = door
    # 20 m/s along y, which is to the left of a camera that looks along x.
    rig.steer({"mover": {"position": [-2, 1, 0]}})
    rig.step(seconds=0.04)
    rig.steer({"mover": {"velocity": [0, 20, 0]}})
    rig.step(seconds=0.04)
    cam = rig.camera("main")
    flow, ids = cam.flow(), cam.instances()
    got = numpy_of(ask(api, "vget /camera/0/optical_flow npy"))
    assert got.shape == (480, 640, 2) and got.dtype == np.float32 and np.array_equal(got, flow, equal_nan=True)
    assert np.array_equal(np.load(ask(api, "vget /camera/0/optical_flow a.npy")), flow, equal_nan=True)
    mover = ids == {item["name"]: item["id"] for item in rig.objects()}["mover"]
    assert mover.sum() > 300 and (flow[mover, 0] < -20).all() and (np.abs(flow[mover, 1]) < -0.2 * flow[mover, 0]).all()
    for shown in (api.get_image(0, "optical_flow", "png"), api.get_image(0, "optical_flow", "bmp")):
        # Cyan, the hue across from red, at full strength; black where nothing moves, and where nothing is.
        assert (shown[mover][:, :2].max(axis=1) == 255).all() and (shown[mover][:, 2] == 0).all() and (shown[mover][:, :2] > 150).all()
        assert not shown[~mover].any()


def test_boxes_of_the_mask_are_those_of_the_truth(api, door):
    rig = door[0]
    rig.step(seconds=1)
    mask = api.get_image(0, "object_mask", "png")
    truth = {one["name"]: one["box"] for one in rig.camera("main").truth()["objects"]}
    for name in ("box", "mover"):
        x, y, width, height = api.get_bbox(mask, name, normalize=False)[1]
        assert [x, y, width + 1, height + 1] == truth[name]


def test_ray_depth_is_the_length_of_each_pixels_ray(tmp_path, unrealcv):
    with camrig.start("minimal", mode="lockstep", args=["--unrealcv", "0", "--unrealcv-ray-depth"]) as rig:
        cam = rig.camera("main")
        made = unrealcv.UnrealCv_API(rig.call("server.info")["unrealcv"], "127.0.0.1", (640, 480))
        rays = made.get_depth(0)[:, :, 0]
        metres = cam.depth()
        x, y = np.meshgrid(np.arange(640), np.arange(480))
        k = cam.K
        length = np.sqrt(((x - k[0, 2]) / k[0, 0]) ** 2 + ((y - k[1, 2]) / k[1, 1]) ** 2 + 1)
        there = np.isfinite(metres)
        assert rays[there] == pytest.approx((metres * length)[there], rel=1e-6)
        made.client.disconnect()


def test_poses_go_round_and_are_camrigs_mirrored(api, door):
    cam = door[0].camera("main")
    for location, rotation in [((100, 250, 50.5), (-12.5, 297.7, 0)), ((-1e3, -3, 1e-1), (10, -170, 5.25)), ((0, 0, 0), (0, 180, 0))]:
        api.set_cam_location(0, location)
        api.set_cam_rotation(0, rotation)
        assert api.get_cam_location(0) == pytest.approx(location, abs=1e-3)
        turned = [rotation[0], math.remainder(rotation[1], 360), rotation[2]]
        assert np.abs(np.exp(1j * np.radians(api.get_cam_rotation(0))) - np.exp(1j * np.radians(turned))).max() < 1e-5
        pose = cam.get()["pose"]
        assert pose["position"] == pytest.approx([location[0] / 100, -location[1] / 100, location[2] / 100], abs=1e-12)
        assert pose["tilt_deg"] == pytest.approx(rotation[0], abs=1e-9) and pose["roll_deg"] == pytest.approx(rotation[2], abs=1e-9)
        assert math.remainder(pose["pan_deg"] + rotation[1], 360) == pytest.approx(0, abs=1e-9)
    assert ask(api, "vset /camera/0/pose 1 2 3 4 5 6") == "ok"
    assert ask(api, "vget /camera/0/pose") == "1.000 2.000 3.000 4.000 5.000 6.000"
    assert api.get_cam_pose(0) == [1, 2, 3, 4, 5, 6]
    # Yaw is clockwise from above: what stood ahead moves to the left of the picture.
    ask(api, "vset /camera/0/pose -600 0 100 0 0 0")
    middle = [np.argwhere(api.get_mask(api.get_image(0, "object_mask", "png"), "box"))[:, 1].mean()]
    ask(api, "vset /camera/0/rotation 0 10 0")
    middle.append(np.argwhere(api.get_mask(api.get_image(0, "object_mask", "png"), "box"))[:, 1].mean())
    assert middle[1] < middle[0] - 50


def test_a_camera_is_placed_without_what_its_head_and_a_knock_turn(api, door):
    rig = door[0]
    rig.call("actor.spawn", name="car", model="box", position=[0, 0, 1])
    rig.call("camera.create", name="head", size=[320, 240], hfov_deg=60, mount={"actor": "car"}, ptz={"preset": "ideal"})
    rig.call("ptz.move", camera="head", pan_deg=40, tilt_deg=-10)
    rig.step(seconds=30)
    rotation = lambda: [float(angle) for angle in ask(api, "vget /camera/1/rotation").split()]
    before = rotation()
    assert before[:2] == pytest.approx([-10, -40], abs=1e-3)
    assert ask(api, "vset /camera/1/location 100 0 300") == "ok"
    assert rotation() == pytest.approx(before, abs=1e-3)
    # The knock is a fault of its body: who puts it somewhere knows nothing of that.
    pose = rig.camera("main").get()["pose"]
    rig.call("fault.set", camera="main", kind="knock", params={"pan_deg": 5})
    rig.step(seconds=1)
    for x in (10, 20, 30):
        assert ask(api, f"vset /camera/0/location {x} 0 100") == "ok"
        rig.step(seconds=0.2)
    after = rig.camera("main").get()["pose"]
    assert after["pan_deg"] == pytest.approx(pose["pan_deg"], abs=1e-9) and after["position"] == pytest.approx([0.3, 0, 1])


def test_a_zoomed_head_keeps_the_field_of_view_that_it_is_told(api, door):
    rig = door[0]
    rig.call("camera.create", name="head", size=[640, 480], hfov_deg=60, ptz={"preset": "ideal"})
    rig.call("ptz.move", camera="head", zoom=4)
    rig.step(seconds=30)
    fov_of = lambda: float(ask(api, "vget /camera/1/fov"))
    fov = fov_of()
    assert fov == pytest.approx(2 * math.degrees(math.atan(math.tan(math.radians(30)) / 4)), abs=0.01)
    assert ask(api, "vset /camera/1/size 320 240") == "ok"
    assert fov_of() == pytest.approx(fov, abs=0.01)
    assert ask(api, "vset /camera/1/fov 20") == "ok"
    assert fov_of() == pytest.approx(20, abs=0.01)
    rig.call("ptz.move", camera="head", zoom=1)
    rig.step(seconds=30)
    assert fov_of() == pytest.approx(2 * math.degrees(math.atan(math.tan(math.radians(10)) * 4)), abs=0.01)


def test_cameras_are_made_sized_and_destroyed(api, door):
    rig = door[0]
    name = api.set_new_camera()
    assert api.get_camera_list() == ["main", name] and set(api.cam) == {0, 1}
    assert ask(api, "vget /camera/1/size", "vget /camera/1/location") == ["640 480", "0.000 0.000 0.000"]
    assert float(api.get_cam_fov(1)) == 90
    api.set_cam_fov(1, 60)
    assert ask(api, "vset /camera/1/size 320 200") == "ok"
    state = rig.camera(name).get()
    assert state["size"] == [320, 200] and state["hfov_deg"] == pytest.approx(60)
    assert api.get_image(1, "lit", "bmp").shape == (200, 320, 3)
    assert ask(api, f"vset /object/{name}/destroy") == "ok"
    assert api.get_camera_list() == ["main"]
    assert ask(api, "vget /camera/1/lit png") == "error Invalid sensor id"


def test_two_eyes_are_made_or_none(api, door):
    rig = door[0]
    for number in range(len(rig.cameras()), 255):
        rig.create_camera(f"filler_{number}", size=(16, 16))
    assert ask(api, "vset /objects/spawn StereoCameraActor").startswith("error ")
    assert len(rig.cameras()) == 255, "the first eye is gone again"


def test_a_read_shows_the_connections_last_write_and_a_batch_is_one_instant(unrealcv, tmp_path):
    with camrig.start("minimal", mode="realtime", args=["--unrealcv", "0"]) as rig:
        port = rig.call("server.info")["unrealcv"]
        api = unrealcv.UnrealCv_API(port, "127.0.0.1", (640, 480))
        rig.call("actor.set", name="mover", behaviour={"type": "route", "route": "circle", "speed": 20, "mode": "loop"})
        raw = hello(port)
        rims, deadline = 0, time.monotonic() + 30
        while rims < 10:  # at first the mover is behind the box
            assert time.monotonic() < deadline, f"the mover was seen {rims} times"
            # Picture, ids and depth of one moment cover the same pixels, though the mover goes 20 m/s.
            lit, mask, depth, again = at_once(raw, "vget /camera/0/lit bmp", "vget /camera/0/object_mask bmp", "vget /camera/0/depth npy", "vget /camera/0/object_mask png")
            mask = api.decoder.decode_bmp(mask)
            assert np.array_equal(mask, api.decoder.decode_png(again))
            # At the mover's rim depth jumps.
            mover = api.get_mask(mask, "mover") > 0
            inside, cm = mover[:, :-1] & ~mover[:, 1:], numpy_of(depth)
            if inside.any():
                rims += 1
                steps = np.abs(cm[:, 1:] - cm[:, :-1])[inside]
                assert np.median(steps) > 5
        raw.close()
        for x in (-400, -500, -600):
            api.set_cam_location(0, [x, 0, 100])
            api.set_cam_rotation(0, [0, 0, 0])
            ask(api, "vset /object/box/hide")
            assert not api.get_mask(api.get_image(0, "object_mask", "bmp"), "box").any()
            ask(api, "vset /object/box/show")
            mask = api.get_image(0, "object_mask", "bmp")
            assert api.get_mask(mask, "box").any() and api.get_cam_location(0)[0] == x
        # vbatch makes one moment of requests that wait for their answers.
        assert ask(api, "vbatch 20") == "ok"
        places = {api.client.request("vget /object/mover/location") for _ in range(20)}
        assert len(places) == 1
        wait_until(lambda: api.client.request("vget /object/mover/location") not in places, what="the mover to be somewhere else")
        api.client.disconnect()


def test_objects_are_found_measured_moved_hidden_scaled_coloured_spawned_and_destroyed(api, door):
    rig = door[0]
    listed = {one["name"]: one for one in rig.call("object.list")["objects"]}
    for name, one in listed.items():
        x, y, z = one["position"]
        assert api.get_obj_location(name) == pytest.approx([100 * x, -100 * y, 100 * z], abs=6e-4)
    assert api.get_obj_rotation("box") == pytest.approx([0, -30, 0], abs=1e-3)
    assert [api.get_obj_uclass(name) for name in listed] == ["ground", "box", "box"]
    assert [ask(api, f"vget /object/{name}/mobility") for name in listed] == ["Static", "Static", "Movable"]

    box = rig.call("object.get", name="box")["box"]
    bounds = api.get_obj_bounds("box")
    mirrored = [box["min"][0], -box["max"][1], box["min"][2], box["max"][0], -box["min"][1], box["max"][2]]
    assert bounds == pytest.approx([100 * v for v in mirrored], abs=6e-3)
    vertices = np.array(api.get_vertex_locations("box"))
    assert np.concatenate([vertices.min(0), vertices.max(0)]) == pytest.approx(bounds, abs=6e-3)

    before = api.get_image(0, "lit", "png")
    api.set_hide_obj("box")
    assert not api.get_mask(api.get_image(0, "object_mask", "png"), "box").any()
    assert rig.call("object.get", name="box")["hidden"] and "box" in api.get_objects()
    api.set_show_obj("box")
    assert np.array_equal(api.get_image(0, "lit", "png"), before)

    for name in ("box", "mover"):
        api.set_obj_location(name, [-50, 120, 30])
        api.set_obj_rotation(name, [0, 45, 0])
        assert api.get_obj_pose(name) == pytest.approx([-50, 120, 30, 0, 45, 0], abs=1e-3)
        api.set_obj_scale(name, [2, 2, 2])
        assert api.get_obj_scale(name) == [2, 2, 2]
    assert ask(api, "vset /object/box/scale 1 2 3").startswith("error ")

    api.set_obj_color("box", [1, 200, 3])
    assert ask(api, "vget /object/box/color") == "(R=1,G=200,B=3,A=255)"
    mask = api.get_image(0, "object_mask", "png")
    assert (mask == [3, 200, 1]).all(axis=2).any()

    assert api.set_new_obj("box_C", "crate 1".replace(" ", "_"), [0, 300, 0]) == "crate_1"
    assert api.get_obj_location("crate_1") == [0, 300, 0] and api.get_obj_uclass("crate_1") == "box"
    assert ask(api, "vset /objects/spawn box crate_1") == "error Failed to spawn crate_1, object exists."
    assert ask(api, "vset /objects/spawn Teapot_C t") == "error Can not find a class with name 'Teapot_C'"
    api.destroy_obj("crate_1")
    api.destroy_obj("box")
    assert api.get_objects() == ["ground", "mover"]
    assert ask(api, "vget /object/box/location") == "error Cannot find object"


def test_agents_are_driven_by_their_functions_and_ticks(api, door):
    rig = door[0]
    ask(api, "vset /object/mover/location 0 200 0", "vset /object/mover/rotation 0 0 0")
    assert ask(api, "vbp mover set_move 90 150") == "{}"
    assert ask(api, "vset /action/tick_intervel 0.5", "vset /action/tick", "vset /action/tick") == ["ok"] * 3
    assert rig.status()["world_ns"] == 10**9
    # Turned to the right, it goes along +y, 1.5 m in a second.
    assert api.get_obj_location("mover") == pytest.approx([0, 350, 0], abs=0.1)
    assert api.get_obj_rotation("mover")[1] == pytest.approx(90, abs=1e-3)
    assert json.loads(ask(api, "vbp mover nav_to_goal 0 400 0")) == {}
    ask(api, "vset /action/set_fixed_frame_rate 0.5", "vset /action/tick")
    assert api.get_obj_location("mover") == pytest.approx([0, 400, 0], abs=1)
    assert ask(api, "vbp mover jump") == "error Not Implemented"
    assert api.get_is_paused() and api.set_pause() is None


def test_files_are_written_below_the_folder_and_nowhere_else(api, door, tmp_path):
    folder = door[2]
    bgr = door[0].camera("main").frame().image
    status = ask(api, "vget /unrealcv/status")
    assert f"Config file: {folder}/unrealcv.ini\n" in status and "Width: 640" in status
    import cv2

    assert ask(api, "vget /camera/0/lit sub/a.png") == str(folder / "sub/a.png")
    assert np.array_equal(cv2.imread(str(folder / "sub/a.png")), bgr)
    assert ask(api, "vget /camera/0/lit") == str(folder / "00000000.png")
    assert np.load(ask(api, "vget /camera/0/depth d.npy")).shape == (480, 640)
    for name in (f"{tmp_path}/x.png", "../x.png", "sub/../../x.png"):
        assert ask(api, f"vget /camera/0/lit {name}").startswith("error ")
    assert not (tmp_path / "x.png").exists()
    for what in ("lit x.exr", "lit x.jpg", "depth png", "lit gif"):
        assert ask(api, f"vget /camera/0/{what}") == f"error Invalid filename type, filename {what.split()[1]}"


def test_without_a_folder_no_file_is_written(unrealcv):
    with camrig.start("minimal", mode="lockstep", args=["--unrealcv", "0"]) as rig:
        api = unrealcv.UnrealCv_API(rig.call("server.info")["unrealcv"], "127.0.0.1", (640, 480))
        assert "--unrealcv-dir" in ask(api, "vget /camera/0/lit a.png")
        api.client.disconnect()


def test_what_is_unknown_or_wrong_is_told(api):
    with pytest.warns(UserWarning):
        answer = api.client.request("vget /nonsense")
    assert answer == "error No handler found for URI 'vget /nonsense' (Can not find a handler)"
    assert ask(api, "vset /camera/0/location 1 2 x").startswith("error No handler found")
    assert ask(api, "vset /object/box/color 1 2 256") == "error Argument Invalid"
    assert ask(api, "vset /object/box/location 1e300 0 0").startswith("error No handler found")
    for name in ("a/b", "x" * 65):
        assert ask(api, f"vset /objects/spawn box {name}").startswith("error ")
    assert ask(api, "vset /camera/0/fov 400").startswith("error ")
    assert ask(api, "vset /action/game/level ../../etc/passwd").startswith("error Can not find a level")
    assert ask(api, "vget /unrealcv/echo a b") == "a b"


def test_another_level_is_loaded(api, door):
    api.set_map("clock")
    assert door[0].status()["scene"] == "clock" and ask(api, "vget /scene/name") == "clock"
    assert "box" not in api.get_objects()


def test_what_gym_unrealcv_and_unrealzoo_send_is_answered(unrealcv, door):
    rig, port, _ = door
    first = unrealcv.Client(("127.0.0.1", port))
    assert first.connect()
    first.disconnect()  # they look for a Unix socket then, and come back
    client = unrealcv.Client(("127.0.0.1", port))
    assert client.connect()
    for line in ("vrun setres 640x480w", "DisableAllScreenMessages", "vrun sg.ShadowQuality 0", "vrun slomo 2", "vrun t.maxFPS 30", "vset /action/keyboard Up 0.01"):
        client.request(line, -1)
    objects = client.request("vget /objects").split()
    asked = [f"vget /object/{name}/{what}" for name in objects for what in ("location", "rotation")]
    asked += ["vget /camera/0/location", "vget /camera/0/rotation", "vget /camera/0/lit bmp", "vget /camera/0/object_mask bmp", "vget /camera/0/depth npy"]
    answers = client.request(asked)
    for name, location in zip(objects, answers[::2]):
        place = next(one["position"] for one in rig.objects() if one["name"] == name)
        assert [float(number) for number in location.split()] == pytest.approx([100 * place[0], -100 * place[1], 100 * place[2]], abs=1e-3)
    lit, mask, depth = answers[-3:]
    assert lit[:2] == mask[:2] == b"BM" and numpy_of(depth).shape == (480, 640)
    assert client.request("vget /object/box/vertices") == client.request("vget /object/box/vertex_location")
    client.request("vset /camera/0/pose 100.0 200.0 150.0 -5.0 30.0 0.0", -1)
    assert client.request("vget /camera/0/pose") == "100.000 200.000 150.000 -5.000 30.000 0.000"
    client.request("vset /camera/0/moveto 110.0 200.0 150.0")
    assert client.request("vget /camera/0/location") == "110.000 200.000 150.000"
    for line in ("vbp mover set_move -30.0 100.0", "vbp mover nav_to_goal 100.0 200.0 0.0"):
        assert client.request(line) == "{}"
    client.disconnect()


def test_the_program_of_the_page_runs(unrealcv):
    (program,) = blocks("docs/unrealcv.md", "python")
    with camrig.start("hall", mode="lockstep", args=["--unrealcv", "0"]) as rig:
        told = {}
        exec(program.replace("9000", str(rig.call("server.info")["unrealcv"])), told)
        assert told["image"].shape == (480, 640, 3) and not np.array_equal(told["image"], told["next_image"])
        assert np.array_equal(told["next_image"], rig.cameras()[0].frame().image) and rig.status()["world_ns"] == 40_000_000
        assert 0 < told["box"][1][0][0] < told["box"][1][1][0] < 1 and told["depth"].min() > 100
        told["api"].client.disconnect()


def hello(port):
    raw = socket.create_connection(("127.0.0.1", port), timeout=20)
    assert answer(raw) == b"connected to minimal"
    return raw


def frame(payload, magic=MAGIC, size=None):
    return struct.pack("<II", magic, len(payload) if size is None else size) + payload


def answer(raw):
    with raw.makefile("rb", buffering=0) as stream:
        return payload(stream)


def at_once(raw, *commands):
    """Answers to commands that come together. The client sends one behind the other: on a busy machine the last may come behind an answer, and is no batch then."""
    raw.sendall(b"".join(frame(f"{number}:{command}".encode()) for number, command in enumerate(commands)))
    return [answer(raw).partition(b":")[2] for _ in commands]


def payload(stream):
    """Of the next frame, however it comes."""
    def exactly(size):
        read = b""
        while len(read) < size:
            read += stream.read(size - len(read)) or pytest.fail("the stream ended in a frame")
        return read

    magic, size = struct.unpack("<II", exactly(8))
    assert magic == MAGIC
    return exactly(size)


def is_closed(raw):
    try:
        return raw.recv(1) == b""
    except ConnectionError:
        return True


BROKEN = {
    "magic": frame(b"0:vget /cameras", magic=1), "256M": frame(b"", size=256 << 20), "4G": frame(b"", size=0xFFFFFFFF), "empty": frame(b"", size=0),
    "no_id": frame(b"vget /cameras"), "empty_id": frame(b":vget"), "negative_id": frame(b"-1:vget /cameras"), "http": b"POST / HTTP/1.1\r\n\r\n",
}


@pytest.mark.parametrize("bad", BROKEN.values(), ids=BROKEN.keys())
def test_broken_streams_are_closed_and_others_go_on(door, bad):
    port = door[1]
    with hello(port) as good, hello(port) as raw:
        raw.sendall(bad)
        assert is_closed(raw)
        good.sendall(frame(b"5:vget /cameras"))
        assert answer(good) == b"5:main"


def test_many_connections_and_clients_that_vanish_leave_nothing(door):
    rig, port, _ = door
    process = Process(rig.call("server.info")["pid"])
    open_now = lambda: rig.call("server.info")["connections"]["unrealcv"]["open"]
    with hello(port) as raw:
        raw.sendall(frame(b"0:vget /camera/0/lit bmp"))
        answer(raw)
    wait_until(lambda: open_now() == 0, what="the door to be empty")
    fds, rss = process.fds(), []
    for turn in range(1, 7):
        raws = [socket.create_connection(("127.0.0.1", port), timeout=20) for _ in range(100)]
        wait_until(lambda: rig.call("server.info")["connections"]["unrealcv"]["refused"] == 68 * turn, what="all but 32 to be refused")
        assert open_now() == 32
        for number, raw in enumerate(raws):
            if number % 3 == 0:
                try:
                    raw.sendall(frame(b"7:vget /camera/0/lit bmp") * 20)  # and takes none of the answers
                except ConnectionError:
                    pass
            raw.close()
        wait_until(lambda: open_now() == 0, what="the door to be empty")
        wait_until(lambda: process.fds() <= fds, what="all descriptors to be closed")
        rss.append(process.rss_kib())
    # How many answers were being made at once is the machine's, so the most of it comes in any turn; what leaks comes in each.
    assert min(after - before for before, after in zip(rss, rss[1:])) < 1024, rss
    hello(port).close()


def test_broken_streams_leave_neither_descriptors_nor_memory(door):
    rig, port, _ = door
    process = Process(rig.call("server.info")["pid"])
    open_now = lambda: rig.call("server.info")["connections"]["unrealcv"]["open"]
    more = b"\0" * 60_000

    def break_all():
        for bad in BROKEN.values():
            with hello(port) as raw:
                raw.sendall(frame(b"0:vget /cameras") + bad + more)
                while not is_closed(raw):
                    pass
        # A frame that says more than ever comes.
        with hello(port) as raw:
            raw.sendall(frame(more, size=1 << 20))
        wait_until(lambda: open_now() == 0, what="the door to be empty")

    for _ in range(3):
        break_all()
    fds, rss = process.fds(), process.rss_kib()
    for _ in range(60):
        break_all()
    wait_until(lambda: process.fds() <= fds, what="all descriptors to be closed")
    assert process.rss_kib() < rss + 1024  # 540 connections
    hello(port).close()


def test_floods_of_small_commands_are_answered_each_and_leave_nothing(door):
    """At full speed from four clients that write all they have before they read; what one of them is refused stops no other."""
    rig, port, _ = door
    process = Process(rig.call("server.info")["pid"])
    commands = [b"vget /camera/0/location", b"vset /object/mover/location %d 0 0", b"vset /nonsense %d", b"vget /object/mover/location"]
    count, failed = 20_000, []

    def flood(client):
        with hello(port) as raw:
            def write():
                for first in range(0, count, 500):
                    raw.sendall(b"".join(frame(b"%d:%s" % (i, command % i if b"%" in (command := commands[i % 4]) else command))
                                         for i in range(first, first + 500)))

            writer = threading.Thread(target=write)
            writer.start()
            with raw.makefile("rb") as stream:
                for i in range(count):
                    number, text = payload(stream).split(b":", 1)
                    if int(number) != i or text.startswith(b"error") != (i % 4 == 2):
                        failed.append((client, i, text))
            writer.join()

    def flood_all():
        threads = [threading.Thread(target=flood, args=(n,)) for n in range(4)]
        begin = time.monotonic()
        for thread in threads:
            thread.start()
        with hello(port) as good:
            for i in range(20):
                good.sendall(frame(b"%d:vget /camera/0/lit bmp" % i))
                assert len(answer(good)) > 640 * 480 * 4
        for thread in threads:
            thread.join(timeout=120)
        assert not failed and not any(thread.is_alive() for thread in threads)
        print(f"{4 * count / (time.monotonic() - begin):.0f} commands a second")
        wait_until(lambda: rig.call("server.info")["connections"]["unrealcv"]["open"] == 0, what="the door to be empty")

    flood_all()
    fds, rss = process.fds(), process.rss_kib()
    flood_all()
    wait_until(lambda: process.fds() <= fds, what="all descriptors to be closed")
    assert process.rss_kib() < rss + 8 * 1024


def test_several_clients_have_their_own_order_and_ids(door):
    port = door[1]
    failed = []

    def ask_much(first):
        with hello(port) as raw:
            for i in range(first, first + 500):
                raw.sendall(frame(b"%d:vget /unrealcv/echo %d" % (i, i)))
            for i in range(first, first + 500):
                if answer(raw) != b"%d:%d" % (i, i):
                    failed.append(i)

    threads = [threading.Thread(target=ask_much, args=(1000 * n,)) for n in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(timeout=60)
    assert not failed and not any(thread.is_alive() for thread in threads)


def test_ten_thousand_small_commands_in_one_batch_survive(api):
    answers = api.client.request(["vget /object/box/color"] * 10_000)
    assert len(answers) == 10_000 and set(answers) == {ask(api, "vget /object/box/color")}


def test_the_door_is_shut_by_default_and_never_open_to_others(tmp_path):
    with camrig.start("minimal", mode="lockstep") as rig:
        assert "unrealcv" not in rig.call("server.info")
    (token := tmp_path / "token").write_text("a-good-token\n")
    token.chmod(0o600)
    with camrig.start("minimal", mode="lockstep", args=["--unrealcv", "0", "--host", "0.0.0.0", "--token-file", str(token)]) as rig:
        port = rig.call("server.info")["unrealcv"]
        with pytest.raises(ConnectionRefusedError):
            socket.create_connection(("127.0.0.2", port), timeout=2)  # who listened on all addresses would take it
        hello(port).close()

"""Rig, Camera and Frame against a stand-in for the daemon."""

from fractions import Fraction

import numpy as np
import pytest

import camrig
from camrig.spec import camera_params


def test_camera_options_become_parameters(client_rig, fake):
    client_rig.create_camera(
        "lobby",
        size=(640, 480),
        fps=Fraction(30000, 1001),
        vfov_deg=60,
        position=np.array([2, 3, 2.8]),
        look_at=(12, 9, 1),
        lens=("plumb_bob", np.array([0.1, 0, 0, 0, 0])),
        near=0.1,
        far=100,
        quality="fast",
        code_strip=True,
        outputs=["mjpeg", {"kind": "rtsp", "codec": "h264"}],
        place="entrance",
    )
    assert fake.requests == [
        (
            "camera.create",
            {
                "name": "lobby",
                "size": [640, 480],
                "fps": "30000/1001",
                "vfov_deg": 60.0,
                "pose": {"position": [2.0, 3.0, 2.8], "look_at": [12.0, 9.0, 1.0]},
                "lens": {"model": "plumb_bob", "coefficients": [0.1, 0.0, 0.0, 0.0, 0.0]},
                "near": 0.1,
                "far": 100.0,
                "quality": "fast",
                "code_strip": True,
                "outputs": [{"kind": "mjpeg"}, {"kind": "rtsp", "codec": "h264"}],
                "place": "entrance",
            },
        )
    ]


def test_what_is_not_given_is_not_sent():
    assert camera_params() == {}
    assert camera_params(pan_deg=10) == {"pose": {"pan_deg": 10.0}}
    assert camera_params(orientation=[0, 0, 0, 1]) == {"pose": {"orientation": [0.0, 0.0, 0.0, 1.0]}}


def test_intrinsics_are_a_mapping_or_a_camera_matrix():
    wanted = {"fx": 500.0, "fy": 501.0, "cx": 319.5, "cy": 239.5}
    assert camera_params(intrinsics=wanted) == {"intrinsics": wanted}
    assert camera_params(intrinsics=[[500, 0, 319.5], [0, 501, 239.5], [0, 0, 1]]) == {"intrinsics": wanted}
    with pytest.raises(camrig.CamrigError, match="skew"):
        camera_params(intrinsics=[[500, 1, 319.5], [0, 501, 239.5], [0, 0, 1]])


@pytest.mark.parametrize("bad", [{"size": (640,)}, {"position": (1, 2)}, {"orientation": (0, 0, 1)}])
def test_vectors_of_wrong_length_are_refused(bad):
    with pytest.raises(camrig.CamrigError) as caught:
        camera_params(**bad)
    assert caught.value.kind == "invalid_argument"


def test_step_takes_one_of_seconds_and_nanoseconds(client_rig, fake):
    client_rig.step(seconds=0.2)
    client_rig.step(nanoseconds=1)
    assert fake.world_ns == 200_000_001
    for wrong in ({}, {"seconds": 1, "nanoseconds": 1}):
        with pytest.raises(camrig.CamrigError):
            client_rig.step(**wrong)


def test_a_raw_frame_is_bgr_and_knows_its_instant(client_rig, fake):
    cam = client_rig.create_camera("lobby")
    client_rig.step(seconds=0.2)
    frame = cam.frame()
    assert frame.image.shape == (4, 6, 3) and frame.image.dtype == np.uint8
    assert frame.image.flags.c_contiguous and frame.image.flags.writeable
    np.testing.assert_array_equal(frame.image, fake.picture[:, :, 2::-1])
    assert (frame.time_ns, frame.monotonic_ns, frame.sequence) == (200_000_000, 200_001_000, 5)
    assert (frame.stamp_ns, frame.steady_ns) == (200_000_000, 200_001_000)
    assert (frame.camera, frame.kind) == ("lobby", "color")


def test_min_ns_is_handed_on(client_rig, fake):
    client_rig.create_camera("lobby").frame(min_ns=7)
    method, params = fake.requests[-1]
    assert method == "frame.get" and params.items() >= {"camera": "lobby", "kind": "color", "format": "raw", "min_ns": 7}.items()


def test_png_frames_are_exact_too(client_rig, fake):
    cam = client_rig.create_camera("lobby")
    np.testing.assert_array_equal(cam.frame(format="png").image, fake.picture[:, :, 2::-1])


def test_pictures_decode_without_opencv(monkeypatch, client_rig, fake):
    cam = client_rig.create_camera("lobby")
    reply = fake.do_frame_get({"camera": "lobby", "kind": "color", "format": "png"})
    fake.handlers["frame.get"] = lambda params: reply
    monkeypatch.setitem(__import__("sys").modules, "cv2", None)
    np.testing.assert_array_equal(cam.frame(format="png").image, fake.picture[:, :, 2::-1])


def test_depth_is_metres(client_rig):
    depth = client_rig.create_camera("lobby").depth()
    assert depth.shape == (4, 6) and depth.dtype == np.float32 and np.isinf(depth).all()


def test_what_the_rig_cannot_do_yet_is_unsupported(client_rig):
    cam = client_rig.create_camera("lobby")
    for call in (cam.instances, cam.truth):
        with pytest.raises(camrig.CamrigError) as caught:
            call()
        assert caught.value.kind == "unsupported"


@pytest.mark.parametrize("damage", [{"data": "!"}, {"data": "AAAA"}, {"size": [1]}, {"sequence": None}, {"pixels": "xyz"}])
def test_a_damaged_frame_is_an_error_and_no_crash(client_rig, fake, damage):
    cam = client_rig.create_camera("lobby")
    sound = fake.do_frame_get({"camera": "lobby", "kind": "color", "format": "raw"})
    fake.handlers["frame.get"] = lambda params: {**sound, **damage}
    with pytest.raises(camrig.CamrigError) as caught:
        cam.frame()
    assert caught.value.kind == "internal"


def test_snapshots_are_files_of_the_kind_their_name_says(client_rig, tmp_path):
    cam = client_rig.create_camera("lobby")
    assert cam.snapshot(tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    assert cam.snapshot(str(tmp_path / "a.jpg")).read_bytes().startswith(b"\xff\xd8")
    with pytest.raises(camrig.CamrigError, match=r"\.jpg nor \.png"):
        cam.snapshot(tmp_path / "a.bmp")


def test_set_get_and_delete(client_rig, fake):
    cam = client_rig.create_camera("lobby")
    cam.set(fps=10, position=(1, 2, 3))
    assert cam.get()["fps"] == 10
    assert [c.name for c in client_rig.cameras()] == ["lobby"]
    cam.delete()
    assert client_rig.cameras() == []


def test_urls(client_rig):
    cam = client_rig.create_camera("lobby")
    assert client_rig.device(cam) == cam.url() == "http://127.0.0.1:8123/cameras/lobby/stream.mjpg"
    assert client_rig.device("lobby") == cam.url()
    assert cam.url(fps=5, quality=80) == "http://127.0.0.1:8123/cameras/lobby/stream.mjpg?fps=5&quality=80"
    assert cam.url("png") == "http://127.0.0.1:8123/cameras/lobby/snapshot.png"
    assert cam.url("rtsp") == "rtsp://127.0.0.1:8555/lobby"
    assert cam.url("rtsp-sub") == "rtsp://127.0.0.1:8555/lobby/sub"
    assert cam.url("rtsp-mjpeg") == "rtsp://127.0.0.1:8555/lobby/mjpeg"
    client_rig.token = "t0ken+token"
    assert cam.url().endswith("?token=t0ken%2Btoken")
    with pytest.raises(camrig.CamrigError):
        cam.url("gif")


@pytest.mark.parametrize(
    ("listens", "url"),
    [("0.0.0.0", "http://127.0.0.1:80"), ("10.0.0.5", "http://10.0.0.5:80"), ("fe80::1", "http://[fe80::1]:80"), (None, "http://127.0.0.1:80")],
)
def test_urls_name_the_address_the_rig_listens_on(client_rig, fake, listens, url):
    fake.handlers["server.info"] = lambda params: {"http": 80, "host": listens}
    assert client_rig.http_url == url


def test_a_service_that_is_off_is_unsupported(client_rig, fake):
    fake.handlers["server.info"] = lambda params: {"http": 8123, "rtsp": None}
    with pytest.raises(camrig.CamrigError) as caught:
        client_rig.rtsp_url  # noqa: B018
    assert caught.value.kind == "unsupported"


def test_errors_survive_pickling():
    import pickle

    for error in (camrig.CamrigError("not_found", "no camera"), camrig.CamrigTimeout("unavailable", "late")):
        copy = pickle.loads(pickle.dumps(error))
        assert type(copy) is type(error) and (copy.kind, copy.message) == (error.kind, error.message)


def of_instants(**time_ns):
    """frame.get that shows these world times, whatever is asked for."""
    fake = {"sequence": 1, "monotonic_ns": 0, "size": [1, 1], "format": "raw", "pixels": "rgba8", "data": "AAAAAA=="}
    return lambda params: {**fake, "camera": params["camera"], "time_ns": time_ns[params["camera"]]}


def test_grabbed_pictures_of_different_instants_are_an_error(client_rig, fake):
    fake.handlers["world.status"] = lambda params: {"mode": "lockstep", "paused": False, "world_ns": 7}
    for name in ("left", "right"):
        client_rig.create_camera(name)
    fake.handlers["frame.get"] = of_instants(left=7, right=7)
    got = client_rig.grab()
    assert got.time_ns == 7 and sorted(got) == ["left", "right"] and got["left"]["color"].shape == (1, 1, 3)
    fake.handlers["frame.get"] = of_instants(left=7, right=6)
    with pytest.raises(camrig.CamrigError, match="different instants.*left at 7 ns, right at 6 ns") as caught:
        client_rig.grab(["left", "right"])
    assert caught.value.kind == "unavailable"


def test_in_real_time_an_instant_that_was_dropped_gives_way_to_a_later_one(client_rig, fake):
    fake.handlers["world.status"] = lambda params: {"mode": "realtime", "paused": False, "world_ns": 10**9}
    for name, fps in (("left", 10), ("right", 4)):
        client_rig.create_camera(name, fps=fps)
    asked = []

    def frame_get(params):
        asked.append(params["min_ns"])
        late = 100_000_000 if params["camera"] == "left" and len(asked) <= 2 else 0
        return of_instants(left=params["min_ns"] + late, right=params["min_ns"])(params)

    fake.handlers["frame.get"] = frame_get
    assert client_rig.grab(["left", "right"]).time_ns == 1_500_000_000  # both are due every half second
    assert len(asked) == 4


def test_frames_that_never_fall_together_cannot_be_grabbed(client_rig, fake):
    fake.handlers["world.status"] = lambda params: {"mode": "realtime", "paused": False, "world_ns": 10**9}
    client_rig.create_camera("left", fps="30000/1001")
    client_rig.create_camera("right", fps="29999/1000")
    with pytest.raises(camrig.CamrigError, match="do not fall together"):
        client_rig.grab()


@pytest.mark.parametrize("wrong", [{"kinds": ["colour"]}, {"kinds": []}, {"cameras": [f"c{i}" for i in range(33)]}])
def test_what_cannot_be_grabbed_is_an_invalid_argument(client_rig, wrong):
    with pytest.raises(camrig.CamrigError) as caught:
        client_rig.grab(**{"cameras": ["a"], **wrong})
    assert caught.value.kind == "invalid_argument"


def test_faults_have_their_own_parameters_as_keywords(client_rig, fake):
    fake.handlers = {"fault.set": lambda params: {"id": 3}, "fault.clear": lambda params: {"cleared": 1}, "fault.list": lambda params: {"faults": []}}
    assert client_rig.fault.set("lobby", "drop", severity=0.5, end_s=3, burst_frames=8)["id"] == 3
    assert client_rig.fault.clear("lobby") == client_rig.fault.clear(id=3) == 1
    assert client_rig.fault.list() == []
    assert fake.requests == [
        ("fault.set", {"camera": "lobby", "kind": "drop", "severity": 0.5, "end_s": 3, "params": {"burst_frames": 8}}),
        ("fault.clear", {"camera": "lobby"}),
        ("fault.clear", {"id": 3}),
        ("fault.list", {}),
    ]

"""Optical flow as programs get it: of cameras that are due at odd times, whose rows show one time after the other, or that show a photo."""

import io
import urllib.request

import cv2
import numpy as np
import pytest

import camrig

VELOCITY = np.array([0.6, 1.4, 0.0])
PERIOD_NS = 40_000_000


@pytest.fixture(scope="module")
def hall():
    with camrig.start("scenes/hall.json", mode="lockstep") as rig:
        rig.step(seconds=0.4)
        yield rig


@pytest.fixture
def straight():
    """The minimal scene, whose mover goes straight on: whatever it shows has moved by the same way in the same time."""
    with camrig.start("minimal", mode="lockstep") as rig:
        rig.steer({"mover": {"position": [-1.5, -1.2, 0]}})
        rig.step(seconds=0.01)
        rig.steer({"mover": {"velocity": VELOCITY.tolist()}})
        rig.step(seconds=0.3)
        yield rig


class Seen:
    """What a camera shows of the mover and the box at its latest frame."""

    def __init__(self, cam):
        depth, ids, truth = cam.depth(), cam.instances(), cam.truth()
        names = {item["name"]: item["id"] for item in truth["objects"]}
        self.flow, self.time_ns, self.view = cam.flow(), truth["time_ns"], camrig.Projection.of(truth)
        self.y, self.x = np.nonzero(np.isin(ids, [names["mover"], names["box"]]))
        self.moves = ids[self.y, self.x] == names["mover"]
        self.depth = depth[self.y, self.x].astype(np.float64)
        assert self.moves.sum() > 300 and (~self.moves).sum() > 300

    def flow_wrong_by(self, next_ns):
        """How many pixels its flow differs from where those points are at that time, at most."""
        rays = np.stack([self.x, self.y, np.ones_like(self.x)], 1) @ np.linalg.inv(self.view.K).T
        points = self.view.world_from_camera @ np.concatenate([rays * self.depth[:, None], np.ones((len(rays), 1))], 1).T
        gone = VELOCITY * (next_ns - self.time_ns) / 1e9 * self.moves[:, None]
        expected = self.view.project(points[:3].T + gone) - np.stack([self.x, self.y], 1)
        assert np.abs(expected[self.moves]).max() > 2
        return np.abs(self.flow[self.y, self.x] - expected).max()


@pytest.mark.parametrize("clock", [
    {"phase_ns": 13_000_000}, {"phase_ns": 13_000_000, "rate_ppb": 900_000}, {"trigger_jitter_ns": 15_000_000, "seed": 4},
], ids=["phase", "rate", "jitter"])
def test_flow_leads_to_the_next_due_frame_of_a_camera_with_a_clock(straight, clock):
    cam = straight.camera("main")
    cam.set(clock=clock)
    straight.step(nanoseconds=PERIOD_NS)
    apart = []
    for _ in range(5):
        seen = Seen(cam)
        straight.step(nanoseconds=PERIOD_NS)
        next_ns = cam.truth()["time_ns"]
        apart.append(next_ns - seen.time_ns)
        assert seen.flow_wrong_by(next_ns) < 0.02
    assert PERIOD_NS - 17_000_000 < min(apart) and max(apart) < PERIOD_NS + 17_000_000


def test_flow_leads_to_where_things_are_in_the_next_frame(hall):
    lobby = hall.camera("lobby")
    flow, truth, ids = lobby.flow(), lobby.truth(), lobby.instances()
    fetched = urllib.request.urlopen(f"{hall.http_url}/cameras/lobby/flow.npy").read()
    assert np.array_equal(np.load(io.BytesIO(fetched)), flow, equal_nan=True)
    assert np.array_equal(hall.grab(["lobby"], ["flow"])["lobby"]["flow"], flow, equal_nan=True)
    standing = ~np.isin(ids, [item["id"] for item in truth["objects"] if item["class"] == "person"])
    assert np.array_equal(np.isnan(flow[..., 0]), ids == 0)
    hall.step(nanoseconds=40_000_000)
    later = {item["id"]: item for item in lobby.truth()["objects"]}
    seen = 0
    for item in truth["objects"]:
        if item["class"] != "person" or item["pixels"] < 500 or np.linalg.norm(item["velocity"]) < 0.5:
            continue
        # The middle of all that is seen of them goes as their box does, within what limbs do.
        moved = np.nanmedian(flow[ids == item["id"]], axis=0)
        box, box_later = item["box_full"], later[item["id"]]["box_full"]
        assert np.abs(moved - [box_later[0] + box_later[2] / 2 - box[0] - box[2] / 2, box_later[1] - box[1]]).max() < 1.5
        seen += 1
    assert seen > 0
    floor = flow[standing & (ids != 0)]
    assert np.median(np.abs(floor)) == 0


def test_flow_comes_raw_only(hall):
    with pytest.raises(camrig.CamrigError, match="raw only"):
        hall.camera("lobby").frame(kind="flow", format="png")


def test_rows_that_show_one_time_after_the_other_lead_one_frame_on_each(straight):
    cam = straight.camera("main")
    straight.step(nanoseconds=PERIOD_NS)
    at_once = Seen(cam)
    cam.set(sensor={"preset": "imx219", "exposure_s": 0.004, "readout_s": 0.033})
    straight.step(nanoseconds=PERIOD_NS)
    seen = Seen(cam)
    # Each row's points are where they are in its time, a period before where that row shows them next.
    assert seen.flow_wrong_by(seen.time_ns + PERIOD_NS) < 0.02
    box = lambda one: [one.y[one.moves].max() - one.y[one.moves].min(), one.x[one.moves].max() - one.x[one.moves].min()]
    assert box(seen) != box(at_once)


def test_rows_of_a_head_that_gains_speed_have_the_way_of_their_own_time(straight):
    acceleration = np.radians(60)
    cam = straight.create_camera("dome", size=(640, 480), fps=25, vfov_deg=50, position=(-6, 0, 1), look_at=(0, 0, 1),
                                 sensor={"preset": "imx219", "exposure_s": 0.002, "readout_s": 0.036}, ptz={"preset": "ideal", "acceleration_deg_s2": 60})
    begin_ns = straight.status()["world_ns"]
    cam.ptz.move(pan_deg=120)
    straight.step(seconds=0.28)
    flow, truth = cam.flow(), cam.truth()
    stands = np.isin(cam.instances(), [item["id"] for item in truth["objects"] if item["name"] != "mover"])
    middle_s = lambda row: (truth["exposure_start_ns"] + row * truth["row_ns"] + 1e6 - begin_ns) / 1e9
    pan = lambda seconds: acceleration * seconds**2 / 2
    assert truth["ptz"]["true"]["pan_deg"] == pytest.approx(np.degrees(pan(middle_s(239.5))), abs=0.02)
    view = camrig.Projection.of(truth)
    fx, cx = view.K[0, 0], view.K[0, 2]
    wrong = []
    for row in range(0, 480, 12):
        # The camera stands level: what stands still goes around the vertical as the head turns.
        x = np.flatnonzero(stands[row])
        here = np.arctan((x - cx) / fx)
        turn = pan(middle_s(row) + PERIOD_NS / 1e9) - pan(middle_s(row))
        wrong += list(np.abs(flow[row, x, 0] - (fx * np.tan(here + turn) + cx - x)))
    # A row is drawn at most half a pixel from where it should be: here 4 ms, in which the head gains a quarter of a degree a second.
    first, last = (pan(middle_s(row) + 0.04) - pan(middle_s(row)) for row in (0, 479))
    assert fx * (last - first) > 0.7 and len(wrong) > 5000 and max(wrong) < 0.1


def test_flow_of_rows_behind_a_lens_that_zooms_leads_to_the_zoom_of_the_next_frame(straight):
    lens = {"model": "plumb_bob", "coefficients": [-0.2, 0.03, 0, 0, 0]}
    cam = straight.create_camera("zooms", size=(640, 480), fps=25, vfov_deg=50, place="main", lens=lens, sensor={"preset": "imx219", "exposure_s": 0.002, "readout_s": 0.036})
    straight.call("camera.set", name="zooms", zoom=3, seconds=1)
    straight.step(seconds=0.2)
    flow, ids, truth = cam.flow(), cam.instances(), cam.truth()
    straight.step(nanoseconds=PERIOD_NS)
    later = cam.truth()
    y, x = np.nonzero(np.isin(ids, [item["id"] for item in truth["objects"] if item["name"] != "mover"]))
    # All rows of a picture have one focal length, and what stands goes away from the middle with it.
    k, k_later = (camrig.Projection.of(one).K for one in (truth, later))
    expected = (np.stack([x, y], 1) - k[:2, 2]) * (k_later[0, 0] / k[0, 0] - 1) + k_later[:2, 2] - k[:2, 2]
    assert np.abs(expected).max() > 8
    assert np.abs(flow[y, x] - expected).max() < 0.02


def test_a_photos_shapes_stand_and_what_walks_in_it_flows(straight, tmp_path):
    plate = tmp_path / "plate.png"
    cv2.imwrite(str(plate), np.full((480, 640, 3), 90, np.uint8))
    pose = straight.camera("main").get()["pose"]
    straight.call("camera.create", name="photo", size=[640, 480], fps=25, vfov_deg=50, pose=pose, backdrop={
        "file": str(plate), "proxies": {"ground": {"polygon_m": [[-4, -4], [8, -4], [8, 4], [-4, 4]]}}})
    straight.set_object("ground", hidden=True)
    straight.step(nanoseconds=PERIOD_NS)
    cam = straight.camera("photo")
    seen, ids, depth = Seen(cam), cam.instances(), cam.depth()
    assert seen.flow_wrong_by(seen.time_ns + PERIOD_NS) < 0.02
    shape, nothing = (ids == 0) & np.isfinite(depth), np.isinf(depth)
    assert shape.sum() > 10_000 and (seen.flow[shape] == 0).all()
    assert nothing.sum() > 10_000 and np.isnan(seen.flow[nothing]).all()

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

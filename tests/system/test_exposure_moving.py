"""Under a rolling shutter of cameras that move, and of things that do: boxes and keypoints are where the picture shows them.

Beside the camera is a twin with a global shutter that is due a thousand times a second: what it shows at the time of a row is what that
row has to show, and where the world's points are in it at that time is where truth has to put them.
"""

import json

import numpy as np
import pytest

import camrig

WIDTH, HEIGHT = 640, 480
READOUT_S, EXPOSURE_S = 0.03, 0.0005
SENSOR = {"preset": "ideal", "white_balance": 6500, "exposure_s": EXPOSURE_S, "gain_db": 20, "readout_s": READOUT_S}
PERIOD_MS = 40


@pytest.fixture
def scene(tmp_path):
    """A lane with posts beside it, a van on it, and somebody who walks across."""
    posts = [{"name": f"post{i}", "model": "post", "class": "post", "position": [4 * i, 6, 0], "yaw_deg": 20 * i} for i in range(-3, 8)]
    file = tmp_path / "lane.json"
    file.write_text(json.dumps({
        "camrig_scene": 1, "name": "lane", "step_ns": 5_000_000,
        "environment": {"background": [0.5, 0.6, 0.7], "ambient": {"sky": [0.6, 0.6, 0.6], "ground": [0.4, 0.4, 0.4]}},
        "models": {"floor": {"shape": "ground", "size": [200, 200]}, "post": {"shape": "box", "size": [0.6, 0.4, 2.5], "color": [0.8, 0.1, 0.1]},
                   "van": {"shape": "box", "size": [2, 4, 2], "color": [0.1, 0.1, 0.8]}, "anna": {"file": "camrig:people/anna"}},
        "objects": [{"name": "floor", "model": "floor", "class": "ground"}, *posts],
        "routes": {"lane": {"points": [[-60, 0], [200, 0]]}, "across": {"points": [[5, -3], [5, 5.5]]}},
        "actors": [{"name": "van", "model": "van", "class": "vehicle", "behaviour": {"type": "route", "route": "lane", "speed": 15, "start_m": 50}},
                   {"name": "anna", "model": "anna", "class": "person", "behaviour": {"type": "route", "route": "across", "speed": 1.5}}],
    }))  # fmt: skip
    return file


CORNERS = np.array([[x, y, z] for x in (-0.3, 0.3) for y in (-0.2, 0.2) for z in (0, 2.5)])


def corners_of(post):
    x, y, z, w = post["orientation"]
    turn = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])  # fmt: skip
    return CORNERS @ turn.T + post["position"]


class Twins:
    """The camera, and what its twin showed in each of the last milliseconds."""

    def __init__(self, rig, **how):
        self.rig = rig
        self.cam = rig.create_camera("rolls", size=(WIDTH, HEIGHT), fps=1000 / PERIOD_MS, vfov_deg=50, sensor=SENSOR, **how)
        self.twin = rig.create_camera("twin", size=(WIDTH, HEIGHT), fps=1000, vfov_deg=50, **how)
        self.truths, self.ids = [], []

    def both(self, tell):
        for cam in (self.cam, self.twin):
            tell(cam)

    def take(self):
        """Goes on to the camera's next picture."""
        self.truths, self.ids = [], []
        for _ in range(PERIOD_MS):
            self.rig.step(nanoseconds=1_000_000)
            self.truths.append(self.twin.truth())
            self.ids.append(self.twin.instances())
        self.truth, self.seen, self.picture = self.cam.truth(), self.cam.instances(), self.cam.frame().image
        assert self.truth["time_ns"] == self.truths[-1]["time_ns"]
        self.times_ns = np.array([one["time_ns"] for one in self.truths])

    def time_of_row(self, y):
        return self.truth["exposure_start_ns"] + y * self.truth["row_ns"] + EXPOSURE_S * 5e8

    def solved(self, places):
        """Where a point is when its row counts, of its places (times x 2) in the twin's pictures."""
        y = places[-1][1]
        for _ in range(50):
            x, y = (np.interp(self.time_of_row(y), self.times_ns, places[:, k]) for k in (0, 1))
        return np.array([x, y])

    def projected(self, points_at):
        """The same of points of the world: `points_at` gives them (N x 3) of a truth."""
        places = np.stack([camrig.Projection.of(truth).project(points_at(truth)) for truth in self.truths])
        return np.stack([self.solved(places[:, k]) for k in range(places.shape[1])])

    def edge_errors(self, number):
        """By how many pixels an object's left and right edges in the id picture are beside those of the twin at the rows' times, of the rows
        in which both have them."""
        errors = []
        for y in range(HEIGHT):
            here = np.flatnonzero(self.seen[y] == number)
            k = np.searchsorted(self.times_ns, self.time_of_row(y))
            before, after = (np.flatnonzero(self.ids[i][y] == number) for i in (k - 1, k))
            if min(map(len, (here, before, after))) == 0 or here[0] == 0 or here[-1] == WIDTH - 1:
                continue
            share = (self.time_of_row(y) - self.times_ns[k - 1]) / (self.times_ns[k] - self.times_ns[k - 1])
            errors += [here[i] - (before[i] + share * (after[i] - before[i])) for i in (0, -1)]
        return np.array(errors)


def by_name(truth):
    return {one["name"]: one for one in truth["objects"]}


def check_posts(twins):
    """Boxes of all posts that are whole in the picture; returns how far off they would be at the frame's instant."""
    leans = []
    for one in twins.truth["objects"]:
        if one["class"] != "post" or one["truncated"] > 0 or any(by_name(truth).get(one["name"], {"truncated": 1})["truncated"] > 0 for truth in twins.truths):
            continue
        corners = twins.projected(lambda truth, name=one["name"]: corners_of(by_name(truth)[name]))
        low, high = corners.min(axis=0), corners.max(axis=0)
        box = np.array(one["box_full"])
        assert np.abs(box - [*low, *(high - low)]).max() < 0.01, (one["name"], box, low, high)
        errors = twins.edge_errors(one["id"])
        if len(errors) > 40:
            assert np.abs(errors).mean() < 0.5 and abs(errors.mean()) < 0.2, (one["name"], errors)
            leans.append(np.abs(box - by_name(twins.truths[-1])[one["name"]]["box_full"]).max())
    return leans


def test_of_a_camera_on_a_panning_head(scene):
    with camrig.start(str(scene), mode="lockstep") as rig:
        rig.step(seconds=0.2)
        twins = Twins(rig, position=(4, -4, 1.6), pan_deg=60, tilt_deg=0, ptz={"preset": "ideal", "speed_deg_s": 120, "acceleration_deg_s2": 2000})
        twins.both(lambda cam: cam.ptz.move(mode="continuous", pan_deg=100, tilt_deg=-20))
        rig.step(seconds=0.08)
        leans = []
        for _ in range(3):
            twins.take()
            leans += check_posts(twins)
        assert len(leans) >= 3 and max(leans) > 15, leans


def test_of_a_camera_on_a_moving_vehicle(scene):
    with camrig.start(str(scene), mode="lockstep") as rig:
        rig.step(seconds=0.2)
        twins = Twins(rig, mount={"actor": "van"}, position=(0, 1.2, 1.5), pan_deg=90, tilt_deg=0)
        leans = []
        for _ in range(4):
            twins.take()
            leans += check_posts(twins)
        assert len(leans) >= 3 and max(leans) > 15, leans


@pytest.mark.parametrize("pan_deg_s", [0, 90])
def test_of_somebody_who_walks(scene, pan_deg_s):
    """17 keypoints, seen by a camera that stands and by one whose head turns."""
    with camrig.start(str(scene), mode="lockstep") as rig:
        rig.step(seconds=0.52)
        twins = Twins(rig, position=(0, -1.5, 1.2), pan_deg=-20, tilt_deg=-3, ptz={"preset": "ideal", "speed_deg_s": 120, "acceleration_deg_s2": 2000})
        if pan_deg_s:
            twins.both(lambda cam: cam.ptz.move(mode="continuous", pan_deg=pan_deg_s))
        rig.step(seconds=0.08)
        for _ in range(2):
            twins.take()
            anna = by_name(twins.truth)["anna"]
            points = np.array(anna["keypoints"])
            places = np.stack([np.array(by_name(truth)["anna"]["keypoints"])[:, :2] for truth in twins.truths])
            shown = np.stack([twins.solved(places[:, k]) for k in range(17)])
            assert np.abs(points[:, :2] - shown).max() < 0.01
            off = np.abs(points[:, :2] - places[-1]).max()
            assert off > (10 if pan_deg_s else 2), off
            errors = twins.edge_errors(anna["id"])
            assert len(errors) > 200 and np.median(np.abs(errors)) < 0.5 and abs(np.median(errors)) < 0.2
            # They are on her in the picture: of those that are seen (v is 2), the pixel or one beside it.
            for x, y, v in anna["keypoints"]:
                if v == 2:
                    u, w = round(x), round(y)
                    assert (twins.seen[w - 2 : w + 3, u - 2 : u + 3] == anna["id"]).any(), (x, y)

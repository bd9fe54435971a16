"""The people sample: what its views do to pictures and boxes, and what its score counts."""

import math
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from camrig import CamrigError
from camrig.samples import people
from camrig.samples.hog import strongest
from camrig.samples.scoring import Tally
from camrig.samples.views import MARGIN, WINDOW_MARGIN, AsSeen, Upright

SIZE = (640, 480)
FOCAL = 400.0


def truth(objects=(), *, height=4.0, down_deg=30.0, roll_deg=0.0, yaw_deg=20.0, lens="pinhole"):
    """A camera above the origin."""
    yaw, pitch, roll = (math.radians(v) / 2 for v in (yaw_deg, down_deg, roll_deg))
    cy, sy, cp, sp, cr, sr = (f(v) for v in (yaw, pitch, roll) for f in (math.cos, math.sin))
    turn = [cy * cp * sr - sy * sp * cr, cy * sp * cr + sy * cp * sr, sy * cp * cr - cy * sp * sr, cy * cp * cr + sy * sp * sr]
    return {
        "camera": "cam", "size": list(SIZE), "lens": {"model": lens, "coefficients": []},
        "intrinsics": {"fx": FOCAL, "fy": FOCAL, "cx": 319.5, "cy": 239.5},
        "pose": {"position": [0, 0, height], "orientation": turn}, "objects": list(objects),
    }  # fmt: skip


def project(state, points):
    """By OpenCV, from a rotation made from the quaternion by OpenCV's own convention-free axis and angle."""
    x, y, z, w = state["pose"]["orientation"]
    angle = 2 * math.acos(min(1.0, w))
    axis = np.array([x, y, z]) / max(math.sin(angle / 2), 1e-12)
    world_from_body = cv2.Rodrigues(axis * angle)[0]
    optical_from_world = np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0]]) @ world_from_body.T
    k = np.array([[FOCAL, 0, 319.5], [0, FOCAL, 239.5], [0, 0, 1]])
    offset = -optical_from_world @ np.array(state["pose"]["position"], float)
    return cv2.projectPoints(np.array(points, float), cv2.Rodrigues(optical_from_world)[0], offset, k, None)[0].reshape(-1, 2)


def pole(state, at, tall):
    """A picture with a thin upright pole, white on black."""
    image = np.zeros((SIZE[1], SIZE[0]), np.uint8)
    foot, head = project(state, [(*at, 0), (*at, tall)])
    cv2.line(image, tuple(map(round, foot)), tuple(map(round, head)), 255, 3)
    return image, foot, head


@pytest.mark.parametrize("at", [(6.0, 0.5), (5.0, 4.5), (7.0, -1.0)])
@pytest.mark.parametrize("roll_deg", [0.0, 8.0])
def test_what_leans_in_the_picture_stands_in_the_upright_view(at, roll_deg):
    state = truth(roll_deg=roll_deg)
    image, _, _ = pole(state, at, 1.7)
    rows, columns = np.nonzero(Upright(state, 1.5).picture(image) > 127)
    assert np.ptp(rows) > 60
    slope = np.polyfit(rows, columns, 1)[0]
    assert abs(math.degrees(math.atan(slope))) < 0.7


def test_a_window_of_the_upright_view_comes_back_to_where_the_person_is():
    state = truth(roll_deg=5.0)
    image, foot, head = pole(state, (6.0, 2.0), 1.7)
    view = Upright(state, 1.5)
    rows, columns = np.nonzero(view.picture(image) > 127)
    tall = np.ptp(rows) / (1 - 2 * WINDOW_MARGIN)
    x, y, width, height = view.box((columns.mean() - tall / 4, rows.min() - WINDOW_MARGIN * tall, tall / 2, tall))
    assert y == pytest.approx(head[1], abs=3)
    assert y + height == pytest.approx(foot[1], abs=3)
    assert x + width / 2 == pytest.approx((head[0] + foot[0]) / 2, abs=2)


@pytest.mark.parametrize("tall, is_person", [(0.8, False), (1.25, True), (1.7, True), (2.2, True), (3.0, False)])
def test_only_what_is_as_tall_as_people_and_stands_on_the_floor_is_one(tall, is_person):
    state = truth()
    image, _, _ = pole(state, (6.0, 0.0), tall)
    view = Upright(state, 1.5)
    rows, columns = np.nonzero(view.picture(image) > 127)
    height = np.ptp(rows) / (1 - 2 * WINDOW_MARGIN)
    assert (view.box((columns.mean() - height / 4, rows.min() - WINDOW_MARGIN * height, height / 2, height)) is not None) == is_person


def test_what_is_above_the_horizon_is_no_person():
    view = Upright(truth(down_deg=0.0), 1.0)
    assert view.box((200.0, MARGIN + 10.0, 32.0, 64.0)) is None


def test_upright_says_which_lens_it_cannot_take():
    with pytest.raises(CamrigError, match="kannala"):
        Upright(truth(lens="kannala_brandt"), 1.5)


def test_as_seen_repeats_the_edge_and_takes_boxes_back():
    image = np.full((10, 20, 3), 7, np.uint8)
    view = AsSeen(2.0)
    assert view.picture(image).shape == (20 + 2 * MARGIN, 40 + 2 * MARGIN, 3)
    assert (view.picture(image) == 7).all()
    x, y, width, height = view.box((MARGIN + 0.0, MARGIN + 0.0, 64.0, 128.0))
    assert (y, height) == (8.0, 48.0)
    assert x + width / 2 == 16.0 and width == pytest.approx(0.41 * 48)


def test_one_person_is_found_once_and_by_several_windows():
    at = [(0.5, (100.0, 50.0, 41.0, 100.0)), (0.9, (103.0, 50.0, 41.0, 100.0)), (0.4, (100.0, 55.0, 41.0, 100.0))]
    lone = [(2.0, (300.0, 50.0, 41.0, 100.0))]
    assert strongest(at + lone) == [at[1]]


def person(number, box, visible=1.0, truncated=0.0, center=(6.0, 0.0, 0.9), seated=False):
    points = [None] * 17
    points[11] = points[12] = (0, 0, 0.9)
    points[13] = points[14] = (0.5, 0, 0.85) if seated else (0, 0, 0.5)
    return {"id": number, "class": "person", "pixels": 1 if visible else 0, "visible_fraction": visible, "truncated": truncated, "box_full": list(box),
            "center": list(center), "keypoints_world": points}  # fmt: skip


BOX = (100.0, 100.0, 41.0, 100.0)


def test_a_detection_is_right_once():
    tally = Tally()
    marks = tally.add([(0.5, BOX), (0.9, (104.0, 100.0, 41.0, 100.0))], truth([person(1, BOX)]))
    assert [mark for _, mark in marks] == ["right", "wrong"]
    assert tally.precision() == 0.5 and tally.recall("clear") == 1.0


@pytest.mark.parametrize("hard", [{"visible": 0.3}, {"truncated": 0.4}, {"seated": True}])
def test_people_who_are_hard_to_see_neither_count_nor_make_detections_wrong(hard):
    tally = Tally()
    marks = tally.add([(0.5, BOX), (0.4, (104.0, 100.0, 41.0, 100.0))], truth([person(1, BOX, **hard)]))
    assert [mark for _, mark in marks] == ["ignored", "ignored"]
    assert tally.there[("all",)] == 0 and math.isnan(tally.precision())


def test_a_detection_beside_somebody_is_wrong_and_leaves_him_missed():
    tally = Tally()
    marks = tally.add([(0.5, (140.0, 100.0, 41.0, 100.0))], truth([person(1, BOX)]))
    assert [mark for _, mark in marks] == ["wrong"]
    assert tally.recall("clear") == 0.0


@pytest.mark.parametrize("height, is_scored", [(60.0, False), (70.0, True), (370.0, True), (400.0, False)])
def test_detections_far_out_of_the_range_of_heights_are_left_out(height, is_scored):
    tally = Tally()
    tally.add([(0.5, (100.0, 20.0, 0.41 * height, height))], truth())
    assert tally.wrong == is_scored


def test_recall_by_angle_counts_the_unoccluded():
    tally = Tally()
    steep, level = person(1, BOX, center=(3.0, 0.0, 1.0)), person(2, (300.0, 100.0, 41.0, 100.0), center=(20.0, 0.0, 1.0))
    hidden = person(3, (500.0, 100.0, 41.0, 100.0), visible=0.6)
    tally.add([(0.5, tuple(level["box_full"]))], truth([steep, level, hidden]))
    assert tally.recall("steepness", math.inf) == 0.0 and tally.there[("steepness", math.inf)] == 1
    assert tally.recall("steepness", 12) == 1.0
    assert tally.recall("all") == pytest.approx(1 / 3) and tally.recall("clear") == 0.5


def test_whom_the_edge_cuts_off_is_told_apart_from_the_unoccluded():
    tally = Tally()
    tally.add([(0.5, BOX)], truth([person(1, BOX, truncated=0.1)]))
    assert tally.recall("cut") == 1.0 and tally.there[("clear",)] == 0 and tally.recall("all") == 1.0


class Running:
    """A rig whose world runs on to what it is asked for; it waits 10 s for a frame."""

    world_ns = 3_000_000_000

    def status(self):
        return {"mode": "realtime", "world_ns": self.world_ns}

    def camera(self, name):
        return self

    def frame(self, min_ns):
        if min_ns - self.world_ns > 10_000_000_000:
            raise CamrigError("unavailable", f"no frame at or after min_ns {min_ns} yet")
        self.world_ns = max(self.world_ns, min_ns)

    def pause(self):
        pass

    resume = pause


@pytest.mark.parametrize("every_s", [0.5, 5.0, 45.0])
def test_pictures_come_however_far_apart_and_into_a_folder_that_was_not_there(monkeypatch, tmp_path, every_s):
    seen = []

    def observe(camera):
        seen.append(camera.world_ns)
        return SimpleNamespace(image=np.zeros((SIZE[1], SIZE[0], 3), np.uint8)), truth()

    monkeypatch.setattr(people, "observe", observe)
    people.score(Running(), ["cam"], 3, every_s, lambda image, view: [], people.Views("as-seen", 1.0), str(tmp_path / "new" / "pictures"))
    assert seen == [round((3 + every_s * n) * 1e9) for n in (1, 2, 3)]
    assert sorted(file.name for file in (tmp_path / "new" / "pictures").iterdir()) == ["cam-000.png", "cam-001.png", "cam-002.png"]


@pytest.mark.parametrize("beside_px, mark", [(13.0, "right"), (14.4, "wrong")])
def test_an_overlap_of_half_is_a_find(beside_px, mark):
    """Of two boxes 41 px wide, (41 - d) / (41 + d)."""
    marks = Tally().add([(0.5, (100.0 + beside_px, 100.0, 41.0, 100.0))], truth([person(1, BOX)]))
    assert [found for _, found in marks] == [mark]


def test_an_opencv_without_the_detector_is_refused_with_what_to_install(monkeypatch):
    """OpenCV 5 without contrib."""
    monkeypatch.delattr(cv2, "HOGDescriptor", raising=False)
    with pytest.raises(CamrigError, match="no HOG people detector; pip install 'camrig.samples.'") as caught:
        people.main(["--control", "/nowhere"])
    assert caught.value.kind == "unsupported"

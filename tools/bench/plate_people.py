"""python -m tools.bench.plate_people [--report]

A detector for one place, trained on people in a photograph of it, against the stock one (Hattori et al., CVPR 2015: scene-specific detectors
without real data). The place is the shipped street, so that the whole truth is known:

1. the photo: the street seen by one camera, with nobody in it;
2. `camrig plate calibrate` finds that camera from eight places on the ground, clicked with an error of 0.7 pixels;
3. people of the shipped models walk in the photo (`camrig record` writes pictures and labels): the training set;
4. OpenCV's HOG with a linear SVM (cv2.ml) is trained on it, once more with what it took for people wrongly;
5. both detectors look at pictures of the street itself, with its own people, cars and shadows, by the true camera.

Scored as the Caltech benchmark does (camrig.samples.scoring).
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from camrig.samples.hog import Detector, overlap
from camrig.samples.views import WINDOW_MARGIN, AsSeen, upright
from tools.bench import report
from tools.bench.detection_curve import Curve

PAGE = report.REPOSITORY / "docs" / "backdrops.md"
PLACE = "crossing"
SIZE = (640, 480)
CLICKS_PX = [(60, 440), (580, 450), (320, 400), (120, 300), (520, 310), (330, 250), (240, 340), (430, 360)]
CLICK_ERROR_PX = 0.7
ENLARGE = 1.5
WINDOW = (64, 128)
#: Where people walk in the photo: the user's polygon, in metres.
WALK = [[-4.5, -5.5], [7.0, -5.5], [7.0, 4.0], [-4.5, 4.0]]
PEOPLE = 14
FALSE_PER_PICTURE = (0.1, 1.0)


def take_photo(folder: Path) -> dict[str, Any]:
    """The street without anybody; gives what its camera is, and where the places are that a user measures."""
    with report.start("street", mode="lockstep", seed=11) as rig:
        for actor in rig.actors():
            rig.remove_actor(actor["name"])
        cam = rig.create_camera("true", place=PLACE, size=SIZE, fps=1)
        rig.step(seconds=1)
        cv2.imwrite(str(folder / "photo.png"), cam.frame().image)
        sight, world = np.linalg.inv(cam.K), cam.world_from_camera
        error = np.random.default_rng(3).normal(0, CLICK_ERROR_PX, (len(CLICKS_PX), 2))
        points = []
        for px, off in zip(np.array(CLICKS_PX, float), error):
            ray = world[:3, :3] @ sight @ [*px, 1]
            points.append({"px": (px + off).tolist(), "m": (world[:3, 3] - ray * world[2, 3] / ray[2])[:2].tolist()})
        (folder / "clicks.json").write_text(json.dumps({"points": points}))
        return {"position": world[:3, 3], "fx": cam.K[0, 0]}


def calibrate(folder: Path) -> dict[str, Any]:
    """Makes the scene with people of it; gives what was found."""
    light = json.loads((report.REPOSITORY / "scenes" / "street.json").read_text())
    models = {f"person_{n}": {"file": f"camrig:people/{name}"} for n, name in enumerate(people_names())}
    rng = np.random.default_rng(7)
    actors = []
    for n in range(PEOPLE):
        at = [float(rng.uniform(WALK[0][axis], WALK[2][axis])) for axis in (0, 1)]
        actors.append({"name": f"walker_{n}", "model": f"person_{n % len(models)}", "class": "person", "position": [*at, 0],
                       "behaviour": {"type": "wander", "area": "walk", "speed": float(rng.uniform(1.0, 1.6)), "clip": "walk"}})
    scene = {"camrig_scene": 1, "name": "photo", "seed": 5, "models": models, "areas": {"walk": {"points": WALK}}, "actors": actors,
             "environment": light["environment"], "lights": light["lights"]}
    (folder / "scene.json").write_text(json.dumps(scene))
    run = [os.environ["CAMRIG_BIN"], "--json", "plate", "calibrate", "clicks.json", "--photo", "photo.png", "--scene", "scene.json", "--name", "gate"]
    return json.loads(subprocess.run(run, cwd=folder, capture_output=True, text=True, check=True).stdout)


def people_names() -> list[str]:
    return sorted(path.stem for path in (report.REPOSITORY / "scenes" / "people").glob("*.glb"))


def training_set(folder: Path, pictures: int) -> list[tuple[np.ndarray, list[dict[str, Any]]]]:
    """Pictures with the people in them, as a user has them from `camrig record`."""
    with report.start(str(folder / "scene.json"), mode="lockstep", seed=1) as rig:
        rig.camera("gate").set(fps="1/2")
        rig.record(folder / "set", ["gate"], frames=pictures)
    coco = json.loads((folder / "set" / "coco.json").read_text())
    boxes: dict[int, list[dict[str, Any]]] = {each["id"]: [] for each in coco["images"]}
    for each in coco["annotations"]:
        boxes[each["image_id"]].append(each)
    return [(cv2.imread(str(folder / "set" / each["file_name"])), boxes[each["id"]]) for each in coco["images"]]


def descriptor() -> cv2.HOGDescriptor:
    return cv2.HOGDescriptor()  # 64x128, as the stock model's


def window_of(image: np.ndarray, box: Any) -> np.ndarray | None:
    """The detector's window about a person's box in an enlarged picture."""
    x, y, width, height = upright(tuple(float(v) for v in box))
    whole = height / (1 - 2 * WINDOW_MARGIN)
    middle = (x + width / 2, y + height / 2)
    left, top = middle[0] - whole / 4, middle[1] - whole / 2
    if left < -whole / 4 or top < -whole / 8 or left + whole / 2 > image.shape[1] + whole / 4 or top + whole > image.shape[0] + whole / 8:
        return None
    scale = WINDOW[1] / whole
    move = np.array([[scale, 0, -left * scale], [0, scale, -top * scale]])
    return cv2.warpAffine(image, move, WINDOW, flags=cv2.INTER_AREA, borderMode=cv2.BORDER_REPLICATE)


def features(windows: list[np.ndarray]) -> np.ndarray:
    hog = descriptor()
    return np.array([hog.compute(window).ravel() for window in windows], np.float32)


def fit(right: np.ndarray, wrong: np.ndarray) -> np.ndarray:
    """A linear SVM as HOGDescriptor takes it: weights, then the offset."""
    svm = cv2.ml.SVM.create()
    svm.setType(cv2.ml.SVM_C_SVC)
    svm.setKernel(cv2.ml.SVM_LINEAR)
    svm.setC(0.01)
    svm.setTermCriteria((cv2.TERM_CRITERIA_MAX_ITER + cv2.TERM_CRITERIA_EPS, 20_000, 1e-4))
    svm.train(np.vstack([right, wrong]), cv2.ml.ROW_SAMPLE, np.r_[np.ones(len(right), np.int32), -np.ones(len(wrong), np.int32)])
    rho, _, _ = svm.getDecisionFunction(0)
    weights = svm.getSupportVectors()[0]
    # OpenCV's decision function of a two-class machine is that of the first label: its sign is looked up, not assumed.
    sign = 1.0 if (right @ weights).mean() - rho > (wrong @ weights).mean() - rho else -1.0
    return np.r_[sign * weights, -sign * rho].astype(np.float32)


def random_windows(image: np.ndarray, boxes: list[dict[str, Any]], count: int, rng: np.random.Generator) -> list[np.ndarray]:
    """Windows that show nobody by more than a fifth."""
    windows = []
    for _ in range(20 * count):
        height = float(np.exp(rng.uniform(np.log(80), np.log(300))))
        box = (rng.uniform(0, image.shape[1] - 0.41 * height), rng.uniform(0, max(1.0, image.shape[0] - height)), 0.41 * height, height)
        if all(overlap(box, upright(tuple(each["bbox"]))) < 0.2 for each in boxes) and (window := window_of(image, box)) is not None:
            windows.append(window)
        if len(windows) == count:
            break
    return windows


def train(pictures: list[tuple[np.ndarray, list[dict[str, Any]]]]) -> np.ndarray:
    rng = np.random.default_rng(2)
    right, wrong = [], []
    for image, boxes in pictures:
        people = [each for each in boxes if not each["iscrowd"] and each["visible_fraction"] >= 0.9 and each["truncated"] == 0 and 60 <= each["bbox"][3]]
        for window in filter(lambda found: found is not None, (window_of(image, each["bbox"]) for each in people)):
            right += [window, window[:, ::-1].copy()]
        wrong += random_windows(image, boxes, 12, rng)
    positive, negative = features(right), features(wrong)
    model = fit(positive, negative)
    hard = []
    for image, boxes in pictures[:: max(1, len(pictures) // 40)]:
        for _, box in Detector(0.0, model)(image, AsSeen(ENLARGE)):
            if all(overlap(box, upright(tuple(each["bbox"]))) < 0.3 for each in boxes) and (window := window_of(image, box)) is not None:
                hard.append(window)
    print(f"{len(right)} windows of people, {len(wrong)} without, {len(hard)} that were taken for people wrongly")
    return fit(positive, np.vstack([negative, features(hard)])) if hard else model


def judge(detectors: dict[str, Detector], pictures: int) -> dict[str, Curve]:
    """On the street itself: the same people as in the training, but its own walks, cars and shadows."""
    curves = {name: Curve() for name in detectors}
    with report.start("street", mode="lockstep", seed=23) as rig:
        cam = rig.create_camera("held_out", place=PLACE, size=SIZE, fps=25)
        for _ in range(pictures):
            rig.step(seconds=1.6)
            image, truth = cam.frame().image, cam.truth()
            for name, detector in detectors.items():
                curves[name].add(detector(image, AsSeen(ENLARGE)), truth)
    return curves


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--train", type=int, default=200, help="pictures to train on (default 200)")
    parser.add_argument("--test", type=int, default=60, help="pictures to judge by (default 60)")
    parser.add_argument("--report", action="store_true", help="writes the table into docs/backdrops.md")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        true = take_photo(folder)
        found = calibrate(folder)
        off = np.linalg.norm(np.array(found["camera"]["pose"]["position"]) - true["position"])
        print(found["reason"])
        model = train(training_set(folder, options.train))
    curves = judge({"stock": Detector(-0.6), "of this place": Detector(-0.6, model)}, options.test)
    rows = ["| detector | average precision | " + " | ".join(f"found at {each:g} wrong a picture" for each in FALSE_PER_PICTURE) + " |", "|---" * 4 + "|"]
    for title, curve in curves.items():
        rows.append(f"| {title} | {curve.average_precision():.2f} | " + " | ".join(f"{curve.recall_at(each):.2f}" for each in FALSE_PER_PICTURE) + " |")
    first = next(iter(curves.values()))
    text = "\n".join(rows) + (f"\n\n{first.people} people in {len(first.pictures)} pictures of 640x480 of the street itself; trained on {options.train} pictures of people in the photo. "
                              f"The camera was found {100 * off:.1f} cm from where it is, its focal length {abs(found['camera']['intrinsics']['fx'] / true['fx'] - 1):.2%} off.")
    print(text)
    if options.report:
        report.put(PAGE, "place", text, "`python -m tools.bench.plate_people --report`")


if __name__ == "__main__":
    main()

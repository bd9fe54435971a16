"""A camera as ROS sees it: calibration files and the grid of its frames."""

import subprocess
from fractions import Fraction

import numpy as np
import pytest
import yaml

import camrig
from camrig.ros2.camera_state import OPTICAL_FROM_LINK, CameraState, camera_info_yaml


def reply(**changes):
    """What camera.get answers."""
    camera = {
        "name": "cam",
        "size": [640, 480],
        "fps": 25,
        "intrinsics": {"fx": 500.5, "fy": 501.25, "cx": 319.5, "cy": 239.5},
        "lens": {"model": "pinhole", "coefficients": []},
        "pose": {"position": [1, 2, 3], "orientation": [0, 0, 0, 1], "pan_deg": 0},
        "outputs": [],
    }
    return {**camera, **changes}


def test_the_calibration_file_has_what_ros_parsers_ask_for():
    lens = {"model": "plumb_bob", "coefficients": [-0.2, 1e-05, 0.001, -2e-17, 0.1]}
    info = yaml.safe_load(camera_info_yaml(CameraState.of(reply(lens=lens))))
    assert (info["image_width"], info["image_height"], info["camera_name"]) == (640, 480, "cam")
    assert info["camera_matrix"] == {"rows": 3, "cols": 3, "data": [500.5, 0, 319.5, 0, 501.25, 239.5, 0, 0, 1]}
    assert info["distortion_model"] == "plumb_bob"
    # PyYAML, as ROS's Python tools use it, takes 1e-05 for text: each must be a number, and the same to the last bit.
    assert info["distortion_coefficients"] == {"rows": 1, "cols": 5, "data": lens["coefficients"]}
    assert info["rectification_matrix"] == {"rows": 3, "cols": 3, "data": [1, 0, 0, 0, 1, 0, 0, 0, 1]}
    assert info["projection_matrix"] == {"rows": 3, "cols": 4, "data": [500.5, 0, 319.5, 0, 0, 501.25, 239.5, 0, 0, 0, 1, 0]}


@pytest.mark.parametrize(
    "model, count, ros_model", [("pinhole", 0, "plumb_bob"), ("rational_polynomial", 8, "rational_polynomial"), ("equidistant", 4, "equidistant")]
)
def test_every_lens_model_has_the_name_and_count_of_ros(model, count, ros_model):
    state = CameraState.of(reply(lens={"model": model, "coefficients": [0.01] * count}))
    assert state.distortion_model == ros_model
    assert state.distortion == ((0.01,) * count or (0.0,) * 5)


@pytest.mark.parametrize("model, count", [("plumb_bob", 5), ("rational_polynomial", 8), ("equidistant", 4)])
def test_the_parser_of_ros_reads_the_calibration_to_the_last_bit(model, count, tmp_path):
    """Debian's camera-calibration-parsers-tools: ROS's own C++."""
    lens = {"model": model, "coefficients": [0.1 / 3, 1e-05, -2e-17, 0.001, 0.25, 1 / 7, 2.0, 3e-9][:count]}
    state = CameraState.of(reply(lens=lens, intrinsics={"fx": 500 / 3, "fy": 501, "cx": 319.5, "cy": 239.123456789}))
    (tmp_path / "cam.yaml").write_text(camera_info_yaml(state))
    subprocess.run(["/usr/lib/camera_calibration_parsers/convert", tmp_path / "cam.yaml", tmp_path / "out.yaml"], check=True, capture_output=True)
    info = yaml.safe_load((tmp_path / "out.yaml").read_text())
    assert (info["camera_name"], info["image_width"], info["image_height"], info["distortion_model"]) == ("cam", 640, 480, model)
    assert [float(v) for v in info["distortion_coefficients"]["data"]] == lens["coefficients"]
    for key, values in (("camera_matrix", state.k), ("rectification_matrix", state.r), ("projection_matrix", state.p)):
        assert tuple(info[key]["data"]) == values


def test_a_lens_without_a_name_in_ros_is_refused():
    with pytest.raises(camrig.CamrigError) as caught:
        CameraState.of(reply(lens={"model": "orthographic", "coefficients": []}))
    assert caught.value.kind == "unsupported"


@pytest.mark.parametrize("fps, rate", [(25, Fraction(25)), ("30000/1001", Fraction(30000, 1001)), (12.5, Fraction(25, 2)), (0.1, Fraction(1, 10))])
def test_next_due_walks_the_grid_of_the_contract(fps, rate):
    state = CameraState.of(reply(fps=fps))
    assert state.rate == rate
    now_ns = -1
    for n in range(2000):
        now_ns = state.next_due_ns(now_ns)
        assert now_ns == n * rate.denominator * 10**9 // rate.numerator
    assert state.next_due_ns(now_ns - 1) == now_ns


def test_a_camera_with_a_phase_has_its_frames_later():
    late = CameraState.of(reply(fps=10, clock={"phase_ns": 70_000_000, "rate_ppb": 0}))
    assert [late.due_count(after_ns, 1_000_000_000) for after_ns in (0, 870_000_000, 969_999_999, 970_000_000)] == [10, 1, 1, 0]
    assert CameraState.of(reply(fps=10)).due_count(970_000_000, 1_000_000_000) == 1


def test_the_optical_frame_looks_along_the_x_axis_of_the_link():
    x, y, z, w = OPTICAL_FROM_LINK
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    right, down, forward = rotation.T  # axes of the optical frame, in the link's: x forward, y left, z up
    assert np.allclose([right, down, forward], [[0, -1, 0], [0, 0, -1], [1, 0, 0]])


@pytest.mark.parametrize("clock", [{"phase_ns": 1_000_000}, {"rate_ppb": -1_000_000}, {"trigger_jitter_ns": 20_000_000}])
def test_no_step_passes_two_exposures_of_a_clock_that_moves_them(clock):
    """They are half a period apart and a thousandth less, at the least."""
    state = CameraState.of(reply(fps=25, clock=clock))
    assert 0 < state.next_due_ns(10**9) - 10**9 < 19_900_000


def test_a_clock_that_only_says_wrong_times_leaves_the_grid_as_it_is():
    state = CameraState.of(reply(fps=25, clock={"offset_ns": 5, "phase_ns": 0, "rate_ppb": 0, "trigger_jitter_ns": 0}))
    assert state.next_due_ns(10**9) == 1_040_000_000

"""The C++ client library as its users get it: installed, found by CMake from outside, against a running rig."""

import concurrent.futures
import json
import os
import subprocess

import cv2
import numpy as np
import pytest

from conftest import REPOSITORY, wait_until
from test_docs import blocks
from test_install import BUILD, CAMRIG, run
from virtual_display import VirtualDisplay

pytestmark = [pytest.mark.slow, pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep", args=["--quality", "fast"])]


# Writes a camera's optical flow: as it comes, then as a cv::Mat.
FLOW_OF = """
#include <iostream>
#include <camrig/client.h>
#include <camrig/opencv.h>
int main(int, char** arguments) {
    const auto camera = camrig::client::connect().camera(arguments[1]);
    const auto flow = camera.flow();
    const cv::Mat picture = to_mat(flow);
    if (flow.pixels != "flow32f" || picture.type() != CV_32FC2) return 1;
    std::cout.write(reinterpret_cast<const char*>(flow.data.data()), static_cast<std::streamsize>(flow.data.size()));
    std::cout.write(reinterpret_cast<const char*>(picture.data), static_cast<std::streamsize>(picture.total() * picture.elemSize()));
}
"""


@pytest.fixture(scope="module")
def programs(tmp_path_factory):
    """The folder of the examples and the probe below, built against an installed and then moved camrig."""
    folder = tmp_path_factory.mktemp("client")
    run("cmake", "--build", BUILD, "--target", "camrig_client_package", "wheel")
    run("cmake", "--install", BUILD, "--prefix", folder / "usr")
    (folder / "usr").rename(folder / "elsewhere")
    run("cp", "-r", REPOSITORY / "examples", folder / "examples")  # nothing beside them can be found by accident
    # The programs of the documents too: they must at least be ones.
    program = blocks("docs/cpp-client.md", "cpp")[0]
    (folder / "examples" / "from_docs.cpp").write_text(program)
    readme = blocks("README.md", "cpp")[0]
    (folder / "examples" / "from_readme.cpp").write_text("#include <iostream>\n" + readme.replace("const auto rig", "int main() {\nconst auto rig") + "}\n")
    (folder / "examples" / "flow_of.cpp").write_text(FLOW_OF)
    with (folder / "examples" / "CMakeLists.txt").open("a") as more:
        more.write("foreach(one from_docs from_readme flow_of)\nadd_executable(${one} ${one}.cpp)\ntarget_link_libraries(${one} camrig::opencv)\nendforeach()\n")
    run("cmake", "-S", folder / "examples", "-B", folder / "build", f"-DCMAKE_PREFIX_PATH={folder / 'elsewhere'}", "-DCMAKE_CXX_FLAGS=-Wall -Wextra -Werror",
        "-DCMAKE_BUILD_TYPE=Debug")
    run("cmake", "--build", folder / "build", "-j", os.cpu_count())
    return folder / "build"


@pytest.fixture
def environment(rig):
    return dict(os.environ, CAMRIG_CONTROL=rig.info()["control"])


def test_the_first_camera_is_short_and_takes_the_picture_that_the_rig_shows(programs, rig, environment, tmp_path):
    assert len((REPOSITORY / "examples/first_camera.cpp").read_text().splitlines()) < 40
    said = run(programs / "first_camera", tmp_path / "first.png", env=environment)
    assert said.startswith("frame ") and "640x480" in said
    cam = rig.create_camera("again", size=(640, 480), vfov_deg=60, position=(2, 3, 2.8), look_at=(12, 9, 1))
    assert np.array_equal(cv2.imread(str(tmp_path / "first.png")), cam.frame().image)
    assert "first" not in [camera.name for camera in rig.cameras()]


def test_the_menu_of_the_dummy_camera_needs_no_display(programs, rig, environment, tmp_path):
    environment.pop("DISPLAY", None)
    rig.create_camera("dummy", size=(320, 240), position=(4, 9, 1.7), pan_deg=90)
    menu = subprocess.run([programs / "dummy_camera", "dummy"], input=f"ww\nj\n+\nz\nx 0.5\np {tmp_path / 'seen.png'}\nq\n", env=environment,
                          capture_output=True, text=True, timeout=60, check=True).stdout
    assert "no command 'z'" in menu and "the world is at 0.5 s" in menu
    state = rig.camera("dummy").get()  # not its own: it stays
    assert state["pose"]["position"] == pytest.approx([4, 10, 1.7])
    assert state["pose"]["pan_deg"] == pytest.approx(95) and state["vfov_deg"] == pytest.approx(60 / 1.1)
    assert np.array_equal(cv2.imread(str(tmp_path / "seen.png")), rig.camera("dummy").frame().image)


def test_a_camera_of_its_own_is_deleted_when_the_menu_ends(programs, rig, environment):
    subprocess.run([programs / "dummy_camera", "mine"], input="w\n", env=environment, capture_output=True, text=True, timeout=60, check=True)
    assert "mine" not in [camera.name for camera in rig.cameras()]


@pytest.mark.camrig(scene="scenes/hall.json", mode="realtime", args=["--quality", "fast"])
def test_the_programs_of_the_documents_run(programs, rig, environment):
    said = run(programs / "from_docs", env=environment)
    *objects, last = said.splitlines()
    assert last.startswith("shows from ") and {'"hall"', '"anna"'} <= {line.split()[0] for line in objects}
    assert "mine" not in [camera.name for camera in rig.cameras()]
    assert run(programs / "from_readme", env=environment).splitlines()[0] == f"lobby {rig.camera('lobby').url('rtsp')}"


def test_optical_flow_is_that_of_python(programs, rig, environment):
    cam = rig.create_camera("turns", size=(320, 240), fps=25, position=(4, 9, 1.7), pan_deg=0)
    rig.call("camera.set", name="turns", pose={"position": [5, 9, 1.7], "pan_deg": 20}, seconds=1)
    rig.step(seconds=0.4)
    raw, mat = np.frombuffer(subprocess.run([programs / "flow_of", "turns"], env=environment, capture_output=True, timeout=60, check=True).stdout,
                             np.float32).reshape(2, 240, 320, 2)
    flow = cam.flow()
    assert np.nanmax(np.abs(flow)) > 2
    assert np.array_equal(raw, flow, equal_nan=True) and np.array_equal(mat, flow, equal_nan=True)


def test_errors_are_one_line_that_says_what_to_do(programs, tmp_path):
    done = subprocess.run([programs / "first_camera"], env=dict(os.environ, CAMRIG_CONTROL=str(tmp_path / "none")), capture_output=True, text=True, timeout=60)
    assert done.returncode == 1 and len(done.stderr.splitlines()) == 1 and "camrig serve SCENE" in done.stderr


def test_the_window_of_the_dummy_camera_moves_it_by_button_and_key(programs, rig, environment):
    cam = rig.create_camera("dummy", size=(640, 480), position=(2, 3, 2.8), look_at=(12, 9, 1))
    before = cam.get()["pose"]
    with VirtualDisplay(900, 700) as display:
        environment["DISPLAY"] = display.name
        window = subprocess.Popen([programs / "dummy_camera", "dummy", "--window"], env=environment)
        try:
            display.wait_window("camrig: dummy")
            display.move_window("camrig: dummy", 0, 0)
            wait_until(lambda: np.abs(display.picture()[0:480, 0:640].astype(int) - cam.frame().image).mean() < 2, what="the live picture")
            display.click(75, 480 + 18)  # the first button: ahead
            wait_until(lambda: cam.get()["pose"]["position"] != before["position"], what="the button")
            display.key("j")
            wait_until(lambda: cam.get()["pose"]["pan_deg"] == pytest.approx(before["pan_deg"] + 5), what="the key")
            shown = cam.frame().image
            wait_until(lambda: np.abs(display.picture()[0:480, 0:640].astype(int) - shown).mean() < 2, what="the new picture")
            display.key("q")
            assert window.wait(20) == 0
        finally:
            window.kill()
            window.wait()


def test_cpp_python_and_cli_that_change_one_camera_at_once_all_see_the_final_state(programs, rig, environment):
    """Who writes last wins, whole: no client may be left with a state that the rig does not have."""
    rig.create_camera("shared", size=(320, 240), position=(4, 9, 1.7), pan_deg=0)

    def cpp():
        with subprocess.Popen([programs / "dummy_camera", "shared"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment, text=True) as menu:
            said, _ = menu.communicate("j\n" * 40 + "q\n", timeout=60)
        return said

    def python():
        for i in range(40):
            rig.camera("shared").set(vfov_deg=40 + i)

    def cli():
        for i in range(8):
            run(CAMRIG, "camera", "set", "shared", "--fps", 10 + i, env=environment)

    with concurrent.futures.ThreadPoolExecutor() as pool:
        for done in [pool.submit(one) for one in (cpp, python, cli)]:
            done.result()
    # Each wrote what the others did not, so all of it is there.
    state = rig.camera("shared").get()
    assert (state["vfov_deg"], state["fps"]) == (pytest.approx(79), 17) and state["pose"]["pan_deg"] == pytest.approx(-160)
    assert json.loads(run(CAMRIG, "--json", "camera", "get", "shared", env=environment)) == state
    seen_by_cpp = subprocess.run([programs / "dummy_camera", "shared"], input="q\n", env=environment, capture_output=True, text=True, timeout=60, check=True).stdout
    assert "pan -160.0" in seen_by_cpp and "field of view 79.0" in seen_by_cpp
    # And of what all wrote, all see the same one value.
    with concurrent.futures.ThreadPoolExecutor() as pool:
        for done in [pool.submit(run, CAMRIG, "camera", "set", "shared", "--vfov-deg", 50 + i, env=environment) for i in range(3)]:
            done.result()
    final = rig.camera("shared").get()["vfov_deg"]
    assert final in [pytest.approx(50 + i) for i in range(3)]
    assert json.loads(run(CAMRIG, "--json", "camera", "get", "shared", env=environment))["vfov_deg"] == final


def test_a_component_that_is_not_there_is_named(programs, tmp_path):
    (tmp_path / "CMakeLists.txt").write_text("cmake_minimum_required(VERSION 3.16)\nproject(x CXX)\nfind_package(camrig REQUIRED COMPONENTS opencv telepathy)\n")
    done = subprocess.run(["cmake", "-S", tmp_path, "-B", tmp_path / "build", f"-DCMAKE_PREFIX_PATH={programs.parent / 'elsewhere'}"], capture_output=True, text=True,
                          timeout=60, check=False)
    assert done.returncode != 0 and "telepathy" in done.stderr

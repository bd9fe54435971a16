#!/usr/bin/env python3
"""Prints when each picture of an RTSP stream was taken. Standard library only.

    python3 docs/examples/rtsp_times.py rtsp://127.0.0.1:8554/lobby 25

Two ways lead to the time of a picture, and both are shown:
* every stream, H.264 or MJPEG: RTP stamps count 90000 ticks a second, and RTCP sender reports name the absolute time of a
  tick, so   time = report.time + (stamp - report.stamp) / 90000   (RFC 3550);
* H.264: each picture carries a message (SEI user_data_unregistered) with sequence, world time, CLOCK_MONOTONIC and absolute
  time. It stays in recordings.
"""

import hashlib
import socket
import struct
import sys
import urllib.parse
from typing import Iterator, NamedTuple, Optional

UUID = bytes.fromhex("7353d587fbca489f8f46ebe016b7c52e")
NTP_1970 = 2_208_988_800
TICKS_PER_S = 90_000


class Times(NamedTuple):
    """What the message in an H.264 picture says."""
    sequence: int
    world_ns: int
    monotonic_ns: int
    realtime_ns: int


class Picture(NamedTuple):
    stamp: int  # RTP time
    payloads: list[bytes]  # of its RTP packets
    realtime_ns: Optional[int]  # when it was taken, by stamps and reports; None before the first report
    times: Optional[Times]


class RtspReader:
    """One client of one stream, over TCP."""

    def __init__(self, url: str, timeout_s: float = 30.0):
        parts = urllib.parse.urlsplit(url)
        self.url = f"rtsp://{parts.hostname}:{parts.port or 554}{parts.path}"
        self.user, self.password = parts.username, parts.password
        self.socket = socket.create_connection((parts.hostname, parts.port or 554), timeout_s)
        self.data = b""
        self.challenge = self.session = None
        self.number = 0
        self.report: Optional[tuple[int, int]] = None  # (RTP time, ns since 1970)
        self.sdp = self.ask("DESCRIBE", self.url, Accept="application/sdp")
        controls = [line[10:] for line in self.sdp.splitlines() if line.startswith("a=control:") and line != "a=control:*"]
        track = controls[-1] if "://" in controls[-1] else f"{self.url}/{controls[-1]}"
        self.ask("SETUP", track, Transport="RTP/AVP/TCP;unicast;interleaved=0-1")
        self.ask("PLAY", self.url, Range="npt=0-")

    def ask(self, method: str, url: str, **headers: str) -> str:
        """Sends a request and gives the body of the answer; pictures that come in between are skipped."""
        self.number += 1
        headers["CSeq"] = str(self.number)
        if self.session:
            headers["Session"] = self.session
        if self.challenge:
            headers["Authorization"] = self.digest(method, url)
        lines = [f"{method} {url} RTSP/1.0", *(f"{key}: {value}" for key, value in headers.items()), "", ""]
        self.socket.sendall("\r\n".join(lines).encode())
        while self.take(1) == b"$":
            self.take(struct.unpack("!BH", self.take(3))[1])
        head = b"R"
        while not head.endswith(b"\r\n\r\n"):
            head += self.take(1)
        status, *fields = head.decode().split("\r\n")
        answer = {key.lower(): value for key, value in (field.split(": ", 1) for field in fields if field)}
        self.answer = answer  # the header fields of the last one
        body = self.take(int(answer.get("content-length", 0))).decode()
        if status.split()[1] == "401" and self.user and not self.challenge:
            parts = answer["www-authenticate"].removeprefix("Digest ").split(",")
            self.challenge = {key.strip(): value.strip('"') for key, value in (part.split("=", 1) for part in parts)}
            return self.ask(method, url, **{key: value for key, value in headers.items() if key != "CSeq"})
        if status.split()[1] != "200":
            raise ConnectionError(f"{method} {url}: {status}")
        self.session = answer.get("session", self.session or "").split(";")[0] or None
        return body

    def digest(self, method: str, url: str) -> str:
        md5 = lambda text: hashlib.md5(text.encode()).hexdigest()
        realm, nonce = self.challenge["realm"], self.challenge["nonce"]
        response = md5(f"{md5(f'{self.user}:{realm}:{self.password}')}:{nonce}:{md5(f'{method}:{url}')}")
        return f'Digest username="{self.user}", realm="{realm}", nonce="{nonce}", uri="{url}", response="{response}"'

    def take(self, size: int) -> bytes:
        while len(self.data) < size:
            more = self.socket.recv(1 << 16)
            if not more:
                raise EOFError("the server closed the connection")
            self.data += more
        taken, self.data = self.data[:size], self.data[size:]
        return taken

    def pictures(self) -> Iterator[Picture]:
        """Pictures until the stream ends (RTCP BYE, or the connection goes)."""
        payloads: list[bytes] = []
        while True:
            try:
                magic, channel, size = struct.unpack("!cBH", self.take(4))
                packet = self.take(size)
            except (EOFError, ConnectionError):
                return
            if magic != b"$":
                raise ConnectionError(f"{packet[:20]!r} is no RTP")
            if channel == 1:
                if not self.read_reports(packet):
                    return
                continue
            first, kind, _, stamp, _ = struct.unpack_from("!BBHII", packet)
            start = 12 + 4 * (first & 0x0F)
            payloads.append(packet[start:])
            if kind & 0x80:  # the marker: last packet of the picture
                yield Picture(stamp, payloads, self.time_of(stamp), times_of(payloads))
                payloads = []

    def read_reports(self, packet: bytes) -> bool:
        """Keeps the newest sender report; False at a BYE."""
        while len(packet) >= 4:
            kind, words = struct.unpack_from("!xBH", packet)
            if kind == 200:
                seconds, fraction, stamp = struct.unpack_from("!III", packet, 8)
                self.report = stamp, (seconds - NTP_1970) * 10**9 + (fraction * 10**9 + (1 << 31) >> 32)
            elif kind == 203:
                return False
            packet = packet[4 * (words + 1):]
        return True

    def time_of(self, stamp: int) -> Optional[int]:
        if self.report is None:
            return None
        ticks = (stamp - self.report[0] + (1 << 31)) % (1 << 32) - (1 << 31)  # stamps wrap around
        return self.report[1] + ticks * 10**9 // TICKS_PER_S

    def close(self) -> None:
        self.socket.close()


def times_of(payloads: list[bytes]) -> Optional[Times]:
    """The message of an H.264 picture. It is far shorter than a packet, so it is never split."""
    for payload in payloads:
        payload = payload.replace(b"\0\0\3", b"\0\0")  # emulation prevention (H.264, 7.4.1)
        at = payload.find(UUID)
        if at >= 0 and len(payload) >= at + 48:
            return Times(*struct.unpack_from("!4q", payload, at + 16))
    return None


def main() -> None:
    if len(sys.argv) < 2:
        sys.exit("usage: rtsp_times.py rtsp://[camrig:TOKEN@]HOST:PORT/NAME [NUMBER OF PICTURES]")
    reader = RtspReader(sys.argv[1])
    wanted = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    for number, picture in enumerate(reader.pictures(), 1):
        by_report = f"{picture.realtime_ns / 1e9:.6f}" if picture.realtime_ns else "(no report yet)"
        message = picture.times
        inside = f"  sequence {message.sequence}  world {message.world_ns / 1e9:.6f} s  taken {message.realtime_ns / 1e9:.6f}" if message else ""
        print(f"stamp {picture.stamp:10d}  taken {by_report}{inside}")
        if number == wanted:
            break


if __name__ == "__main__":
    main()

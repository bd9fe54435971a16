"""Cameras that are due at the same instant show the same nanosecond: read from the pixels."""

import collections
import http.client
import threading
import urllib.request

import cv2
import numpy as np
import pytest

import camrig
from conftest import wait_until


def grid(fps_num, fps_den, until_ns):
    """Frame times of a rate, from the contract's formula."""
    n, times = 1, []
    while (t := n * fps_den * 10**9 // fps_num) <= until_ns:
        times.append(t)
        n += 1
    return times


class PartReader(threading.Thread):
    """Reads an MJPEG stream part by part, as HTTP; keeps headers and decoded code strips."""

    def __init__(self, url, until_sequence, read_codes=True):
        super().__init__(daemon=True)
        self.read_codes = read_codes
        self.parts = []
        self.until_sequence = until_sequence
        self.response = urllib.request.urlopen(url, timeout=60)
        self.first = self.read_part()

    def read_part(self):
        headers = {}
        while True:
            line = self.response.readline()
            if not line:
                return None
            line = line.strip()
            if line.startswith(b"--") or (not line and not headers):
                continue
            if not line:
                break
            key, value = line.split(b":", 1)
            headers[key.decode().lower()] = value.strip().decode()
        data = self.response.read(int(headers["content-length"]))
        return headers, data

    def run(self):
        part = self.first
        while part:
            headers, data = part
            image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
            sequence = int(headers["x-sequence"])
            if not self.parts or self.parts[-1][0] != sequence:  # a repeat while nothing new comes is no frame
                self.parts.append((sequence, int(headers["x-world-time-ns"]), int(headers["x-monotonic-ns"]), camrig.read_code(image) if self.read_codes else None))
            if sequence >= self.until_sequence:
                return
            try:
                part = self.read_part()
            except (ConnectionError, ValueError, http.client.HTTPException):
                return  # the stream ended


RATES = {"a": ("25", 25, 1), "b": ("10", 10, 1), "c": ("30000/1001", 30000, 1001), "d": ("5", 5, 1)}


@pytest.mark.camrig(scene="scenes/clock.json", mode="lockstep")
def test_four_rates_show_the_same_nanosecond_at_common_instants(rig):
    seconds = 2
    cameras = {name: rig.create_camera(name, size=(256, 192), fps=rate[0], code_strip=True) for name, rate in RATES.items()}
    due = {name: grid(num, den, seconds * 10**9) for name, (_, num, den) in RATES.items()}
    readers = {name: PartReader(cam.url(), until_sequence=len(due[name])) for name, cam in cameras.items()}
    for reader in readers.values():
        reader.start()
    rig.step(seconds=seconds)
    by_time = collections.defaultdict(dict)
    for name, reader in readers.items():
        reader.join(60)
        assert not reader.is_alive()
        frames = [part for part in reader.parts if part[1] > 0]
        assert [part[1] for part in frames] == due[name]  # every due frame, at its exact nanosecond, none twice
        for sequence, world_ns, monotonic_ns, code in frames:
            assert code is not None
            assert (code.sequence, code.time_ns) == (sequence, world_ns)  # pixels and headers agree
            by_time[world_ns][name] = monotonic_ns
    together = [stamps for stamps in by_time.values() if len(stamps) > 1]
    assert len(together) >= 5 * seconds  # 25, 10 and 5 frames/s meet every 200 ms
    assert all(len(set(stamps.values())) == 1 for stamps in together)  # one instant, one stamp
    for camera in rig.stats()["cameras"]:
        assert camera["due"] == camera["rendered"] + camera["dropped"]
        assert camera["dropped"] == 0
        for output in camera["outputs"]:
            for reader in output["readers"]:
                assert reader["offered"] == reader["delivered"] == len(due[camera["name"]])
                assert reader["dropped"] == 0


@pytest.mark.camrig(scene="scenes/clock.json", mode="realtime")
def test_in_real_time_the_books_balance_and_common_instants_agree(rig):
    cameras = {name: rig.create_camera(name, size=(256, 192), fps=rate[0], code_strip=True) for name, rate in RATES.items()}
    start = {name: cam.frame().sequence for name, cam in cameras.items()}
    readers = {name: PartReader(cam.url(), until_sequence=start[name] + int(3 * RATES[name][1] / RATES[name][2]))
               for name, cam in cameras.items()}
    for reader in readers.values():
        reader.start()
    stamps = collections.defaultdict(set)
    for name, reader in readers.items():
        reader.join(60)
        assert not reader.is_alive()
        for sequence, world_ns, monotonic_ns, code in reader.parts[1:]:
            assert (code.sequence, code.time_ns) == (sequence, world_ns)
            assert world_ns == sequence * RATES[name][2] * 10**9 // RATES[name][1]  # on the grid, also after drops
            stamps[world_ns].add(monotonic_ns)
    assert all(len(values) == 1 for values in stamps.values())
    for camera in rig.stats()["cameras"]:
        assert camera["due"] == camera["rendered"] + camera["dropped"]


def books(rig, cameras):
    """due, rendered and dropped of each camera, between two instants: a pause draws the one under way to its end."""
    names = {cam.name for cam in cameras}
    rig.pause()
    stats = rig.stats()
    rig.resume()
    return stats, {c["name"]: (c["due"], c["rendered"], c["dropped"]) for c in stats["cameras"] if c["name"] in names}


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime", args=["--overload", "drop"])
def test_overload_drops_whole_instants_for_all_cameras_evenly(rig):
    cameras = [rig.create_camera(f"c{i}", size=(1280, 720), fps=60) for i in range(8)]
    readers = [PartReader(cam.url(), until_sequence=10**9, read_codes=False) for cam in cameras]
    for reader in readers:
        reader.start()
    _, before = books(rig, cameras)
    rendered_by = lambda name: next(c["rendered"] for c in rig.stats()["cameras"] if c["name"] == name)
    wait_until(lambda: rendered_by("c0") >= before["c0"][1] + 60, 120, "60 instants")
    stats, after = books(rig, cameras)
    counted = {name: tuple(b - a for a, b in zip(before[name], after[name])) for name in before}
    assert len(set(counted.values())) == 1, counted  # all cameras lost the very same instants
    due, rendered, dropped = counted["c0"]
    assert due == rendered + dropped
    assert dropped > 0 and stats["dropped_instants"] > 0, "this machine was too fast for the test to mean anything; raise the load"
    for cam in cameras:
        cam.delete()
    for reader in readers:
        reader.join(60)
        assert not reader.is_alive()
        numbers = [part[0] for part in reader.parts]
        assert numbers == sorted(set(numbers))


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime", args=["--overload", "slow"])
def test_policy_slow_slows_the_world_and_drops_no_instant(rig):
    cameras = [rig.create_camera(f"c{i}", size=(1280, 720), fps=60) for i in range(8)]
    readers = [PartReader(cam.url(), until_sequence=cam.frame().sequence + 60, read_codes=False) for cam in cameras]
    for reader in readers:
        reader.start()
    for reader in readers:
        reader.join(120)
        assert not reader.is_alive()
    stats = rig.stats()
    assert stats["dropped_instants"] == 0
    assert all(camera["dropped"] == 0 for camera in stats["cameras"])

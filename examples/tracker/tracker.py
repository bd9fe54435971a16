"""Follows a walking person with a pan/tilt head, as any client of a network camera would: pictures by RTSP, the head by ONVIF. README.md explains it."""

import argparse
import asyncio
import collections
import contextlib
import os
import threading
import time

os.environ.setdefault("OPENCV_FFMPEG_CAPTURE_OPTIONS", "rtsp_transport;tcp|fflags;nobuffer|flags;low_delay|threads;1")  # no picture waits
import cv2  # noqa: E402  (reads the line above when it is loaded)
import numpy as np  # noqa: E402
from onvif import ONVIFCamera  # noqa: E402

FOV = "http://www.onvif.org/ver10/tptz/PanTiltSpaces/TranslationSpaceFov"  # moves in halves of the picture
SETTLE_S = 0.5  # what the head is off is made good in so long
LOST_S = 1.5    # so long it goes on without seeing the person; so long again it stands before it goes home


class Stream(threading.Thread):
    """Reads all pictures and keeps the newest: (time of arrival, picture)."""

    def __init__(self, uri):
        super().__init__(daemon=True)
        self.capture, self.newest, self.done = cv2.VideoCapture(uri, cv2.CAP_FFMPEG), None, False
        self.start()

    def run(self):
        while not self.done and (read := self.capture.read())[0]:
            self.newest = time.monotonic(), read[1]
        self.done = True


class Head:
    """A head by ONVIF. Places are (pan, tilt) in its own units: right and up positive, -1 to 1 from end to end of its way."""

    def __init__(self, ptz, profile):
        self.ptz, self.profile = ptz, {"ProfileToken": profile}
        self.seen = collections.deque(maxlen=400)  # (time, place), as it told
        self.told = collections.deque([(0.0, np.zeros(2))], maxlen=50)  # (time from which on, speed in places a second)

    async def look(self):
        """Where it is now, and whether it moves. Round heads go on counting past the end of their scale."""
        await asyncio.sleep(0.01)
        before = time.monotonic()
        status = await self.ptz.GetStatus(self.profile)
        place = np.array([status.Position.PanTilt.x, status.Position.PanTilt.y])
        if self.seen:
            place[0] += 2 * round((self.seen[-1][1][0] - place[0]) / 2)
        self.seen.append(((before + time.monotonic()) / 2, place))
        return place, status.MoveStatus.PanTilt == "MOVING"

    def at(self, when):
        """Where it was at a time, by what it told; where it will be, by what it was told."""
        times, places = zip(*self.seen)
        if when <= times[-1]:
            return np.array([np.interp(when, times, one) for one in np.transpose(places)])
        now, place, speed = times[-1], places[-1], self.told[0][1]
        for begin, following in [*self.told, (when, None)]:
            if min(begin, when) > now:
                place, now = place + speed * (min(begin, when) - now), min(begin, when)
            speed = following
        return place

    async def move(self, operation, **how):
        """Tells it, and waits until it stands."""
        asked, start, latency = time.monotonic(), self.seen[-1][1], 0.0
        await getattr(self.ptz, operation)({**self.profile, **how})
        while (now := await self.look())[1]:
            if np.abs(now[0] - start).max() < 1e-3:
                latency = time.monotonic() - asked
        return np.abs(now[0] - start), latency

    async def measure(self):
        """What a client must find out about a head that it does not know: half a picture in places, its latency, its full speed."""
        home, _ = await self.look()
        (right, _), self.latency = await self.move("RelativeMove", Translation={"PanTilt": {"x": 1, "y": 0, "space": FOV}})
        (_, down), _ = await self.move("RelativeMove", Translation={"PanTilt": {"x": 0, "y": -1, "space": FOV}})
        self.half = np.array([right, down])
        await self.ptz.ContinuousMove({**self.profile, "Velocity": {"PanTilt": {"x": -0.2, "y": 0.2}}})
        begin = time.monotonic() + self.latency + 0.2  # it has its speed by then
        while time.monotonic() < begin + 0.5:
            await self.look()
        self.full = abs(self.at(begin + 0.4) - self.at(begin)) / 0.4 / 0.2
        await self.move("AbsoluteMove", Position={"PanTilt": {"x": home[0], "y": home[1]}})

    async def go(self, speed):
        x, y = (float(one) for one in np.clip(speed / self.full, -1, 1))
        await self.ptz.ContinuousMove({**self.profile, "Velocity": {"PanTilt": {"x": x, "y": y}}})
        self.told.append((time.monotonic() + self.latency, np.array([x, y]) * self.full))


if not hasattr(cv2, "HOGDescriptor"):
    raise SystemExit(f"this OpenCV {cv2.__version__} has no HOG people detector: pip install 'opencv-python<5', or opencv-contrib-python in its place")
HOG = cv2.HOGDescriptor()
HOG.setSVMDetector(cv2.HOGDescriptor.getDefaultPeopleDetector())


def find(picture, near=None):
    """Middle of the likeliest person, -1 to 1 to the right and upwards, or None. `near`: where one is expected, or None for anywhere."""
    height, width = picture.shape[:2]
    left = 0 if near is None else int(np.clip((near[0] + 1) / 2 * width - width / 4, 0, width / 2))
    boxes, scores = HOG.detectMultiScale(picture[:, left:left + (width if near is None else width // 2)], winStride=(8, 8), scale=1.1, hitThreshold=0.2)
    middles = [np.array([(left + x + w / 2) / width * 2 - 1, 1 - (y + h / 2) / height * 2]) for x, y, w, h in boxes]
    likely = [float(score) - (0 if near is None else 4 * np.linalg.norm(middle - near)) for middle, score in zip(middles, scores)]
    return middles[np.argmax(likely)] if likely and max(likely) > -1 else None


async def follow(head, stream, age, seconds):
    """Person and head are compared where both are known: at the time that a picture shows. What follows is said for when it will be done."""
    place, last, end = None, None, time.monotonic() + seconds
    while time.monotonic() < end and not stream.done:
        await head.look()
        if stream.newest is last:
            continue
        last = stream.newest
        shown = last[0] - age
        expected = None if place is None else place + speed * (shown - seen)
        near = None if place is None or shown - seen > LOST_S / 2 else (expected - head.at(shown)) / head.half
        found = await asyncio.to_thread(find, last[1], near)
        if found is not None:
            there = head.at(shown) + found * head.half
            if place is None:
                place, speed, seen = there, np.zeros(2), shown
            else:  # an alpha-beta filter: place and speed of the person
                wrong, passed = there - expected, max(shown - seen, 0.02)
                place, speed, seen = expected + 0.4 * wrong, speed + 0.06 * wrong / passed, shown
        if place is None:
            continue
        then = time.monotonic() + head.latency
        if then - seen > 2 * LOST_S:
            place = None
            await head.ptz.GotoHomePosition(head.profile)
        else:
            is_lost = then - seen > LOST_S
            await head.go(np.zeros(2) if is_lost else speed + (place + speed * (then - seen) - head.at(then)) / SETTLE_S)
    await head.ptz.Stop({**head.profile, "PanTilt": True, "Zoom": True})


async def main(options, watch):
    camera = ONVIFCamera(options.host, options.port, options.user, options.password)
    await camera.update_xaddrs()
    media, ptz = await camera.create_media_service(), await camera.create_ptz_service()
    profile = next(one for one in await media.GetProfiles() if one.PTZConfiguration)
    setup = {"Stream": "RTP-Unicast", "Transport": {"Protocol": "RTSP"}}
    stream = Stream((await media.GetStreamUri({"StreamSetup": setup, "ProfileToken": profile.token})).Uri)
    head = Head(ptz, profile.token)
    await head.measure()
    print(f"half a picture is {head.half.round(3)}, the latency {head.latency:.2f} s, the full speed {head.full.round(3)} a second", flush=True)
    while not stream.done and (not stream.newest or find(stream.newest[1]) is None):
        await asyncio.sleep(0.1)  # until somebody comes
    with watch:
        await follow(head, stream, options.age, options.seconds)
    if stream.done:
        raise SystemExit("the pictures have ended")
    stream.done = True
    stream.join()
    await camera.close()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("host")
    parser.add_argument("port", type=int, help="of the camera's ONVIF device")
    parser.add_argument("--user", default="camrig")
    parser.add_argument("--password", default="")
    parser.add_argument("--seconds", type=float, default=60, help="from when somebody is found")
    parser.add_argument("--age", type=float, default=0.05, help="s from what a picture shows to its arrival here")
    parser.add_argument("--truth", metavar="CAMERA", help="of a camrig rig on this machine: say how well it went")
    arguments = parser.parse_args()
    if arguments.truth:
        from truth import Watch  # the only thing here that knows of camrig
    asyncio.run(main(arguments, Watch(arguments.truth) if arguments.truth else contextlib.nullcontext()))

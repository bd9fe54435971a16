"""How stock readers take faults: a campaign per reader, and the table of docs/faults.md made of the reports.

    python -m tools.bench.fault_readers --write

Without --write it prints the table. The readers are OpenCV's VideoCapture, opened anew when it gives no picture, ffmpeg, and GStreamer, by HTTP, RTSP
and from a user-space device, and one that reads a device as ROS usb_cam does. What our own probe says is the table of tools.bench.fault_probe.
"""

from __future__ import annotations

import argparse
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import camrig
import camrig.campaign
from camrig.campaign import Result
from camrig.rig import Rig

PAGE = Path(__file__).resolve().parents[2] / "docs" / "faults.md"
BEGIN, END = "<!-- readers, made by: python -m tools.bench.fault_readers --write -->", "<!-- readers end here -->"
HOLD_S, RECOVER_S, SILENCE_S = 4.0, 15.0, 1.0
AT_ONCE = 4

_OPENCV = """
import sys, time, cv2
while True:
    source = cv2.VideoCapture(sys.argv[1])
    while source.read()[0]: print("picture", flush=True)
    print("no picture: opens anew", flush=True)
    source.release(); time.sleep(0.2)
"""
_FFMPEG = ["ffmpeg", "-nostdin", "-hide_banner", "-loglevel", "info", "-nostats"]
_SHOW = ["-vf", "showinfo", "-f", "null", "-"]
_FFMPEG_TROUBLE = r"(?i)error|corrupt|invalid|overread|conceal|missing|missed|unexpected|expected"
_SINK = ["!", "fakesink", "silent=false", "sync=false"]
#: Column: (program, what it prints with each picture, what it prints in trouble).
READERS: dict[str, tuple[list[str], str, str]] = {
    "OpenCV, HTTP": ([sys.executable, "-c", _OPENCV, "{http}"], "^picture", "^no picture"),
    "OpenCV, RTSP": ([sys.executable, "-c", _OPENCV, "{rtsp}"], "^picture", "^no picture"),
    "OpenCV, device": ([sys.executable, "-c", _OPENCV, "{device}"], "^picture", "^no picture"),
    "ffmpeg, HTTP": ([*_FFMPEG, "-i", "{http}", *_SHOW], "pts_time:", _FFMPEG_TROUBLE),
    "ffmpeg, RTSP": ([*_FFMPEG, "-rtsp_transport", "tcp", "-i", "{rtsp}", *_SHOW], "pts_time:", _FFMPEG_TROUBLE),
    "ffmpeg, device": ([*_FFMPEG, "-f", "v4l2", "-i", "{device}", *_SHOW], "pts_time:", _FFMPEG_TROUBLE),
    "GStreamer, RTSP": (["gst-launch-1.0", "-v", "rtspsrc", "location={rtsp}", "protocols=tcp", "latency=0", "!", "decodebin", *_SINK], "chain ", "ERROR|WARN"),
    "GStreamer, device": (["gst-launch-1.0", "-v", "v4l2src", "device={device}", *_SINK], "chain ", "ERROR|WARN"),
    "as usb_cam, device": ([sys.executable, str(Path(__file__).with_name("usb_cam_reader.py")), "{device}"], "^picture", "exiting"),
}
FAULTS: list[dict[str, Any]] = [
    {"kind": "black"},
    {"kind": "freeze"},
    {"kind": "drop"},
    {"kind": "duplicate"},
    {"kind": "reduced_rate"},
    {"kind": "drop", "name": "drop, bursts of 50", "severity": 0.9, "params": {"probability": 1, "burst_frames": 50}},
    {"kind": "corrupt_jpeg", "name": "corrupt_jpeg, bitflip"},
    {"kind": "corrupt_jpeg", "name": "corrupt_jpeg, truncate", "params": {"mode": "truncate"}},
    {"kind": "corrupt_video", "name": "corrupt_video, bitflip"},
    {"kind": "corrupt_video", "name": "corrupt_video, drop_idr", "params": {"mode": "drop_idr", "probability": 1}},
    {"kind": "other_size"},
    {"kind": "late", "name": "late, bursts of 12", "params": {"frames": 12, "in_bursts": True}},
    {"kind": "bandwidth", "params": {"kbit_per_s": 100}},
    {"kind": "tearing"},
    {"kind": "stall"},
    {"kind": "disconnect"},
    {"kind": "refuse"},
    {"kind": "restart"},
    {"kind": "cut_part", "params": {"probability": 1}},
    {"kind": "bad_part", "name": "bad_part, length", "params": {"probability": 1}},
    {"kind": "bad_part", "name": "bad_part, boundary", "params": {"mode": "boundary", "probability": 1}},
    {"kind": "packet_loss"},
    {"kind": "packet_reorder"},
    {"kind": "packet_delay", "params": {"jitter_s": 0.1}},
    {"kind": "new_ssrc", "params": {"period_s": 1}},
    {"kind": "buffer_error", "params": {"probability": 1}},
    {"kind": "wrong_size"},
    {"kind": "device_error", "name": "device_error, qbuf"},
    {"kind": "device_error", "name": "device_error, streaming", "params": {"at": "streaming"}},
    {"kind": "unplug"},
]
#: Of these, the ones that are measured now.
FAULTS_MEASURED = list(FAULTS)
#: Faults of one way to readers are tried on those that read by it.
ONLY = {"corrupt_jpeg": "HTTP", "corrupt_video": "RTSP", "cut_part": "HTTP", "bad_part": "HTTP", "packet_loss": "RTSP", "packet_reorder": "RTSP", "packet_delay": "RTSP", "new_ssrc": "RTSP", "other_size": "HTTP", "device_error": "device", "buffer_error": "device",
        "wrong_size": "device", "unplug": "device"}


def run_reader(rig: Rig, number: int) -> dict[str, Result]:
    """Results by row, of the reader of this number."""
    name, (program, well, troubled) = list(READERS.items())[number]
    faults = [fault for fault in FAULTS_MEASURED if ONLY.get(fault["kind"], "") in name]
    if not faults:
        return {}
    outputs = [{"kind": "mjpeg"}, {"kind": "rtsp"}, {"kind": "device", "number": 210 + number}]
    report = camrig.campaign.run(rig, camrig.campaign.load({
        "name": name, "faults": faults, "program": program, "check": {"well": well, "troubled": troubled, "every_s": SILENCE_S},
        "camera": {"name": f"reader{number}", "size": [320, 240], "fps": 15, "outputs": outputs},
        "hold_s": HOLD_S, "recover_s": RECOVER_S, "stays_s": 1.0,
    }), lambda result: print(f"{name}: {result.row}: {result.outcome} {result.noticed_s}", file=sys.stderr, flush=True))
    return {result.row: result for result in report.results}


def said(result: Result | None) -> str:
    """A cell of the table."""
    if result is None:
        return ""
    if result.outcome == "refused":
        return "refused"
    if result.outcome == "unnoticed":
        return "reads on"
    if result.outcome == "ended":
        return f"ends after {result.ended_s:.1f} s, code {result.exit_code}"
    noticed = "" if result.noticed_s is None else f"{result.noticed_s:.1f} s; "
    if result.outcome == "lost":
        return f"{noticed}not back"
    if result.outcome == "recovered":
        return f"{noticed}back " + (f"after {result.recovered_s:.1f} s" if result.recovered_s else "before its end")
    return result.outcome.replace("_", " ")


def title_of(fault: dict[str, Any]) -> str:
    """The first cell of its row."""
    kind, comma, more = str(fault.get("name", fault["kind"])).partition(",")
    return f"`{kind}`{comma}{more}"


def cells_of(lines: list[str]) -> dict[tuple[str, str], str]:
    """What a table of the page says, by (first cell of the row, column)."""
    split = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines if line.startswith("|")]
    return {(row[0], column): cell for row in split[2:] for column, cell in zip(split[0][1:], row[1:])}


def table(results: dict[str, dict[str, Result]], before: dict[tuple[str, str], str]) -> str:
    """`results`: by reader and row, of what was measured now; `before`: cells_of() the page, for the others."""
    lines = ["| fault | " + " | ".join(READERS) + " |", "|---" * (len(READERS) + 1) + "|"]
    for fault in FAULTS:
        row, title = fault.get("name", fault["kind"]), title_of(fault)
        cells = [said(results[reader][row]) if row in results.get(reader, {}) else before.get((title, reader), "") for reader in READERS]
        lines.append(f"| {title} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def put(made: str, begin: str, end: str, is_written: bool) -> None:
    """Puts a table between these marks of the page, or prints it."""
    if not is_written:
        print(made)
        return
    before, rest = PAGE.read_text().split(begin)
    PAGE.write_text(before + begin + "\n\n" + made + "\n\n" + end + rest.split(end)[1])


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tools.bench.fault_readers", description="how stock readers take faults")
    parser.add_argument("--write", action="store_true", help=f"into {PAGE.name}")
    parser.add_argument("--only", metavar="KIND", action="append", default=[], help="measure the rows of this kind; others stay as they are in the page")
    parser.add_argument("--reader", metavar="NAME", action="append", choices=list(READERS), default=[], help="measure this column; others stay as they are")
    options = parser.parse_args()
    if options.only:
        FAULTS_MEASURED[:] = [fault for fault in FAULTS if fault["kind"] in options.only]
    numbers = [number for number, name in enumerate(READERS) if name in (options.reader or READERS)]
    with camrig.start("scenes/minimal.json", mode="realtime") as rig, ThreadPoolExecutor(AT_ONCE) as pool:
        results = dict(zip([list(READERS)[number] for number in numbers], pool.map(lambda number: run_reader(rig, number), numbers)))
    before = PAGE.read_text().split(BEGIN)[1].split(END)[0]
    put(table(results, cells_of(before.splitlines())), BEGIN, END, options.write)
    return 0


if __name__ == "__main__":
    sys.exit(main())

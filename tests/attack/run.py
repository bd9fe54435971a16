#!/usr/bin/env python3
"""Attacks a running rig as strangers on this machine could, and says of each attack whether the rig stood it.

    tests/attack/run.py                all attacks, a quarter of an hour; one line each, exit 1 if one was not stood
    tests/attack/run.py -k rtsp        only attacks with this in their names; -k may be given again
    tests/attack/run.py --list         names them

While the attacks run, an ordinary MJPEG reader and an ordinary RTSP reader look at one camera: together they may lose at most
0.5 % of their frames, or one, and after all the rig may have at most 60 MiB more memory than before. Everything is bounded in count and
time and stays on the loopback interface. Needs CAMRIG_BIN or a build, and root for what other users of the machine try.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import camrig

from bystanders import Bystanders
from target import Target
import attacks_control
import attacks_devices
import attacks_ends
import attacks_files
import attacks_http
import attacks_models
import attacks_rtsp
import attacks_work

MOST_LOST = 0.005
MOST_GROWTH_MIB = 60
WATCHED_FPS = 10
SUITES = (attacks_work, attacks_control, attacks_http, attacks_rtsp, attacks_devices, attacks_files, attacks_models, attacks_ends)


def main() -> int:
    parser = argparse.ArgumentParser(description="Attacks a running rig and says what it stood.")
    parser.add_argument("-k", dest="only", action="append", help="only attacks with this, or one of these, in their names")
    parser.add_argument("--list", action="store_true", help="names the attacks")
    arguments = parser.parse_args()
    attacks = [attack for suite in SUITES for attack in suite.ATTACKS if any(text in attack.__name__ for text in arguments.only or [""])]
    if not attacks:
        parser.error(f"no attack has {' or '.join(arguments.only)} in its name; --list names them")
    if arguments.list:
        print("\n".join(f"{attack.__name__}: {attack.__doc__}" for attack in attacks))
        return 0

    failed = 0
    with tempfile.TemporaryDirectory(prefix="camrig-attack-") as folder, camrig.start("hall", tcp=0) as rig:
        target = Target(rig, Path(folder))
        rig.create_camera("watched", size=(320, 240), fps=WATCHED_FPS, place="lobby")
        target.settle()
        before_kib = target.rss_kib()
        with Bystanders(rig.camera("watched"), WATCHED_FPS) as bystanders:
            for attack in attacks:
                begin = time.monotonic()
                try:
                    said = attack(target) or ""
                    verdict = "stood "
                except Exception as problem:  # whatever went wrong, the other attacks are tried too
                    said, verdict = f"{type(problem).__name__}: {problem}".replace("\n", " ")[:300], "FAILED"
                    failed += 1
                print(f"{verdict} {attack.__name__} ({time.monotonic() - begin:.1f} s) {said}", flush=True)
                if not target.is_alive():
                    print(f"FAILED the rig ended; its log:\n{rig.log}")
                    return 1
        for name, expected, lost in bystanders.losses():
            # When the first and the last frame were due is known to a frame: of a short run, 0.5 % would be none. What the rig dropped
            # (dropped_for: overload, own_cost) is lost too: attacks that make it work too much are attacks.
            good = expected > 0 and lost <= max(1, MOST_LOST * expected)
            failed += not good
            print(f"{'stood ' if good else 'FAILED'} the {name} reader lost {lost} of {expected} frames")
        target.settle()
        grown_mib = (target.rss_kib() - before_kib) / 1024
        failed += grown_mib > MOST_GROWTH_MIB
        print(f"{'stood ' if grown_mib <= MOST_GROWTH_MIB else 'FAILED'} memory: {grown_mib:+.0f} MiB, {before_kib // 1024} before")
    print(f"{failed} not stood" if failed else "all stood")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())

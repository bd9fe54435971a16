#!/usr/bin/env python3
"""Finds tests that were skipped without leave: a skipped test proves nothing, and nobody reads that it was.

    tools/checks/skips.py RESULTS.xml...   JUnit files of ctest and pytest; one line per test, exit 1 if one was skipped that
                                           tests/allowed_skips.txt does not name, or if a file holds no test at all
"""

from __future__ import annotations

import fnmatch
import pathlib
import sys
import xml.etree.ElementTree as ElementTree

ALLOWED = pathlib.Path(__file__).resolve().parents[2] / "tests" / "allowed_skips.txt"


def allowed() -> list[str]:
    """The patterns of test names; what follows ':' is the reason, for people."""
    lines = (line.strip() for line in ALLOWED.read_text().splitlines())
    patterns = []
    for line in lines:
        if line and not line.startswith("#"):
            pattern, separator, reason = line.partition(": ")
            if not separator or not reason:
                raise SystemExit(f"{ALLOWED}: '{line}' gives no reason; write 'TEST: why it may be skipped'")
            patterns.append(pattern)
    return patterns


def main(files: list[str]) -> int:
    patterns, bad = allowed(), 0
    for file in files:
        cases = list(ElementTree.parse(file).iter("testcase"))
        if not cases:
            print(f"{file}: no test was run")
            bad += 1
        for case in cases:
            # ctest has no classes; it calls a test that was not run "notrun" and one that skipped itself "skipped".
            if case.find("skipped") is None and case.get("status") not in ("notrun", "disabled"):
                continue
            name = case.get("name", "")
            full = f"{case.get('classname', '')}.{name}" if case.get("classname") not in (None, "", name) else name
            if any(fnmatch.fnmatchcase(full, pattern) for pattern in patterns):
                continue
            reason = case.find("skipped")
            said = (reason.get("message") or "").strip() if reason is not None else ""
            print(f"{full}: skipped ({said or 'it says not why'}); a test that may be skipped stands in tests/allowed_skips.txt")
            bad += 1
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

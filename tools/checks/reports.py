#!/usr/bin/env python3
"""Holds the pages of measurements to what their scripts wrote last: no number in them is edited by hand.

    tools/checks/reports.py                one line per part that is missing, not sealed, or changed since; exit 1 if there is one
    tools/checks/reports.py --self-check   shows on made-up pages that changes are found and good pages pass

Parts, seals and who writes them: tools/bench/report.py.
"""

from __future__ import annotations

import re
import sys
import tempfile
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPOSITORY))
from tools.bench import report  # noqa: E402

#: The parts that a page must have. Every part of any page must be sealed.
PAGES = {
    "accuracy.md": "bounds curve detail shadows reprojection calibration stereo offset depth inverse lens_methods antialias textures colour jpeg h264",
    "backdrops.md": "place",
    "devices.md": "colours latency",
    "farm-model.md": "measured log moves batch",
    "farm-record.md": "kills",
    "farm.md": "live",
    "getting-started.md": "first_steps",
    "mutations.md": "mutations",
    "network.md": "strategies camsim",
    "quality.md": "pictures light cost",
    "speed.md": "targets cameras sizes outputs load overload sharing sensors limits kernels peers soak",
    "streams.md": "opening latency h264 h265 sub clients",
    "truth.md": "cost",
}
MARK = re.compile(r"<!-- (?:part|end of) (\w+)")


def faults(docs: Path, pages: dict[str, str] = PAGES) -> list[str]:
    found = []
    for path in sorted(docs.rglob("*.md")):
        text = path.read_text()
        parts = report.parts(text)
        for part in parts:
            if part.seal is None:
                found.append(f"{path}: part {part.name} has no seal; the script that its last line names writes it")
            elif not part.is_sealed:
                found.append(f"{path}: part {part.name} is not what its script wrote; run that again, or take the change back")
        whole = [part.name for part in parts]
        if broken := {name for name in MARK.findall(text) if MARK.findall(text).count(name) != 2 * whole.count(name)}:
            found.append(f"{path}: marks that do not belong together: {', '.join(sorted(broken))}")
        wanted = pages.get(str(path.relative_to(docs)), "").split()
        found += [f"{path}: part {name} is missing" for name in wanted if name not in whole]
    found += [f"{docs / page} is missing" for page in pages if not (docs / page).exists()]
    return found


def self_check() -> int:
    good = f"# Page\n<!-- part a -->\n| 1 |\n<!-- end of a, seal {report.seal_of('a', '| 1 |')} -->\n"
    cases = {
        good: True,
        good.replace("| 1 |", "| 2 |"): False,
        good.replace(", seal", ", sealed"): False,
        re.sub(", seal .* -->", " -->", good): False,
        good.replace("part a", "part b").replace("end of a", "end of b"): False,
        "# Page\n": False,
        good + good.replace("part a", "part b"): False,
    }
    wrong = 0
    for page, is_good in cases.items():
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "page.md").write_text(page)
            if (faults(Path(folder), {"page.md": "a"}) == []) != is_good:
                print(f"{'refused' if is_good else 'taken'}:\n{page}")
                wrong += 1
    return 1 if wrong else 0


def main() -> int:
    if sys.argv[1:] == ["--self-check"]:
        return self_check()
    found = faults(REPOSITORY / "docs")
    print("\n".join(found), end="\n" if found else "")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

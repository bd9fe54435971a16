"""Parts of the pages in docs that a script measured, each with what made it, and sealed.

    <!-- part NAME -->
    what was measured

    *Commit 0123456789, 2026-11-23; 2 cores of ..; drawn by ..; `the command that makes it again`.*
    <!-- end of NAME, seal 0123456789abcdef -->

The seal is the beginning of the SHA-256 of the part's name and text. tools/checks/reports.py finds what was edited by hand
since, so a page's numbers are those that its script wrote last.
"""

from __future__ import annotations

import contextlib
import datetime
import hashlib
import os
import re
import subprocess
from pathlib import Path
from typing import Any, Iterator, NamedTuple

REPOSITORY = Path(__file__).resolve().parents[2]
#: What a measurement depends on.
SOURCES = ("core", "control", "rtsp_out", "v4l2_sink", "tools", "scenes")
PART = re.compile(r"<!-- part (?P<name>\w+) -->\n(?P<text>.*?)\n<!-- end of (?P=name)(?:, seal (?P<seal>\w+))? -->", re.DOTALL)


class Part(NamedTuple):
    name: str
    text: str
    seal: str | None

    @property
    def is_sealed(self) -> bool:
        return self.seal == seal_of(self.name, self.text)


def seal_of(name: str, text: str) -> str:
    return hashlib.sha256(f"{name}\n{text}".encode()).hexdigest()[:16]


def parts(page: str) -> list[Part]:
    return [Part(found["name"], found["text"], found["seal"]) for found in PART.finditer(page)]


def machine() -> str:
    model = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
    return f"{os.cpu_count()} cores of {model[1].strip() if model else 'an unknown processor'}"


#: Renderers of the rigs since the last put().
_drew: set[str] = set()


@contextlib.contextmanager
def start(*arguments: Any, **options: Any) -> Iterator[Any]:
    """As camrig.start; the report will say what drew."""
    import camrig

    with camrig.start(*arguments, **options) as rig:
        yield rig
        # A rig tells what it began with; on a CPU Mesa draws what that does not (docs/quality.md), from when it is first needed.
        name = rig.call("server.info")["renderer"]
        _drew.add(name + (", what that does not draw by Mesa's llvmpipe" if name.startswith("camrig's rasteriser") and ";" not in name else ""))


def commit() -> str:
    def git(*arguments: str) -> str:
        return subprocess.run(["git", *arguments], cwd=REPOSITORY, capture_output=True, text=True, check=True).stdout.strip()

    return git("rev-parse", "--short=10", "HEAD") + (" and changes to it" if git("status", "--porcelain", "--", *SOURCES) else "")


def put(path: Path, name: str, text: str, by: str) -> None:
    """Renews a part of a page. `by`: how it is made again."""
    renderers = sorted(_drew)
    _drew.clear()
    made = [f"Commit {commit()}, {datetime.date.today()}", machine(), *(["drawn by " + " and ".join(renderers)] if renderers else []), by]
    text = f"{text.strip()}\n\n*{'; '.join(made)}.*"
    page = path.read_text()
    if name not in [part.name for part in parts(page)]:
        raise ValueError(f"{path} has no part {name}: it needs lines '<!-- part {name} -->' and '<!-- end of {name} -->' where it is to be")
    whole = f"<!-- part {name} -->\n{text}\n<!-- end of {name}, seal {seal_of(name, text)} -->"
    path.write_text(PART.sub(lambda found: whole if found["name"] == name else found[0], page))

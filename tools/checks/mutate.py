#!/usr/bin/env python3
"""Breaks the program at random places, one at a time, and sees whether a test notices.

    tools/checks/mutate.py                        40 mutations, seed 1; one line each, the survivors with their diff
    tools/checks/mutate.py --count 5 --seed 7 --only core/world
    tools/checks/mutate.py --show                 prints the mutations and changes nothing

Works on a copy of the last commit (a git worktree in build/mutate) with a build of its own. A mutation that does not compile does
not count and another is taken for it. Tests run from near to far: the test program of the same folder, the other test programs,
then the quick system tests; the first that fails, hangs or crashes has caught it. Exit 1 if one survived.
"""

from __future__ import annotations

import argparse
import os
import random
import re
import subprocess
import sys
from pathlib import Path
from typing import Iterator, NamedTuple

REPOSITORY = Path(__file__).resolve().parents[2]
COPY = REPOSITORY / "build" / "mutate"
FOLDERS = ("core", "control", "rtsp_out", "v4l2_sink", "tools/camrig", "tools/probe")
PROGRAM_LIMIT_S, SYSTEM_LIMIT_S = 300, 1500

#: What is replaced by what. Only in code: not in comments, strings, includes, templates' brackets.
OPERATORS: list[tuple[str, str]] = [
    (r" < ", " <= "), (r" <= ", " < "), (r" > ", " >= "), (r" >= ", " > "), (r" == ", " != "), (r" != ", " == "),
    (r" && ", " || "), (r" \|\| ", " && "), (r" \+ ", " - "), (r" - ", " + "), (r" \* ", " / "), (r" / ", " * "),
    (r"\btrue\b", "false"), (r"\bfalse\b", "true"), (r"\bstd::min\(", "std::max("), (r"\bstd::max\(", "std::min("),
    (r" \+= ", " -= "), (r" -= ", " += "), (r"\bif \((?!const|auto)", "if (!("), (r"(?<![\w.])0(?![\w.'])", "1"),
    (r"(?<![\w.])1(?![\w.'])", "2"), (r"\bcontinue;", "break;"),
]
#: A statement on one line, which is left out: a call or an assignment.
STATEMENT = re.compile(r"^\s+(?!return|break|continue|using|const|auto|static|std::|if|for|while|else|case|throw)[\w.>()\[\]-]+(\(.*\)| [+-]?= .*);$")
NOT_CODE = re.compile(r'^\s*(//|#|\*|static_assert|LOG|CHECK|template|using|namespace)|spdlog::|"')


class Mutation(NamedTuple):
    file: str
    line: int  # from 0
    before: str
    after: str

    def __str__(self) -> str:
        return f"{self.file}:{self.line + 1}: {self.before.strip()}  ->  {self.after.strip() or '(left out)'}"


def variants(line: str) -> Iterator[str]:
    if NOT_CODE.search(line):
        return
    code = line.split("//")[0]
    for pattern, replacement in OPERATORS:
        for found in re.finditer(pattern, code):
            if pattern.startswith(r"\bif"):
                # The whole condition, when it ends on this line.
                depth, at = 1, found.end()
                while at < len(code) and depth:
                    depth += {"(": 1, ")": -1}.get(code[at], 0)
                    at += 1
                if depth == 0 and ";" not in code[found.end():at]:
                    yield code[:found.start()] + "if (!(" + code[found.end():at] + ")" + code[at:]
                continue
            yield code[:found.start()] + replacement + code[found.end():]
    if STATEMENT.match(code):
        yield ""


def mutations(only: str, rng: random.Random) -> Iterator[Mutation]:
    """Without end, each folder as often as it has lines."""
    listed = subprocess.run(["git", "ls-files", *FOLDERS], cwd=REPOSITORY, capture_output=True, text=True, check=True).stdout.split()
    places = []
    for file in listed:
        if file.endswith((".cpp", ".h")) and file.startswith(only):
            places += [(file, number) for number, line in enumerate((REPOSITORY / file).read_text().splitlines()) if any(True for _ in variants(line))]
    if not places:
        raise SystemExit(f"nothing to mutate below '{only}'")
    while True:
        file, number = rng.choice(places)
        line = (REPOSITORY / file).read_text().splitlines()[number]
        yield Mutation(file, number, line, rng.choice(list(variants(line))))


def run(*command: str, limit_s: float, **options) -> bool:
    """Whether it ended well and in time."""
    try:
        return subprocess.run(command, cwd=COPY, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, timeout=limit_s, **options).returncode == 0
    except subprocess.TimeoutExpired:
        return False


def build() -> bool:
    return run("cmake", "--build", "--preset", "ci", "-j", str(os.cpu_count()), limit_s=3600)


def programs(file: str) -> list[Path]:
    """All test programs, those of the file's folder first."""
    folder = str(Path(file).parent)
    found = sorted(path for path in (COPY / "build/ci/tests").rglob("test_*") if path.is_file() and os.access(path, os.X_OK))
    shared = lambda path: len(os.path.commonprefix([str(path.relative_to(COPY / "build/ci/tests").parent).removeprefix("unit/") + "/", folder.removeprefix("core/") + "/"]))
    return sorted(found, key=lambda path: -shared(path))


def caught_by(file: str) -> str | None:
    for program in programs(file):
        # Comparisons with Mesa's rasteriser take minutes and are the business of the render tests.
        if not run(str(program), "--gtest_brief=1", limit_s=PROGRAM_LIMIT_S):
            return program.name
    environment = {**os.environ, "CAMRIG_BIN": str(COPY / "build/ci/tools/camrig/camrig"), "PYTHONPATH": str(COPY / "control/python")}
    python = str(REPOSITORY / ".venv/bin/python")
    if not run(python, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "tests/system", "-m", "not slow", "--ignore-glob=*/test_accuracy*.py",
               limit_s=SYSTEM_LIMIT_S, env=environment):
        return "system tests"
    return None


def main() -> int:
    parser = argparse.ArgumentParser(description="Breaks the program at random places and sees whether a test notices.")
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="only files whose paths begin so")
    parser.add_argument("--show", action="store_true", help="prints the mutations and changes nothing")
    arguments = parser.parse_args()
    source = mutations(arguments.only, random.Random(arguments.seed))
    if arguments.show:
        for _ in range(arguments.count):
            print(next(source))
        return 0

    if not COPY.exists():
        subprocess.run(["git", "worktree", "add", "--detach", str(COPY)], cwd=REPOSITORY, check=True, capture_output=True)
    subprocess.run(["git", "checkout", "--detach", "--force", subprocess.run(["git", "rev-parse", "HEAD"], cwd=REPOSITORY, capture_output=True, text=True,
                   check=True).stdout.strip()], cwd=COPY, check=True, capture_output=True)
    os.environ.update(CCACHE_BASEDIR=str(COPY), CCACHE_NOHASHDIR="1")
    if not run("cmake", "--preset", "ci", limit_s=300) or not build():
        raise SystemExit(f"the copy in {COPY} does not build without a mutation")

    tried = survived = 0
    while tried < arguments.count:
        mutation = next(source)
        path = COPY / mutation.file
        text = path.read_text()
        lines = text.splitlines(keepends=True)
        lines[mutation.line] = mutation.after + "\n"
        path.write_text("".join(lines))
        try:
            if not build():
                continue
            tried += 1
            catcher = caught_by(mutation.file)
        finally:
            path.write_text(text)
        survived += catcher is None
        print(f"{tried:3d} {'SURVIVED' if catcher is None else 'caught by ' + catcher}: {mutation}", flush=True)
    print(f"{tried - survived} of {tried} caught")
    return 1 if survived else 0


if __name__ == "__main__":
    sys.exit(main())

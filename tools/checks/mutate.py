#!/usr/bin/env python3
"""Breaks the program at random places, one at a time, and sees whether a test notices.

    tools/checks/mutate.py                          2 more mutations of each area, seed 1; a line each, at the end a table of all so far
    tools/checks/mutate.py --each 1 --seed 7 --only core/world
    tools/checks/mutate.py --only core/world#2      one of them again, after a test was written for it
    tools/checks/mutate.py --show                   prints the mutations and changes nothing
    tools/checks/mutate.py --write                  puts the table into docs/mutations.md

Works on a copy of the last commit (a git worktree in build/mutate) with a build of its own, and builds what the next test needs only.
Of Python the package is mutated too: its tests need nothing built. A mutation that does not compile does not count; the next of its area is taken for it. Tests run from near to far: the
test programs of the area, then its system tests; the first that fails, crashes or hangs twice has caught it. Exit 1 if one survived.
Mutations depend on seed and sources only: a new test does not change them.
"""

from __future__ import annotations

import argparse
import io
import itertools
import json
import os
import random
import re
import resource
import signal
import subprocess
import sys
import time
import tokenize
from pathlib import Path
from typing import Iterable, Iterator, NamedTuple

REPOSITORY = Path(__file__).resolve().parents[2]
COPY = REPOSITORY / "build" / "mutate"
#: Compiles what is not in the compiler's cache: what a mutation touched.
COMPILER = REPOSITORY / "build" / "mutate-compiler"
#: What was tried, for each seed: another run goes on with others, or tries one again.
KEPT = REPOSITORY / "build" / "mutations.json"
JOBS = os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL", str(os.cpu_count()))
#: A test that needs more hangs. CPU time is what counts on a busy machine; wall time is for those that wait for ever.
CPU_LIMIT_S, WALL_LIMIT_S = 300, 900


class Area(NamedTuple):
    """Sources (those of folders below that are areas of their own excepted), and the tests that are there for them, near to far."""

    programs: tuple[str, ...]
    system: tuple[str, ...] = ()
    python: tuple[str, ...] = ()  # tests that need nothing built


AREAS = {
    "core/base": Area(("test_base", "test_world", "test_stream", "test_control"), ("bad_input",)),
    "core/camera": Area(("test_camera", "test_truth", "test_lens"), ("truth",)),
    "core/codec": Area(("test_codec", "test_http"), ("pictures", "clients")),
    "core/engine": Area(("test_engine",), ("lockstep", "actions", "synchronism")),
    "core/fault": Area(("test_fault", "test_http", "test_rtsp"), ("faults", "fault_streams")),
    "core/frame": Area(("test_frame", "test_codec"), ("pictures",)),
    "core/render": Area(("test_render_parts", "test_render", "test_layers", "test_lens", "test_quality"), ("truth",)),
    "core/render/gl": Area(("test_render", "test_layers", "test_quality", "test_lens", "test_hard_cases", "test_gpu", "test_allocation"), ("truth",)),
    "core/render/software": Area(("test_render_software", "test_render", "test_software", "test_layers", "test_allocation"), ("pictures",)),
    "core/sensor": Area(("test_sensor",), ("sensor",)),
    "core/stream": Area(("test_stream", "test_engine", "test_http"), ("lockstep", "synchronism")),
    "core/truth": Area(("test_truth",), ("truth", "record")),
    "core/world": Area(("test_world", "test_engine"), ("actors", "mounted_cameras", "scenes")),
    "control/client": Area(("test_control",), ("cpp_client",)),
    "control/onvif": Area(("test_onvif",), ("onvif", "onvif_events", "onvif_media", "onvif_users")),
    "control/python": Area((), ("grab", "actions", "record", "campaigns"), ("tests/unit/python",)),
    "control/rpc": Area(("test_control", "test_cli"), ("authority", "bad_input", "actions", "scene_schema")),
    "control/server": Area(("test_control",), ("authority", "bad_input")),
    "rtsp_out/http": Area(("test_http",), ("clients", "authority", "web")),
    "rtsp_out/rtsp": Area(("test_rtsp",), ("rtsp", "rtsp_access", "rtsp_bounds", "lockstep")),
    "v4l2_sink": Area(("test_device", "test_loopback"), ("devices",)),
    "v4l2_sink/loopback": Area(("test_loopback",)),
    "v4l2_sink/preload": Area(("test_device", "test_device_programs"), ("devices", "device_colours")),
    "v4l2_sink/preload/client": Area(("test_device", "test_device_programs"), ("devices",)),
    "tools/camrig": Area(("test_cli",), ("actions", "record", "grab", "authority")),
    "tools/probe": Area(("test_probe",), ("probe",)),
    "tools/view": Area(("test_view",), ("view",)),
}

#: What is replaced by what. Only in code: not in comments, strings, includes, templates' brackets.
OPERATORS: list[tuple[str, str]] = [
    (r" < ", " <= "), (r" <= ", " < "), (r" > ", " >= "), (r" >= ", " > "), (r" == ", " != "), (r" != ", " == "),
    (r" && ", " || "), (r" \|\| ", " && "), (r" \+ ", " - "), (r" - ", " + "), (r" \* ", " / "), (r" / ", " * "),
    (r"\btrue\b", "false"), (r"\bfalse\b", "true"), (r"\bstd::min\(", "std::max("), (r"\bstd::max\(", "std::min("),
    (r" \+= ", " -= "), (r" -= ", " += "), (r"\bif \((?!const|auto)", "if (!("), (r"(?<![\w.])0(?![\w.'])", "1"),
    (r"(?<![\w.])1(?![\w.'])", "2"), (r"\bcontinue;", "break;"),
]
PYTHON_OPERATORS: list[tuple[str, str]] = [
    *(pair for pair in OPERATORS[:6]), (r" and ", " or "), (r" or ", " and "), (r" \+ ", " - "), (r" - ", " + "), (r" \* ", " / "), (r" // ", " * "), (r" / ", " * "),
    (r"\bTrue\b", "False"), (r"\bFalse\b", "True"), (r"\bmin\(", "max("), (r"\bmax\(", "min("), (r" \+= ", " -= "), (r" -= ", " += "), (r"\bif not ", "if "),
    (r"\bif (?!not )", "if not "), (r" is not None", " is None"), (r" is None", " is not None"), (r" not in ", " in "), (r"(?<![\w.])0(?![\w.])", "1"),
    (r"(?<![\w.])1(?![\w.])", "2"), (r"\bcontinue$", "break"), (r"\bbreak$", "continue"),
]  # fmt: skip
#: A statement on one line, which is left out: a call or an assignment.
PYTHON_STATEMENT = re.compile(r"^(\s+)(?!return|yield|raise|assert|with|def|class|if|for|while|else|elif|try|import|from|lambda|@)[\w.\[\]]+(\(.*\)| [+-]?= .*[^,\[({])$")
PYTHON_NOT_CODE = re.compile(r"""^\s*(#|import|from|def|class|@|assert|\w+: [\w\[\], .|]+$)|["']""")
STATEMENT = re.compile(r"^\s+(?!return|break|continue|using|const|auto|static|std::|if|for|while|else|case|throw)[\w.>()\[\]-]+(\(.*\)| [+-]?= .*);$")
NOT_CODE = re.compile(r'^\s*(//|#|\*|static_assert|LOG|CHECK|template|using|namespace)|spdlog::|"')


class Mutation(NamedTuple):
    area: str
    number: int  # in its area, from 1
    file: str
    line: int  # from 0
    before: str
    after: str

    def __str__(self) -> str:
        return f"{self.area}#{self.number}  {self.file}:{self.line + 1}: {self.before.strip()}  ->  {self.after.strip() or '(left out)'}"


def python_variants(line: str) -> Iterator[str]:
    if PYTHON_NOT_CODE.search(line):
        return
    code = line.split("  #")[0]
    for pattern, replacement in PYTHON_OPERATORS:
        for found in re.finditer(pattern, code):
            yield code[:found.start()] + replacement + code[found.end():]
    if found := PYTHON_STATEMENT.match(code):
        yield found[1] + "pass"


def lines_in_strings(text: str) -> set[int]:
    """Lines of Python that a string goes over, from 0: of texts about the code."""
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    return {line - 1 for token in tokens if token.type == tokenize.STRING for line in range(token.start[0], token.end[0] + 1)}


def places_of(file: str) -> Iterator[tuple[int, str, list[str]]]:
    """Lines of a source (from 0) with what each can be replaced by."""
    text = (REPOSITORY / file).read_text()
    is_python = file.endswith(".py")
    left_out = lines_in_strings(text) if is_python else set()
    for number, line in enumerate(text.splitlines()):
        if number not in left_out and (found := list(python_variants(line) if is_python else variants(line))):
            yield number, line, found


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


def area_of(file: str) -> str:
    return max((area for area in AREAS if file.startswith(area + "/")), key=len, default="")


def mutations(area: str, seed: int) -> Iterator[Mutation]:
    """Those of an area, in random order, each once."""
    listed = subprocess.run(["git", "ls-files", area], cwd=REPOSITORY, capture_output=True, text=True, check=True).stdout.split()
    places = []
    for file in listed:
        if file.endswith((".cpp", ".h", ".py")) and area_of(file) == area:
            places += [(file, *place) for place in places_of(file)]
    rng = random.Random(f"{seed} {area}")
    rng.shuffle(places)
    for number, (file, line, text, found) in enumerate(places, 1):
        yield Mutation(area, number, file, line, text, rng.choice(found))


def limited() -> None:
    resource.setrlimit(resource.RLIMIT_CPU, (CPU_LIMIT_S, CPU_LIMIT_S))
    os.setsid()


def failure(command: list[str], environment: dict[str, str] | None = None) -> str | None:
    """The first test that failed, or how the command ended otherwise; None if well."""
    process = subprocess.Popen(command, cwd=COPY, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace", preexec_fn=limited)
    try:
        said, _ = process.communicate(timeout=WALL_LIMIT_S)
    except subprocess.TimeoutExpired:
        said = ""
    finally:
        # Also what it started: a rig of a test that was ended.
        try:
            os.killpg(process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
    if process.returncode == 0:
        return None
    if process.returncode == 5 and "pytest" in command:
        raise SystemExit(f"no test was run: {' '.join(command)}")
    failed = re.search(r"\[  FAILED  \] (\S+)|^(?:FAILED|ERROR) \S*?(\w+\.py\S*)", said, re.MULTILINE)
    process.wait()
    return (failed[1] or failed[2]).rstrip(",") if failed else "it hangs" if process.returncode in (-signal.SIGKILL, -signal.SIGXCPU) else f"status {process.returncode}"


def build(targets: Iterable[str], flags: str | None = None) -> bool:
    """`flags`: what is not in the compiler's cache is compiled with these beside its own, and stays out of it."""
    command = ["cmake", "--build", "--preset", "ci", "-j", JOBS, "--target", *targets]
    quick = {"CCACHE_PREFIX": str(COMPILER), "CCACHE_READONLY": "1", "CAMRIG_MUTATE_FLAGS": flags} if flags else {}
    return subprocess.run(command, cwd=COPY, env={**os.environ, **quick}, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False).returncode == 0


def tests_of(area: str) -> Iterator[tuple[str, list[str], dict[str, str] | None]]:
    """Near to far: what to build (nothing: ""), how to run it, in what environment."""
    environment = {**os.environ, "CAMRIG_BIN": str(COPY / "build/ci/tools/camrig/camrig"), "PYTHONPATH": str(COPY / "control/python")}
    pytest = [str(REPOSITORY / ".venv/bin/python"), "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider"]
    for path in AREAS[area].python:
        yield "", [*pytest, path], environment
    for name in AREAS[area].programs:
        program = next((COPY / "build/ci").rglob(f"CMakeFiles/{name}.dir")).parents[1] / name
        yield name, [str(program), "--gtest_brief=1", "--gtest_fail_fast"], None
    for name in AREAS[area].system:
        slow = [] if name == "cpp_client" else ["-m", "not slow"]  # it has no others
        yield "camrig", [*pytest, *slow, f"tests/system/test_{name}.py"], environment


def caught_by(area: str) -> str | None:
    """Raises ValueError when it does not compile."""
    # Pictures take too long without any optimisation.
    # A warning of what is compiled without optimisation, or of what a mutation left unused, is no reason to leave it out.
    flags = "-Wno-error " + ("-g0 -O1" if area.startswith("core/") else "-g0 -O0")
    for target, command, environment in tests_of(area):
        if target and not build([target], flags):
            raise ValueError(target)
        # Twice, so that a test that fails now and then by itself catches nothing.
        if failure(command, environment) and (failed := failure(command, environment)):
            return failed
    return None


def prepare(areas: set[str], is_checked: bool) -> None:
    """The copy as the last commit is, and what these areas need built; their tests pass, or they are of no use."""
    if not COPY.exists():
        subprocess.run(["git", "worktree", "add", "--detach", str(COPY)], cwd=REPOSITORY, check=True, capture_output=True)
    subprocess.run(["git", "checkout", "--detach", "--force", head()], cwd=COPY, check=True, capture_output=True)
    COMPILER.write_text('#!/bin/sh\nexec "$@" $CAMRIG_MUTATE_FLAGS\n')
    COMPILER.chmod(0o755)
    os.environ.update(CCACHE_BASEDIR=str(COPY), CCACHE_NOHASHDIR="1", CCACHE_SLOPPINESS="time_macros")
    subprocess.run(["cmake", "--preset", "ci"], cwd=COPY, check=True, stdout=subprocess.DEVNULL)
    tests = {tuple(command): (target, command, environment) for area in areas for target, command, environment in tests_of(area)}
    targets = {target for target, _, _ in tests.values() if target}
    if targets and not build(targets):
        raise SystemExit(f"the copy in {COPY} does not build without a mutation")
    for _, command, environment in tests.values() if is_checked else ():
        if failed := failure(command, environment):
            raise SystemExit(f"fails without a mutation: {failed} ({' '.join(command)})")


def head() -> str:
    return subprocess.run(["git", "rev-parse", "HEAD"], cwd=REPOSITORY, capture_output=True, text=True, check=True).stdout.strip()


def check_syntax(path: Path) -> None:
    try:
        compile(path.read_text(), str(path), "exec")
    except SyntaxError as problem:
        raise ValueError(path.name) from problem


def try_one(mutation: Mutation) -> str | None:
    path = COPY / mutation.file
    text = path.read_text()
    lines = text.splitlines(keepends=True)
    lines[mutation.line] = mutation.after + "\n"
    path.write_text("".join(lines))
    try:
        if path.suffix == ".py":
            check_syntax(path)
        return caught_by(mutation.area)
    finally:
        path.write_text(text)


def table(results: dict[str, str | None]) -> str:
    """Of all that was tried, mutation -> who caught it."""
    lines = ["| area | mutations | caught |", "|---|---|---|"]
    areas = {area: [catcher for tried, catcher in results.items() if tried.startswith(area + "#")] for area in AREAS}
    for area, catchers in (*((f"`{area}`", catchers) for area, catchers in areas.items() if catchers), ("all", list(results.values()))):
        lines.append(f"| {area} | {len(catchers)} | {len(catchers) - catchers.count(None)} |")
    if gone := [tried for tried, catcher in results.items() if catcher is None]:
        lines += ["", "Not caught:", "", "```", *gone, "```"]
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description="Breaks the program at random places and sees whether a test notices.")
    parser.add_argument("--each", type=int, default=2, help="of each area (2)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", action="append", help="AREA, or AREA#NUMBER for one mutation; may come more than once")
    parser.add_argument("--unchecked", action="store_true", help="does not run the tests without a mutation first")
    parser.add_argument("--show", action="store_true", help="prints the mutations and changes nothing")
    parser.add_argument("--write", action="store_true", help="puts the table into docs/mutations.md")
    arguments = parser.parse_args()
    wanted = [tuple(only.partition("#")[::2]) for only in arguments.only or AREAS]
    if unknown := [area for area, _ in wanted if area not in AREAS]:
        parser.error(f"no area {', '.join(unknown)}; there are {', '.join(AREAS)}")
    if not arguments.show:
        prepare({area for area, _ in wanted}, not arguments.unchecked)

    signal.signal(signal.SIGTERM, signal.default_int_handler)  # also where SIGINT is ignored: started by a shell in the background
    left = {wish: mutations(wish[0], arguments.seed) for wish in wanted}
    if arguments.show:
        for (_, number), source in left.items():
            for mutation in source if number else itertools.islice(source, arguments.each):
                if not number or mutation.number == int(number):
                    print(mutation)
        return 0

    kept = KEPT.with_stem(f"{KEPT.stem}-{arguments.seed}")
    results: dict[str, str | None] = json.loads(kept.read_text()) if kept.exists() else {}
    survivors = 0
    try:
        # All areas in turns, so that a run that is ended early has been everywhere.
        for _ in range(arguments.each):
            for (area, number), source in left.items():
                for mutation in source:
                    if mutation.number != int(number) if number else str(mutation) in results:
                        continue
                    begin = time.monotonic()
                    try:
                        catcher = try_one(mutation)
                    except ValueError as of_target:
                        print(f"   does not compile ({of_target}): {mutation}", flush=True)
                        continue
                    results[str(mutation)] = catcher
                    kept.write_text(json.dumps(results, indent=0))
                    survivors += catcher is None
                    print(f"   {time.monotonic() - begin:4.0f} s  {'SURVIVED' if catcher is None else 'caught by ' + catcher}: {mutation}", flush=True)
                    break
    except KeyboardInterrupt:
        print("ended early")
    print(text := table(results))
    if arguments.write:
        sys.path.insert(0, str(REPOSITORY))
        from tools.bench import report

        report.put(REPOSITORY / "docs/mutations.md", "mutations", text, f"`tools/checks/mutate.py --seed {arguments.seed} --write`")
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main())

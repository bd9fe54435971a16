#!/usr/bin/env python3
"""Holds the sources to the allowed edges of docs/architecture.md: who may include whom.

    tools/checks/edges.py                 checks this repository; one line per bad include, exit 1 if there is one
    tools/checks/edges.py --root DIR      checks another tree
    tools/checks/edges.py --self-check    shows on made-up trees that bad includes are found and good ones pass

Only includes between our own folders count ("folder/file.h", from the repository root), and the includes of EGL and GL.
"""

from __future__ import annotations

import argparse
import pathlib
import re
import sys
import tempfile

# A folder, and the folders it may use beside itself. The longest match names the part a file belongs to.
ALLOWED: dict[str, list[str]] = {
    "core/base": [],
    "core/camera": ["core/base"],
    "core/sensor": ["core/base", "core/camera"],
    "core/daylight": ["core/base"],
    "core/photo": ["core/base", "core/camera", "core/daylight"],
    "core/fault": ["core/base", "core/camera"],
    "core/world": ["core/base", "core/camera", "core/daylight", "core/fault", "core/sensor"],
    "core/frame": ["core/base", "core/fault"],
    "core/codec": ["core/base", "core/frame"],
    "core/stream": ["core/base", "core/fault", "core/frame", "core/codec"],
    "core/render": ["core/base", "core/camera", "core/fault", "core/sensor", "core/world", "core/frame"],
    "core/bake": ["core/base", "core/world", "core/frame", "core/render"],
    "core/truth": ["core/base", "core/camera", "core/fault", "core/world", "core/frame"],
    "core/engine": ["core"],
    "v4l2_sink": ["core/base", "core/fault", "core/frame", "core/codec", "core/stream"],
    "rtsp_out": ["core/base", "core/fault", "core/frame", "core/codec", "core/stream"],
    "control/rpc": ["core/base", "core/camera", "core/daylight", "core/photo", "core/fault", "core/world", "core/frame", "core/codec", "core/stream",
                    "core/truth", "core/engine/command.h"],
    "control/onvif": ["core/base", "core/camera", "core/world", "core/frame", "core/stream", "core/engine/command.h"],
    "control/unrealcv": ["core/base", "core/camera", "core/world", "core/frame", "core/codec", "core/stream", "core/truth",
                         "core/engine/command.h", "control/server/accept_loop.h", "control/server/loop_event.h", "control/server/loop_post.h",
                         "control/server/loop_thread.h"],
    "control/server": ["core/base", "control/rpc"],
    "control/client": ["core/base"],
    "control/web": [],
    "tools": ["core", "v4l2_sink", "rtsp_out", "control"],
}
# Each folder in these is a sink; a sink never includes another. Files beside them are for all sinks of that folder.
SINK_FOLDERS = ("v4l2_sink", "rtsp_out")
# Public headers of the client library are included as its users do: <camrig/rig.h>.
PUBLIC_HEADERS = {"camrig": "control/client/camrig"}
GRAPHICS = re.compile(r"(EGL|GL|GLES|GLES2|GLES3|KHR|epoxy|glad)/")
GRAPHICS_FOLDER = "core/render/gl"

SOURCES = {".h", ".hpp", ".c", ".cc", ".cpp", ".in"}
OURS = ("core", "v4l2_sink", "rtsp_out", "control", "tools", "tests")
INCLUDE = re.compile(r'^\s*#\s*include\s*(?P<open>["<])(?P<path>[^">]+)[">]')


def under(path: str, folder: str) -> bool:
    return path == folder or path.startswith(folder + "/")


def part_of(path: str) -> str | None:
    """The entry of ALLOWED a file belongs to."""
    owners = [folder for folder in ALLOWED if under(path, folder)]
    return max(owners, key=len) if owners else None


def sink_of(path: str) -> str | None:
    """"rtsp_out/http" for a file in it; None for files that belong to no single sink."""
    parts = path.split("/")
    return "/".join(parts[:2]) if parts[0] in SINK_FOLDERS and len(parts) > 2 else None


def problem_of(source: str, target: str) -> str | None:
    """Why `source` may not include `target` (both from the repository root); None when it may."""
    part = part_of(source)
    if part is None:
        return f"{source} is in no folder that tools/checks/edges.py knows; name it there and in docs/architecture.md"
    if under(target, "tools") and part != "tools":
        return "nothing includes tools"
    if under(target, "tests"):
        return "sources do not include tests"
    mine, other = sink_of(source), sink_of(target)
    if mine and other and mine != other:
        return f"a sink never includes another sink ({mine} -> {other})"
    if under(target, part) or any(under(target, folder) for folder in ALLOWED[part]):
        return None
    may = ", ".join(ALLOWED[part]) or "nothing of ours"
    return f"{part} may use only {may}"


def check_file(root: pathlib.Path, path: pathlib.Path) -> list[str]:
    source = path.relative_to(root).as_posix()
    problems = []
    for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), 1):
        match = INCLUDE.match(line)
        if not match:
            continue
        target = match["path"]
        head, _, rest = target.partition("/")
        if head in PUBLIC_HEADERS:
            target = f"{PUBLIC_HEADERS[head]}/{rest}"
        reason = None
        if GRAPHICS.match(target):
            if not under(source, GRAPHICS_FOLDER):
                reason = f"only {GRAPHICS_FOLDER} includes EGL and GL"
        elif target.split("/")[0] in OURS and "/" in target:
            reason = problem_of(source, target)
        elif match["open"] == '"' and "/" not in target and (path.parent / target).exists():
            reason = f'write it from the repository root: "{path.parent.relative_to(root).as_posix()}/{target}"'
        elif ".." in target.split("/"):
            reason = "includes go from the repository root, without .."
        if reason:
            problems.append(f'{source}:{number}: includes "{target}": {reason}')
    return problems


def check_tree(root: pathlib.Path) -> list[str]:
    problems = []
    for folder in sorted({entry.split("/")[0] for entry in ALLOWED}):
        for path in sorted((root / folder).rglob("*")):
            if path.suffix in SOURCES and path.is_file():
                problems += check_file(root, path)
    return problems


GOOD = [
    ("core/base/a.h", "#include <vector>"),
    ("core/world/a.h", '#include "core/camera/pose.h"'),
    ("core/engine/a.h", '#include "core/render/renderer.h"'),
    ("core/render/gl/a.cpp", "#include <EGL/egl.h>"),
    ("rtsp_out/http/a.h", '#include "core/stream/sink.h"'),
    ("rtsp_out/rtsp/a.h", '#include "rtsp_out/rtsp/b.h"'),
    ("control/rpc/a.h", '#include "core/engine/command.h"'),
    ("control/server/a.h", '#include "control/rpc/rpc_server.h"'),
    ("tools/camrig/a.cpp", '#include "rtsp_out/http/http_server.h"'),
    ("tools/view/a.cpp", "#include <camrig/rig.h>"),
    ("core/base/b.h", '// #include "core/world/world.h"'),
]
BAD = [
    ("core/base/a.h", '#include "core/frame/frame.h"', "core/base may use only nothing of ours"),
    ("core/camera/a.h", '#include "core/world/world.h"', "core/camera may use only core/base"),
    ("core/sensor/a.h", '#include "core/render/renderer.h"', "core/sensor may use only core/base, core/camera"),
    ("core/truth/a.h", '#include "core/render/renderer.h"', "core/truth may use only"),
    ("core/world/a.h", '  #  include <core/render/renderer.h>', "core/world may use only"),
    ("core/render/a.cpp", "#include <GL/gl.h>", "only core/render/gl"),
    ("core/render/gl/a.cpp", '#include "core/engine/rig.h"', "core/render may use only"),
    ("rtsp_out/http/a.h", '#include "rtsp_out/rtsp/b.h"', "a sink never includes another sink"),
    ("v4l2_sink/preload/a.h", '#include "core/world/world.h"', "v4l2_sink may use only"),
    ("control/rpc/a.h", '#include "core/engine/engine.h"', "control/rpc may use only"),
    ("control/client/a.h", '#include "control/rpc/rpc_server.h"', "control/client may use only"),
    ("rtsp_out/a.h", "#include <camrig/rig.h>", "rtsp_out may use only"),
    ("core/engine/a.h", '#include "tools/camrig/serve.h"', "nothing includes tools"),
    ("core/engine/b.h", '#include "tests/unit/fake.h"', "do not include tests"),
    ("core/elsewhere/a.h", '#include "core/base/a.h"', "no folder that tools/checks/edges.py knows"),
    ("core/base/c.h", '#include "../frame/frame.h"', "without .."),
]


def self_check() -> list[str]:
    failures = []
    for source, line in GOOD:
        if found := check_made_up(source, line):
            failures.append(f"should pass: {source} with {line}: {found}")
    for source, line, reason in BAD:
        found = check_made_up(source, line)
        if len(found) != 1 or reason not in found[0] or not found[0].startswith(f"{source}:2:"):
            failures.append(f"should fail with '{reason}': {source} with {line}: {found}")
    return failures


def check_made_up(source: str, line: str) -> list[str]:
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder, source)
        path.parent.mkdir(parents=True)
        path.write_text(f"#pragma once\n{line}\n", encoding="utf-8")
        return check_tree(pathlib.Path(folder))


def main() -> int:
    parser = argparse.ArgumentParser(description="Checks the allowed include edges.")
    parser.add_argument("--root", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parents[2])
    parser.add_argument("--self-check", action="store_true")
    arguments = parser.parse_args()
    problems = self_check() if arguments.self_check else check_tree(arguments.root.resolve())
    for problem in problems:
        print(problem, file=sys.stderr)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Holds the world to functions that give the same bits on every processor: core/base/portable_math.h, not the C library's.

    tools/checks/same_math.py                 checks this repository; one line per bad call, exit 1 if there is one
    tools/checks/same_math.py --self-check    shows on made-up lines that bad calls are found and good ones pass

Exact ones (sqrt, floor, remainder, fmod, llround, ...) are the same everywhere and may be used.
"""

from __future__ import annotations

import argparse
import pathlib
import re

# What decides the state of the world and where cameras are.
PLACES = ["core/world", "core/daylight", "core/camera/pose.cpp", "core/camera/pose.h"]
FUNCTIONS = ("sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh exp exp2 expm1 log log2 log10 log1p pow cbrt hypot "
             "sincos tgamma lgamma erf erfc fma lerp").split()
# Of glm, these call them: axis and angle, rotations, Euler angles.
GLM = FUNCTIONS + "angleAxis angle axis rotate rotateX rotateY rotateZ slerp shortMix eulerAngles roll pitch yaw polar euclidean".split()
STD_CALL = re.compile(r"(?<![\w:.>])(?:std::)?(?P<name>%s)[fl]?\s*\(" % "|".join(FUNCTIONS))
GLM_CALL = re.compile(r"glm::(?P<name>%s)\s*\(" % "|".join(GLM))


def problem_of(line: str) -> str | None:
    code = line.split("//")[0]
    for pattern in (STD_CALL, GLM_CALL):
        if match := pattern.search(code):
            return f"{match.group().rstrip('( ')}: differs between processors; core/base/portable_math.h and core/world/turn.h do not"
    return None


def check_tree(root: pathlib.Path) -> list[str]:
    files = [path for place in PLACES for path in ([root / place] if (root / place).is_file() else sorted((root / place).rglob("*")))]
    return [f"{path.relative_to(root)}:{number}: {problem}"
            for path in files if path.suffix in {".h", ".cpp"}
            for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
            if (problem := problem_of(line))]


GOOD = ["x = portable::sin(y);", "x = std::sqrt(y) + std::floor(z);", "// std::sin(x)", "glm::normalize(v)", "const double sine = f(x);",
        "spdlog::log(level)", "logger.log(x)", "std::remainder(a, b)", "asin_table(3)"]
BAD = ["x = std::sin(y);", "x = cos (y);", "std::atan2(y, x)", "sinf(x)", "glm::angleAxis(a, v)", "glm::slerp(a, b, t)", "1 - std::pow(v, 4.0)",
       "std::hypot(x, y)"]


def self_check() -> list[str]:
    return [f"should pass: {line}" for line in GOOD if problem_of(line)] + [f"should fail: {line}" for line in BAD if not problem_of(line)]


def main() -> int:
    parser = argparse.ArgumentParser(description="Checks that the world calls no function that differs between processors.")
    parser.add_argument("--self-check", action="store_true")
    options = parser.parse_args()
    problems = self_check() if options.self_check else check_tree(pathlib.Path(__file__).resolve().parents[2])
    print("\n".join(problems), end="\n" if problems else "")
    return 1 if problems else 0


if __name__ == "__main__":
    raise SystemExit(main())

"""How long to look, and Markdown."""

from __future__ import annotations

from dataclasses import dataclass

VGA, HD, FULL_HD = (640, 480), (1280, 720), (1920, 1080)


@dataclass(frozen=True)
class Plan:
    seconds: float = 60
    steps: int = 250
    counts: tuple[int, ...] = (1, 2, 4, 8, 12, 16, 32)
    soak_s: float = 300

    @property
    def turn_s(self) -> float:
        """How long one turn of a renderer takes that is measured in turns."""
        return self.seconds / 20


QUICK = Plan(seconds=4, steps=10, counts=(1, 4), soak_s=20)


def table(head: list[str], rows: list[list[object]]) -> str:
    def line(cells: list[object]) -> str:
        return "| " + " | ".join(str(cell) for cell in cells) + " |"

    return "\n".join([line(list(head)), "|" + "---|" * len(head), *(line(row) for row in rows)])

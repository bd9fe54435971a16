"""Figures of docs/speed.md, as PNG beside it. Without matplotlib the page has its tables only."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from . import REPOSITORY

PICTURES = REPOSITORY / "docs" / "pictures" / "speed"


def figure(name: str, caption: str, draw: Callable, folder: Path = PICTURES) -> str:
    """draw(axes) makes one figure; gives the Markdown that shows it."""
    try:
        import matplotlib
    except ImportError:
        return ""
    matplotlib.use("Agg")
    from matplotlib import pyplot

    made, axes = pyplot.subplots(figsize=(6.4, 3.6), dpi=110, layout="constrained")
    axes.grid(True, which="both", alpha=0.25)
    draw(axes)
    folder.mkdir(parents=True, exist_ok=True)
    made.savefig(folder / f"{name}.png", metadata={"Software": None})
    pyplot.close(made)
    return f"\n\n![{caption}](pictures/speed/{name}.png)"


def lines(x: list[float], curves: dict[str, list[float]], x_label: str, y_label: str, *, log_x: bool = False) -> Callable:
    def draw(axes) -> None:
        for label, y in curves.items():
            axes.plot(x, y, marker="o", label=label)
        axes.set_xlabel(x_label)
        axes.set_ylabel(y_label)
        if log_x:
            axes.set_xscale("log", base=2)
            axes.set_xticks(x, [f"{value:g}" for value in x])
        axes.set_ylim(bottom=0)
        axes.legend()

    return draw


def tail(curves: dict[str, list[float]], x_label: str) -> Callable:
    """Share of values above x, both axes logarithmic."""

    def draw(axes) -> None:
        for label, values in curves.items():
            ordered = sorted(values)
            count = len(ordered)
            axes.step(ordered, [(count - i) / count for i in range(count)], label=f"{label} ({count})")
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlabel(x_label)
        axes.set_ylabel("share above")
        axes.legend()

    return draw


def stacked(labels: list[str], parts: dict[str, list[float]], y_label: str) -> Callable:
    def draw(axes) -> None:
        below = [0.0] * len(labels)
        for name, values in parts.items():
            axes.bar(labels, values, bottom=below, label=name)
            below = [a + b for a, b in zip(below, values)]
        axes.set_ylabel(y_label)
        axes.legend()

    return draw

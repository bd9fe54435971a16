"""Plots as SVG, the same bytes for the same numbers."""

from __future__ import annotations

import html
import math
from typing import Mapping, Sequence

COLOURS = ("#c43d3d", "#2e7d9e", "#d9822b", "#2e9e5b", "#7a4fa3", "#777777", "#b0307a", "#4a6b1f", "#101010")
LEFT, TOP, WIDTH, HEIGHT = 62, 14, 380, 250
Points = Sequence[tuple[float, float]]


def plot(x_title: str, y_title: str, series: Mapping[str, Points], names: Sequence[str] = ()) -> str:
    """One plot; series by name, their points joined by lines. names: of the points of every series, which are not joined then."""
    points = [point for of in series.values() for point in of]
    x_ticks, y_ticks = _ticks([x for x, _ in points]), _ticks([y for _, y in points])
    def px(x: float) -> float:
        return LEFT + (x - x_ticks[0]) / (x_ticks[-1] - x_ticks[0]) * WIDTH
    def py(y: float) -> float:
        return TOP + HEIGHT - (y - y_ticks[0]) / (y_ticks[-1] - y_ticks[0]) * HEIGHT
    parts = []
    for x in x_ticks:
        parts.append(f'<path d="M{px(x):.1f} {TOP}V{TOP + HEIGHT}" stroke="#e4e4ea"/><text x="{px(x):.1f}" y="{TOP + HEIGHT + 16}" text-anchor="middle">{x:g}</text>')
    for y in y_ticks:
        parts.append(f'<path d="M{LEFT} {py(y):.1f}H{LEFT + WIDTH}" stroke="#e4e4ea"/><text x="{LEFT - 6}" y="{py(y) + 4:.1f}" text-anchor="end">{y:g}</text>')
    for number, (name, of) in enumerate(series.items()):
        colour = COLOURS[number % len(COLOURS)]
        if len(of) > 1 and not names:
            parts.append(f'<path d="M{"L".join(f"{px(x):.1f} {py(y):.1f}" for x, y in of)}" fill="none" stroke="{colour}" stroke-width="1.6"/>')
        parts += [f'<circle cx="{px(x):.1f}" cy="{py(y):.1f}" r="3.6" fill="{colour}"/>' for x, y in of]
        parts += [f'<text x="{px(x) - 5:.1f}" y="{py(y) + 14:.1f}" text-anchor="end" fill="{colour}">{html.escape(label)}</text>' for label, (x, y) in zip(names, of)]
        parts.append(f'<text x="{LEFT + WIDTH + 10}" y="{TOP + 12 + 16 * number}" fill="{colour}">{html.escape(name)}</text>')
    parts.append(f'<text x="{LEFT + WIDTH / 2}" y="{TOP + HEIGHT + 34}" text-anchor="middle">{html.escape(x_title)}</text>')
    parts.append(f'<text x="14" y="{TOP + HEIGHT / 2}" text-anchor="middle" transform="rotate(-90 14 {TOP + HEIGHT / 2})">{html.escape(y_title)}</text>')
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {LEFT + WIDTH + 130} {TOP + HEIGHT + 42}" width="{LEFT + WIDTH + 130}" role="img" '
            f'font-family="system-ui,sans-serif" font-size="12"><rect width="100%" height="100%" fill="#fff"/>{"".join(parts)}</svg>')


def _ticks(values: Sequence[float]) -> list[float]:
    """Round numbers around all values, at most eight."""
    low, high = min(values, default=0.0), max(values, default=1.0)
    low, high = (0.0 if 0 <= low < 0.5 * high else low), (high if high > low else low + 1)
    step = 10 ** math.floor(math.log10((high - low) / 4))
    step *= next(factor for factor in (1, 2, 5, 10) if (high - low) / (step * factor) <= 6)
    first = math.floor(low / step + 1e-9)
    return [round((first + i) * step, 12) for i in range(math.ceil(high / step - 1e-9) - first + 1)]

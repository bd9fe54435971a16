"""A campaign's report: JSON, and one HTML file that needs no other, with its plots as SVG."""

from __future__ import annotations

import html
import json
import os
from pathlib import Path

from .runner import OUTCOMES, Report, Result

_COLOURS = {"unnoticed": "#2e9e5b", "recovered": "#8fbf3f", "lost": "#d9822b", "ended": "#c43d3d", "never_well": "#777777", "refused": "#b8b8c8"}
_STYLE = """
body{font:15px system-ui,sans-serif;margin:2em auto;max-width:75em;padding:0 1em;color:#222;background:#fff}
table{border-collapse:collapse;margin:1em 0}td,th{padding:.25em .7em;border-bottom:1px solid #ddd;text-align:left;vertical-align:top}
td.n{text-align:right;font-variant-numeric:tabular-nums}.o{color:#fff;border-radius:.3em;padding:.05em .45em}
pre{background:#f4f4f4;padding:.6em;overflow:auto;max-height:20em}svg text{font:12px system-ui,sans-serif}code{background:#f4f4f4}
"""


def write(report: Report, folder: str | os.PathLike[str]) -> Path:
    """Writes report.json and report.html into `folder`, which is made; the path of the page."""
    where = Path(folder)
    where.mkdir(parents=True, exist_ok=True)
    (where / "report.json").write_text(json.dumps(report.to_json(), indent=1) + "\n", encoding="utf-8")
    page = where / "report.html"
    page.write_text(to_html(report), encoding="utf-8")
    return page


def to_html(report: Report) -> str:
    campaign = report.campaign
    name = html.escape(campaign.name)
    counts = report.to_json()["outcomes"]
    legend = " ".join(f"{_badge(key)} {counts[key]} <small>{html.escape(text)}</small>" for key, text in OUTCOMES.items() if counts[key])
    unmapped = "".join(f"<tr><td>{html.escape(key)}</td><td>{html.escape(why)}</td></tr>" for key, why in campaign.unmapped.items())
    return "".join((
        f"<!doctype html><html lang=en><meta charset=utf-8><title>{name}</title><style>{_STYLE}</style>",
        f"<h1>Campaign {name}</h1><p><code>{html.escape(' '.join(campaign.program))}</code></p>",
        f"<p>{html.escape(str(report.rig.get('renderer')))}, camrig {html.escape(str(report.rig.get('version')))}, seed {campaign.seed}; ",
        f"each fault {campaign.hold_s:g} s long, then at most {campaign.recover_s:g} s to be well again.</p><p>{legend}</p>",
        "<h2>Times</h2>", _times(report), "<h2>Severity</h2>", _severities(report), "<h2>Cells</h2>", _table(report.results),
        f"<h2>Not in this campaign</h2><table>{unmapped}</table>" if unmapped else "",
        "<h2>What the program printed last</h2>", *(_output(result) for result in report.results if result.output), "</html>\n",
    ))


def _title(result: Result) -> str:
    return f"{result.row} {result.severity:g}" + (f" #{result.repeat + 1}" if result.repeat else "")


def _badge(outcome: str) -> str:
    return f'<span class=o style="background:{_COLOURS[outcome]}">{outcome.replace("_", " ")}</span>'


def _times(report: Report) -> str:
    """A line per cell: when the fault was there (grey), when the program was well (green) and not (red)."""
    left, width, step = 230, 760, 22
    shown = [result for result in report.results if result.held_s is not None]
    if not shown:
        return "<p>No fault was set.</p>"
    end_s = max(max(result.held_s or 0.0, *(at for at, _ in result.changes), (result.held_s or 0.0) + (result.recovered_s or 0.0)) for result in shown) + 1.0
    scale = width / end_s
    parts = []
    for number, result in enumerate(shown):
        y = 6 + number * step
        parts.append(f'<text x="{left - 8}" y="{y + 12}" text-anchor="end">{html.escape(_title(result))}</text>')
        parts.append(f'<rect x="{left}" y="{y}" width="{(result.held_s or 0) * scale:.1f}" height="16" fill="#dcdce4"/>')
        for index, (at, is_well) in enumerate(result.changes):
            until = result.changes[index + 1][0] if index + 1 < len(result.changes) else end_s
            begin = max(at, 0.0)
            if until > begin:
                colour = "#2e9e5b" if is_well else "#c43d3d"
                parts.append(f'<rect x="{left + begin * scale:.1f}" y="{y + 5}" width="{(until - begin) * scale:.1f}" height="6" fill="{colour}"/>')
    bottom = 10 + len(shown) * step
    ticks = max(1, round(end_s / 10))
    parts += [f'<text x="{left + at * scale:.1f}" y="{bottom + 14}" text-anchor="middle">{at} s</text>' for at in range(0, int(end_s) + 1, ticks)]
    return f'<svg viewBox="0 0 {left + width + 20} {bottom + 24}" role="img">{"".join(parts)}</svg><p><small>Grey: the fault. Green: well. Red: not.</small></p>'


def _severities(report: Report) -> str:
    """Time to recover over severity, a small plot per fault with several."""
    plots = []
    for row in report.campaign.rows:
        of = [result for result in report.results if result.row == row.name and result.held_s is not None]
        if len({result.severity for result in of}) < 2:
            continue
        top = max([result.recovered_s or 0.0 for result in of] + [1.0])
        dots = "".join(
            f'<circle cx="{30 + result.severity * 160:.1f}" cy="{(110 - result.recovered_s / top * 90) if result.recovered_s is not None else 12:.1f}" r="5" '
            f'fill="{_COLOURS[result.outcome]}"><title>{html.escape(_title(result))}: {result.outcome}</title></circle>' for result in of)
        plots.append(f'<svg width="220" height="150" role="img"><text x="30" y="145">{html.escape(row.name)}: severity 0 to 1</text>'
                     f'<path d="M30 15V110H195" fill="none" stroke="#888"/><text x="2" y="24">{top:.1f} s</text><text x="10" y="114">0</text>{dots}</svg>')
    return ("".join(plots) + "<p><small>Time to recover; what did not is at the top.</small></p>") if plots else "<p>No fault at several severities.</p>"


def _table(results: list[Result]) -> str:
    head = ("fault", "severity", "outcome", "noticed s", "recovered s", "ended s", "exit", "due", "delivered", "by fault", "by overload")
    rows = []
    for result in results:
        numbers = [_seconds(result.noticed_s), _seconds(result.recovered_s), _seconds(result.ended_s), "" if result.exit_code is None else str(result.exit_code)]
        books = _books(result)
        rows.append(f"<tr><td>{html.escape(result.row)}</td><td class=n>{result.severity:g}</td><td>{_badge(result.outcome)} {html.escape(result.reason or '')}</td>"
                    + "".join(f"<td class=n>{text}</td>" for text in numbers + books) + "</tr>")
    return "<table><tr>" + "".join(f"<th>{one}</th>" for one in head) + "</tr>" + "".join(rows) + "</table>"


def _books(result: Result) -> list[str]:
    outputs = (result.books or {}).get("outputs", [])
    return [str(sum(output[key] for output in outputs)) for key in ("due", "delivered", "by_fault", "by_overload")] if outputs else [""] * 4


def _seconds(value: float | None) -> str:
    return "" if value is None else f"{value:.2f}"


def _output(result: Result) -> str:
    return f"<details><summary>{html.escape(_title(result))}</summary><pre>{html.escape(result.output)}</pre></details>"

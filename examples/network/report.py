"""The report of a run: results.json, and one HTML file that needs no other."""

from __future__ import annotations

import html
import json
from pathlib import Path
from typing import Any

from .camsim import MEASURED
from .plots import plot
from .sweep import SWEPT

_STYLE = """body{font:15px system-ui,sans-serif;margin:2em auto;max-width:70em;padding:0 1em;color:#222}table{border-collapse:collapse;margin:1em 0}
td,th{padding:.25em .7em;border-bottom:1px solid #ddd;text-align:right;font-variant-numeric:tabular-nums}td:first-child,th:first-child{text-align:left}
figure{display:inline-block;margin:.5em}figcaption{max-width:32em;color:#555}"""
COLUMNS = {"relative_utility": "utility of the best possible", "coverage": "coverage", "handovers": "hand-overs", "handovers_right": "of them to a camera with the same person",
           "returned": "back within 1 s", "idf1": "IDF1", "switches": "identity switches", "error_m": "error, m", "searches": "searches", "messages": "messages", "bytes": "bytes"}


def write(folder: Path, results: dict[str, Any]) -> Path:
    """results: {"run": score of the run, "about": text, "sweeps": ..., "camsim": ...}; the last two may be missing. The path of the page; trade.svg is its first figure."""
    (folder / "results.json").write_text(json.dumps(results, indent=1) + "\n")
    if "sweeps" in results:
        (folder / "trade.svg").write_text(trade(results) + "\n")
    page = folder / "report.html"
    page.write_text(to_html(results))
    return page


def to_html(results: dict[str, Any]) -> str:
    parts = [f"<!doctype html><html lang=en><meta charset=utf-8><title>A network of smart cameras</title><style>{_STYLE}</style><h1>A network of smart cameras</h1>",
             f"<p>{html.escape(results['about'])}</p><h2>The run</h2>", _table({"this run": results["run"]}), _kinds(results["run"])]
    if heads := results["run"].get("heads"):
        rows = "".join(f"<tr><td>{html.escape(name)}</td>" + "".join(f"<td>{one[key]:.0%}</td>" for key in ("busy", "shown", "close_up")) + "</tr>" for name, one in heads["each"].items())
        parts.append(f"<h2>Heads</h2><table><tr><th>head<th>follows somebody<th>of that, shows them<th>as a close-up</tr>{rows}</table><p>Close-ups of {heads['people']} people.</p>")
    parts.append(_graph(results["run"]))
    if sweeps := results.get("sweeps"):
        parts += ["<h2>Strategies, on what the cameras saw in this run</h2>", _table(sweeps["strategy"]), *figures(results)]
    return "".join(parts) + "</html>\n"


def figures(results: dict[str, Any]) -> list[str]:
    sweeps = results["sweeps"]
    out = [_figure(trade(results), "Utility against communication, both as shares of what ABC has: on pictures, in CamSim's kind of world without pictures, and as CamSim itself gives.")]
    for which, title in (("loss", "share of messages that are lost"), ("cameras", "cameras")):
        for key, name in (("relative_utility", "utility of the best possible"), ("idf1", "IDF1"), ("messages", "messages"), ("bytes", "bytes")):
            series = {strategy: [(value, one[key]) for value, one in sweeps[f"{which} {strategy}"].items()] for strategy in SWEPT}
            out.append(_figure(plot(title, name, series), f"{name} against {title}"))
    rounds = sweeps["rounds"]
    series = {"consensus": [(value, one["error_m"]) for value, one in rounds.items() if value], "owner's own": [(0, rounds[0]["error_m"])],
              "central": [(max(rounds), sweeps["strategy"]["central"]["error_m"])]}
    out.append(_figure(plot("rounds of consensus a step", "error on the floor, m", series), "The distributed filter"))
    out.append(_figure(plot("bytes", "error on the floor, m", {"consensus": [(one["bytes"], one["error_m"]) for one in rounds.values()]}), "What its rounds cost"))
    return out


def trade(results: dict[str, Any]) -> str:
    """The figure of Esterle et al. 2014: a point a strategy."""
    of, whole, plain = results["sweeps"]["strategy"], results["sweeps"]["strategy"]["ABC"], results["camsim"]
    series = {"on pictures": [(of[name]["searches"] / whole["searches"], of[name]["utility"] / whole["utility"]) for name in MEASURED],
              "no pictures": [(plain[name]["searches_share"], plain[name]["utility_share"]) for name in MEASURED],
              "CamSim itself": [(searches, utility) for utility, searches in MEASURED.values()]}
    return plot("communication (searches), share of ABC's", "utility, share of ABC's", series, list(MEASURED))


def _table(scores: dict[Any, dict[str, Any]]) -> str:
    head = "".join(f"<th>{title}" for title in COLUMNS.values())
    rows = "".join(f"<tr><td>{html.escape(str(name))}</td>" + "".join(f"<td>{_text(one.get(key))}</td>" for key in COLUMNS) + "</tr>" for name, one in scores.items())
    return f"<table><tr><th>{head}</tr>{rows}</table>"


def _kinds(score: dict[str, Any]) -> str:
    rows = "".join(f"<tr><td>{kind}</td><td>{count}</td><td>{score['bytes_by_kind'][kind]}</td></tr>" for kind, count in score["messages_by_kind"].items())
    return f"<table><tr><th>message<th>sent<th>bytes</tr>{rows}</table><p>{score['lost']} of them were lost.</p>"


def _graph(score: dict[str, Any]) -> str:
    names = sorted(score["overlap"])
    rows = "".join(f"<tr><td>{a}</td>" + "".join(f"<td>{score['graph'].get(a, {}).get(b, 0):.2f} <small>({score['overlap'][a].get(b, 0):.0%})</small></td>" for b in names) + "</tr>" for a in names)
    head = "".join(f"<th>to {name}" for name in names)
    return (f"<h2>The vision graph that hand-overs have left</h2><table><tr><th>pheromone{head}</tr>{rows}</table>"
            "<p>In parentheses, by truth: the share of the people of a row's camera that the column's sees too. Cameras without overlap hand over to who sees people next.</p>")


def _text(value: Any) -> str:
    return "-" if value is None else f"{value:.3f}".rstrip("0").rstrip(".") if isinstance(value, float) else str(value)


def _figure(svg: str, caption: str) -> str:
    return f"<figure>{svg}<figcaption>{html.escape(caption)}</figcaption></figure>"

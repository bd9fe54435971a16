"""/metrics of all nodes on one page, each sample with the label `node`, and what the farm knows of them (Prometheus text format 0.0.4)."""

from __future__ import annotations

import asyncio
import re
from typing import Any, Iterable

import aiohttp

from .door import Door
from .wire import url_of

_NODE_S = 2.0
_MAX_BYTES = 16 << 20
_AT_ONCE = 16
_SAMPLE = re.compile(r"(?P<name>[a-zA-Z_:][a-zA-Z0-9_:]*)(?:\{(?P<labels>.*)\})? (?P<value>\S+.*)")


def merged(pages: dict[str, str]) -> str:
    """Pages by node. The samples of a metric stay together, as the format demands."""
    metrics: dict[str, tuple[list[str], list[str]]] = {}  # by name: its HELP and TYPE, its samples
    for node, page in pages.items():
        name = ""
        for line in page.splitlines():
            if line.startswith("# "):
                name = line.split(" ", 3)[2]
                heads, _ = metrics.setdefault(name, ([], []))
                if line not in heads:
                    heads.append(line)
            elif found := _SAMPLE.fullmatch(line):
                labels = f'node="{node}"' + (f",{found['labels']}" if found["labels"] else "")
                metrics.setdefault(name, ([], []))[1].append(f"{found['name']}{{{labels}}} {found['value']}")
    return "".join("\n".join([*heads, *samples]) + "\n" for heads, samples in metrics.values())


def of_farm(nodes: dict[str, dict[str, Any]], answered: Iterable[str], owners: dict[str, str], full: Iterable[str]) -> str:
    """``answered``: nodes whose own page came."""
    lines: list[str] = []

    def metric(name: str, kind: str, text: str, samples: Iterable[tuple[str, Any]]) -> None:
        lines.extend([f"# HELP {name} {text}", f"# TYPE {name} {kind}", *(f"{name}{{{labels}}} {value}" for labels, value in samples)])

    def each(name: str, text: str, member: str, scale: float = 1, kind: str = "gauge") -> None:
        metric(name, kind, text, ((f'node="{node}"', round(report[member] * scale, 9)) for node, report in nodes.items() if report.get(member) is not None))

    there = set(answered)
    metric("camrig_farm_node_up", "gauge", "1: the node is there and its own page came.", ((f'node="{node}"', int(node in there)) for node in nodes))
    each("camrig_farm_node_sequencer", "1: puts the commands in order.", "is_sequencer")
    each("camrig_farm_node_log_entries_total", "Entries of the log that the node has done.", "applied", kind="counter")
    each("camrig_farm_node_clock_ahead_seconds", "Wall clock before the sequencer's.", "clock_ahead_ms", 1e-3)
    each("camrig_farm_node_clock_bound_seconds", "By how much that may be wrong.", "clock_bound_ms", 1e-3)
    costs = {node: round(sum(report.get("costs", {}).values()), 4) for node, report in nodes.items()}
    metric("camrig_farm_node_cost_cores", "gauge", "Of the cameras that it draws.", ((f'node="{node}"', cost) for node, cost in costs.items()))
    metric("camrig_farm_node_full", "gauge", "1: has more cameras than its cores can draw, and no other node has room.", ((f'node="{node}"', int(node in full)) for node in nodes))
    metric("camrig_farm_camera_owner", "gauge", "Which node a camera is read from.", ((f'node="{node}",camera="{camera}"', 1) for camera, node in owners.items()))
    return "\n".join(lines) + "\n"


def of_door(door: Door) -> str:
    return ("# HELP camrig_farm_door_wrong_tokens_total Shown to this door.\n# TYPE camrig_farm_door_wrong_tokens_total counter\n"
            f"camrig_farm_door_wrong_tokens_total {door.wrong_tokens.count}\n"
            "# HELP camrig_farm_door_bytes Requests and answers of clients that are on their way through this door.\n# TYPE camrig_farm_door_bytes gauge\n"
            f"camrig_farm_door_bytes {door.budget.used}\n")


async def page(door: Door, session: aiohttp.ClientSession) -> str:
    """One at a time."""
    async with door.scraping:
        return await _page(door, session)


async def _page(door: Door, session: aiohttp.ClientSession) -> str:
    nodes = door.nodes()
    status = await door.call("farm.status") if nodes else {"nodes": [], "cameras": []}
    at_once = asyncio.Semaphore(_AT_ONCE)

    async def of_node(report: dict[str, Any]) -> str | None:
        try:
            async with at_once, session.get(url_of(report, "/metrics"), timeout=aiohttp.ClientTimeout(_NODE_S)) as reply:
                text = bytearray()
                async for some in reply.content.iter_any():
                    text += some
                    if len(text) > _MAX_BYTES:
                        return None
                return text.decode()
        except (aiohttp.ClientError, asyncio.TimeoutError, ValueError):
            return None

    answered = zip(nodes, await asyncio.gather(*map(of_node, nodes.values())))
    pages = {node: text for node, text in answered if text is not None}
    owners, full = {camera["camera"]: camera["node"] for camera in status["cameras"]}, {node["node"] for node in status["nodes"] if node["is_full"]}
    return of_door(door) + of_farm(nodes, pages, owners, full) + merged(pages)

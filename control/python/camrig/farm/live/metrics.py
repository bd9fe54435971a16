"""/metrics of all nodes on one page, each sample with the label `node`, and what the farm knows of them (Prometheus text format 0.0.4)."""

from __future__ import annotations

import asyncio
import concurrent.futures
import http.server
import re
import threading
import urllib.request
from typing import Any, Iterable

from .door import Door

_NODE_S, _PAGE_S, _CLIENT_S = 2.0, 10.0, 5.0
_MAX_BYTES = 16 << 20
_AT_ONCE = 16
_SAMPLE = re.compile(r"(?P<name>[a-zA-Z_:][a-zA-Z0-9_:]*)(?:\{(?P<labels>.*)\})? (?P<value>\S+.*)")
_direct = urllib.request.build_opener(urllib.request.ProxyHandler({}))


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


def of_farm(nodes: dict[str, dict[str, Any]], answered: Iterable[str], owners: dict[str, str]) -> str:
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
    metric("camrig_farm_camera_owner", "gauge", "Which node a camera is read from.", ((f'node="{node}",camera="{camera}"', 1) for camera, node in owners.items()))
    return "\n".join(lines) + "\n"


class MetricsPage:
    """One scrape at a time, on a thread of its own; the farm's facts are asked on the loop that made it."""

    def __init__(self, door: Door, address: tuple[str, int]) -> None:
        self._door, self._loop = door, asyncio.get_running_loop()
        self._pool = concurrent.futures.ThreadPoolExecutor(_AT_ONCE)
        page = self

        class Handler(http.server.BaseHTTPRequestHandler):
            timeout = _CLIENT_S

            def do_GET(self) -> None:
                if self.path != "/metrics":
                    self.send_error(404, "there is /metrics")
                    return
                text = page.text().encode()
                self.send_response(200)
                self.send_header("Content-Type", "text/plain; version=0.0.4; charset=utf-8")
                self.send_header("Content-Length", str(len(text)))
                self.end_headers()
                self.wfile.write(text)

            def log_message(self, *_: Any) -> None: ...

        self._server = http.server.HTTPServer(address, Handler)

    def start(self) -> str:
        """Its URL."""
        threading.Thread(target=self._server.serve_forever, daemon=True).start()
        host, port = self._server.server_address[:2]
        return f"http://{host}:{port}/metrics"

    def text(self) -> str:
        nodes, owners = asyncio.run_coroutine_threadsafe(self._ask(), self._loop).result(_PAGE_S)
        pages = {node: page for node, page in zip(nodes, self._pool.map(self._page_of, nodes.values())) if page is not None}
        return of_farm(nodes, pages, owners) + merged(pages)

    async def _ask(self) -> tuple[dict[str, dict[str, Any]], dict[str, str]]:
        nodes = self._door.nodes()
        if not nodes:
            return {}, {}
        status = await self._door.call("farm.status")
        return nodes, {camera["camera"]: camera["node"] for camera in status["cameras"]}

    def _page_of(self, report: dict[str, Any]) -> str | None:
        fields = {"Authorization": f"Bearer {self._door.token}"} if self._door.token else {}
        try:
            with _direct.open(urllib.request.Request(f"http://{report['host']}:{report['http']}/metrics", headers=fields), timeout=_NODE_S) as reply:
                return reply.read(_MAX_BYTES).decode()
        except OSError:
            return None

"""The network in one process, on what its cameras saw in a run: as good as the processes of program.py (the same messages, to the byte), and hundreds of times as fast."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Iterable

from .messages import Link, Message
from .node import Node, phases, run_phase
from .sighting import Sighting, read_line


def read_sightings(folder: Path, names: Iterable[str]) -> dict[str, dict[int, list[Sighting]]]:
    """By camera and time: NAME.seen.jsonl of each."""
    return {name: dict(map(read_line, (folder / f"{name}.seen.jsonl").read_text().splitlines())) for name in names}


def log_line(now_ns: int, told: dict[str, Any], link: Link) -> dict[str, Any]:
    """What a node writes into its log after a step: what it said, and how much it has sent since the run began."""
    return {"t": now_ns, **told, "sent": dict(sorted(link.sent.items())), "bytes": dict(sorted(link.bytes.items())), "lost": link.lost}


def replay(nodes: list[Node], times: list[int], sightings: dict[str, dict[int, list[Sighting]]], rounds: int = 0, loss: float = 0.0, seed: int = 1) -> dict[str, list[dict[str, Any]]]:
    """The log of each node. Messages go the way they go on the bus: encoded, and each node gets those of a phase by sender and in the order in which they were sent."""
    links = {node.name: Link(loss, seed) for node in nodes}
    logs: dict[str, list[dict[str, Any]]] = {node.name: [] for node in nodes}
    for now_ns in times:
        boxes: dict[str, list[Message]] = {node.name: [] for node in nodes}
        for phase in phases(rounds):
            following: dict[str, list[Message]] = {node.name: [] for node in nodes}
            for node in sorted(nodes, key=lambda one: one.name):
                out, told = run_phase(node, phase, boxes[node.name], now_ns, sightings.get(node.name, {}).get(now_ns, []))
                for message in links[node.name].passes(out):
                    if message.to in following:
                        following[message.to].append(Message.decode(message.subject(), message.encode()))
                if told is not None:
                    logs[node.name].append(log_line(now_ns, told, links[node.name]))
            boxes = following
    return logs

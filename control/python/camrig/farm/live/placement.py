"""Which node a camera is read from.

By the names of camera and nodes alone (rendezvous hashing: Thaler, Ravishankar, "Using name-based mappings to increase hit rates",
IEEE/ACM ToN 1998): everybody says the same, and of a node that dies or comes only its own cameras move. Beside that stands a table of
exceptions, which the sequencer writes into the log when a node is full: a camera of it goes to the next node, in the camera's own order,
that has room (bounded loads: Mirrokni, Thorup, Zadimoghaddam, "Consistent hashing with bounded loads", SODA 2018).
"""

from __future__ import annotations

import hashlib
from typing import Any, Mapping, Sequence

#: Of a node's cores. Who is over the first gives cameras away until it is under the second, beyond which nobody is given any: what
#: has moved stays until its node goes.
FULL, ROOM = 0.8, 0.6


def order_of(camera: str, nodes: Sequence[str]) -> list[str]:
    """The first has the camera, the next when that has gone, and so on."""
    return sorted(nodes, key=lambda node: hashlib.sha256(f"{node}\0{camera}".encode()).digest(), reverse=True)


def owner_of(camera: str, nodes: Sequence[str], moved: Mapping[str, str] = {}) -> str:
    return moved[camera] if moved.get(camera) in nodes else order_of(camera, nodes)[0]


def loads_of(costs: Mapping[str, float], nodes: Sequence[str], moved: Mapping[str, str]) -> dict[str, float]:
    """Of each node, in cores."""
    load = dict.fromkeys(nodes, 0.0)
    for camera, cost in costs.items() if nodes else ():
        load[owner_of(camera, nodes, moved)] += cost
    return load


def full_of(costs: Mapping[str, float], cores: Mapping[str, float], moved: Mapping[str, str]) -> dict[str, float]:
    """Nodes that have more than they should, and how much."""
    return {node: load for node, load in loads_of(costs, sorted(cores), moved).items() if load > FULL * cores[node]}


def moves(costs: Mapping[str, float], cores: Mapping[str, float], moved: Mapping[str, str]) -> dict[str, str]:
    """The new table of exceptions. ``costs``: of cameras that are watched, in cores; ``cores``: of the nodes that can have cameras."""
    nodes = sorted(cores)
    table = {camera: node for camera, node in moved.items() if node in cores}
    load = loads_of(costs, nodes, table)
    for node in full_of(costs, cores, table):
        own = [camera for camera in costs if owner_of(camera, nodes, table) == node]
        for camera in sorted(own, key=lambda camera: (costs[camera], camera)):
            if load[node] <= ROOM * cores[node]:
                break
            for other in order_of(camera, nodes):
                if other != node and load[other] + costs[camera] <= ROOM * cores[other]:
                    table[camera] = other
                    load[node] -= costs[camera]
                    load[other] += costs[camera]
                    break
    return {camera: node for camera, node in sorted(table.items()) if order_of(camera, nodes)[0] != node}


def is_placeable(report: Mapping[str, Any]) -> bool:
    """Of a node's report: can it have cameras?"""
    return not any(report.get(why) for why in ("leaves", "clock_is_off", "is_behind"))

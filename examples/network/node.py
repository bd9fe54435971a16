"""What a step of the network is: the same for nodes in processes of their own (program.py), in lockstep or not, and for nodes in one process (replay.py)."""

from __future__ import annotations

from typing import Any, Protocol

from .messages import Message
from .sighting import Sighting


class Node(Protocol):
    """A member of the network. Thread: one. Every message it sends is returned; all it knows of others came by receive()."""

    name: str

    def begin(self, now_ns: int, sightings: list[Sighting]) -> list[Message]:
        """A new picture, and who is in it."""

    def receive(self, inbox: list[Message]) -> list[Message]:
        """Answers messages, at any time."""

    def settle(self) -> list[Message]:
        """Ends what waits for answers: auctions, claims. Who has not answered by now is late."""

    def share(self) -> list[Message]:
        """A round of consensus."""

    def finish(self) -> dict[str, Any]:
        """Ends the step: what the scorer's log says of it. Nothing of it reaches another node."""


def phases(rounds: int) -> list[str]:
    """The phases of a step in lockstep: what each sends arrives before the next begins. Offers; bids; awards; their acceptance; rounds of consensus."""
    return ["begin", "answer", "settle", "answer", *["share"] * rounds, "finish"]


def run_phase(node: Node, phase: str, inbox: list[Message], now_ns: int, sightings: list[Sighting]) -> tuple[list[Message], dict[str, Any] | None]:
    """What the node sends, and after the last phase its log."""
    if phase == "begin":
        return node.begin(now_ns, sightings), None
    out = node.receive(inbox)
    if phase == "settle":
        out += node.settle()
    elif phase == "share":
        out += node.share()
    return out, node.finish() if phase == "finish" else None

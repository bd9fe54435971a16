"""What nodes say to each other. docs/network.md has the table of types."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import dataclass, field
from typing import Any

from .chance import chance


@dataclass(frozen=True)
class Message:
    sender: str
    to: str
    kind: str
    time_ns: int  #: of the picture that it is about
    body: dict[str, Any] = field(default_factory=dict)

    def subject(self) -> str:
        return f"net.{self.to}.{self.kind}"

    def encode(self) -> bytes:
        return json.dumps({"from": self.sender, "t": self.time_ns, **self.body}, separators=(",", ":")).encode()

    @classmethod
    def decode(cls, subject: str, data: bytes) -> Message:
        """Raises ValueError for what is no message of ours."""
        try:
            _, to, kind = subject.split(".")
            body = json.loads(data)
            return cls(str(body.pop("from")), to, kind, int(body.pop("t")), body)
        except (ValueError, KeyError, TypeError, AttributeError) as problem:
            raise ValueError(f"{subject}: {data[:80]!r} is no message of this network: {problem!r}") from None


class Link:
    """A node's way out: loses a share of what is sent, the same messages in every run, and counts what was sent."""

    def __init__(self, loss: float, seed: int) -> None:
        self._loss, self._seed = loss, seed
        self._numbers: Counter[tuple[str, str, int]] = Counter()
        self.sent: Counter[str] = Counter()  #: messages by kind, lost ones too
        self.bytes: Counter[str] = Counter()  #: of their subjects and payloads
        self.lost = 0

    def passes(self, messages: list[Message]) -> list[Message]:
        """Those that arrive."""
        arrive = []
        for message in messages:
            self.sent[message.kind] += 1
            self.bytes[message.kind] += len(message.subject()) + len(message.encode())
            key = (message.to, message.kind, message.time_ns)
            self._numbers[key] += 1
            if self._loss and chance(self._seed, "link", message.sender, *key, self._numbers[key]) < self._loss:
                self.lost += 1
            else:
                arrive.append(message)
        if len(self._numbers) > 10_000:  # times pass and do not come again
            self._numbers.clear()
        return arrive

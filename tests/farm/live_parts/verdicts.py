"""A line for each thing that must hold."""

from __future__ import annotations


class Verdicts:
    def __init__(self) -> None:
        self.failed: list[str] = []

    def check(self, what: str, holds: bool, seen: object = "") -> None:
        print(f"{'ok  ' if holds else 'FAIL'}  {what}{f': {seen}' if seen != '' else ''}", flush=True)
        if not holds:
            self.failed.append(what)

"""Tracking on the floor by one node: Kalman filters, and an assignment of what was seen (Kuhn's Hungarian method, as scipy has it)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import linear_sum_assignment

from .kalman import Kalman
from .sighting import Sighting, alike

GATE = 13.8  # squared Mahalanobis distance of a measurement: 99.9 % of two degrees of freedom
LOOKS_WORTH = 12.0  # what quite unlike colours add to that distance
CONFIRMED = 3  # sightings that make a track one of a person
FORGET_S = 1.5  # without a sighting; a track that is owned lives as long as its owner wants
SMOOTHING = 0.5  # of values and colours, per sighting


@dataclass
class Track:
    number: int
    kalman: Kalman
    colours: np.ndarray  #: float, running mean
    value: float  #: how well it is seen now, smoothed
    before: float = 0.0  #: a step ago
    hits: int = 1
    seen_ns: int = 0
    sighting: Sighting | None = None  #: of this step
    sighting_place: np.ndarray = field(default_factory=lambda: np.zeros(2))  #: where it was last seen, m
    object: str | None = None  #: the network's name for it, as far as this node knows
    told_ns: int = 0  #: when it last learnt that

    def speaks(self) -> dict[str, object]:
        """What others need to recognise it."""
        return {"x": [round(float(v), 2) for v in self.kalman.x], "p": round(float(np.trace(self.kalman.P[:2, :2])) / 2, 2)}


class Tracks:
    def __init__(self) -> None:
        self._now_ns: int | None = None
        self._made = 0
        self.all: list[Track] = []

    def advance(self, now_ns: int) -> None:
        """To a new step, before what was seen in it."""
        dt_s = 0.0 if self._now_ns is None else (now_ns - self._now_ns) / 1e9
        self._now_ns = now_ns
        for track in self.all:
            track.kalman.predict(dt_s)
            track.before, track.sighting = track.value, None

    def see(self, sightings: list[Sighting]) -> None:
        """What one camera sees in this step; of several cameras one after the other."""
        left = set(range(len(sightings)))
        if self.all and sightings:
            cost = np.array([[self._cost(track, one) for one in sightings] for track in self.all])
            for row, column in zip(*linear_sum_assignment(np.minimum(cost, 1e6))):
                if cost[row, column] < GATE:
                    self._take(self.all[row], sightings[column])
                    left.discard(int(column))
        for index in sorted(left):
            self._begin(sightings[index])

    def settle(self, keep: set[str]) -> None:
        """Ends a step: what was not seen counts less, and what was not for long and is no object of `keep` is forgotten."""
        for track in self.all:
            if track.sighting is None:
                track.value *= 1 - SMOOTHING
                track.value = track.value if track.value > 0.02 else 0.0
        self.all = [track for track in self.all if self._now_ns - track.seen_ns <= FORGET_S * 1e9 or track.object in keep]

    def adopt(self, kalman: Kalman, colours: np.ndarray) -> Track:
        """A track that another node hands over and this one has not seen yet."""
        self._made += 1
        track = Track(self._made, kalman, colours.astype(float), 0.0, hits=CONFIRMED, seen_ns=self._now_ns or 0, sighting_place=kalman.x[:2].copy())
        self.all.append(track)
        return track

    def of(self, name: str) -> Track | None:
        return next((track for track in self.all if track.object == name), None)

    @staticmethod
    def _cost(track: Track, sighting: Sighting) -> float:
        distance2 = track.kalman.distance2(sighting.position, sighting.covariance)
        return distance2 + LOOKS_WORTH * (1 - alike(track.colours, sighting.colours)) if distance2 < GATE else 1e6

    def _take(self, track: Track, sighting: Sighting) -> None:
        track.kalman.update(sighting.position, sighting.covariance)
        track.colours = (1 - SMOOTHING / 4) * track.colours + SMOOTHING / 4 * sighting.colours
        if track.sighting is None:
            track.hits += 1
            track.value = (1 - SMOOTHING) * track.value + SMOOTHING * sighting.value
        track.sighting, track.sighting_place, track.seen_ns = sighting, sighting.position, self._now_ns or 0

    def _begin(self, sighting: Sighting) -> None:
        self._made += 1
        self.all.append(Track(self._made, Kalman(sighting.position, sighting.covariance), sighting.colours.astype(float),
                              SMOOTHING * sighting.value, seen_ns=self._now_ns or 0, sighting=sighting, sighting_place=sighting.position))

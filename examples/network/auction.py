"""Sealed-bid second-price auctions (Vickrey 1961), by which cameras hand objects over."""

from __future__ import annotations

from typing import Mapping, NamedTuple


class Sale(NamedTuple):
    winner: str
    price: float  #: what the winner pays


def vickrey(seller: str, reserve: float, bids: Mapping[str, float]) -> Sale:
    """Who gets the object: the highest bid above the seller's own value, at the second highest value.

    To bid the true value is then the best that a bidder can do, whatever others bid. The seller's `reserve` takes part as a bid; a tie stays with
    the seller, and among others goes to the first name, so that all who know the bids know the outcome.
    """
    best = min(bids, key=lambda name: (-bids[name], name), default=None)
    if best is None or bids[best] <= reserve:
        return Sale(seller, 0.0)
    return Sale(best, max([reserve, *(value for name, value in bids.items() if name != best)]))

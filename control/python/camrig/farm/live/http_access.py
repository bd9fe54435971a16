"""Who may ask by HTTP, as the rig's own server has it (rtsp_out/http/access.h and asking_page.h; docs/decisions/0090-who-may-command.md)."""

from __future__ import annotations

import hmac
import ipaddress
from typing import Mapping
from urllib.parse import urlsplit

from ...errors import CamrigError

_LOOKING = ("GET", "HEAD", "OPTIONS")
COOKIE = "camrig_token"


def is_loopback(name: str) -> bool:
    try:
        return ipaddress.ip_address(name).is_loopback
    except ValueError:
        return name.lower() == "localhost" or name.lower().endswith(".localhost")


def _name_of(host: str) -> str:
    return host[1:].partition("]")[0] if host.startswith("[") else host.partition(":")[0]


def token_of(headers: Mapping[str, str], query: Mapping[str, str], cookies: Mapping[str, str]) -> str:
    """That a request shows; empty: none."""
    scheme, _, shown = headers.get("Authorization", "").partition(" ")
    return shown.strip() if scheme.lower() == "bearer" and shown.strip() else query.get("token") or cookies.get(COOKIE, "")


def equal_tokens(shown: str, token: str) -> bool:
    return hmac.compare_digest(shown.encode("utf-8", "surrogateescape"), token.encode())


def check(method: str, headers: Mapping[str, str], own_name: str, has_token: bool, is_guarded: bool) -> None:
    """Raises CamrigError where a web page of another origin asks, or one whose name was bound to this machine anew."""
    def refuse(why: str) -> CamrigError:
        return CamrigError("unauthorized", f"a web page of another origin may neither command nor have pictures made ({why})")

    host = headers.get("Host")  # aiohttp takes no HTTP/1.1 without
    if host is not None and not has_token and not is_loopback(_name_of(host)) and _name_of(host).lower() != own_name.lower():
        raise CamrigError("unauthorized", f"Host '{host[:80]}' is not this server's; use localhost, 127.0.0.1 or the address given by --http")
    if method in _LOOKING and not is_guarded:
        return
    if headers.get("Sec-Fetch-Site", "none") not in ("same-origin", "none"):
        raise refuse("Sec-Fetch-Site")
    for name in ("Origin",) if method not in _LOOKING or "Origin" in headers else ("Referer",):
        if name in headers:
            try:
                page = urlsplit(headers[name])
            except ValueError:
                raise refuse(name) from None
            if page.scheme not in ("http", "https") or host is None or page.netloc.lower() != host.lower():
                raise refuse(name)

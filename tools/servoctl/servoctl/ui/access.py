# SPDX-License-Identifier: Apache-2.0
"""Who may talk to the server: only its own page, by Host and Origin; beyond this computer only with a token."""

from __future__ import annotations

import hmac
import ipaddress
import secrets
import socket
from collections.abc import Mapping
from dataclasses import dataclass
from http.cookies import SimpleCookie

COOKIE = "servoctl_token"
HTTP_PORT = 80
"""Browsers leave it out of Host."""


def is_loopback(host: str) -> bool:
    """The address is of this computer only."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def in_link(host: str) -> str:
    """An address or name in a link; for the one that stands for all of this computer's, its own in the network, or its name."""
    if host in ("0.0.0.0", "::"):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.connect(("192.0.2.1", 9))  # TEST-NET-1, RFC 5737: nothing is sent
                host = str(probe.getsockname()[0])
            except OSError:  # no network
                host = socket.gethostname()
    return f"[{host}]" if ":" in host else host


@dataclass(frozen=True)
class Access:
    """The rules of one server; `token` is empty when only this computer can connect."""

    hosts: tuple[str, ...]
    port: int
    token: str

    @classmethod
    def of(cls, host: str, port: int) -> Access:
        """For a server that listens there. A name or address that is not of this computer asks for a token."""
        if is_loopback(host):
            return cls(("127.0.0.1", "localhost", "[::1]", in_link(host)), port, "")
        return cls((), port, secrets.token_urlsafe(16))

    def refusal(self, headers: Mapping[str, str], token: str = "", needs_origin: bool = False) -> str | None:
        """One sentence, or None when the request is from our page. With a token any host will do: no other site knows
        it, and the cookie is not sent from there."""
        host = headers.get("host", "")
        if self.hosts and host not in [*(f"{name}:{self.port}" for name in self.hosts), *(self.hosts if self.port == HTTP_PORT else ())]:
            return f"This server is not {host or 'what the request names'}."
        origin = headers.get("origin")
        if (needs_origin and origin is None) or (origin is not None and origin != f"http://{host}"):
            return "Requests from other sites are refused."
        if self.token and not hmac.compare_digest((token or _cookie(headers)).encode(), self.token.encode()):
            return "This address needs the token that servoctl ui has printed: open the link as it is."
        return None


def _cookie(headers: Mapping[str, str]) -> str:
    found = SimpleCookie(headers.get("cookie", "")).get(COOKIE)
    return found.value if found else ""

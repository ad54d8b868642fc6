"""The names under which the page may be requested: addresses, and the names of this machine.

A foreign web page can make its own name lead to this machine (DNS rebinding); its scripts could
then read the page as their own. A browser says which name it requested, so a request under a
foreign name is refused. An address is not a name and cannot be rebound.
"""

from __future__ import annotations

import ipaddress
import socket
from urllib.parse import urlsplit

from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Receive, Scope, Send

FOREIGN = 421
"""HTTP: misdirected request."""


class OwnNamesOnly:
    """Refuses requests under a foreign name.

    Args:
        app: answers all other requests.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app
        self._machine = socket.gethostname()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answers one request."""
        host = next((value for name, value in scope.get("headers", ()) if name == b"host"), b"")
        if scope["type"] == "http" and not is_own(host.decode("latin-1"), self._machine):
            refusal = PlainTextResponse("this page is not served under that name", FOREIGN)
            await refusal(scope, receive, send)
        else:
            await self._app(scope, receive, send)


def is_own(host: str, machine: str) -> bool:
    """Whether the Host of a request is an address or a name of this machine.

    Args:
        host: as the browser sends it, with or without a port.
        machine: the machine's name.

    >>> [is_own(host, "drone") for host in ("127.0.0.1:8000", "[::1]", "localhost", "DRONE.local")]
    [True, True, True, True]
    >>> is_own("127.0.0.1.evil.example:8000", "drone")
    False
    """
    try:
        name = urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return False
    own = machine.lower()
    short = own.partition(".")[0]
    return _is_address(name) or name in {"localhost", own, short, f"{short}.local"}


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True

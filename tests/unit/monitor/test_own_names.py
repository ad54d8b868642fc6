"""The page answers under an address or a name of its machine, and under no other one."""

from __future__ import annotations

import asyncio
import socket

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.monitor.feed import Feed
from companion.monitor.own_names import FOREIGN, is_own
from companion.monitor.server import application

MACHINE = socket.gethostname()


def status_of(path: str, host: bytes | None) -> int:
    """What the page answers to a request that is made without a socket."""
    said: list[int] = []

    async def receive() -> dict[str, object]:
        return {"type": "http.request", "body": b"", "more_body": False}

    async def send(message: dict[str, object]) -> None:
        if message["type"] == "http.response.start":
            assert isinstance(message["status"], int)
            said.append(message["status"])

    headers = [] if host is None else [(b"host", host)]
    scope = {"type": "http", "method": "GET", "path": path, "query_string": b"", "headers": headers}
    asyncio.run(application(Feed())(scope, receive, send))  # type: ignore[arg-type]
    return said[0]


@pytest.mark.parametrize("host", ["127.0.0.1:8000", "[::1]:8000", "localhost", MACHINE])
def test_it_answers_under_its_own_names(host: str) -> None:
    assert status_of("/", host.encode()) == 200


@pytest.mark.parametrize("host", ["evil.example:8000", "127.0.0.1.evil.example", "", "[", None])
def test_it_does_not_answer_under_others(host: str | None) -> None:
    for path in ("/", "/index.html", "/stream"):
        assert status_of(path, None if host is None else host.encode()) == FOREIGN


@given(st.text(max_size=30))
def test_whatever_is_said_is_judged(host: str) -> None:
    assert is_own(f"{host}.evil.example", "drone") is False
    is_own(host, "drone")

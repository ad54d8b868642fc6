"""Server-sent events for many clients, none of which waits: the run that is shown, and its news.

A client that connects gets the mission, all events so far and the trail so far; afterwards what
is new. One that is slow loses snapshots but no event, since each event changes what is shown from
then on. Nothing is queued for a client: each only has a place in what was read.

Source: HTML Living Standard, 9.2 (server-sent events).
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Sequence
from typing import Any

from companion.flight_events.writing import line_of
from companion.monitor.follower import Follower
from companion.monitor.watching import Snapshot

MOST_AT_ONCE = 25
"""Snapshots that a client gets when it comes back; of more that it missed some are left out."""
MOST_OF_TRAIL = 6000
"""Snapshots that a client gets when it connects: 20 minutes of them, or thinned."""


class Feed:
    """The run that is shown now, and the news of it."""

    def __init__(self) -> None:
        self.run: Follower | None = None
        self._version = 0
        self._is_closed = False
        self._news = asyncio.Event()
        self._history = (-1, "")

    def show(self, run: Follower) -> None:
        """Shows another run from now on."""
        self.run = run
        self.tell()

    def tell(self) -> None:
        """Wakes all clients: there is news."""
        self._version += 1
        self._news.set()
        self._news = asyncio.Event()

    def close(self) -> None:
        """Ends all streams, after their last news."""
        self._is_closed = True
        self.tell()

    async def stream(self) -> AsyncIterator[str]:
        """Everything for one client, until the feed is closed."""
        cursor = ClientCursor()
        yield "retry: 2000\n\n"
        while True:
            version = self._version
            if self.run is not None and (text := self._news_for(cursor, self.run)):
                yield text
            if self._is_closed:
                return
            if version == self._version:
                await self._news.wait()

    def _news_for(self, cursor: ClientCursor, run: Follower) -> str:
        """What a client has not got yet; a whole history is written once for all who come."""
        if cursor.has_begun(run):
            return cursor.news(run)
        version, text = self._history
        if version != self._version:
            text = ClientCursor().news(run)
            self._history = self._version, text
        cursor.skip(run)
        return text


class ClientCursor:
    """How far one client has read."""

    def __init__(self) -> None:
        self._run: Follower | None = None

    def has_begun(self, run: Follower) -> bool:
        """Whether it has got the beginning of a run."""
        return run is self._run

    def skip(self, run: Follower) -> None:
        """It has got all that there is."""
        self._run = run
        self._events, self._snapshots = len(run.events), len(run.snapshots)

    def news(self, run: Follower) -> str:
        """What this client has not got yet."""
        text = ""
        most = MOST_AT_ONCE
        if not self.has_begun(run):
            self._events = self._snapshots = 0
            most = MOST_OF_TRAIL
            text = _message("mission", run.mission)
        events, snapshots = run.events[self._events :], run.snapshots[self._snapshots :]
        self.skip(run)
        if events:
            text += _message("events", [line_of(event) for event in events])
        if snapshots:
            text += _message("snapshots", [s.as_json() for s in thinned(snapshots, most)])
        return text


def thinned(snapshots: Sequence[Snapshot], most: int) -> Sequence[Snapshot]:
    """At most so many of some snapshots, evenly, the last one included.

    >>> thinned(list(range(10)), 4)
    [0, 3, 6, 9]
    """
    step = -(-len(snapshots) // most)
    return snapshots[(len(snapshots) - 1) % step :: step][-most:]


def _message(kind: str, data: Any) -> str:
    return f"event: {kind}\ndata: {json.dumps(data, separators=(',', ':'))}\n\n"

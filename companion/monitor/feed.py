"""Server-sent events of the shown run, for many clients, none of which delays another.

A client that connects gets the mission, all events and the trail so far, and then what is new. A
slow client loses snapshots but no events, because each event changes what is shown afterwards.
Nothing is queued for a client: each has only a position in what was read.

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
"""Most snapshots for a client that is late; if it missed more, some are left out."""
MOST_OF_TRAIL = 6000
"""Most snapshots for a client that connects: 20 minutes of them, or a selection."""


class Feed:
    """The run that is shown, and its news."""

    def __init__(self) -> None:
        self.run: Follower | None = None
        self._version = 0
        self._is_closed = False
        self._news = asyncio.Event()
        self._history = (-1, "")

    def show(self, run: Follower) -> None:
        """Shows another run."""
        self.run = run
        self.tell()

    def tell(self) -> None:
        """Wakes all clients, because there is news."""
        self._version += 1
        self._news.set()
        self._news = asyncio.Event()

    def close(self) -> None:
        """Ends all streams after their last news."""
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
        """What a client has not received yet; a whole history is encoded once for all clients."""
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
        """Whether it has received the beginning of a run."""
        return run is self._run

    def skip(self, run: Follower) -> None:
        """Marks everything as received."""
        self._run = run
        self._events, self._snapshots = len(run.events), len(run.snapshots)

    def news(self, run: Follower) -> str:
        """What this client has not received yet."""
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
            text += _message("snapshots", [s.as_json() for s in downsampled(snapshots, most)])
        return text


def downsampled(snapshots: Sequence[Snapshot], most: int) -> Sequence[Snapshot]:
    """At most `most` of some snapshots, evenly chosen, the last one included.

    >>> downsampled(list(range(10)), 4)
    [0, 3, 6, 9]
    """
    step = -(-len(snapshots) // most)
    return snapshots[(len(snapshots) - 1) % step :: step][-most:]


def _message(kind: str, data: Any) -> str:
    return f"event: {kind}\ndata: {json.dumps(data, separators=(',', ':'))}\n\n"

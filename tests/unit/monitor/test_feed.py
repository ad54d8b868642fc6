"""What a client of the stream gets: everything when it comes, then news, and never a backlog."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from companion.flight_events.event import Stamped
from companion.flight_events.skills import PlaceReached
from companion.flight_events.writing import line_of
from companion.monitor import feed as feed_module
from companion.monitor.feed import MOST_AT_ONCE, Feed, downsampled
from companion.monitor.follower import Follower


@pytest.fixture
def run(surveillance_run: Path) -> Follower:
    found = Follower(surveillance_run, is_live=True)
    while found.read():
        pass
    return found


async def received(stream: AsyncIterator[str]) -> list[tuple[str, Any]]:
    """What can be had without waiting for news."""
    found = []
    while (text := await next_without_news(stream)) is not None:
        for block in text.split("\n\n"):
            kind, _, data = block.partition("\ndata: ")
            if data:
                found.append((kind.removeprefix("event: "), json.loads(data)))
    return found


async def next_without_news(stream: AsyncIterator[str]) -> str | None:
    """The next text; None at the end, or if the stream waits after it has had its turn."""

    async def read() -> str | None:
        return await anext(stream, None)

    reading = asyncio.create_task(read())
    await asyncio.sleep(0)
    if not reading.done():
        reading.cancel()
        await asyncio.wait([reading])
        return None
    return reading.result()


def test_a_client_that_comes_late_gets_all_there_was(run: Follower) -> None:
    async def scenario() -> list[tuple[str, Any]]:
        feed = Feed()
        feed.show(run)
        feed.close()
        return await received(feed.stream())

    (kind, mission), (_, events), (_, snapshots) = asyncio.run(scenario())
    assert kind == "mission" and mission["name"] == "surveillance" and mission["is_live"]
    assert events == [json.loads(json.dumps(line_of(event))) for event in run.events]
    assert snapshots == [json.loads(json.dumps(s.as_json())) for s in run.snapshots]


def test_a_slow_client_loses_snapshots_and_no_event(run: Follower) -> None:
    async def scenario() -> tuple[str, str]:
        feed = Feed()
        feed.show(run)
        quick, slow = feed.stream(), feed.stream()
        for stream in (quick, slow):
            await anext(stream)
            await anext(stream)
        last = run.snapshots[-1]
        heard = ""
        for i in range(1, 201):
            run.snapshots.append(replace(last, time_s=last.time_s + i))
            run.events.append(Stamped(last.time_s + i, PlaceReached(f"{i}", "move")))
            feed.tell()
            heard += await anext(quick)
        return heard, await anext(slow)

    quick, slow = asyncio.run(scenario())
    assert quick.count('"link_age_s"') == 200 and quick.count('"kind":"at"') == 200
    assert slow.count('"link_age_s"') <= MOST_AT_ONCE and slow.count('"kind":"at"') == 200
    assert json.dumps(run.snapshots[-1].as_json(), separators=(",", ":")) in slow


def test_another_run_begins_with_its_mission(run: Follower, surveillance_run: Path) -> None:
    async def scenario() -> str:
        feed = Feed()
        feed.show(run)
        stream = feed.stream()
        await anext(stream)
        await anext(stream)
        feed.show(Follower(surveillance_run, is_live=True))
        return await anext(stream)

    assert asyncio.run(scenario()).startswith("event: mission\n")


def test_thinning_keeps_the_newest(run: Follower) -> None:
    for most in (1, 7, 100, 10_000):
        kept = downsampled(run.snapshots, most)
        assert len(kept) == min(len(kept), most) and kept[-1] is run.snapshots[-1]
        assert [s.time_s for s in kept] == sorted({s.time_s for s in kept})


@pytest.mark.long
def test_a_history_is_written_once_for_all_who_come(
    run: Follower, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Twenty who come at once cost what one costs, until there is news."""
    written: list[str] = []
    message = feed_module._message

    def counted(kind: str, data: Any) -> str:
        written.append(kind)
        return message(kind, data)

    async def come() -> list[list[tuple[str, Any]]]:
        feed = Feed()
        feed.show(run)
        first = [await received(feed.stream()) for _ in range(20)]
        feed.tell()
        return [*first, await received(feed.stream())]

    monkeypatch.setattr(feed_module, "_message", counted)
    histories = asyncio.run(come())
    assert all(history == histories[0] for history in histories)
    assert written == ["mission", "events", "snapshots"] * 2

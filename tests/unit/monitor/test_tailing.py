"""Files that grow between two looks, by any number of bytes, are read as if they had been whole."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.flight_events.event import Stamped
from companion.flight_events.sortie import GoalFailed, Phase, PhaseEntered
from companion.flight_events.writing import line_of
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.monitor.tailing import EventLines, TlogFrames

HAPPENED = [Stamped(i / 10, GoalFailed("“é”" * i)) for i in range(6)]
EVENTS = "".join(
    json.dumps(line_of(stamped), ensure_ascii=False) + "\n" for stamped in HAPPENED
).encode()


def frame(value: int) -> bytes:
    return MavlinkCodec(1, 26).pack(dialect.MAVLink_named_value_int_message(value, b"it", value))


BATCHES = [(10.0, [frame(1), frame(2)]), (10.05, [frame(3)]), (10.1, [frame(4), frame(5)])]
TLOG = b"".join(
    struct.pack(">Q", round(unix_s * 1e6)) + each for unix_s, frames in BATCHES for each in frames
)
cuts = st.lists(st.integers(0, 600), max_size=6).map(sorted)


@given(cuts)
def test_lines(sizes: list[int]) -> None:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "events.jsonl"
        reader, found = EventLines(path), []
        for size in [*sizes, len(EVENTS)]:
            path.write_bytes(EVENTS[:size])
            found += reader.news()
    assert found == HAPPENED


@pytest.mark.slow
@given(cuts)
def test_frames(sizes: list[int]) -> None:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "flight.tlog"
        reader, found = TlogFrames(path), []
        for size in [*sizes, len(TLOG)]:
            path.write_bytes(TLOG[:size])
            batches, is_more = reader.news()
            assert not is_more
            found += batches
    assert found == BATCHES[:-1], "the newest time may not be complete"


def test_what_is_no_event_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "events.jsonl"
    no_events = b'[1]\n{"type": 3}\n{"t_s": NaN, "type": "TreeStopped"}\nnonsense\n'
    event = Stamped(1.0, PhaseEntered(Phase.ARMING))
    line = json.dumps(line_of(event)).encode() + b"\n"
    path.write_bytes(no_events + line + b'{"t_s": 2, "type": "P')
    assert EventLines(path).news() == [event]


def test_nothing_is_read_behind_damage(tmp_path: Path) -> None:
    path = tmp_path / "flight.tlog"
    path.write_bytes(TLOG + b"\0" * 40 + TLOG)
    reader = TlogFrames(path)
    batches, is_more = reader.news()
    assert batches == BATCHES[:-1] and not is_more
    assert reader.news() == ([], False)


def test_files_that_are_not_there_yet_have_no_news(tmp_path: Path) -> None:
    assert EventLines(tmp_path / "a").news() == []
    assert TlogFrames(tmp_path / "b").news() == ([], False)

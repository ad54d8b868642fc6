"""The client reads from our own server, over a link that loses and repeats."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st

from companion.ground.ftp import FtpServer
from companion.ground.mission_store import MissionStore
from companion.mavlink.ftp_frames import DATA_BYTES
from companion.mavlink.ftp_reading import ANSWER_S, AT_ONCE, TRIES, FileReading, ReadingState

TICK_S = 0.05
CLIENT = (1, 191)
MOST = 50_000


class Link:
    """Between a reading and a server with one file."""

    def __init__(self, root: Path, content: bytes, loss: float = 0.0, seed: int = 0) -> None:
        root.mkdir(exist_ok=True)
        (root / "words.json").write_bytes(content)
        self.server = FtpServer(MissionStore(root))
        self.loss, self.chance = loss, random.Random(seed)
        self.now_s = 0.0
        self.most_at_once = 0

    def read(
        self, path: str = "words.json", most_bytes: int = MOST, limit_s: float = 200.0
    ) -> FileReading:
        reading = FileReading(path, most_bytes, 65530)
        end_s = self.now_s + limit_s
        while reading.state is not ReadingState.ENDED and self.now_s < end_s:
            self.now_s += TICK_S
            payloads = reading.due(self.now_s)
            self.most_at_once = max(self.most_at_once, len(payloads))
            for payload in payloads:
                self.carry(reading, payload)
        return reading

    def carry(self, reading: FileReading, payload: bytes) -> None:
        if self.chance.random() < self.loss:
            return
        for answer in self.server.receive(self.now_s, CLIENT, payload):
            for _ in range(self.chance.choice((1, 1, 2)) if self.loss else 1):
                if self.chance.random() >= self.loss:
                    reading.take(answer)


@pytest.mark.parametrize("size", [0, 1, DATA_BYTES - 1, DATA_BYTES, DATA_BYTES + 1, 16_460])
def test_a_file_of_any_size_is_read_and_closed(tmp_path: Path, size: int) -> None:
    content = random.Random(size).randbytes(size)
    link = Link(tmp_path / "root", content)
    first, second = link.read(), link.read()  # the session of the first was closed
    assert (first.content, second.content) == (content, content)
    assert link.most_at_once <= AT_ONCE
    assert link.now_s / 2 < 1.0 + size / DATA_BYTES / AT_ONCE * TICK_S * 1.5


@drawn(30)
@given(st.floats(0.0, 0.5), st.integers(0, 2**32), st.integers(0, 6000))
def test_a_link_that_loses_gives_the_same_file_or_none(
    tmp_path_factory: pytest.TempPathFactory, loss: float, seed: int, size: int
) -> None:
    content = random.Random(seed).randbytes(size)
    reading = Link(tmp_path_factory.mktemp("lossy"), content, loss, seed).read()
    assert reading.state is ReadingState.ENDED
    assert reading.content == content or (reading.content is None and reading.why_not)
    if loss <= 0.3:
        assert reading.content == content


def test_what_is_not_there_or_is_too_large_is_not_read(tmp_path: Path) -> None:
    link = Link(tmp_path / "root", bytes(2000))
    for reading, why_not in (
        (link.read("other.json"), "file not found"),
        (link.read(most_bytes=1999), "it has 2000 bytes, more than 1999"),
    ):
        assert (reading.content, reading.why_not) == (None, why_not)
    assert link.read().content == bytes(2000)


def test_silence_ends_it(tmp_path: Path) -> None:
    link = Link(tmp_path / "root", bytes(2000), loss=1.0)
    reading = link.read()
    assert (reading.content, reading.why_not) == (None, "no answer")
    assert link.now_s < (TRIES + 3) * (ANSWER_S + 2 * TICK_S)


@given(st.lists(st.binary(min_size=251, max_size=251) | st.binary(max_size=30), max_size=30))
def test_no_payload_raises(payloads: list[bytes]) -> None:
    reading = FileReading("words.json", MOST, 0)
    for at, payload in enumerate(payloads):
        assert len(reading.due(at * TICK_S)) <= AT_ONCE
        reading.take(payload)

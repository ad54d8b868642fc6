"""The loop: who hosts answers at once, who flies keeps to the ticks; simulated time."""

from __future__ import annotations

import gc
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from autopilot import Autopilot, of_type
from notes import Notes
from preparations import Polled
from synthetic import mission

from companion import driving
from companion.app import Companion
from companion.driving import fly
from companion.flight_events.event import FlightEvent, Stamped
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mission.model import Mission
from companion.mission_run import Recorder
from companion.run_sources.hosted_runs import HostedRuns
from companion.tick import TICK_S

UNDER_WAY_S = 0.002
"""From one end to the other."""
START, REQUEST = dialect.MAV_CMD_MISSION_START, dialect.MAV_CMD_REQUEST_MESSAGE
STREAM_S = 0.02
"""Between two messages of the autopilot, so that something else arrives as well."""


class Line(Notes):
    """Link and clock of a companion that hosts, its host and recorder, and a ground station.

    The ground station asks one question after the other, each when the last one was answered,
    until a time; then it starts the mission.
    """

    endpoint = "udpin://0.0.0.0:14540"
    uploads = None
    zero_s, speed = 700.0, 1.0

    def __init__(self, asks_until_s: float) -> None:
        super().__init__()
        self.companion = Companion(HostedRuns(self, mission("F at(A)")))
        self.now = 0.0
        self.steps_s: list[float] = []
        self.beats_s: list[float] = []
        self.began_s = self.ended_s = 0.0
        self.answers = 0
        self.round_trips_s: list[float] = []
        self.shown_s: list[float] = []
        self.set_aside_before = self.set_aside = 0
        self._asks_until_s = asks_until_s
        self._autopilot, self._station = Autopilot(), MavlinkCodec(255, 190)
        self._ear = MavlinkCodec(0, 0)
        self._under_way: list[tuple[float, bytes]] = []
        self._streamed_s = 0.0
        self._ask(REQUEST)

    # -- link and clock ------------------------------------------------------------------------

    def now_s(self) -> float:
        return self.now

    def wall_s_until(self, time_s: float) -> float:
        return time_s - self.now

    def sleep_until(self, time_s: float) -> None:
        self.now = max(self.now, time_s)

    def wait(self, timeout_s: float) -> bool:
        self._stream(self.now + timeout_s)
        arrival_s = min((at_s for at_s, _ in self._under_way), default=float("inf"))
        end_s = self.now + max(0.0, timeout_s)
        self.now = max(self.now, min(arrival_s, end_s))
        return arrival_s <= end_s

    def receive(self) -> list[bytes]:
        self._stream(self.now)
        arrived = [datagram for at_s, datagram in self._under_way if at_s <= self.now]
        self._under_way = [each for each in self._under_way if each[0] > self.now]
        return arrived

    def send(self, datagrams: list[bytes]) -> None:
        self.steps_s.append(self.now)
        for answer in self._autopilot.answer(datagrams):
            self._under_way.append((self.now + UNDER_WAY_S, answer))
        heard: list[Any] = [m for d in datagrams for m in self._ear.parse(d)]
        self.beats_s += [self.now for _ in of_type(heard, "HEARTBEAT")]
        for acknowledged in of_type(heard, "COMMAND_ACK"):
            self.answers += acknowledged.command == REQUEST
            if acknowledged.command == REQUEST:
                self._ask(REQUEST if self.now < self._asks_until_s else START)

    def answer(self, datagrams: list[bytes]) -> None:
        """What leaves within a step: the time that the autopilot has asked for."""
        for message in (m for d in datagrams for m in self._ear.parse(d)):
            self.shown_s.append(message.tc1 / 1e9 - self.now)
            self.round_trips_s.append(self.now + UNDER_WAY_S - message.ts1 / 1e9)

    def discard(self) -> None:
        raise AssertionError("nothing here pauses")

    def account(self) -> str:
        return "nothing arrived"

    def news(self) -> list[FlightEvent]:
        return []

    def _ask(self, command: int) -> None:
        asked = dialect.MAVLink_command_long_message(1, 191, command, 0, 148, 0, 0, 0, 0, 0, 0)
        self._under_way.append((self.now + 2 * UNDER_WAY_S, self._station.pack(asked)))

    def _stream(self, until_s: float) -> None:
        while self._streamed_s <= until_s:
            self._under_way += [(self._streamed_s, d) for d in self._autopilot.telemetry()]
            question = dialect.MAVLink_timesync_message(0, round(self._streamed_s * 1e9))
            self._under_way.append(
                (self._streamed_s + UNDER_WAY_S, self._autopilot.codec.pack(question))
            )
            self._streamed_s += STREAM_S

    # -- host and recorder ---------------------------------------------------------------------

    def load(self, path: Path) -> Mission:
        raise AssertionError("nothing is uploaded")

    def prepare(
        self, mission: Mission, speed_max_mps: float, ground_amsl_m: float | None
    ) -> Polled:
        return Polled(mission, speed_max_mps)

    def begin_run(self, mission: Mission) -> Recorder:
        self.began_s, self.set_aside_before = self.now, gc.get_freeze_count()
        return self

    def end_run(self, recorder: Recorder) -> None:
        self.ended_s, self.set_aside = self.now, gc.get_freeze_count()
        self.companion.stop()

    def tell(self, stamped: Stamped) -> None:
        """Told to nobody."""


@pytest.fixture(scope="module")
def line() -> Line:
    """Ten seconds of questions, then a flight."""
    gc.unfreeze()  # the tests
    line = Line(asks_until_s=10.0)
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(driving, "gc", gc)
        fly(line.companion, line, line, 0.0)  # type: ignore[arg-type]
    gc.freeze()
    return line


@pytest.mark.slow
def test_a_question_waits_for_no_tick_while_nothing_is_flown(line: Line) -> None:
    """One after the other takes the way there and back, and no more."""
    round_trip_s = 2 * UNDER_WAY_S
    assert line.answers == pytest.approx(10.0 / round_trip_s, rel=0.01)


def test_a_flight_keeps_to_the_ticks_from_its_first_step(line: Line) -> None:
    flown = [at_s for at_s in line.steps_s if line.began_s <= at_s <= line.ended_s]
    assert line.ended_s - line.began_s > 5.0
    assert [b - a for a, b in pairwise(flown)] == pytest.approx([TICK_S] * (len(flown) - 1))
    before = max(at_s for at_s in line.steps_s if at_s < line.began_s)
    assert line.began_s - before <= TICK_S + 1e-9


def test_the_heartbeat_is_the_same_with_and_without_questions(line: Line) -> None:
    while_asked = [at_s for at_s in line.beats_s if at_s < 10.0]
    gaps = [later - earlier for earlier, later in pairwise(while_asked)]
    assert len(gaps) >= 8
    assert all(1.0 - 1e-9 <= gap <= 1.0 + TICK_S for gap in gaps)


def test_in_flight_a_question_for_the_time_waits_for_no_tick(line: Line) -> None:
    """PX4 takes no answer that has been 10 ms or more on its way."""
    assert len(line.round_trips_s) > 100
    assert max(line.round_trips_s) == pytest.approx(2 * UNDER_WAY_S)
    assert line.shown_s == pytest.approx([line.zero_s] * len(line.shown_s), abs=1e-9)


def test_in_flight_what_was_there_before_is_not_searched_for_garbage(line: Line) -> None:
    assert line.set_aside_before == 0
    assert line.set_aside > 10_000

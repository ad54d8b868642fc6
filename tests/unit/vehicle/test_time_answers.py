"""Who is answered what time, how often, and what the autopilot makes of it."""

from __future__ import annotations

from typing import Any

import pytest
from autopilot import Autopilot
from notes import Notes
from synthetic import mission

from companion.app import Companion
from companion.flights.simulated_world import lockstep, world_of
from companion.flights.sortie_host import SortieHost
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.run_sources.hosted_runs import HostedRuns
from companion.run_sources.only_run import OnlyRun
from companion.skills.runner import FunctionRunner
from companion.vehicle.boot_clock import BootClock, ClockOffset
from companion.vehicle.time_answers import LEAST_S, NANO
from companion.vehicle.wire import Wire
from sitl.link.routing import LinkName
from sitl.link.time_offset import CONVERGED, DEVIATIONS_MAX, TimeOffset

HEARTBEAT = Autopilot().telemetry()[0]
EAR = MavlinkCodec(0, 0)


def question(stamp: int, system: int = 1, component: int = 1, tc1: int = 0) -> bytes:
    return MavlinkCodec(system, component).pack(dialect.MAVLink_timesync_message(tc1, stamp))


def answers(wire: Wire, now_s: float, *datagrams: bytes) -> list[tuple[int, int]]:
    messages: list[Any] = [m for d in wire.answers(now_s, list(datagrams)) for m in EAR.parse(d)]
    assert all(m.get_srcComponent() == 191 for m in messages)
    return [(message.tc1, message.ts1) for message in messages]


@pytest.fixture
def wire() -> Wire:
    """Of a vehicle that was heard."""
    wire = Wire()
    wire.listen(frozenset(), frozenset())
    wire.parse([HEARTBEAT])
    return wire


def test_the_answer_has_our_time_and_the_question(wire: Wire) -> None:
    wire.time.zero_s = 100.0
    assert answers(wire, 2.5, question(77)) == [(round(102.5 * NANO), 77)]


def test_two_questions_are_answered_once_each(wire: Wire) -> None:
    """They are met once more with all that has arrived within the tick."""
    assert len(answers(wire, 2.5, question(77))) == len(answers(wire, 2.53, question(78))) == 1
    assert answers(wire, 2.56, question(77), question(78)) == []


def test_nobody_is_answered_before_the_vehicle_was_heard() -> None:
    assert answers(Wire(), 2.5, question(77)) == []


@pytest.mark.parametrize(
    "other",
    [
        pytest.param(question(77, system=2), id="another vehicle's autopilot"),
        pytest.param(question(77, component=190), id="a ground station"),
        pytest.param(question(77, component=191), id="another companion, or our own sent back"),
        pytest.param(question(77, tc1=5), id="an answer to a question of ours"),
    ],
)
def test_others_are_not_answered(wire: Wire, other: bytes) -> None:
    assert answers(wire, 2.5, other) == []
    assert answers(wire, 2.5, other, question(78)) == [(round(2.5 * NANO), 78)]


def test_a_question_is_answered_once(wire: Wire) -> None:
    """In flight it is seen when it arrives, and again in the next tick."""
    assert len(answers(wire, 2.50, question(77))) == 1
    assert answers(wire, 2.54, question(77)) == []
    assert len(answers(wire, 2.60, question(78))) == 1


def test_a_flood_is_not_answered_by_a_flood(wire: Wire) -> None:
    flood = [question(stamp) for stamp in range(500)]
    answered = sum(len(answers(wire, tick * 0.05, *flood)) for tick in range(20))
    assert answered <= 20 <= 1.0 / LEAST_S


def test_an_answer_is_never_taken_for_a_question(wire: Wire) -> None:
    assert answers(wire, 0.0, question(77)) == [(1, 77)]


def test_what_was_answered_is_recorded_once(wire: Wire) -> None:
    sent = wire.answers(2.5, [question(77)])
    assert wire.take_answered() == sent
    assert wire.take_answered() == []


def test_a_companion_that_flies_nothing_answers_too() -> None:
    never: Any = pytest.fail
    host = SortieHost(never, never, None, FunctionRunner())
    companion = Companion(HostedRuns(host))
    heard = [HEARTBEAT, question(77)]
    sent: list[Any] = [m for d in companion.step(2.0, heard) for m in EAR.parse(d)]
    assert [m.ts1 for m in sent if m.get_type() == "TIMESYNC" and m.tc1 > 0] == [77]


def test_our_clock_beside_the_autopilots() -> None:
    """It has booted at 1000.03: it reads its clock 30 ms after it was asked, of 40."""
    clock = BootClock()
    assert clock.offset is None
    (asked,) = clock.due(1010.0)
    clock.take(1010.04, dialect.MAVLink_timesync_message(10 * NANO, asked.ts1))
    offset = clock.offset
    assert offset == pytest.approx(ClockOffset(1000.02, 0.02))
    assert offset is not None and abs(offset.offset_s - 1000.03) <= offset.uncertainty_s


# -- the other end ---------------------------------------------------------------------------------


def test_the_autopilot_finds_the_offset_and_follows_a_drift() -> None:
    """Our clock is 1 s ahead and 20 millionths too fast; the way is 2 ms each time."""
    offset = TimeOffset()
    asked_us, remote_us = 0, 0.0
    for k in range(4 * CONVERGED):
        asked_us = 5_000_000 + k * 100_000
        remote_us = (asked_us + 2_000) * (1 + 20e-6) + 1_000_000
        offset.take(asked_us + 4_000, round(remote_us * 1000), asked_us * 1000)
    assert offset.is_converged
    assert offset.estimated_us == pytest.approx(asked_us + 2_000 - remote_us, abs=100)


def test_the_autopilot_leaves_out_what_was_long_on_its_way() -> None:
    offset = TimeOffset()
    offset.take(1_010_000, 5_000_000, 1_000_000_000)
    assert (offset.taken, offset.round_trip_us) == (0, 10_000)
    offset.take(1_009_999, 5_000_000, 1_000_000_000)
    assert offset.taken == 1


def test_the_autopilot_begins_anew_with_another_clock() -> None:
    offset = TimeOffset()
    for k in range(CONVERGED):
        offset.take(k * 100_000, k * 100_000_000, k * 100_000_000)
    assert offset.is_converged and offset.estimated_us == 0.0
    for k in range(CONVERGED, CONVERGED + DEVIATIONS_MAX + 2):
        offset.take(k * 100_000, k * 100_000_000 + 10**9, k * 100_000_000)
    assert not offset.is_converged
    assert offset.estimated_us == -1e6


@pytest.mark.parametrize("zero_s", [pytest.param(None, marks=pytest.mark.long), 5000.0])
def test_in_lockstep_the_autopilot_knows_our_clock(zero_s: float | None) -> None:
    """It counts from the same moment, so that it is behind by what our clock showed then."""
    asked = mission("F at(A)")
    companion = Companion(OnlyRun(asked, Notes()))
    flight = lockstep(companion, world_of(asked, {"version": 1, "lidar": {}}))
    flight.companion.wire.time.zero_s = zero_s
    while flight.now_s < 12.0:
        flight.tick()
    offset = flight.simulation.time_offset(LinkName.OFFBOARD)
    assert offset.taken > 50
    assert offset.round_trip_us < 10_000
    assert offset.estimated_us == pytest.approx(-1e6 * (zero_s or 0.0), abs=1.0)

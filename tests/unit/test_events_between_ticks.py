"""In flight the loop wakes for an event that the plan watches: one step more, and no tick moves."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

import pytest
from autopilot import Autopilot, of_type
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st
from notes import Notes
from synthetic import event, mission, move, skill

from companion.app import Companion
from companion.clock import ScaledClock
from companion.driving import fly
from companion.flight_events.event import FlightEvent
from companion.flight_events.plans import PlanReplaced
from companion.flight_events.sortie import Phase
from companion.flight_events.tree import NodesChanged
from companion.geometry import Ned, distance
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mission.model import Mission
from companion.mission.steps import Charge, Land, TakeOff
from companion.run_sources.only_run import OnlyRun
from companion.tick import TICK_S

STREAM_S = 0.02
"""Between two messages of the autopilot, so that something else arrives as well."""
PATROL = {"a": "G F at(A)", "b": "G F (at(B) | red)", "c": "G F (at(C) | !red)"}
GREEN = "G (green -> F at(A))"
"""Watched, and never a reason for another plan."""


class ScriptedClock(ScaledClock):
    """A clock that sleeps by moving its own wall time on."""

    def __init__(self, speed: float) -> None:
        self.wall_s = 0.0
        super().__init__(speed, monotonic_s=lambda: self.wall_s)

    def sleep_until(self, time_s: float) -> None:
        self.wall_s += max(0.0, self.wall_s_until(time_s))


class Line(Notes):
    """A link, with an autopilot at its other end, and what is said to it at given times.

    Attributes:
        steps: when the companion stepped, and the setpoint that left then.
        said: when something was said.
    """

    endpoint = "udpin://0.0.0.0:14540"

    def __init__(self, mission: Mission, speed: float = 1.0, end_s: float = 12.0) -> None:
        super().__init__()
        self.clock = ScriptedClock(speed)
        self.companion = Companion(OnlyRun(mission, self))
        self.autopilot = Autopilot()
        self.steps: list[tuple[float, Ned | None]] = []
        self.said: list[float] = []
        self.acts: list[tuple[float, Callable[[], object]]] = []
        self._speed, self._end_s = speed, end_s
        self._target, self._ear = MavlinkCodec(1, 42), MavlinkCodec(0, 0)
        self._station = MavlinkCodec(255, 190)
        self._under_way: list[tuple[float, bytes]] = []
        self._streamed_s = 0.0

    def say(self, at_s: float, name: str, value: int, times: int = 1) -> Line:
        """Somebody on board says the value of a name."""
        said = dialect.MAVLink_named_value_int_message(0, name.encode(), value)
        self._under_way += [(at_s, self._target.pack(said)) for _ in range(times)]
        self.said.append(at_s)
        return self

    def command(self, at_s: float, command: int, *parameters: float) -> Line:
        """A ground station commands the companion."""
        filled = (*parameters, *[0.0] * (7 - len(parameters)))
        asked = dialect.MAVLink_command_long_message(1, 191, command, 0, *filled)
        self._under_way.append((at_s, self._station.pack(asked)))
        return self

    def at(self, at_s: float, act: Callable[[], object]) -> Line:
        """Something happens to the autopilot."""
        self.acts.append((at_s, act))
        return self

    def fly(self) -> Line:
        fly(self.companion, self, self.clock, 0.0)  # type: ignore[arg-type]
        return self

    @property
    def extra(self) -> list[float]:
        """The steps that are no ticks."""
        return [at_s for at_s, _ in self.steps if not is_on_grid(at_s)]

    def setpoint_at(self, at_s: float) -> Ned | None:
        """The setpoint that left in a step."""
        return next(place for time_s, place in self.steps if abs(time_s - at_s) < 1e-6)

    # -- link ----------------------------------------------------------------------------------

    def wait(self, timeout_s: float) -> bool:
        now_s, wait_s = self.clock.now_s(), max(0.0, timeout_s)
        self._stream(now_s + wait_s * self._speed)
        arrival_s = min((at_s for at_s, _ in self._under_way), default=math.inf)
        self.clock.wall_s += min(max(0.0, arrival_s - now_s) / self._speed, wait_s)
        return arrival_s <= now_s + wait_s * self._speed

    def receive(self) -> list[bytes]:
        now_s = self.clock.now_s() + 1e-9
        self._stream(now_s)
        arrived = [datagram for at_s, datagram in self._under_way if at_s <= now_s]
        self._under_way = [each for each in self._under_way if each[0] > now_s]
        return arrived

    def send(self, datagrams: list[bytes]) -> None:
        now_s = self.clock.now_s()
        for answer in self.autopilot.answer(datagrams):
            self._under_way.append((now_s + 0.002, answer))
        heard: list[Any] = [m for d in datagrams for m in self._ear.parse(d)]
        told = of_type(heard, "SET_POSITION_TARGET_LOCAL_NED")
        assert len(told) <= 1
        self.steps.append((now_s, (told[0].x, told[0].y, told[0].z) if told else None))
        if now_s > self._end_s:
            self.companion.stop()
            assert now_s < self._end_s + 60.0
        for at_s, act in [each for each in self.acts if each[0] <= now_s]:
            self.acts.remove((at_s, act))
            act()

    def account(self) -> str:
        return "nothing arrived"

    def news(self) -> list[FlightEvent]:
        return []

    def _stream(self, until_s: float) -> None:
        while self._streamed_s <= until_s:
            self._under_way += [(self._streamed_s, d) for d in self.autopilot.telemetry()]
            self._streamed_s += STREAM_S


def is_on_grid(at_s: float) -> bool:
    return abs(at_s / TICK_S - round(at_s / TICK_S)) < 1e-5


def patrol(for_s: float = 0.0, **more: str) -> Mission:
    """A and B in turn, or A and C while it is red; nobody asks for blue."""
    events = [event("red", for_s=for_s), event("green"), event("blue")]
    return mission({**PATROL, **more}, "HABC", [move()], events)


def assert_ticks_stay(line: Line) -> None:
    """Every tick is there, at its time, and there is at most one step between two of them."""
    numbers = [round(at_s / TICK_S) for at_s, _ in line.steps if is_on_grid(at_s)]
    assert numbers == list(range(len(numbers)))
    between = [math.floor(at_s / TICK_S) for at_s in line.extra]
    assert len(between) == len(set(between))


def replanned_s(line: Line) -> list[float]:
    return [s.time_s for s in line.reports if isinstance(s.event, PlanReplaced)]


def flown_s(line: Line) -> float:
    """When the first setpoint of the first new plan is sent: its move is ticked."""
    kinds = [type(s.event) for s in line.reports]
    told = [s for s in line.reports[kinds.index(PlanReplaced) :] if s.event.kind == "status"]
    moves = [s for s in told if isinstance(s.event, NodesChanged) and "move" in s.event.tip]
    return moves[0].time_s


@pytest.mark.parametrize("speed", [1.0, 4.0, pytest.param(0.25, marks=pytest.mark.long)])
def test_a_new_plan_is_flown_from_the_moment_of_its_event(speed: float) -> None:
    line = Line(patrol(), speed).say(7.013, "red", 1).fly()
    assert line.extra == pytest.approx([7.013])
    assert (replanned_s(line), flown_s(line)) == ([7.013], 7.013)
    assert_ticks_stay(line)


def test_without_a_step_more_it_is_flown_from_the_tick_after_that_in_which_it_is_made() -> None:
    line = Line(patrol()).say(7.05, "red", 1).fly()
    assert line.extra == []
    assert (replanned_s(line), flown_s(line)) == ([7.05], 7.1)


between_ticks = st.floats(9.0, 12.0).filter(lambda at_s: not is_on_grid(at_s))


@pytest.fixture(scope="module")
def quiet() -> Line:
    return Line(patrol(green=GREEN)).fly()


@pytest.mark.long
@drawn(5)
@given(
    st.lists(
        st.floats(9.0, 12.0).filter(lambda at_s: not is_on_grid(at_s)), min_size=1, max_size=20
    )
)
def test_a_step_more_moves_no_setpoint_of_a_tick(quiet: Line, times_s: list[float]) -> None:
    """Also those that lead to nothing: trajectories do not run faster for them."""
    line = Line(patrol(green=GREEN))
    for number, at_s in enumerate(sorted(times_s)):
        line.say(at_s, "green", (number + 1) % 2)
    line.fly()
    assert_ticks_stay(line)
    assert line.of(PlanReplaced) == []
    for number in range(round(12.0 / TICK_S)):
        place, expected = (each.setpoint_at(number * TICK_S) for each in (line, quiet))
        assert (place is None) is (expected is None)
        if place is not None and expected is not None:
            assert distance(place, expected) < 1e-3


def test_the_setpoint_of_a_step_more_is_that_of_its_time() -> None:
    line = Line(patrol(green=GREEN)).say(10.02, "green", 1).fly()
    before, then, after = (line.setpoint_at(at_s) for at_s in (10.0, 10.02, 10.05))
    assert before is not None and then is not None and after is not None
    assert distance(before, after) > 0.05
    assert distance(before, then) == pytest.approx(0.4 * distance(before, after), rel=0.05)
    assert distance(before, then) + distance(then, after) == pytest.approx(
        distance(before, after), rel=0.01
    )


def test_ten_thousand_changes_move_no_tick() -> None:
    line = Line(patrol(green=GREEN))
    for number in range(200):
        at_s = 7.0013 + number * 0.0053
        line.say(at_s, "green", 1, times=25).say(at_s, "green", 0, times=25)
    line.fly()
    assert_ticks_stay(line)
    assert 10 < len(line.extra) <= math.ceil(200 * 0.0053 / TICK_S) + 1


def test_an_event_that_flaps_is_answered_once_a_second() -> None:
    line = Line(patrol(), end_s=16.0)
    for number in range(40):
        line.say(7.013 + 0.17 * number, "red", (number + 1) % 2)
    line.fly()
    assert len(replanned_s(line)) >= 4
    assert all(b - a >= 1.0 - 1e-6 for a, b in pairwise(replanned_s(line)))
    assert all(b - a >= 1.0 - 1e-6 for a, b in pairwise(line.extra))
    assert_ticks_stay(line)


def test_what_nobody_watches_waits_for_the_tick() -> None:
    line = Line(patrol()).say(7.013, "blue", 1).say(7.113, "red", 0).say(7.213, "pink", 1)
    assert line.fly().extra == []


def test_an_event_that_has_to_last_counts_in_a_tick() -> None:
    """Its first reading changes nothing; the time passes without a datagram."""
    line = Line(patrol(for_s=0.48)).say(7.013, "red", 1).fly()
    assert line.extra == []
    assert replanned_s(line) == pytest.approx([7.55])


def test_a_command_that_an_event_waits_for_is_answered_at_once() -> None:
    call = dialect.MAV_CMD_USER_2
    red = patrol().events["red"]
    signal = replace(red.when.signal, message="COMMAND", instance="", field="MAV_CMD_USER_2")
    latched = replace(red, when=replace(red.when, signal=signal), latch=True)
    called = replace(patrol(), events={**patrol().events, "red": latched})
    line = Line(called).command(7.013, call).fly()
    assert line.extra == pytest.approx([7.013])
    assert len(line.of(PlanReplaced)) == 1


def phases(line: Line) -> Phase:
    assert line.companion._run is not None
    return line.companion._run.sortie.phase


PAUSE = dialect.MAV_CMD_DO_PAUSE_CONTINUE


@pytest.mark.parametrize("what", ["paused", "taken over", "called home", "landing", "climbing"])
def test_while_no_plan_is_flown_events_wait_for_ticks(what: str) -> None:
    line = Line(patrol(), end_s=7.0 if what == "landing" else 12.0)
    at_s = 9.013
    match what:
        case "paused":
            line.command(7.0, PAUSE, 0.0)
        case "taken over":
            line.at(7.0, lambda: setattr(line.autopilot, "mode", "POSCTL"))
        case "called home":
            line.command(8.5, dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH)
        case "landing":
            line.autopilot.results[dialect.MAV_CMD_NAV_LAND] = [None, 0]
        case "climbing":
            at_s = 0.513
    seen: list[Phase] = []
    line.say(at_s, "red", 1).at(at_s - 0.1, lambda: seen.append(phases(line)))
    line.fly()
    assert Phase.TASK not in seen
    assert line.extra == []


def test_on_the_dock_events_wait_for_ticks() -> None:
    """What was begun there is finished first."""
    dock = replace(
        skill("dock", Land(), "", "at(A)", effect="docked"),
        execute=(Land(), Charge(90.0), TakeOff()),
    )
    events = [event("red")]
    docking = mission("F (docked & X (red | at(B)))", "HAB", [move(), dock], events)
    line = Line(docking, end_s=30.0)
    line.autopilot.battery_percent = 50
    landed: list[bool] = []
    for at_s in (15.013, 16.033):
        line.at(at_s - 0.1, lambda: landed.append(line.autopilot.is_landed))
        line.say(at_s, "red", round(at_s) % 2)
    line.at(20.0, lambda: setattr(line.autopilot, "battery_percent", 95)).fly()
    assert landed == [True, True]
    assert line.extra == []

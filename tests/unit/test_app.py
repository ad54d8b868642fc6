"""The parts together: a companion that talks bytes with a scripted autopilot, and its loop."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import pytest
from autopilot import ARM, LAND, SET_MODE, TAKE_OFF, Autopilot, named, of_type
from happened import Happened, Replan
from synthetic import PAYLOAD, POSITIONS, command, event, mission

from companion.acting.journal import NoJournal
from companion.acting.sortie import authority
from companion.acting.sortie.preflight.arming_terms import ArmingTerms
from companion.acting.sortie.terms import SortieTerms
from companion.app import Companion
from companion.driving import fly
from companion.errors import Aborted, LinkTimeout
from companion.flight_events.event import FlightEvent, Stamped
from companion.flight_events.hosting import DatagramsDropped, FramesRefused
from companion.flight_events.reports import SignalOfAnother
from companion.flight_events.skills import PlaceReached, SkillCompleted
from companion.flight_events.sortie import (
    Phase,
    PhaseEntered,
    SetpointRefused,
    StoppedAsAsked,
    TaskSatisfied,
)
from companion.geometry import Ned
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mission.model import Mission
from companion.run_sources.only_run import OnlyRun
from companion.slices import InSlices
from companion.tick import TICK_S
from companion.vehicle.run_clocks import ClockReading


class Notes(Happened):
    """A recorder that keeps everything."""

    journal = NoJournal()
    name = "the-run"

    def __init__(self) -> None:
        self.reports: list[Stamped] = []
        self.datagrams: list[tuple[float, list[bytes]]] = []
        self.positions: list[Ned] = []

    def report(self, stamped: Stamped) -> None:
        self.reports.append(stamped)

    def clocks(self, reading: ClockReading) -> None:
        """Not read."""

    def packets(self, now_s: float, datagrams: list[bytes]) -> None:
        self.datagrams.append((now_s, list(datagrams)))

    def position(self, now_s: float, position: Ned) -> None:
        self.positions.append(position)


PAUSED_S = 3.0


class World:
    """A companion and an autopilot, in lockstep; fulfils what `fly` needs of link and clock.

    Attributes:
        late_s: by how much every sleep is too long.
        is_silent: nothing arrives any longer.
        neighbour: hears what leaves, and answers; it may do something to the world as well.
    """

    endpoint = "udpin://0.0.0.0:14540"
    zero_s, speed = None, 1.0

    def __init__(self, asked: Mission, **options: Any) -> None:
        self.notes = Notes()
        self.companion = Companion(OnlyRun(asked, self.notes), **options)
        self.autopilot = Autopilot()
        self.now = 0.0
        self.late_s = 0.0
        self.is_silent = False
        self.untold: list[FlightEvent] = []
        self.neighbour: Callable[[list[bytes]], list[bytes]] = lambda datagrams: []
        self.ticks: list[float] = []
        self._answers: list[bytes] = []

    def now_s(self) -> float:
        return self.now

    def sleep_until(self, time_s: float) -> None:
        self.now = max(self.now, time_s) + self.late_s

    def wall_s_until(self, time_s: float) -> float:
        return time_s - self.now

    def wait(self, timeout_s: float) -> bool:
        """All arrives with the tick."""
        return False

    def receive(self) -> list[bytes]:
        self.ticks.append(self.now)
        return [] if self.is_silent else [*self._answers, *self.autopilot.telemetry()]

    def send(self, datagrams: list[bytes]) -> None:
        self._answers = [*self.autopilot.answer(datagrams), *self.neighbour(datagrams)]

    @property
    def has_heard(self) -> bool:
        return not self.is_silent

    def account(self) -> str:
        return "nothing arrived"

    def news(self) -> list[FlightEvent]:
        return [self.untold.pop(0)] if self.untold and self.now > 4.0 else []

    def discard(self) -> None:
        """What has arrived is what the autopilot says now."""

    def fly(self, timeout_s: float = 30.0) -> World:
        fly(self.companion, self, self, timeout_s)  # type: ignore[arg-type]
        return self


@pytest.fixture(scope="module")
def flown() -> World:
    """A flight to A that goes well; to be looked at only."""
    return World(mission("F at(A)")).fly()


@pytest.mark.slow
def test_a_flight_from_the_ground_to_the_ground(flown: World) -> None:
    assert flown.notes.events[-3:] == [
        PlaceReached("A", "move(H, A)"),
        PhaseEntered(Phase.LANDING),
        TaskSatisfied(),
    ]
    assert flown.companion.has_ended and flown.companion.failure is None
    commands = of_type(flown.autopilot.heard, "COMMAND_LONG")
    assert [c.command for c in commands] == [ARM, TAKE_OFF, SET_MODE, LAND]
    assert not flown.autopilot.is_armed
    arrived = max(flown.notes.positions)
    assert math.dist(arrived, POSITIONS["A"]) < 0.3


def test_all_that_came_and_left_is_recorded(flown: World) -> None:
    ear = MavlinkCodec(0, 0)
    recorded = [d for _, datagrams in flown.notes.datagrams for d in datagrams]
    senders = {m.get_srcComponent() for d in recorded for m in ear.parse(d)}
    assert senders == {1, 191}
    left = [d for d in recorded if d[6] != 1]
    assert len(left) == len(flown.autopilot.heard)
    times = [now_s for now_s, _ in flown.notes.datagrams]
    assert times == flown.ticks


def test_a_report_is_recorded_once(flown: World) -> None:
    told = flown.notes.events
    assert [event for event in told if told.count(event) != 1] == []


def test_ticks_are_a_twentieth_of_a_second_apart(flown: World) -> None:
    expected = [i * TICK_S for i in range(len(flown.ticks))]
    assert flown.ticks == pytest.approx(expected, abs=1e-6)


def test_a_late_tick_is_not_made_up_for_by_a_burst() -> None:
    world = World(mission("G F at(A) & G F at(B)"))
    world.companion.stop()
    world.late_s = 0.2
    world.fly()
    assert all(b - a >= TICK_S for a, b in pairwise(world.ticks))


def test_no_vehicle_in_time_is_an_error_with_the_account_of_the_link() -> None:
    world = World(mission("F at(A)"))
    world.is_silent = True
    with pytest.raises(LinkTimeout) as error:
        world.fly(timeout_s=5.0)
    first = str(error.value).splitlines()[0]
    assert first == "no vehicle on udpin://0.0.0.0:14540 after 5 s: nothing arrived"
    assert world.now == pytest.approx(5.0, abs=0.11)


@pytest.mark.parametrize(
    ("left_out", "missing"),
    [
        ("HOME_POSITION", "no home (HOME_POSITION)"),
        ("LOCAL_POSITION_NED", "no position (LOCAL_POSITION_NED)"),
        ("ATTITUDE", "no heading (ATTITUDE)"),
        ("EXTENDED_SYS_STATE", "not whether it stands on the ground (EXTENDED_SYS_STATE)"),
    ],
)
def test_a_vehicle_that_is_heard_and_not_ready_in_time_is_told_what_it_lacks(
    left_out: str, missing: str
) -> None:
    world = World(mission("F at(A)"))
    codec, whole = MavlinkCodec(1, 1), world.autopilot.telemetry

    def telemetry() -> list[bytes]:
        frames = whole()
        return [f for f in frames if left_out not in {m.get_type() for m in codec.parse(f)}]

    world.autopilot.telemetry = telemetry  # type: ignore[method-assign]
    with pytest.raises(LinkTimeout) as error:
        world.fly(timeout_s=5.0)
    first = str(error.value).splitlines()[0]
    assert first == (
        f"the vehicle on udpin://0.0.0.0:14540 is not ready after 5 s: it tells {missing}"
    )


def test_a_search_for_a_plan_on_the_ground_is_no_wait_for_the_vehicle(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    class TakesSeconds(InSlices[Any]):
        """Work that is done after 3 s."""

        def step(self) -> bool:
            return world.now > 3.0 and super().step()

    monkeypatch.setattr("companion.acting.sortie.beginning.InSlices", TakesSeconds)
    world = World(mission("F at(A)"))
    world.fly(timeout_s=1.0)
    assert world.companion.failure is None


def test_a_vehicle_that_falls_silent_later_is_another_matter(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert authority.NEVER_BACK_S == 1800.0
    monkeypatch.setattr(authority, "NEVER_BACK_S", 60.0)
    world = World(mission("G F at(A) & G F at(B)"))

    def falls_silent(datagrams: list[bytes]) -> list[bytes]:
        world.is_silent = world.now > 8.0
        return []

    world.neighbour = falls_silent
    world.fly(timeout_s=1.0)
    assert str(world.companion.failure) == "no position from the vehicle for 60 s"


def test_what_a_flood_has_lost_is_told_in_the_flight_and_on_its_record() -> None:
    world = World(mission("F at(A)"))
    world.untold = [DatagramsDropped(1), FramesRefused(0, 3, 0), DatagramsDropped(3)]
    world.fly()
    lost = [s for s in world.notes.reports if s.event.kind == "link"]
    assert [s.event for s in lost] == [
        DatagramsDropped(1),
        FramesRefused(0, 3, 0),
        DatagramsDropped(3),
    ]
    assert [s.time_s for s in lost] == pytest.approx([4.0, 4.05, 4.1], abs=0.1)
    texts = [m.text for m in of_type(world.autopilot.heard, "STATUSTEXT")]
    assert any(text.startswith("datagrams dropped: 3") for text in texts)
    assert any(text.startswith("frames refused: 0 unsigned, 3 with") for text in texts)


def test_a_stop_lands() -> None:
    world = World(mission("G F at(A) & G F at(B)"))

    def operator(datagrams: list[bytes]) -> list[bytes]:
        if world.now > 8.0:
            world.companion.stop()
        return []

    world.neighbour = operator
    world.fly()
    assert world.notes.events[-1] == StoppedAsAsked()
    assert not world.autopilot.is_armed
    assert world.companion.failure is None


def test_the_failure_is_that_of_the_sortie() -> None:
    world = World(mission("F at(A)"))
    world.autopilot.results[ARM] = [dialect.MAV_RESULT_DENIED]
    world.fly()
    assert isinstance(world.companion.failure, Aborted)
    assert str(world.companion.failure) == "not armed: denied"
    assert of_type(world.autopilot.heard, "SET_POSITION_TARGET_LOCAL_NED") == []


@pytest.mark.slow
@pytest.mark.parametrize("accepts", [False, True])
def test_weak_failsafes_are_refused_unless_accepted(accepts: bool) -> None:
    terms = SortieTerms(arming=ArmingTerms(accepts_weak_failsafes=accepts))
    world = World(mission("F at(A)"), terms=terms)
    world.autopilot.parameters["COM_OBL_RC_ACT"] = 0.0
    world.fly()
    assert (world.companion.failure is None) is accepts


def test_a_command_of_a_skill_reaches_its_component() -> None:
    world = World(mission("F done", skills=[command("do", "at(H)", "done")]))
    payload = Autopilot(component=PAYLOAD)
    world.neighbour = payload.answer
    world.fly()
    assert SkillCompleted("do") in world.notes.events
    sent = [m for m in of_type(payload.heard, "COMMAND_LONG") if m.target_component == PAYLOAD]
    assert {(m.param1, m.param2) for m in sent} == {(1.5, -2.0)}


def test_an_event_off_the_wire_replans() -> None:
    asked = mission("G (F at(A) | found) & G (F at(B) | found)", events=[event("found")])
    world, detector, another = World(asked), MavlinkCodec(1, 26), MavlinkCodec(2, 26)
    world.neighbour = lambda datagrams: [
        detector.pack(named("found", world.now > 8.0)),
        another.pack(named("found", 1)),
    ]
    world.fly()
    assert world.notes.events.count(SignalOfAnother("NAMED_VALUE_INT[found].value", 2, 1)) == 1
    assert [event for event in world.notes.story if isinstance(event, Replan)] == [
        Replan("found", "move(here, B), (wait)^w")  # which was demanded before
    ]


def test_every_setpoint_of_a_flight_stays_within_the_limits() -> None:
    world = World(mission("F at(A) & F at(B) & F at(C)", places="HABC")).fly()
    setpoints = of_type(world.autopilot.heard, "SET_POSITION_TARGET_LOCAL_NED")
    assert len(setpoints) > 100
    for s in setpoints:
        assert -1.5 <= s.x <= 7.5 and -1.5 <= s.y <= 7.5 and -4.0 <= s.z <= -0.5
        assert math.hypot(s.vx, s.vy, s.vz) <= 2.0 * 1.01
    assert world.notes.of(SetpointRefused) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    "ticks",
    [pytest.param(n, marks=[pytest.mark.long] if n % 3 else []) for n in range(12)],
)
def test_no_command_leaves_after_a_stop_on_the_ground(ticks: int) -> None:
    world = World(mission("F at(A)"))
    world.autopilot.results[ARM] = [None]
    count, mark = [0], [0]

    def operator(datagrams: list[bytes]) -> list[bytes]:
        if of_type(world.autopilot.heard, "COMMAND_LONG"):
            count[0] += 1
            if count[0] == ticks + 1:
                world.companion.stop()
                mark[0] = len(world.autopilot.heard)
        return []

    world.neighbour = operator
    world.fly()
    assert of_type(world.autopilot.heard[mark[0] :], "COMMAND_LONG") == []


class Paused(World):
    """Its process is paused once in the task; the autopilot holds meanwhile, and tells it last.

    Attributes:
        paused_s: when the pause began.
    """

    def __init__(self, is_in_a_step: bool) -> None:
        super().__init__(mission("F at(A)"))
        self.paused_s = math.inf
        self._is_in_a_step = is_in_a_step
        self._is_backlog = False
        self._record, self.notes.packets = self.notes.packets, self._packets  # type: ignore

    def _packets(self, now_s: float, datagrams: list[bytes]) -> None:
        """The recorder is called in a step."""
        self._record(now_s, datagrams)
        self._pause(self._is_in_a_step)

    def sleep_until(self, time_s: float) -> None:
        super().sleep_until(time_s)
        self._pause(not self._is_in_a_step)

    def receive(self) -> list[bytes]:
        """What arrived in a pause comes first, and more than a step reads."""
        if not self._is_backlog:
            return super().receive()
        self.autopilot.mode = "OFFBOARD"
        old = self.autopilot.telemetry()
        self.autopilot.mode = "AUTO.LOITER"
        return old

    def discard(self) -> None:
        self._is_backlog = False

    def _pause(self, is_here: bool) -> None:
        if is_here and self.paused_s == math.inf and self.now > 6.0:
            self.paused_s = self.now
            self.now += PAUSED_S
            self._is_backlog = True
            self.autopilot.mode = "AUTO.LOITER"


@pytest.mark.parametrize("is_in_a_step", [True, False])
def test_after_a_pause_of_the_process_the_mode_is_heard_before_anything_is_sent(
    is_in_a_step: bool,
) -> None:
    """A setpoint would bring a PX4 that holds back to OFFBOARD."""
    world, sent = Paused(is_in_a_step), list[float]()

    def neighbour(datagrams: list[bytes]) -> list[bytes]:
        heard = [m for d in datagrams for m in MavlinkCodec(0, 0).parse(d)]
        sent.extend(world.now for _ in of_type(heard, "SET_POSITION_TARGET_LOCAL_NED"))
        return []

    world.neighbour = neighbour
    world.fly()
    assert PhaseEntered(Phase.TASK) in world.notes.events
    assert isinstance(world.companion.failure, Aborted)
    assert world.paused_s - 1.5 * TICK_S < sent[-1] <= world.paused_s


class PausedEarly(World):
    """Pauses for 3 s as soon as a phase has been entered, before anything is asked for in it."""

    def __init__(self, phase: Phase) -> None:
        super().__init__(mission("F at(A)"))
        self._phase: Phase | None = phase

    def sleep_until(self, time_s: float) -> None:
        super().sleep_until(time_s)
        assert self.now < 100.0, self.notes.events
        if self._phase is not None and PhaseEntered(self._phase) in self.notes.events:
            self.now += PAUSED_S
            self._phase = None


@pytest.mark.parametrize("phase", [Phase.CHECKING, Phase.ARMING, Phase.TAKE_OFF])
def test_after_a_pause_on_the_ground_the_next_heartbeat_is_enough(phase: Phase) -> None:
    """Nobody is asked for anything yet, so no mode is another one."""
    world = PausedEarly(phase).fly()
    assert world.notes.events[-1] == TaskSatisfied()

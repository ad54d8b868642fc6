"""The companion as a whole, from the link to the flight; it exists as long as the program.

`Companion` is a state machine: time and datagrams in, datagrams out. `driving.fly` runs it over a
link in real (or scaled) time; the simulator's harness runs the same object in lockstep.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from companion.acting.sortie.phases import ON_THE_GROUND
from companion.acting.sortie.terms import USUAL_TERMS, SortieTerms
from companion.errors import CompanionError
from companion.flight_events.event import FlightEvent, Stamped
from companion.flight_events.hosting import TerminalHungUp
from companion.flight_events.sortie import Phase
from companion.ground.component import COMMANDS, WANTED, Component
from companion.ground.operations import MonitorPage, SystemStatus
from companion.ground.parameters import BELIEF_RETRY, SPEED_MAX
from companion.mavlink.framing import Message, source
from companion.mission_run import PreparedRun, Run
from companion.outcomes import Refusal
from companion.run_sources.run_source import RunSource
from companion.vehicle.flight_memory import FlightMemory
from companion.vehicle.telemetry import Telemetry
from companion.vehicle.wire import AUTOPILOT, Wire

BEGINNING = (*ON_THE_GROUND, Phase.ARMING, Phase.TAKE_OFF)
RETURN = "MAV_CMD_NAV_RETURN_TO_LAUNCH"
NOTHING_FLOWN = Refusal("nothing is flown")


class Companion:
    """MAVLink component 191: flies its mission at once, or waits until operators start missions.

    Args:
        runs: what it flies, one run after the other.
        terms: the operator's choices for all sorties.
        page: the monitor page, if there is one.
        memory: what is remembered of earlier flights.

    Attributes:
        failure: why the last run failed.
        now_s: when the last step began.
        wire: decodes and packs messages.
        telemetry: what was last heard from the autopilot.
    """

    def __init__(
        self,
        runs: RunSource,
        terms: SortieTerms = USUAL_TERMS,
        *,
        page: MonitorPage | None = None,
        memory: FlightMemory | None = None,
    ) -> None:
        self.failure: CompanionError | None = None
        self.now_s = 0.0
        self.wire, self.telemetry = Wire(), Telemetry(memory.frames if memory else None)
        self._component = Component(self, runs.uploads, page)
        self._runs = runs
        self._run: Run | None = None
        self._run_of = partial(
            Run,
            wire=self.wire,
            telemetry=self.telemetry,
            terms=terms,
            memory=memory or FlightMemory(),
        )
        self._is_stopping = self._has_hung_up = False
        self._adjusted = -1
        self._listen()
        self._begin_next()

    # -- for the program -----------------------------------------------------------------------

    @property
    def missing(self) -> str | None:
        """What a run still has to hear from its vehicle; None if it waits for nothing."""
        is_begun = self._run is not None and not self._run.is_waiting
        return None if is_begun else self._runs.missing(self.telemetry)

    @property
    def has_ended(self) -> bool:
        """Whether nothing is left to do."""
        if self._run is not None:
            return self._runs.is_over and self._run.sortie.has_ended
        return self._runs.is_over or self._is_stopping

    @property
    def is_idle(self) -> bool:
        """Whether nothing is flown, nor will be before an operator starts it."""
        return self._run is None and self._runs.awaits_start

    def stop(self) -> None:
        """Holds, lands and ends, as after Ctrl-C."""
        self._is_stopping = True
        if self._run is not None:
            self._run.sortie.stop()

    def hang_up(self) -> None:
        """Notes that the terminal is gone; the flight continues."""
        self._has_hung_up = True

    def note(self, news: list[FlightEvent]) -> None:
        """Records what was dropped or refused on the link."""
        for event in news:
            self._say(event)

    def is_urgent(self, now_s: float, datagrams: list[bytes]) -> bool:
        """Whether datagrams, which are not taken yet, change an event that the plan watches."""
        if self._run is None or not self._run.watched:
            return False
        messages = self.wire.peek(datagrams)
        return self._run.is_urgent(now_s, messages, self._component.foresee(messages))

    def step(
        self,
        now_s: float,
        datagrams: list[bytes],
        is_tick: bool = True,
        reports: Sequence[bytes] = (),
    ) -> list[bytes]:
        """One tick: reads what arrived, acts, returns the datagrams to send.

        Or an extra step between two ticks, which flies a plan that is made in it at once. Reports
        come from other programs on board (`vehicle/detections.py`).
        """
        self.now_s = now_s
        self._begin_next()
        if self._has_hung_up:
            self._has_hung_up = False
            self._say(TerminalHungUp())
        if self.wire.system:  # before that, nobody would receive the texts
            for event in self._runs.news(now_s, is_flying=self._run is not None):
                self._say(event)
        messages = self.wire.parse(datagrams)
        asked = self._component.receive(now_s, self.wire.system, messages)
        at_once, run = self.wire.answer(now_s, messages), self._run
        answered = self.wire.take_answered()
        if run is None:
            self._idle(messages)
            questions = self.telemetry.questions(now_s, (self.wire.system, AUTOPILOT), False)
            leaving = self._component.transmit(now_s, self._is_stopping)
            return at_once + self.wire.pack(leaving + questions)
        self._follow_parameters()
        happened = run.step(now_s, messages, asked, is_tick, reports)
        for stamped in happened:
            self._component.tell(now_s, stamped.event)
        if run.has_armed:
            self._component.mark(run.recorder.name)
        self.failure = run.sortie.failure
        leaving = self._component.transmit(now_s, run.sortie.has_ended)
        answers = self.wire.pack(leaving + run.vehicle.transmit(now_s))
        run.record(now_s, datagrams + answered + answers, happened)
        if run.sortie.has_ended and not self._runs.is_over:
            self._runs.end(run.recorder)
            self._run = None
            self._listen()
        return at_once + answers

    # -- ground.operations.Operations ----------------------------------------------------------

    @property
    def system_status(self) -> SystemStatus:
        """The status in HEARTBEAT: of the present sortie, or of the last one."""
        phase = self._run.sortie.phase if self._run else Phase.ENDED
        return SystemStatus.of(phase, has_failed=self.failure is not None)

    @property
    def awaited(self) -> frozenset[str]:
        """The MAV_CMD names for which events of the flown mission wait."""
        return self._run.awaited if self._run else frozenset()

    def start(self) -> Refusal | None:
        """Flies the newest mission, from the step after its preparation."""
        if self._run is not None:
            phase = self._run.sortie.phase
            if phase in BEGINNING and not self._runs.has_newer:
                return None
            return Refusal(f"{self._run.mission.name} is {phase.value}")
        speed_max_mps = self._component.parameters[SPEED_MAX]
        return self._runs.start(self.telemetry, self.now_s, speed_max_mps)

    def pause(self) -> Refusal | None:
        """Holds in the air and freezes the task."""
        return self._run.sortie.pause() if self._run else NOTHING_FLOWN

    def resume(self) -> Refusal | None:
        """Continues after a pause, or takes the control that the pilot has handed over."""
        return self._run.sortie.resume() if self._run else NOTHING_FLOWN

    def return_home(self) -> Refusal | None:
        """Flies home and lands; the mission's own event for this has priority, and ends a pause."""
        if self._run is None:
            return NOTHING_FLOWN
        if RETURN not in self._run.awaited:
            return self._run.sortie.return_home()
        return self._run.sortie.resume() if self._run.sortie.phase is Phase.PAUSED else None

    # -- runs ----------------------------------------------------------------------------------

    def _begin_next(self) -> None:
        """Begins the next run, if nothing is flown and it can begin."""
        if self._run is not None or self._is_stopping:
            return
        match self._runs.next(self.telemetry, self.now_s):
            case PreparedRun() as prepared:
                self._begin(prepared)
            case CompanionError() as failure:
                self.failure = failure

    def _begin(self, prepared: PreparedRun) -> None:
        self.failure, self._adjusted = None, -1
        start_s = self.now_s
        if (journalled := prepared.journalled) is not None:
            start_s = max(start_s, journalled.goes_on_s)
            if (settings := journalled.settings) is not None:
                self._component.parameters.put(SPEED_MAX, settings.speed_max_mps)
                self._component.parameters.put(BELIEF_RETRY, settings.belief_retry_s)
        self._run = self._run_of(prepared, start_s=start_s)
        self._listen()

    def _idle(self, messages: list[Message]) -> None:
        """Reads messages while nothing is flown."""
        for message in messages:
            is_theirs = source(message) == (self.wire.system, AUTOPILOT)
            if is_theirs and self.telemetry.is_news(self.now_s, message):
                self.telemetry.take(self.now_s, message)

    def _say(self, event: FlightEvent) -> None:
        """Reports an event outside of the flight; in the flight's record if there is one."""
        stamped = Stamped(round(self.now_s, 3), event)
        if self._run is not None:
            self._run.flight.add_report(stamped)
            return
        self._runs.tell(stamped)
        self._component.tell(self.now_s, event)

    def _follow_parameters(self) -> None:
        """Applies the companion's parameters to the run."""
        parameters = self._component.parameters
        if self._run is not None and self._adjusted != parameters.version:
            self._adjusted = parameters.version
            self._run.adjust(parameters[SPEED_MAX], parameters[BELIEF_RETRY])

    def _listen(self) -> None:
        """Selects the messages to decode, which depend on the mission's events."""
        if self._run is None:
            self.wire.listen(self.telemetry.wanted | WANTED, frozenset())
            return
        vehicle = self._run.vehicle
        self.wire.listen(vehicle.wanted | WANTED, vehicle.continual, vehicle.telling | COMMANDS)

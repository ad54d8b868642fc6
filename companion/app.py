"""The companion from the link to what is flown; it lives as long as the program.

`Companion` is a state machine: time and datagrams in, datagrams out. `driving.fly` drives it in
real (or scaled) time from a socket; the simulator's harness drives the same object in lockstep.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from companion.acting.authority import why_left_alone
from companion.acting.function_port import FunctionPort
from companion.acting.journal import JournalledFlight
from companion.acting.phases import ON_THE_GROUND
from companion.acting.preparation import Preparation, PreparedMission
from companion.acting.sortie_terms import USUAL_TERMS, SortieTerms
from companion.errors import Aborted, CompanionError
from companion.flight_events.event import FlightEvent, Stamped
from companion.flight_events.hosting import (
    MissionReady,
    MissionUnreadable,
    RunNotBegun,
    TerminalHungUp,
)
from companion.flight_events.sortie import Phase
from companion.ground.component import COMMANDS, WANTED, Component
from companion.ground.operations import MonitorPage, SystemStatus
from companion.ground.parameters import BELIEF_RETRY, SPEED_MAX
from companion.host import Host
from companion.mavlink.framing import Message, source
from companion.mission.model import Mission
from companion.mission_run import Recorder, Run
from companion.only_run import OnlyRun
from companion.outcomes import Refusal
from companion.planning.engine_port import Engine
from companion.vehicle.flight_memory import FlightMemory
from companion.vehicle.telemetry import TELEMETRY, Telemetry
from companion.vehicle.wire import AUTOPILOT, Wire

BEGINNING = (*ON_THE_GROUND, Phase.ARMING, Phase.TAKE_OFF)
RETURN = "MAV_CMD_NAV_RETURN_TO_LAUNCH"
NOTHING_FLOWN = Refusal("nothing is flown")


class Companion:
    """Component 191 for as long as it lives: flies one mission at once, or hosts sorties.

    With a host it waits for MISSION_START on the ground, has the newest mission prepared, flies it,
    and waits again; it ends when it is stopped. Without one it prepares its only mission at once,
    and ends with its only run.

    Args:
        mission: what to fly; None to wait for an upload.
        recorder: told of everything that happens in the only run; None with a host.
        terms: on which each sortie is flown.
        host: makes and ends runs, and reads missions.
        page: the monitor page, if there is one.
        engine: who plans the only mission; None for the built-in search. A host knows its own.
        journalled: a run that was cut off, to go on with; the mission is its own.
        memory: of earlier flights.
        functions: calls functions of packages in the only run; a host knows its own.

    Attributes:
        failure: why the last run did not end well.
        wire, telemetry: its ear and its voice, and what its vehicle has told of itself.
    """

    def __init__(
        self,
        mission: Mission | None,
        recorder: Recorder | None,
        terms: SortieTerms = USUAL_TERMS,
        host: Host | None = None,
        page: MonitorPage | None = None,
        engine: Engine | None = None,
        journalled: JournalledFlight | None = None,
        memory: FlightMemory | None = None,
        functions: FunctionPort | None = None,
    ) -> None:
        self.failure: CompanionError | None = None
        self.wire, self.telemetry = Wire(), Telemetry(memory.frames if memory else None)
        self._component = Component(self, host.uploads if host else None, page)
        self._host, self._mission = host, mission
        self._run_of = partial(
            Run,
            wire=self.wire,
            telemetry=self.telemetry,
            terms=terms,
            memory=memory or FlightMemory(),
            may_yield=host is not None,
        )
        self._run: Run | None = None
        self._preparation: Preparation | None = None
        self._is_prepared = self._is_stopping = self._has_hung_up = False
        self._adjusted, self._now_s = -1, journalled.goes_on_s if journalled else 0.0
        self._only = OnlyRun.of(mission, recorder, engine, journalled, functions)
        self._listen()
        self._begin_only()

    # -- from outside --------------------------------------------------------------------------

    @property
    def missing(self) -> str | None:
        """What the only run still waits to hear of its vehicle; None if it waits for nothing."""
        is_begun = self._run is not None and not self._run.is_waiting
        return None if is_begun or self._host is not None else self.telemetry.missing

    @property
    def has_ended(self) -> bool:
        """Whether nothing is left to do."""
        if self._run is not None:
            return self._host is None and self._run.sortie.has_ended
        return self._is_stopping or (self._host is None and self.failure is not None)

    @property
    def is_idle(self) -> bool:
        """Whether it hosts and nothing is flown, nor will be in the next step."""
        return self._host is not None and self._run is None and not self._is_prepared

    def stop(self) -> None:
        """Hold, land, end: what Ctrl-C asks for."""
        self._is_stopping = True
        if self._run is not None:
            self._run.sortie.stop()

    def hang_up(self) -> None:
        """The terminal is gone: the flight goes on, and its record says so."""
        self._has_hung_up = True

    def note(self, news: list[FlightEvent]) -> None:
        """What was dropped or refused on the link: the record says so."""
        for event in news:
            self._say(event)

    def is_urgent(self, now_s: float, datagrams: list[bytes]) -> bool:
        """Whether they change an event that the plan watches; they are for the next step yet."""
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
        """One tick: reads what arrived, acts, returns what has to leave.

        Or a step between two ticks: what is planned anew in it is flown in it, too. Reports are
        those of other programs on board (`vehicle/detections.py`).
        """
        self._now_s = now_s
        if self._host is not None and self._preparation is not None and self._is_prepared:
            self._launch(self._host, self._preparation)
        if self._has_hung_up:
            self._has_hung_up = False
            self._say(TerminalHungUp())
        if self.wire.system:  # before that, nobody would hear what is told
            self._poll()
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
        if run.sortie.has_ended and self._host is not None:
            self._host.end_run(run.recorder)
            self._run = None
            self._listen()
        return at_once + answers

    # -- ground.operations.Operations ----------------------------------------------------------

    @property
    def system_status(self) -> SystemStatus:
        """What HEARTBEAT says of the sortie, or of the last one."""
        phase = self._run.sortie.phase if self._run else Phase.ENDED
        return SystemStatus.of(phase, has_failed=self.failure is not None)

    @property
    def awaited(self) -> frozenset[str]:
        """The MAV_CMD names that the events of the flown mission wait for."""
        return self._run.awaited if self._run else frozenset()

    def start(self) -> Refusal | None:
        """Flies the newest mission, from the step on after which it is prepared."""
        if self._run is not None:
            phase = self._run.sortie.phase
            if phase in BEGINNING:
                return None
            return Refusal(f"{self._run.mission.name} is {phase.value}")
        if self._host is None or self._mission is None:
            return Refusal("there is no mission; upload one")
        if refusal := why_left_alone(self.telemetry.state, self._now_s):
            return refusal
        if self._preparation is None:
            speed_max_mps = self._component.parameters[SPEED_MAX]
            ground_amsl_m = self.telemetry.ground_amsl_m
            self._preparation = self._host.prepare(self._mission, speed_max_mps, ground_amsl_m)
        return None

    def pause(self) -> Refusal | None:
        """Holds in the air, the task frozen."""
        return self._run.sortie.pause() if self._run else NOTHING_FLOWN

    def resume(self) -> Refusal | None:
        """Goes on after a pause, or with control that the pilot has handed over."""
        return self._run.sortie.resume() if self._run else NOTHING_FLOWN

    def return_home(self) -> Refusal | None:
        """Flies home and lands; the mission's own event for that goes before, and ends a pause."""
        if self._run is None:
            return NOTHING_FLOWN
        if RETURN not in self._run.awaited:
            return self._run.sortie.return_home()
        return self._run.sortie.resume() if self._run.sortie.phase is Phase.PAUSED else None

    # -- runs ----------------------------------------------------------------------------------

    def _begin_only(self) -> None:
        """Begins the only run, as soon as it can be prepared."""
        if (only := self._only) is None:
            return
        match only.prepare(self.telemetry):
            case PreparedMission() as prepared:
                self._begin(prepared, only.recorder, only.journalled)
            case Aborted() as failure:
                self.failure = failure
            case None:
                return
        self._only = None

    def _begin(
        self, prepared: PreparedMission, recorder: Recorder, journalled: JournalledFlight | None
    ) -> None:
        self.failure, self._adjusted = None, -1
        if journalled is not None and (settings := journalled.settings) is not None:
            self._component.parameters.put(SPEED_MAX, settings.speed_max_mps)
            self._component.parameters.put(BELIEF_RETRY, settings.belief_retry_s)
        self._run = self._run_of(prepared, recorder, start_s=self._now_s, journalled=journalled)
        self._listen()

    def _launch(self, host: Host, preparation: Preparation) -> None:
        """Begins the run that was asked for; in a tick of its own, after the answer has left."""
        self._preparation, self._is_prepared = None, False
        if self._is_stopping:
            return
        if refusal := self._begin_prepared(host, preparation):
            self._say(RunNotBegun(refusal.reason))

    def _begin_prepared(self, host: Host, preparation: Preparation) -> Refusal | None:
        """Begins a run, if the vehicle is still one to begin it with; or why there is none."""
        if refusal := why_left_alone(self.telemetry.state, self._now_s):
            return refusal
        try:
            prepared = preparation.result()
        except CompanionError as error:
            return Refusal(str(error))
        try:
            recorder = host.begin_run(prepared.mission)
        except OSError as error:
            return Refusal(f"no run folder: {error}")
        self._begin(prepared, recorder, journalled=None)
        return None

    def _idle(self, messages: list[Message]) -> None:
        """Nothing is flown: hears the autopilot, and looks for what leads to the next run.

        A new mission is taken when the start that was asked for has had its end: its host learns
        at the beginning of a run which mission was started.
        """
        for message in messages:
            is_theirs = source(message) == (self.wire.system, AUTOPILOT)
            if is_theirs and self.telemetry.is_news(self._now_s, message):
                self.telemetry.take(self._now_s, message)
        self._begin_only()
        if self._preparation is not None:
            self._is_prepared = self._preparation.done()
            return
        if self._host is None or self._host.uploads is None:
            return
        if (path := self._host.uploads.take_active()) is not None:
            self._take(self._host, path)

    def _take(self, host: Host, path: Path) -> None:
        try:
            self._mission = host.load(path)
        except (CompanionError, OSError) as error:
            self._say(MissionUnreadable(str(error)))
            return
        self._say(MissionReady(self._mission.name))

    def _poll(self) -> None:
        """Tells what became of uploads."""
        if self._host is not None and self._host.uploads is not None:
            is_flying = self._run is not None or self._preparation is not None
            for verdict in self._host.uploads.poll(self._now_s, is_flying):
                for news in verdict.news:
                    self._say(news)

    def _say(self, event: FlightEvent) -> None:
        """Reports what is not of the flight; in its records if there is one."""
        stamped = Stamped(round(self._now_s, 3), event)
        if self._run is not None:
            self._run.flight.add_report(stamped)
        elif self._host is not None:
            self._host.tell(stamped)
            self._component.tell(self._now_s, event)

    def _follow_parameters(self) -> None:
        """A run follows the companion's parameters."""
        parameters = self._component.parameters
        if self._run is not None and self._adjusted != parameters.version:
            self._adjusted = parameters.version
            self._run.adjust(parameters[SPEED_MAX], parameters[BELIEF_RETRY])

    def _listen(self) -> None:
        """What is decoded depends on the events of the mission."""
        if self._run is None:
            self.wire.listen(TELEMETRY | WANTED, frozenset())
            return
        vehicle = self._run.vehicle
        self.wire.listen(vehicle.wanted | WANTED, vehicle.continual, vehicle.telling | COMMANDS)

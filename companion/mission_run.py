"""One mission flown once, with all its parts.

`Run` joins the acting side and the MAVLink side, and records what happens: messages and time in,
messages out. The link, which outlives a run, belongs to `app.py`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from companion.acting.assembly import assemble, envelope_of
from companion.acting.charge.charge_report import ChargeReport
from companion.acting.event_detector import EventDetector
from companion.acting.found_places import FoundPlaces
from companion.acting.journal import (
    FlightBegun,
    FlightCounts,
    Journal,
    JournalledFlight,
    OperatorSettings,
    VehicleSeen,
)
from companion.acting.kept_clearance import KeptClearance
from companion.acting.preparation import PreparedMission
from companion.acting.sight_limit import SightLimit
from companion.acting.sortie.phases import ON_THE_GROUND
from companion.acting.sortie.resumption import Resumption, restore
from companion.acting.sortie.sortie import Sortie
from companion.acting.sortie.terms import USUAL_TERMS, SortieTerms
from companion.flight_events.event import Stamped
from companion.flight_events.plans import LapCompleted, NoPlanFound, PlanReplaced
from companion.flight_events.reports import SignalHeard, SignalSilent
from companion.flight_events.sortie import AutopilotSaid, Phase
from companion.flight_events.word import since
from companion.geometry import Ned
from companion.mavlink.framing import Message
from companion.mission.digest import digest
from companion.mission.facts import Fact
from companion.mission.installed_calls import functions_of
from companion.mission.refinement import confirming
from companion.mission.signals import Signal
from companion.planning.planner import Planner
from companion.vehicle.detections import Detections
from companion.vehicle.flight_memory import FlightMemory
from companion.vehicle.offboard import MavlinkVehicle
from companion.vehicle.run_clocks import ClockReading, RunClocks
from companion.vehicle.signals import OtherSystems, SignalReader, SignalReading
from companion.vehicle.surroundings import Surroundings
from companion.vehicle.telemetry import Telemetry
from companion.vehicle.wire import Wire

SEEN_EVERY_S = 1.0
"""How often the journal gets the vehicle's position."""


class Recorder(Protocol):
    """Records what happens in a run."""

    @property
    def name(self) -> str:
        """The name of the record; empty if there is none."""

    @property
    def journal(self) -> Journal:
        """Stores what another process needs to continue the run."""

    def report(self, stamped: Stamped) -> None:
        """Records an event."""

    def packets(self, now_s: float, datagrams: list[bytes]) -> None:
        """Records datagrams of the link, in either direction."""

    def position(self, now_s: float, position: Ned) -> None:
        """Records the vehicle's position, once per tick."""

    def clocks(self, reading: ClockReading) -> None:
        """Records a reading of the clocks."""


@dataclass(frozen=True)
class PreparedRun:
    """A run that can begin.

    Attributes:
        mission: the mission to fly.
        recorder: records everything that happens.
        journalled: a run that was cut off, which this one continues in the same record.
        may_yield: wait for the operator when somebody else takes control in flight.
    """

    mission: PreparedMission
    recorder: Recorder
    journalled: JournalledFlight | None = None
    may_yield: bool = False


class Run:
    """One flight of one mission, with all its parts; reported times count from its start.

    Args:
        prepared: what to fly.
        wire: knows the system id of the vehicle.
        telemetry: what was last heard from the autopilot, also before this run.
        start_s: when the run begins.
        terms: the operator's choices for all sorties.
        memory: what is remembered of earlier flights.

    Raises:
        LookupError: the run that was cut off had another mission.
    """

    def __init__(
        self,
        prepared: PreparedRun,
        wire: Wire,
        telemetry: Telemetry,
        start_s: float,
        terms: SortieTerms = USUAL_TERMS,
        memory: FlightMemory | None = None,
    ) -> None:
        mission, journalled = prepared.mission.mission, prepared.journalled
        self._detector = detector = EventDetector(mission.events)
        self.mission, self.recorder, self.start_s = mission, prepared.recorder, start_s
        self._wire, self._telemetry = wire, telemetry
        telemetry.placed.anchor_at(mission.anchor)
        self._heard_before = list(telemetry.newest.values())
        telemetry.words.take_news()  # discards that of another flight
        signals = detector.signals | confirming(mission.skills)
        said = frozenset(signal for signal in signals if not signal.is_report)
        self.vehicle = self._vehicle(said, memory)
        self._other_systems = OtherSystems(SignalReader(said))
        self.awaited = frozenset(s.field for s in signals if s.is_pulse)
        acting = assemble(prepared.mission, self.vehicle, detector)
        self.flight = acting.flight
        self._found = FoundPlaces(mission, acting.flight)
        self._detections = Detections(signals, self._found.reports)
        self.executive = acting.executive
        self.flight.functions.prepare(functions_of(mission))
        self._seen_s = -math.inf
        self._clocks = RunClocks(wire, telemetry)
        self._keep(prepared.mission.planner, journalled)
        speed_mps = mission.speed_limits.speed_mps
        resumption = Resumption(journalled, speed_mps, lambda: wire.system) if journalled else None
        self.sortie = Sortie(
            acting,
            mission,
            terms=terms,
            may_yield=prepared.may_yield,
            resumption=resumption,
        )
        self._surroundings = Surroundings(mission.grid, telemetry)
        self._sight = SightLimit(self.flight)
        planner = prepared.mission.planner
        self._clearance = KeptClearance(self.flight, planner)
        self._charge = ChargeReport(self.flight, planner.energy)

    def _vehicle(self, said: frozenset[Signal], memory: FlightMemory | None) -> MavlinkVehicle:
        """The vehicle, which reads the mission's signals."""
        markers = (place.marker for place in self.mission.places.values())
        return MavlinkVehicle(
            self._wire,
            self._telemetry,
            envelope_of(self.mission),
            said,
            takeoff_up_m=-self.mission.home.position[2],
            marker_components=frozenset(marker.component for marker in markers if marker),
            memory=memory,
        )

    def _keep(self, planner: Planner, journalled: JournalledFlight | None) -> None:
        """From now on, stores in the journal what another process would need to continue."""
        flight, mission, journal = self.flight, self.mission, self.recorder.journal
        flight.journal, flight.now_s = journal, self.start_s
        if journalled is None:
            about = FlightBegun(mission.name, mission.path, digest(mission), self.start_s)
            journal.note(self.start_s, about)
            flight.task.on_change = lambda change: journal.note(flight.now_s, change)
            return
        self.start_s = journalled.begun.start_s
        counts = journalled.counts
        reports = self.executive.reports
        reports.replans, reports.laps = counts.replans, counts.laps
        self._found.restore(journalled.found, planner)
        self._report(restore(journalled, flight, planner, self._detector))
        if (seen := journalled.seen) is not None:
            self._telemetry.frame.keep(seen.origin, seen.altitude_m)

    @property
    def is_waiting(self) -> bool:
        """Whether it waits for its vehicle, and not for a plan."""
        return self.sortie.phase is Phase.WAITING and not self.sortie.beginning.is_planning

    @property
    def has_armed(self) -> bool:
        """Whether the vehicle was first heard to be armed in this step."""
        return self._clocks.has_armed

    @property
    def watched(self) -> frozenset[Fact]:
        """The events that the present plan watches; none while no plan is flown."""
        is_flown = self.sortie.phase is Phase.TASK
        return self.executive.watched if is_flown else frozenset()

    def is_urgent(self, now_s: float, messages: list[Message], asked: list[SignalReading]) -> bool:
        """Whether messages that are not taken yet, or requests, change a watched event."""
        readings = asked + self.vehicle.foresee(messages)
        return not self.watched.isdisjoint(self._detector.foresee(now_s, readings))

    def step(
        self,
        now_s: float,
        messages: list[Message],
        asked: list[SignalReading],
        is_tick: bool = True,
        reports: Sequence[bytes] = (),
    ) -> list[Stamped]:
        """One tick, or a step between two: reads what arrived and acts; returns what happened.

        A plan made in a tick is flown from the next tick on. A plan made in a step between two
        ticks is flown at once, which is the purpose of such a step.
        """
        plan = self.executive.lasso
        self.flight.speed_limit.advance(now_s)
        self.vehicle.setpoints.set_speed_limit(self.flight.speed_limit.now_mps)
        self.vehicle.setpoints.set_violated(bool(self.flight.task.violated))
        readings = asked + self.vehicle.receive(now_s, messages) + self._detections.read(reports)
        if self._found.reports:
            readings += self._found.look(
                now_s,
                self._detections,
                zero_s=self._wire.time.zero_s,
                zero=self._telemetry.frame.zero,
            )
        if not self.sortie.has_ended:  # the end is the last event of its record
            self._tell_of_others(messages)
        self._sight.take(self.vehicle.scans, self.vehicle.state)
        if self._surroundings.take(self.vehicle.scans):
            self.flight.routes.see(self._surroundings.grid)
        state = self.vehicle.state
        self._clocks.follow(state is not None and state.heartbeat.is_armed)
        self.sortie.step(now_s, readings)
        if not is_tick and self.executive.lasso is not plan:
            self.sortie.step(now_s, [])
        if self.sortie.has_ended:
            self.flight.functions.end_calls()
        else:
            self._tell_of_silence(now_s)
            self._charge.look(self.executive.lasso)
        self._learn()
        self._note_vehicle(now_s)
        return self.flight.collect_reports()

    def _tell_of_others(self, messages: list[Message]) -> None:
        """Reports the autopilot's texts, and refused reports and messages of others."""
        for text in self._telemetry.words.take_news():
            self.flight.report(AutopilotSaid(text))
        passed_over = self._other_systems.news(self._wire.system, messages)
        for news in (*self._detections.news(), *passed_over):
            self.flight.report(news)

    def _tell_of_silence(self, now_s: float) -> None:
        """Reports events whose signals have fallen silent, or are heard again."""
        for event, is_silent in self._detector.silences(now_s):
            of_signal = SignalSilent if is_silent else SignalHeard
            self.flight.report(of_signal(event.name, str(event.when.signal)))

    def _note_vehicle(self, now_s: float) -> None:
        """Notes the position of a vehicle in the air in the journal, once a second."""
        state, frame = self.vehicle.state, self._telemetry.frame
        if state is None or now_s - self._seen_s < SEEN_EVERY_S:
            return
        is_heard = state.motion.silence_s(now_s) < SEEN_EVERY_S
        if not is_heard or not state.heartbeat.is_armed or self.vehicle.frame.doubt is not None:
            return
        if frame.origin is not None and self.sortie.phase not in ON_THE_GROUND:
            seen = VehicleSeen(
                state.motion.position,
                origin=frame.origin,
                altitude_m=frame.altitude_m,
                system=self._wire.system,
                zero_s=round(state.motion.measured_s - state.motion.boot_s, 3),
            )
            self.recorder.journal.note(now_s, seen)
            self._seen_s = now_s

    def record(self, now_s: float, packets: list[bytes], reports: list[Stamped]) -> None:
        """Passes everything on to the recorder.

        The record begins with what was last heard before: without the origin of the local frame,
        which is not told again, a reader would not know where the vehicle is.
        """
        self.recorder.packets(now_s - self.start_s, self._heard_before + packets)
        self._heard_before = []
        state = self.vehicle.state
        if state is not None and self.vehicle.frame.doubt is None:
            self.recorder.position(now_s - self.start_s, state.motion.position)
        for stamped in reports:
            if isinstance(stamped.event, PlanReplaced | NoPlanFound | LapCompleted):
                told = self.executive.reports
                counts = FlightCounts(told.replans, told.laps)
                self.recorder.journal.note(now_s, counts)
        self._report(reports)
        for reading in self._clocks.due(now_s, self.start_s, self.sortie.has_ended):
            self.recorder.clocks(reading)

    def _report(self, reports: list[Stamped]) -> None:
        for stamped in reports:
            time_s = round(stamped.time_s - self.start_s, 3)
            self.recorder.report(Stamped(time_s, since(stamped.event, self.start_s)))

    def _learn(self) -> None:
        """Updates the drag of the vehicle, and the clearance that its accuracy demands."""
        state = self.vehicle.state
        if not self.sortie.has_ended and state is not None:
            self.flight.guidance.learn(state)
            self._clearance.follow(state)

    def adjust(self, speed_max_mps: float, belief_retry_s: float) -> None:
        """Applies the companion's parameters; slows down a flight under way if necessary."""
        self.flight.speed_limit.set_operator_limit(speed_max_mps)
        self.flight.belief_retry_s = belief_retry_s if belief_retry_s >= 0.0 else None
        settings = OperatorSettings(speed_max_mps, belief_retry_s)
        self.recorder.journal.note(self.flight.now_s, settings)

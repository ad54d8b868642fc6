"""A flight that continues after the companion was away, with its state from the journal.

Nothing is sent before control is given back. Actions whose commands may have taken effect count as
failed; they are reported and are in no later plan, unless their skill may be repeated.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from companion.acting.event_detector import EventDetector
from companion.acting.flight import Flight
from companion.acting.journal import CommandSettled, JournalledFlight
from companion.acting.positions import tell_overrun, tell_positions
from companion.acting.sortie.phases import GOES_ON_WITH, SortieEvent
from companion.acting.sortie.preflight.kept_fence import keep_to
from companion.errors import Aborted, CompanionError
from companion.flight_events.event import Stamped
from companion.flight_events.facts import BeliefWithdrawn
from companion.flight_events.plans import TaskRecalled
from companion.flight_events.skills import OutcomeUnknown
from companion.flight_events.sortie import FlightFoundAgain, Phase
from companion.flight_events.word import ViolatedBefore
from companion.geometry import distance
from companion.planning.energy.ratio_estimate import RatioEstimate
from companion.planning.planner import Planner
from companion.planning.task_replay import TaskReplay
from companion.vehicle.ports.state import Mode, VehicleState

DRIFT_M = 5.0
"""How far a holding vehicle may be from where it is expected."""
UNSEEN_S = 3.0
"""How long it may have moved since it was seen: a second to the next entry of the journal, a second
to the autopilot's failsafe, and a second to stop."""

TWO_KEYS = "hold, then continue, to give control back"
STREAMED = (Phase.TASK, Phase.PAUSED, Phase.RETURNING, Phase.LANDING)
"""The phases in which setpoints are streamed, so that the autopilot notices their loss; a vehicle
is also held before it lands."""


@dataclass(frozen=True)
class Resumption:
    """A flight to continue.

    Attributes:
        journalled: its state from the journal.
        speed_mps: greatest speed of the vehicle.
        system: MAVLink system id of the vehicle that is heard.
    """

    journalled: JournalledFlight
    speed_mps: float
    system: Callable[[], int]

    @property
    def goes_on_with(self) -> SortieEvent:
        """The event that follows once the vehicle is in OFFBOARD and under control again."""
        return GOES_ON_WITH[self.journalled.flown]

    @property
    def failure(self) -> CompanionError | None:
        """Why the flight did not end well; None if it ended well, or was not ending."""
        ending = self.journalled.ending
        if ending is None or not ending.exit_code:
            return None
        failure = CompanionError(ending.reason)
        failure.exit_code = ending.exit_code
        return failure

    def why_not(self, state: VehicleState) -> Aborted | None:
        """Why the flight cannot continue; None if it can, once control is given back."""
        what = "the companion was away"
        if self.is_landing(state):
            return None
        if self.journalled.flown not in GOES_ON_WITH:
            return Aborted(f"{what} while the vehicle was left on hold; it is left alone")
        if state.is_standing:
            return Aborted(f"{what}, and the vehicle has landed; it is not armed again")
        return None

    def is_landing(self, state: VehicleState) -> bool:
        """Whether it lands, or has landed, as it was to do; nothing has to be sent for that."""
        was_to_land = self.journalled.flown is Phase.LANDING
        return was_to_land and (state.is_standing or state.heartbeat.mode is Mode.LAND)

    def why_asked(self, state: VehicleState) -> str | None:
        """Why the operator is asked, even if the autopilot holds by the loss of our stream."""
        journalled, seen = self.journalled, self.journalled.seen
        if journalled.phase is Phase.YIELDED:
            return "somebody else had control"
        if journalled.flown not in STREAMED or seen is None:
            return "the vehicle was not flown by setpoints"
        if seen.system != self.system():
            return f"the vehicle's system id is {self.system()}, and it was {seen.system}"
        away_m = distance(seen.position, state.motion.position)
        if away_m > DRIFT_M + UNSEEN_S * self.speed_mps:
            return f"the vehicle is {away_m:.0f} m from where it was"
        return None

    def found(self, state: VehicleState, resumes: bool) -> FlightFoundAgain:
        """The event that reports that the flight has been found still under way."""
        asked = self.why_asked(state) or _why_it_keeps(state)
        key = (
            "it continues when the autopilot holds by itself"
            if resumes and asked is None
            else TWO_KEYS
        )
        about = f"{asked}: {key}" if asked is not None else key
        return FlightFoundAgain(round(self.journalled.away_s, 1), self.journalled.phase, about)


def _why_it_keeps(state: VehicleState) -> str | None:
    """Why the autopilot's hold will not be due to our lost stream, as in a take-off by the plan."""
    mode = state.heartbeat.mode
    is_held = mode is Mode.LOITER and state.heartbeat.is_failsafe
    return None if is_held or mode is Mode.OFFBOARD else f"{mode.value} is flown"


def restore(
    journalled: JournalledFlight, flight: Flight, planner: Planner, detector: EventDetector
) -> list[Stamped]:
    """Restores the task from the journal, and keeps later changes in it.

    Returns:
        The task, the word so far and what it violates: for the record, which leaves out what it
        already has. They are not news: one event reports the violated lines.

    Raises:
        LookupError: the journal belongs to another mission.
    """
    task, journal = flight.task, flight.journal
    replay = TaskReplay(task, planner)
    goes_on_s = flight.now_s
    mission = planner.mission
    recalled = TaskRecalled(mission.written_task, mission.priorities)
    flight.add_report(Stamped(journalled.begun.start_s, recalled))
    for change in journalled.changes:
        late = replay.make(change)
        flight.now_s = change.at.now_s or goes_on_s
        tell_positions(flight)
        tell_overrun(flight, late)
    flight.now_s = goes_on_s
    word = flight.collect_reports()
    if task.violated:
        flight.report(ViolatedBefore(task.violated))
    if journalled.fence is not None:
        keep_to(flight, journalled.fence)
    if (learnt := journalled.energy) is not None and planner.energy is not None:
        flying = RatioEstimate(learnt.flying, learnt.flying_deviation)
        planner.energy.recall(flying, RatioEstimate(learnt.gauge, learnt.gauge_deviation))
    events = mission.events
    detector.resume(name for name, event in events.items() if event.fact in task.facts)
    task.on_change = lambda change: journal.note(flight.now_s, change)
    flight.photos_reported |= journalled.photos
    for shot in journalled.shots:
        flight.vehicle.cameras.recall(shot)
        if shot.position == task.word.positions and shot.owner not in journalled.photos:
            flight.report(
                OutcomeUnknown(shot.action, "the camera is asked how many photos it has taken")
            )
    for each in journalled.unsettled:
        _give_up(replay, each.action, flight)
        journal.note(flight.now_s, CommandSettled(each.number))
    task.interrupt()
    return word


def _give_up(replay: TaskReplay, name: str, flight: Flight) -> None:
    """Counts an action as failed whose command may have taken effect."""
    action = replay.action(name)
    if action.is_repeatable:
        flight.report(OutcomeUnknown(name, "it may be repeated"))
        return
    flight.report(OutcomeUnknown(name, "it counts as failed, and is not done again"))
    flight.task.withdraw(action.assumes, None)
    flight.task.bar(action)
    for belief in sorted(action.assumes):
        flight.report(BeliefWithdrawn(belief))

"""Events about the sortie: its phases, who has control, what the gate holds back, and its end."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Annotated, Literal

from companion.flight_events.event import FlightEvent
from companion.flight_events.event_fields import Doc, Reason


class Phase(Enum):
    """Where a sortie is; companion/acting/sortie/phases.py says where each phase leads."""

    WAITING = "waiting for the vehicle"
    CHECKING = "checking the autopilot's failsafes"
    ARMING = "arming"
    TAKE_OFF = "taking off"
    OFFBOARD = "entering OFFBOARD"
    TASK = "flying the task"
    PAUSED = "paused"
    RETURNING = "returning"
    YIELDED = "yielded"
    HOLDING = "holding"
    PARTING = "leaving the vehicle on hold"
    LANDING = "landing"
    ENDED = "ended"


EXIT_CODE = Doc("with which the command ends")
PhaseName = Annotated[Phase, Doc("the name of the phase")]
Destination = Annotated[str, Doc("the place that the vehicle flies to")]
LimitWords = Annotated[str, Doc("the limit: laps or seconds")]
Percent = Annotated[int, Doc("the charge")]
ZeroExitCode = Annotated[Literal[0], EXIT_CODE]


@dataclass(frozen=True, slots=True)
class PhaseEntered(FlightEvent):
    """A phase of the sortie began."""

    kind = "phase"
    template = "{phase}"

    phase: PhaseName


@dataclass(frozen=True, slots=True)
class GoalFailed(FlightEvent):
    """A phase did not reach its goal."""

    kind = "phase"
    template = "{reason}"

    reason: Reason


@dataclass(frozen=True, slots=True)
class AutopilotSaid(FlightEvent):
    """The autopilot sent a text in flight, a warning or worse."""

    kind = "autopilot"
    template = "the autopilot says: {words}"

    words: Annotated[str, Doc("what it says")]


@dataclass(frozen=True, slots=True)
class WeakFailsafeAccepted(FlightEvent):
    """The vehicle is armed although a failsafe of its autopilot is weak."""

    kind = "phase"
    template = "weak failsafe accepted: {weakness}"

    weakness: Annotated[str, Doc("which failsafe, and how it is weak")]


@dataclass(frozen=True, slots=True)
class ControlYielded(FlightEvent):
    """Somebody else has control, and may give it back."""

    kind = "phase"
    template = "{loss}; hold, then continue, to give control back"

    loss: Annotated[str, Doc("who has control, or why the companion has lost it")]


@dataclass(frozen=True, slots=True)
class ControlRegained(FlightEvent):
    """The operator gave control back."""

    kind = "phase"
    template = "control given back by the operator"


@dataclass(frozen=True, slots=True)
class ControlTakenBack(FlightEvent):
    """The autopilot held because it no longer heard the companion; the flight continues."""

    kind = "phase"
    template = "the autopilot held because it no longer heard the companion; the flight continues"


@dataclass(frozen=True, slots=True)
class LinkSilent(FlightEvent):
    """A vehicle in the air is not heard: the companion sends nothing and waits."""

    kind = "phase"
    template = "the vehicle is not heard; waiting for it"


@dataclass(frozen=True, slots=True)
class LinkBack(FlightEvent):
    """The vehicle is heard again, and nobody took control in between."""

    kind = "phase"
    template = "the vehicle is heard again; the flight continues"


@dataclass(frozen=True, slots=True)
class FlightFoundAgain(FlightEvent):
    """The companion was away, and finds the flight still under way; it sends nothing yet."""

    kind = "phase"
    template = "the companion was away for {away_s} s, while {phase}; {key}"

    away_s: Annotated[float, Doc("how long the companion was away, in seconds")]
    phase: PhaseName
    key: Annotated[str, Doc("what the flight waits for, in words")]


@dataclass(frozen=True, slots=True)
class StopRequested(FlightEvent):
    """The operator asked for a stop, which begins now."""

    kind = "phase"
    template = "stopping as asked"


@dataclass(frozen=True, slots=True)
class PauseEnded(FlightEvent):
    """The operator's pause ended because of the charge; the flight continues."""

    kind = "phase"
    template = "the pause is over: the charge is needed to land at a safe place"


@dataclass(frozen=True, slots=True)
class ReturnBegun(FlightEvent):
    """The task has no plan, so the vehicle flies home or to another safe place."""

    kind = "phase"
    template = "returning to {place}"

    place: Destination


@dataclass(frozen=True, slots=True)
class ReturnFailed(FlightEvent):
    """A flight home or to another safe place failed."""

    kind = "phase"
    template = "cannot return to {place}: {reason}"

    place: Destination
    reason: Reason


@dataclass(frozen=True, slots=True)
class FlightLimitReached(FlightEvent):
    """A mission without an end reached its time or lap limit; the vehicle flies home."""

    kind = "phase"
    template = "{limit} flown: returning"

    limit: LimitWords


@dataclass(frozen=True, slots=True)
class BatteryLow(FlightEvent):
    """The autopilot reports a low charge, and the mission has no rule for it."""

    kind = "phase"
    template = "the battery is low, and the mission has no rule for this: returning to {place}"

    place: Destination


@dataclass(frozen=True, slots=True)
class VehicleLanded(FlightEvent):
    """The vehicle landed as planned, and the plan continues."""

    kind = "phase"
    template = "landed as planned"


@dataclass(frozen=True, slots=True)
class VehicleAirborne(FlightEvent):
    """The vehicle took off as planned."""

    kind = "phase"
    template = "in the air again"


@dataclass(frozen=True, slots=True)
class BatteryCharged(FlightEvent):
    """The battery reached the charge that the plan waited for."""

    kind = "phase"
    template = "charged to {percent} %"

    percent: Percent


@dataclass(frozen=True, slots=True)
class ChargeAwaited(FlightEvent):
    """The dock does not charge, and no other dock is in reach: the vehicle waits on it."""

    kind = "phase"
    template = (
        "the battery does not charge, it is at {percent} %: the vehicle waits on the ground for "
        "up to {patience_s} s"
    )

    percent: Percent
    patience_s: Annotated[int, Doc("how long it waits at most, in seconds")]


@dataclass(frozen=True, slots=True)
class ChargeCutShort(FlightEvent):
    """An event came that a `ready` line answers, so the vehicle takes off again."""

    kind = "phase"
    template = "charging ends at {percent} %, to answer an event"

    percent: Percent


@dataclass(frozen=True, slots=True)
class ChargeSufficient(FlightEvent):
    """The charge is enough for the rest of the plan, so the vehicle does not land to charge."""

    kind = "phase"
    template = "no landing to charge: the battery has {percent} %, and {enough} % are enough"

    percent: Percent
    enough: Annotated[int, Doc("percent of the charge that are enough")]


@dataclass(frozen=True, slots=True)
class VehicleCrashed(FlightEvent):
    """A sign of a crash was seen; the run ends with exit code 5."""

    kind = "crash"
    template = "{sign}"

    sign: Annotated[str, Doc("what was seen")]


@dataclass(frozen=True, slots=True)
class SetpointRefused(FlightEvent):
    """The gate began to hold setpoints back."""

    kind = "gate"
    template = "setpoint refused, holding: {reason}"

    reason: Reason


class RunEnded(FlightEvent):
    """The run is over.

    Attributes:
        exit_code: with which the command ends; 0 is good.
    """

    __slots__ = ()
    kind = "end"
    exit_code: int


@dataclass(frozen=True, slots=True)
class TaskSatisfied(RunEnded):
    """The run is over, and the task is satisfied."""

    template = "task satisfied, landed"

    exit_code: ZeroExitCode = 0


@dataclass(frozen=True, slots=True)
class ReturnedAsAsked(RunEnded):
    """The run is over: the operator called the vehicle home."""

    template = "returned as asked, landed"

    exit_code: ZeroExitCode = 0


@dataclass(frozen=True, slots=True)
class EndedAtLimit(RunEnded):
    """The run is over: it reached its time or lap limit."""

    template = "{limit} flown, landed; {verdict}"

    limit: LimitWords
    verdict: Annotated[str, Doc("whether the task holds, in words")]
    exit_code: ZeroExitCode = 0


@dataclass(frozen=True, slots=True)
class StoppedAsAsked(RunEnded):
    """The run is over: the operator stopped it."""

    template = "stopped as asked"

    exit_code: ZeroExitCode = 0


@dataclass(frozen=True, slots=True)
class RunFailed(RunEnded):
    """The run is over, and did not end well."""

    template = "{reason}"

    reason: Reason
    exit_code: Annotated[int, EXIT_CODE]

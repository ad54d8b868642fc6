"""The phases of a sortie, from the ground to the ground, and the table of their transitions.

`sortie.py` asks this table where an event leads. The diagram in docs/sortie.md is drawn from it.
"""

from __future__ import annotations

from enum import Enum

from companion.flight_events.sortie import Phase
from companion.transitions import StateTransition, TransitionTable
from companion.vehicle.ports.goals import Goal


class SortieEvent(Enum):
    """What happens to a sortie."""

    FOUND_AGAIN = "the companion was away, and its vehicle still flies"
    PLANNED = "the vehicle stands where the mission begins, and there is a plan"
    CHECKED = "the failsafes are strong, or the operator accepts them"
    REACHED = "the goal of the phase is reached"
    FAILED = "the goal is not reached in time, or the autopilot refuses it"
    TASK_GOES_ON = "in OFFBOARD, or resumed by the operator, to fly the task"
    RETURN_GOES_ON = "in OFFBOARD, or resumed by the operator, to fly home"
    PAUSE_GOES_ON = "in OFFBOARD again, after an interrupted pause"
    LANDING_GOES_ON = "a landing was interrupted, and the vehicle lands or is in OFFBOARD again"
    NEEDS_TAKE_OFF = "the plan has landed the vehicle, and the next plan begins in the air"
    SATISFIED = "the task is satisfied, or the vehicle reaches home or a safe place"
    OUT_OF_PLANS = "there is no plan, and the mission says land, or no safe place is in reach"
    LEFT_ON_HOLD = "there is no plan, and the mission says hold"
    NO_WAY_HOME = "no clear route leads home"
    PAUSED = "the operator pauses"
    CALLED_HOME = "the operator, a limit of the flight or a low battery calls the vehicle home"
    TAKEN_OVER = "the pilot or a failsafe takes the vehicle; an operator may give it back"
    SILENT = "nothing is heard of the vehicle in the air"
    HANDED_BACK = "the pilot chose hold, and the operator says continue; or --resume allows it"
    HIT = "the vehicle has hit something, and still flies"
    FRAME_LOST = "the vehicle's place on the earth is in doubt for too long"
    STOPPED_IN_THE_AIR = "somebody stops the companion, and the vehicle is armed"
    STOPPED = "somebody stops the companion, and the vehicle is not armed or not ours"
    GIVEN_UP = "the sortie cannot begin, or the vehicle is no longer ours to fly"


ON_THE_GROUND = (Phase.WAITING, Phase.CHECKING)
"""The phases in which the vehicle is not ours yet."""
UNDER_TASK = (Phase.TASK, Phase.PAUSED, Phase.RETURNING)
"""The phases in which our setpoints fly the vehicle in OFFBOARD, or its plan has landed it."""
LANDS = (Phase.HOLDING, Phase.LANDING)
"""The phases in which the vehicle is about to land, or lands."""

GOALS: dict[Phase, Goal] = {
    Phase.ARMING: Goal.ARMED,
    Phase.TAKE_OFF: Goal.AIRBORNE,
    Phase.OFFBOARD: Goal.OFFBOARD,
    Phase.HOLDING: Goal.HOLDING,
    Phase.PARTING: Goal.HOLDING,
    Phase.LANDING: Goal.LANDED,
}
"""The phases that pursue a goal of the vehicle."""

GOES_ON_WITH = {
    Phase.ARMING: SortieEvent.TASK_GOES_ON,
    Phase.TAKE_OFF: SortieEvent.TASK_GOES_ON,
    Phase.TASK: SortieEvent.TASK_GOES_ON,
    Phase.PAUSED: SortieEvent.PAUSE_GOES_ON,
    Phase.RETURNING: SortieEvent.RETURN_GOES_ON,
    Phase.HOLDING: SortieEvent.LANDING_GOES_ON,
    Phase.LANDING: SortieEvent.LANDING_GOES_ON,
}
"""The event with which a flight in each phase continues; one left on hold does not."""

_P, _E = Phase, SortieEvent
_OURS = (_P.ARMING, _P.TAKE_OFF, _P.OFFBOARD, *UNDER_TASK, _P.PARTING)
_ENDS = "the companion sends nothing more"
_LANDS = "the vehicle lands where it is"
_HOLDS = "the vehicle holds, then lands where it is"

TRANSITIONS = TransitionTable(
    StateTransition(_P.WAITING, _E.PLANNED, _P.CHECKING, "the companion asks the autopilot"),
    StateTransition(_P.WAITING, _E.FOUND_AGAIN, _P.YIELDED, "the companion waits for control"),
    StateTransition(
        _P.WAITING, _E.LANDING_GOES_ON, _P.LANDING, "the companion watches the landing"
    ),
    StateTransition(_P.CHECKING, _E.CHECKED, _P.ARMING, "the companion sends its first command"),
    StateTransition(_P.ARMING, _E.REACHED, _P.TAKE_OFF, "the vehicle climbs"),
    StateTransition(_P.ARMING, _E.FAILED, _P.ENDED, _ENDS),
    StateTransition(
        _P.TAKE_OFF, _E.REACHED, _P.OFFBOARD, "the companion streams setpoints that hold"
    ),
    StateTransition(_P.TAKE_OFF, _E.FAILED, _P.LANDING, _LANDS),
    StateTransition(_P.OFFBOARD, _E.TASK_GOES_ON, _P.TASK, "the vehicle flies the plan"),
    StateTransition(_P.OFFBOARD, _E.RETURN_GOES_ON, _P.RETURNING, "the vehicle flies home"),
    StateTransition(_P.OFFBOARD, _E.PAUSE_GOES_ON, _P.PAUSED, "the vehicle holds"),
    StateTransition(_P.OFFBOARD, _E.LANDING_GOES_ON, _P.LANDING, _LANDS),
    StateTransition(_P.OFFBOARD, _E.FAILED, _P.LANDING, _LANDS),
    StateTransition(_P.TASK, _E.SATISFIED, _P.LANDING, _LANDS),
    StateTransition(_P.TASK, _E.NEEDS_TAKE_OFF, _P.ARMING, "the vehicle takes off again"),
    StateTransition(_P.TASK, _E.OUT_OF_PLANS, _P.HOLDING, _HOLDS),
    StateTransition(_P.TASK, _E.LEFT_ON_HOLD, _P.PARTING, "the vehicle is left on hold"),
    StateTransition(_P.TASK, _E.PAUSED, _P.PAUSED, "the vehicle holds; the task is frozen"),
    StateTransition(
        _P.TASK, _E.CALLED_HOME, _P.RETURNING, "the vehicle leaves the task and flies home"
    ),
    StateTransition(
        _P.PAUSED, _E.TASK_GOES_ON, _P.TASK, "the companion plans from where the vehicle is"
    ),
    StateTransition(
        _P.PAUSED, _E.RETURN_GOES_ON, _P.RETURNING, "the vehicle flies home from where it is"
    ),
    StateTransition(
        _P.PAUSED,
        _E.CALLED_HOME,
        _P.RETURNING,
        "the vehicle flies home; a limit waits until the pause ends",
    ),
    StateTransition(_P.RETURNING, _E.PAUSED, _P.PAUSED, "the vehicle holds"),
    StateTransition(_P.RETURNING, _E.SATISFIED, _P.LANDING, _LANDS),
    StateTransition(_P.RETURNING, _E.NO_WAY_HOME, _P.HOLDING, _HOLDS),
    StateTransition(
        _P.YIELDED, _E.HANDED_BACK, _P.OFFBOARD, "the companion streams setpoints that hold"
    ),
    StateTransition(_P.HOLDING, _E.REACHED, _P.LANDING, _LANDS),
    StateTransition(_P.HOLDING, _E.FAILED, _P.LANDING, _LANDS),
    StateTransition(_P.PARTING, _E.REACHED, _P.ENDED, _ENDS),
    StateTransition(_P.PARTING, _E.FAILED, _P.ENDED, _ENDS),
    StateTransition(_P.LANDING, _E.REACHED, _P.ENDED, _ENDS),
    StateTransition(_P.LANDING, _E.FAILED, _P.ENDED, _ENDS),
    *(StateTransition(phase, _E.TAKEN_OVER, _P.YIELDED, _ENDS) for phase in UNDER_TASK),
    *(StateTransition(phase, _E.SILENT, _P.YIELDED, _ENDS) for phase in UNDER_TASK),
    *(StateTransition(phase, _E.STOPPED_IN_THE_AIR, _P.HOLDING, _HOLDS) for phase in _OURS),
    *(
        StateTransition(phase, event, _P.HOLDING, _HOLDS)
        for event in (_E.HIT, _E.FRAME_LOST)
        for phase in _OURS
    ),
    *(
        StateTransition(phase, _E.STOPPED, _P.ENDED, _ENDS)
        for phase in (*ON_THE_GROUND, *_OURS, _P.YIELDED)
    ),
    *(
        StateTransition(phase, _E.GIVEN_UP, _P.ENDED, _ENDS)
        for phase in _P
        if phase is not _P.ENDED
    ),
)
"""The phase after each event; stopping a vehicle that already holds or lands changes nothing."""

"""The phases of a sortie, from the ground to the ground, and the table that leads through them.

`sortie.py` does in each tick what the present phase is for, and asks this table where an event
leads. The diagram in docs/sortie.md is drawn from it.
"""

from __future__ import annotations

from enum import Enum

from companion.flight_events.sortie import Phase
from companion.transitions import StateTransition, TransitionTable
from companion.vehicle.port import Goal


class SortieEvent(Enum):
    """What happens to a sortie."""

    FOUND_AGAIN = "the companion was away, and its flight still goes on"
    PLANNED = "the vehicle stands where the mission begins, and there is a plan"
    CHECKED = "the failsafes are strong, or accepted"
    REACHED = "the phase's goal is reached"
    FAILED = "the phase's goal is not reached in its time, or refused"
    TASK_GOES_ON = "in OFFBOARD, or resumed by the operator: the task goes on"
    RETURN_GOES_ON = "in OFFBOARD, or resumed by the operator: the flight home goes on"
    PAUSE_GOES_ON = "in OFFBOARD again, in a pause: the pause goes on"
    LANDING_GOES_ON = "it was to land, and lands or is in OFFBOARD again: the landing goes on"
    NEEDS_TAKE_OFF = "the plan has landed the vehicle, and a new one begins in the air"
    SATISFIED = "the task is satisfied, or home or a safe place is reached"
    OUT_OF_PLANS = "there is no plan, and the mission lands, or no safe place can be reached"
    LEFT_ON_HOLD = "there is no plan, and the mission holds"
    NO_WAY_HOME = "no clear route leads home"
    PAUSED = "the operator pauses"
    CALLED_HOME = "the operator, a limit of the flight, or a low battery calls the vehicle home"
    TAKEN_OVER = "the pilot or a failsafe takes the vehicle; an operator may give it back"
    SILENT = "nothing is heard of the vehicle in the air"
    HANDED_BACK = "the pilot holds, and the operator resumes; or the rule of resume holds"
    HIT = "the vehicle has hit something, and still flies"
    FRAME_LOST = "where the vehicle is on the earth is in doubt for too long"
    STOPPED_IN_THE_AIR = "a stop is asked for, and the vehicle is armed"
    STOPPED = "a stop is asked for, and the vehicle is not armed or not ours"
    GIVEN_UP = "it cannot begin, or the vehicle is no longer ours to fly"


ON_THE_GROUND = (Phase.WAITING, Phase.CHECKING)
"""Phases in which the vehicle is not ours yet."""
UNDER_TASK = (Phase.TASK, Phase.PAUSED, Phase.RETURNING)
"""Phases in which the vehicle is in OFFBOARD by our setpoints, or on the ground by its plan."""

GOALS: dict[Phase, Goal] = {
    Phase.ARMING: Goal.ARMED,
    Phase.TAKE_OFF: Goal.AIRBORNE,
    Phase.OFFBOARD: Goal.OFFBOARD,
    Phase.HOLDING: Goal.HOLDING,
    Phase.PARTING: Goal.HOLDING,
    Phase.LANDING: Goal.LANDED,
}
"""The phases that work towards a goal of the vehicle."""

_P, _E = Phase, SortieEvent
_OURS = (_P.ARMING, _P.TAKE_OFF, _P.OFFBOARD, *UNDER_TASK, _P.PARTING)
_ENDS = "nothing is sent any more"
_LANDS = "it lands where it is"

TRANSITIONS = TransitionTable(
    StateTransition(_P.WAITING, _E.PLANNED, _P.CHECKING, "the autopilot is asked"),
    StateTransition(_P.WAITING, _E.FOUND_AGAIN, _P.YIELDED, "it is waited for control"),
    StateTransition(_P.WAITING, _E.LANDING_GOES_ON, _P.LANDING, "its landing is watched"),
    StateTransition(_P.CHECKING, _E.CHECKED, _P.ARMING, "the first command is sent"),
    StateTransition(_P.ARMING, _E.REACHED, _P.TAKE_OFF, "it climbs"),
    StateTransition(_P.ARMING, _E.FAILED, _P.ENDED, _ENDS),
    StateTransition(_P.TAKE_OFF, _E.REACHED, _P.OFFBOARD, "setpoints that hold are streamed"),
    StateTransition(_P.TAKE_OFF, _E.FAILED, _P.LANDING, _LANDS),
    StateTransition(_P.OFFBOARD, _E.TASK_GOES_ON, _P.TASK, "the plan is flown"),
    StateTransition(_P.OFFBOARD, _E.RETURN_GOES_ON, _P.RETURNING, "it flies home"),
    StateTransition(_P.OFFBOARD, _E.PAUSE_GOES_ON, _P.PAUSED, "it holds"),
    StateTransition(_P.OFFBOARD, _E.LANDING_GOES_ON, _P.LANDING, _LANDS),
    StateTransition(_P.OFFBOARD, _E.FAILED, _P.LANDING, _LANDS),
    StateTransition(_P.TASK, _E.SATISFIED, _P.LANDING, _LANDS),
    StateTransition(_P.TASK, _E.NEEDS_TAKE_OFF, _P.ARMING, "it takes off again"),
    StateTransition(_P.TASK, _E.OUT_OF_PLANS, _P.HOLDING, "it holds, then lands where it is"),
    StateTransition(_P.TASK, _E.LEFT_ON_HOLD, _P.PARTING, "it is left on hold"),
    StateTransition(_P.TASK, _E.PAUSED, _P.PAUSED, "it holds, the task is frozen"),
    StateTransition(_P.TASK, _E.CALLED_HOME, _P.RETURNING, "it leaves the task and flies home"),
    StateTransition(_P.PAUSED, _E.TASK_GOES_ON, _P.TASK, "a new plan is made from here"),
    StateTransition(_P.PAUSED, _E.RETURN_GOES_ON, _P.RETURNING, "it flies home from here"),
    StateTransition(
        _P.PAUSED, _E.CALLED_HOME, _P.RETURNING, "it flies home; a limit waits for the pause's end"
    ),
    StateTransition(_P.RETURNING, _E.PAUSED, _P.PAUSED, "it holds"),
    StateTransition(_P.RETURNING, _E.SATISFIED, _P.LANDING, _LANDS),
    StateTransition(_P.RETURNING, _E.NO_WAY_HOME, _P.HOLDING, "it holds, then lands where it is"),
    StateTransition(_P.YIELDED, _E.HANDED_BACK, _P.OFFBOARD, "setpoints that hold are streamed"),
    StateTransition(_P.HOLDING, _E.REACHED, _P.LANDING, _LANDS),
    StateTransition(_P.HOLDING, _E.FAILED, _P.LANDING, _LANDS),
    StateTransition(_P.PARTING, _E.REACHED, _P.ENDED, _ENDS),
    StateTransition(_P.PARTING, _E.FAILED, _P.ENDED, _ENDS),
    StateTransition(_P.LANDING, _E.REACHED, _P.ENDED, _ENDS),
    StateTransition(_P.LANDING, _E.FAILED, _P.ENDED, _ENDS),
    *(StateTransition(phase, _E.TAKEN_OVER, _P.YIELDED, _ENDS) for phase in UNDER_TASK),
    *(StateTransition(phase, _E.SILENT, _P.YIELDED, _ENDS) for phase in UNDER_TASK),
    *(
        StateTransition(phase, _E.STOPPED_IN_THE_AIR, _P.HOLDING, "it holds, then lands")
        for phase in _OURS
    ),
    *(
        StateTransition(phase, event, _P.HOLDING, "it holds, then lands")
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
"""The phase after each event; a stop while it holds or lands already changes nothing."""
